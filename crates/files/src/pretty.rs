//! Readable JSON: two spaces per level, lists of plain values on one line.

use serde_json::Value;

/// The text of `value`, ending in a line break.
pub(crate) fn pretty(value: &Value) -> String {
    let mut text = String::new();
    write(&mut text, value, 0);
    text.push('\n');
    text
}

fn write(out: &mut String, value: &Value, depth: usize) {
    match value {
        Value::Array(items) if items.iter().any(is_nested) => {
            let items = items.iter().map(|item| (None, item));
            write_lines(out, ['[', ']'], items, depth);
        }
        Value::Array(items) => write_row(out, items),
        Value::Object(fields) if !fields.is_empty() => {
            let fields = fields.iter().map(|(key, value)| (Some(key.as_str()), value));
            write_lines(out, ['{', '}'], fields, depth);
        }
        plain => out.push_str(&plain.to_string()),
    }
}

fn is_nested(value: &Value) -> bool {
    value.is_array() || value.is_object()
}

fn write_row(out: &mut String, items: &[Value]) {
    out.push('[');
    for (i, item) in items.iter().enumerate() {
        out.push_str(if i == 0 { "" } else { ", " });
        out.push_str(&item.to_string());
    }
    out.push(']');
}

fn write_lines<'a>(
    out: &mut String,
    [open, close]: [char; 2],
    entries: impl Iterator<Item = (Option<&'a str>, &'a Value)>,
    depth: usize,
) {
    out.push(open);
    for (i, (key, value)) in entries.enumerate() {
        out.push_str(if i == 0 { "\n" } else { ",\n" });
        out.push_str(&"  ".repeat(depth + 1));
        if let Some(key) = key {
            out.push_str(&Value::from(key).to_string());
            out.push_str(": ");
        }
        write(out, value, depth + 1);
    }
    out.push('\n');
    out.push_str(&"  ".repeat(depth));
    out.push(close);
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn rows_stay_on_one_line() {
        let value = json!({"a \"b\"": [[1, 2.5], [null, "x"]], "empty": {}, "none": [], "deep": {"c": true}});
        let expected = r#"{
  "a \"b\"": [
    [1, 2.5],
    [null, "x"]
  ],
  "empty": {},
  "none": [],
  "deep": {
    "c": true
  }
}
"#;
        assert_eq!(pretty(&value), expected);
        assert_eq!(serde_json::from_str::<Value>(expected).unwrap(), value);
    }
}
