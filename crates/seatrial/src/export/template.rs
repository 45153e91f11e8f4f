//! Text templates.

/// `template` with every `{{key}}` replaced by its value. Inserted values are not expanded again.
pub fn fill(template: &str, values: &[(&str, String)]) -> String {
    let mut parts = template.split("{{");
    let mut out = parts.next().unwrap_or_default().to_owned();
    for part in parts {
        let (key, rest) = part.split_once("}}").unwrap_or((part, ""));
        let value = values.iter().find(|(own, _)| *own == key);
        debug_assert!(value.is_some(), "no value for {key}");
        out.push_str(value.map_or("", |(_, value)| value));
        out.push_str(rest);
    }
    out
}
