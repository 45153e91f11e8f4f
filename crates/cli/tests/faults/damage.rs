//! Pseudo-random damage to texts, documents and bytes, the same in every run.

use std::ops::Range;

use serde_json::{Map, Value};

use crate::places::unsealed;
pub use crate::support::draw::Draw;
use crate::tables;

/// Replacements of a number or a text.
const STRANGE: [&str; 30] = [
    "0",
    "-1",
    "-0.0",
    "-5",
    "7",
    "1e-12",
    "1e-300",
    "1e5",
    "1e9",
    "1e12",
    "1e300",
    "1e999",
    "nan",
    "inf",
    "9.97e36",
    "-32768",
    "4294967296",
    "18446744073709551616",
    "9007199254740993",
    "0.5",
    "true",
    "\"x\"",
    "\"\"",
    "[]",
    "{}",
    "[1, 2]",
    "null",
    "\"\\u0000\"",
    "\"../../x\"",
    "1979-05-27",
];

/// `bytes` of a file called `name`, damaged as an author or a program might.
pub fn damaged(draw: &mut Draw, name: &str, bytes: &[u8]) -> Vec<u8> {
    if name.ends_with(".parquet") {
        return tables::damaged(draw, name, bytes);
    }
    let text = String::from_utf8(unsealed(bytes)).unwrap();
    let is_json = name.ends_with("json");
    match draw.below(4) {
        0..=2 if is_json => damaged_json(draw, &text),
        0..=2 if name.ends_with(".csv") || name.ends_with(".asc") => damaged_cells(draw, &text),
        _ => damaged_text(draw, &text),
    }
    .into_bytes()
}

/// Places of numbers and quoted texts that are values.
fn values(text: &str) -> Vec<Range<usize>> {
    let bytes = text.as_bytes();
    let (mut found, mut at) = (Vec::new(), 0);
    while at < bytes.len() {
        let start = at;
        if bytes[at] == b'"' {
            at += 1 + text[at + 1..].find('"').map_or(0, |end| end + 1);
            if !text[at..].trim_start().starts_with([':', '=']) {
                found.push(start..at);
            }
        } else if bytes[at].is_ascii_digit() || bytes[at] == b'-' {
            let more = text[at + 1..].find(|c: char| !(c.is_ascii_digit() || ".eE+-".contains(c)));
            at = more.map_or(bytes.len(), |end| at + 1 + end);
            if start == 0 || !bytes[start - 1].is_ascii_alphanumeric() {
                found.push(start..at);
            }
        } else {
            at += 1;
        }
    }
    found
}

/// Changes a value, a key or the lines of a text.
fn damaged_text(draw: &mut Draw, text: &str) -> String {
    let values = values(text);
    let mut lines: Vec<&str> = text.lines().collect();
    let (one, other) = (draw.below(lines.len()), draw.below(lines.len()));
    let longer;
    match draw.below(12) {
        0 => drop(lines.remove(one)),
        1 => lines.insert(other, lines[one]),
        2 => lines.swap(one, other),
        3 => return text.chars().take(draw.below(text.len())).collect(),
        4 => {
            // A misspelled key, or a section turned into a separate table.
            longer = lines[one].replacen(['e', '['], "", 1);
            lines[one] = &longer;
        }
        _ if !values.is_empty() => {
            let place = values[draw.below(values.len())].clone();
            let value = changed_value(draw, &text[place.clone()]);
            return format!("{}{value}{}", &text[..place.start], &text[place.end..]);
        }
        _ => {}
    }
    lines.join("\n")
}

/// Another value in place of one: something strange, or the same number of another size or sign.
fn changed_value(draw: &mut Draw, value: &str) -> String {
    let factor = [-1.0, 1e-6, 0.01, 0.5, 2.0, 100.0, 1e6][draw.below(7)];
    match value.parse::<f64>() {
        Ok(number) if draw.below(2) == 0 && value.contains('.') => format!("{:?}", number * factor),
        Ok(number) if draw.below(2) == 0 => format!("{}", (number * factor) as i64),
        _ => draw.one_of(&STRANGE).to_owned(),
    }
}

