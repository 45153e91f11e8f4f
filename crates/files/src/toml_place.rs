//! Where in a TOML file a key stands, by the spans of its reader.

use std::fs;
use std::ops::Range;
use std::path::Path;

use refusal::{Invalid, PathStep};
use toml::de::{DeArray, DeTable, DeValue};
use toml::{Spanned, Value};

/// Most bytes of a file in which a key is looked for: many times what a hand writes.
const MOST: u64 = 1 << 24;

/// `line 3, column 5` of byte `at`, counted from 1.
pub(crate) fn line_and_column(text: &str, at: usize) -> String {
    let before = text.get(..at).unwrap_or(text);
    let line = before.rsplit('\n').next().unwrap_or_default();
    format!("line {}, column {}", 1 + before.matches('\n').count(), 1 + line.chars().count())
}

/// The innermost key whose name or value is at `span`, and where it begins.
pub(crate) fn key_at(text: &str, span: &Range<usize>) -> Option<(String, usize)> {
    let whole = DeTable::parse(text).ok()?;
    let mut innermost = None;
    within_table(whole.get_ref(), span, &mut innermost);
    innermost
}

/// The part of `text` that the `way` leads to: a value, or its key.
pub(crate) fn span_of(text: &str, way: &[PathStep], is_key: bool) -> Option<Range<usize>> {
    let whole = DeTable::parse(text).ok()?;
    let Some((PathStep::Key(first), rest)) = way.split_first() else { return Some(whole.span()) };
    let (mut key, mut value) = whole.get_ref().get_key_value(first.as_str())?;
    for step in rest {
        match (step, value.get_ref()) {
            (PathStep::Key(name), DeValue::Table(table)) => {
                (key, value) = table.get_key_value(name.as_str())?
            }
            (PathStep::Item(place), DeValue::Array(list)) => value = list.get(*place)?,
            _ => return None,
        }
    }
    Some(if is_key { key.span() } else { value.span() })
}

fn within_table(table: &DeTable<'_>, span: &Range<usize>, innermost: &mut Option<(String, usize)>) {
    let holds = |outer: Range<usize>| outer.start <= span.start && span.end <= outer.end;
    for (key, value) in table {
        if holds(key.span()) || holds(value.span()) {
            *innermost = Some((key.get_ref().to_string(), key.span().start));
        }
        // Tables may go on elsewhere in the file than where they begin.
        within(value.get_ref(), span, innermost);
    }
}

fn within(value: &DeValue<'_>, span: &Range<usize>, innermost: &mut Option<(String, usize)>) {
    match value {
        DeValue::Table(table) => within_table(table, span, innermost),
        DeValue::Array(list) => list.iter().for_each(|item| within(item.get_ref(), span, innermost)),
        _ => {}
    }
}

/// Adds its line and column to what is `invalid` in the hand-written `file`. Nothing is added where they cannot be found, or where
/// the file has another value there: a flag has changed it.
pub(crate) fn placed(file: &Path, mut invalid: Invalid) -> Invalid {
    let names_a_key = invalid.thing.contains('`') && !invalid.found.contains("(line ");
    if file.extension().is_none_or(|end| end != "toml") || !names_a_key {
        return invalid;
    }
    let ordinary = fs::metadata(file).is_ok_and(|file| file.is_file() && file.len() <= MOST);
    let Some(text) = ordinary.then(|| fs::read_to_string(file).ok()).flatten() else { return invalid };
    if let Some(at) = place_of(&text, &invalid.thing, Some(&invalid.found)) {
        invalid.found = format!("{} ({})", invalid.found, line_and_column(&text, at));
    }
    invalid
}

