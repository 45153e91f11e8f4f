//! Values that replace those of a hand-written file.

use std::fmt;
use std::str::FromStr;

use refusal::Invalid;
use toml::{Table, Value};

use crate::error::Result;

/// A replacement for a value in a hand-written file: `campaign.realizations=100`.
#[derive(Clone, Debug, PartialEq)]
pub struct Change {
    file: String,
    keys: Vec<String>,
    value: Value,
}

/// Replacements for values in a study's hand-written files, each at most once.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Changes(Vec<Change>);

impl Change {
    /// Replaces the value at the dotted `key`, which begins with the file's usual name without `.toml`.
    ///
    /// # Errors
    /// A malformed key, or one that names only the file.
    pub fn new(key: &str, value: Value) -> Result<Self, Invalid> {
        let mut keys = dotted(key).unwrap_or_default().into_iter();
        let (file, keys) = (keys.next().unwrap_or_default(), keys.collect::<Vec<_>>());
        if keys.is_empty() {
            let expected =
                "a file's usual name without `.toml` and a key in it, such as campaign.current.std_m_s";
            let remedy = "correct it, with quotes around a part that is no plain word";
            return Err(Invalid::new("key", format!("`{key}`"), expected, remedy));
        }
        Ok(Self { file, keys, value })
    }

    /// Usual name, without `.toml`, of its file.
    pub fn file(&self) -> &str {
        &self.file
    }

    /// The dotted key, with the file.
    pub fn key(&self) -> String {
        let plain = |key: &String| key.chars().all(|c| c.is_ascii_alphanumeric() || matches!(c, '_' | '-'));
        let written =
            |key: &String| if plain(key) { key.clone() } else { Value::from(key.as_str()).to_string() };
        std::iter::once(&self.file).chain(&self.keys).map(written).collect::<Vec<_>>().join(".")
    }

    /// The value.
    pub fn value(&self) -> &Value {
        &self.value
    }

    /// Applies the replacement to `file`. A missing table is created; an item of a list is identified by its
    /// `name` or its index from 0.
    fn apply(&self, file: &mut Table) -> Result<(), Invalid> {
        let mut whole = Value::Table(std::mem::take(file));
        let mut place = Ok(&mut whole);
        for key in &self.keys {
            place = place.and_then(|value| self.below(value, key));
        }
        let placed = place.map(|place| *place = self.value.clone());
        if let Value::Table(changed) = whole {
            *file = changed;
        }
        placed
    }

    /// The value at `key` in `value`.
    fn below<'a>(&self, value: &'a mut Value, key: &str) -> Result<&'a mut Value, Invalid> {
        let thing = format!("`{}`", self.key());
        match value {
            Value::Table(table) => Ok(table.entry(key).or_insert_with(|| Table::new().into())),
            Value::Array(list) => {
                let names: Vec<String> = list.iter().enumerate().map(|(i, item)| name(i, item)).collect();
                let place = names.iter().position(|name| name == key).or_else(|| key.parse().ok());
                let unknown = || Invalid::unknown(thing, key, names.iter().map(String::as_str));
                place.and_then(|place| list.get_mut(place)).ok_or_else(unknown)
            }
            other => {
                let (found, remedy) = (format!("`{key}` below {other}"), "name the key of the value itself");
                Err(Invalid::new(thing, found, "keys below a table or a list", remedy))
            }
        }
    }
}

/// The identification of an item of a list: its `name`, or its index.
fn name(place: usize, item: &Value) -> String {
    let own = item.get("name").and_then(Value::as_str);
    own.map_or_else(|| place.to_string(), str::to_owned)
}

/// The parts of a dotted key, as TOML reads them.
fn dotted(key: &str) -> Option<Vec<String>> {
    let mut table: Table = toml::from_str(&format!("{key} = 0")).ok()?;
    let mut keys = Vec::new();
    loop {
        let mut entries = std::mem::take(&mut table).into_iter();
        let ((key, value), None) = (entries.next()?, entries.next()) else { return None };
        keys.push(key);
        match value {
            Value::Table(below) => table = below,
            _ => return Some(keys),
        }
    }
}

/// `text` as a TOML value; as a string if it is not one.
fn value_of(text: &str) -> Value {
    let mut table: Table = toml::from_str(&format!("value = {text}")).unwrap_or_default();
    let value = table.remove("value").filter(|_| table.is_empty());
    value.unwrap_or_else(|| text.into())
}

impl FromStr for Change {
    type Err = Invalid;

    fn from_str(text: &str) -> Result<Self, Invalid> {
        match text.split_once('=') {
            Some((key, value)) => Self::new(key, value_of(value)),
            None => Err(Invalid::new("change", format!("`{text}`"), "FILE.KEY=VALUE", "add = and a value")),
        }
    }
}

/// As on the command line.
impl fmt::Display for Change {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}={}", self.key(), self.value)
    }
}

impl Changes {
    /// All of `changes`.
    ///
    /// # Errors
    /// A key that two of them have.
    pub fn new(changes: Vec<Change>) -> Result<Self, Invalid> {
        let twice = changes.iter().enumerate().find(|(i, change)| {
            changes[..*i].iter().any(|other| other.file == change.file && other.keys == change.keys)
        });
        match twice {
            Some((_, change)) => {
                Err(Invalid::new(format!("`{}`", change.key()), "it twice", "every key once", "remove one"))
            }
            None => Ok(Self(changes)),
        }
    }

    /// Those of `file`, a usual name without `.toml`.
    pub fn of<'a>(&'a self, file: &'a str) -> impl Iterator<Item = &'a Change> {
        self.0.iter().filter(move |change| change.file == file)
    }

    /// All of them.
    pub fn iter(&self) -> impl Iterator<Item = &Change> {
        self.0.iter()
    }

    /// `text`, which is the TOML of `file`, with the replacements applied.
    ///
    /// # Errors
    /// Text that is not TOML; a change within a value that is neither table nor list.
    pub(crate) fn applied(&self, file: &str, text: &str) -> Result<String, Invalid> {
        let mut table: Table = toml::from_str(text).map_err(|e| {
            Invalid::new("text", e.message(), "TOML with numbers of 64 bits and a sign", "correct it")
        })?;
        self.of(file).try_for_each(|change| change.apply(&mut table))?;
        Ok(table.to_string())
    }

    /// The replacements for `file`, as a list in words.
    pub(crate) fn in_words(&self, file: &str) -> String {
        self.of(file).map(Change::to_string).collect::<Vec<_>>().join(", ")
    }
}