/// Changes cells, columns or rows of lines of numbers.
fn damaged_cells(draw: &mut Draw, text: &str) -> String {
    let separator = if text.contains(',') { "," } else { " " };
    let mut rows: Vec<Vec<String>> =
        text.lines().map(|line| line.split(separator).map(str::to_owned).collect()).collect();
    let row = draw.below(rows.len());
    let column = draw.below(rows[row].len());
    let factor = [-1.0, 0.0, 1e-3, 60.0, 1e9][draw.below(5)];
    let whole = |rows: &mut Vec<Vec<String>>, change: &dyn Fn(&str) -> String| {
        for cell in rows.iter_mut().filter_map(|row| row.get_mut(column)) {
            *cell = change(cell);
        }
    };
    let scaled = |cell: &str| cell.parse::<f64>().map_or(cell.to_owned(), |n| (n * factor).to_string());
    match draw.below(10) {
        0 => whole(&mut rows, &scaled),
        1 => whole(&mut rows, &|_| String::new()),
        2 => rows.iter_mut().for_each(|row| drop((column < row.len()).then(|| row.remove(column)))),
        3 => rows[row].truncate(column),
        4 => rows[row].push("1".to_owned()),
        5 => rows.truncate(row),
        6 => rows[row][column] = "1".repeat(1 << draw.below(18)),
        7 => {
            rows[row][column] =
                ["\"", ";", "\t", "\u{0}", "1,5", "NaN", "-", " ", "é"][draw.below(9)].to_owned()
        }
        _ => rows[row][column] = changed_value(draw, &rows[row][column].clone()),
    }
    rows.iter().map(|row| row.join(separator) + "\n").collect()
}

/// Changes a value, a key or a list of a document.
fn damaged_json(draw: &mut Draw, text: &str) -> String {
    let Ok(mut whole) = serde_json::from_str::<Value>(text) else { return damaged_text(draw, text) };
    let mut all = Vec::new();
    pointers(&whole, "", &mut all);
    // Half of the time near the root, where there is little of everything.
    let near: Vec<&String> = all.iter().filter(|pointer| pointer.matches('/').count() < 4).collect();
    let pick = |draw: &mut Draw| match draw.below(2) {
        0 => near[draw.below(near.len())].clone(),
        _ => all[draw.below(all.len())].clone(),
    };
    let (one, other) = (pick(draw), pick(draw));
    let copy = whole.pointer(&other).cloned().unwrap_or_default();
    let raw = draw.one_of(&STRANGE);
    let mut sentinel = false;
    let Some(node) = whole.pointer_mut(&one) else { return text.to_owned() };
    match (draw.below(8), node) {
        (0, node) => *node = copy,
        (1, Value::Array(list)) => list.truncate(draw.below(list.len())),
        (1, Value::Object(map)) => *map = without(map, draw.below(map.len())),
        (2, Value::Array(list)) if !list.is_empty() => list.push(list[draw.below(list.len())].clone()),
        (2, Value::Object(map)) => drop(map.insert("strange".to_owned(), copy)),
        (3, Value::Array(list)) => list.reverse(),
        (4, node) => *node = (0..1 << draw.below(9)).fold(copy, |inner, _| Value::Array(vec![inner])),
        (_, Value::Number(number)) if draw.below(2) == 0 => {
            let factor = [-1.0, 0.0, 1e-9, 0.5, 3.0, 1e9][draw.below(6)];
            let changed = number.as_f64().unwrap_or_default() * factor;
            *number = serde_json::Number::from_f64(changed).unwrap_or_else(|| 0.into());
        }
        (_, node) => {
            *node = Value::String("@strange@".to_owned());
            sentinel = true;
        }
    }
    let text = whole.to_string();
    if sentinel { text.replacen("\"@strange@\"", raw, 1) } else { text }
}

fn without(map: &Map<String, Value>, index: usize) -> Map<String, Value> {
    let kept = map.iter().enumerate().filter(|(i, _)| *i != index);
    kept.map(|(_, (key, value))| (key.clone(), value.clone())).collect()
}

/// Pointers of all values below `value`.
fn pointers(value: &Value, above: &str, all: &mut Vec<String>) {
    all.push(above.to_owned());
    match value {
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, one)| pointers(one, &format!("{above}/{i}"), all));
        }
        Value::Object(map) => {
            let escaped = |key: &str| key.replace('~', "~0").replace('/', "~1");
            map.iter().for_each(|(key, one)| pointers(one, &format!("{above}/{}", escaped(key)), all));
        }
        _ => {}
    }
}

/// Flips, cuts, blanks or repeats bytes.
pub fn damaged_bytes(draw: &mut Draw, mut bytes: Vec<u8>) -> Vec<u8> {
    // All may have been cut off before.
    if bytes.is_empty() {
        return bytes;
    }
    let at = draw.below(bytes.len());
    let end = (at + 1 + draw.below(64)).min(bytes.len());
    match draw.below(5) {
        0 => bytes.truncate(at),
        1 => bytes[at..end].fill(0),
        2 => bytes[at..end].fill(0xff),
        3 => {
            let part = bytes[at..end].to_vec();
            bytes.splice(at..at, part);
        }
        _ => bytes[at] ^= 1 << draw.below(8),
    }
    bytes
}