/// Where the key begins that a message calls `thing`: "maneuver `slow`, `feedback.every_s`". If a value is `expected`, it has
/// to be there.
pub(crate) fn place_of(text: &str, thing: &str, expected: Option<&str>) -> Option<usize> {
    let whole = DeTable::parse(text).ok()?;
    let (mut table, mut at) = (whole.get_ref(), None);
    let parts: Vec<&str> = thing.split('`').collect();
    let mut last = None;
    for pair in parts.chunks_exact(2) {
        let (kind, name) = (pair[0].trim().rsplit([' ', '[']).next().unwrap_or_default(), pair[1]);
        if let Some((start, item)) = item(table, kind.trim_end_matches(']'), name) {
            (table, at) = (item, Some(start));
            continue;
        }
        let (start, value) = below(table, name)?;
        (at, last) = (Some(start), Some(value));
        if let DeValue::Table(below) = value {
            table = below;
        }
    }
    match (last, expected) {
        (Some(value), Some(expected)) if !shows(value, expected) => None,
        _ => at,
    }
}

/// The item called `name` of the list of tables `kind` in `table`, or in tables below it.
fn item<'a, 'i>(table: &'a DeTable<'i>, kind: &str, name: &str) -> Option<(usize, &'a DeTable<'i>)> {
    let called = |item: &'a Spanned<DeValue<'i>>| {
        let as_table = item.get_ref().as_table()?;
        let (start, value) = entry(as_table, "name")?;
        (value.as_str() == Some(name)).then_some((start, as_table))
    };
    let list = entry(table, kind).and_then(|(_, list)| list.as_array());
    let listed = list.and_then(|list| list.iter().find_map(called));
    let mut tables = table.values().filter_map(|value| value.get_ref().as_table());
    listed.or_else(|| tables.find_map(|below| item(below, kind, name)))
}

/// The key with its value at the dotted `path`, of which items of lists may be indices or names.
fn below<'a, 'i>(table: &'a DeTable<'i>, path: &str) -> Option<(usize, &'a DeValue<'i>)> {
    if let Some(whole) = entry(table, path) {
        return Some(whole);
    }
    let (first, rest) = path.split_once('.')?;
    match entry(table, first)?.1 {
        DeValue::Table(table) => below(table, rest),
        DeValue::Array(list) => {
            let (place, rest) = rest.split_once('.')?;
            below(of_list(list, place)?, rest)
        }
        _ => None,
    }
}

fn of_list<'a, 'i>(list: &'a DeArray<'i>, place: &str) -> Option<&'a DeTable<'i>> {
    let called =
        |item: &&DeTable<'i>| entry(item, "name").is_some_and(|(_, name)| name.as_str() == Some(place));
    let mut tables = list.iter().filter_map(|item| item.get_ref().as_table());
    tables.clone().find(called).or_else(|| tables.nth(place.parse().ok()?))
}

fn entry<'a, 'i>(table: &'a DeTable<'i>, key: &str) -> Option<(usize, &'a DeValue<'i>)> {
    let (key, value) = table.iter().find(|(name, _)| name.get_ref() == key)?;
    Some((key.span().start, value.get_ref()))
}

/// Whether the value `expected` is that of the file; anything is of tables and lists.
fn shows(value: &DeValue<'_>, expected: &str) -> bool {
    let plain = expected.trim_matches('`');
    // Behind the number may be a unit.
    let first = plain.split(' ').next().unwrap_or_default();
    let number = |text: &str| {
        text.replace('_', "").parse::<Value>().ok().and_then(|value| match value {
            Value::Integer(n) => Some(n as f64),
            Value::Float(x) => Some(x),
            _ => None,
        })
    };
    match value {
        DeValue::String(text) => plain.contains(text.as_ref()),
        DeValue::Integer(n) => number(n.as_str()).is_none_or(|number| first.parse() == Ok(number)),
        DeValue::Float(x) => number(x.as_str()).is_none_or(|number| first.parse() == Ok(number)),
        DeValue::Boolean(flag) => plain.contains(if *flag { "true" } else { "false" }),
        DeValue::Datetime(_) | DeValue::Array(_) | DeValue::Table(_) => true,
    }
}
