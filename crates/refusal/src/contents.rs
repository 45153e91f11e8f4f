//! Strict reading of files that people write: refuses what serde accepts in data between programs.
//!
//! A file is read into [`Contents`] first, whatever its syntax, and then into the type that is wanted. So each type is
//! compiled for one reader, and a fault has the way to it, step by step ([`PathStep`]).

use std::collections::BTreeSet;
use std::convert::Infallible;
use std::fmt::{self, Display};

use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error, Expected, IntoDeserializer, MapAccess,
    SeqAccess, Unexpected, VariantAccess, Visitor,
};

use crate::Invalid;

/// What a file holds, keys in its order.
#[derive(Clone, Debug, PartialEq)]
pub enum Contents {
    /// Nothing: JSON's null.
    Nothing,
    /// True or false.
    Truth(bool),
    /// A whole number below zero, or one of TOML.
    Signed(i64),
    /// A whole number.
    Whole(u64),
    /// Another number, finite or not.
    Real(f64),
    /// A text.
    Text(String),
    /// A list.
    List(Vec<Contents>),
    /// Keys with their values, each key once.
    Table(Vec<(String, Contents)>),
}

/// A step on the way to a value.
#[derive(Clone, Debug, PartialEq, Eq)]
pub enum PathStep {
    /// To the value of a key.
    Key(String),
    /// To an item of a list, from 0.
    Item(usize),
}

/// Why [`Contents`] are not of a type, and where.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Unreadable {
    /// In serde's words.
    pub message: String,
    /// The way from the outermost value.
    pub way: Vec<PathStep>,
    /// Whether the place is that of the last key, not of its value.
    pub is_key: bool,
    /// The refusal, if a number is outside of its bounds.
    pub invalid: Option<Box<Invalid>>,
}

impl Unreadable {
    fn below(mut self, step: PathStep) -> Self {
        self.way.insert(0, step);
        self
    }
}

impl Display for Unreadable {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(&self.message)
    }
}

impl std::error::Error for Unreadable {}

impl Error for Unreadable {
    fn custom<T: Display>(message: T) -> Self {
        Self { message: message.to_string(), way: Vec::new(), is_key: false, invalid: None }
    }

    fn invalid_type(found: Unexpected, expected: &dyn Expected) -> Self {
        match found {
            Unexpected::Unit => Self::custom(format_args!("invalid type: null, expected {expected}")),
            found => Self::custom(format_args!("invalid type: {found}, expected {expected}")),
        }
    }
}

macro_rules! is {
    ($($method:ident($($value:ident: $type:ty)?) $contents:expr;)+) => {
        $(fn $method<E: Error>(self, $($value: $type)?) -> Result<Contents, E> {
            Ok($contents)
        })+
    };
}

struct Reading;

impl<'de> Visitor<'de> for Reading {
    type Value = Contents;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        f.write_str("a value")
    }

    is! {
        visit_bool(value: bool) Contents::Truth(value);
        visit_i64(value: i64) Contents::Signed(value);
        visit_u64(value: u64) Contents::Whole(value);
        visit_f64(value: f64) Contents::Real(value);
        visit_str(value: &str) Contents::Text(value.to_owned());
        visit_string(value: String) Contents::Text(value);
        visit_unit() Contents::Nothing;
        visit_none() Contents::Nothing;
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<Contents, D::Error> {
        Contents::deserialize(deserializer)
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Contents, A::Error> {
        let mut items = Vec::new();
        while let Some(item) = list.next_element()? {
            items.push(item);
        }
        Ok(Contents::List(items))
    }

    fn visit_map<A: MapAccess<'de>>(self, mut table: A) -> Result<Contents, A::Error> {
        let mut entries: Vec<(String, Contents)> = Vec::new();
        let mut known = BTreeSet::new();
        while let Some(key) = table.next_key::<String>()? {
            if !known.insert(key.clone()) {
                return Err(A::Error::custom(format_args!("key `{key}` twice, expected every key once")));
            }
            entries.push((key, table.next_value()?));
        }
        Ok(Contents::Table(entries))
    }
}

impl<'de> Deserialize<'de> for Contents {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        deserializer.deserialize_any(Reading)
    }
}

impl<'de> Deserializer<'de> for &Contents {
    type Error = Unreadable;

    fn deserialize_any<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        match self {
            Contents::Nothing => visitor.visit_unit(),
            Contents::Truth(value) => visitor.visit_bool(*value),
            Contents::Signed(value) => visitor.visit_i64(*value),
            Contents::Whole(value) => visitor.visit_u64(*value),
            Contents::Real(value) => visitor.visit_f64(*value),
            Contents::Text(value) => visitor.visit_str(value),
            Contents::Table(entries) => visitor.visit_map(Unread { all: entries, read: 0 }),
            Contents::List(items) => {
                // An internally tagged enum is read as anything; serde mentions it in the expectation.
                let expecting = (&visitor as &dyn Expected).to_string();
                if expecting.starts_with("internally tagged enum") {
                    return Err(not_a_table());
                }
                let mut unread = Unread { all: items, read: 0 };
                let value = visitor.visit_seq(&mut unread)?;
                match unread.read < items.len() {
                    true => Err(Error::custom(format_args!("a value too many, expected {expecting}"))),
                    false => Ok(value),
                }
            }
        }
    }

    fn deserialize_option<V: Visitor<'de>>(self, visitor: V) -> Result<V::Value, Unreadable> {
        match self {
            Contents::Nothing => visitor.visit_none(),
            _ => visitor.visit_some(self),
        }
    }

    fn deserialize_newtype_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        visitor.visit_newtype_struct(self)
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        _: &'static str,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        if matches!(self, Contents::List(_)) { Err(not_a_table()) } else { self.deserialize_any(visitor) }
    }

    fn deserialize_enum<V: Visitor<'de>>(
        self,
        _: &'static str,
        variants: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        let (name, value) = match self {
            Contents::Text(name) => (name, None),
            Contents::Table(entries) if entries.len() == 1 => (&entries[0].0, Some(&entries[0].1)),
            _ => {
                let Err(error) = self.deserialize_any(OneOf(variants));
                return Err(error);
            }
        };
        visitor.visit_enum(Variant { name, value })
    }

    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct seq tuple tuple_struct map identifier ignored_any
    }
}

/// Expects one of these names, and takes nothing.
struct OneOf(&'static [&'static str]);

impl Visitor<'_> for OneOf {
    type Value = Infallible;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "one of `{}`", self.0.join("`, `"))
    }
}

fn not_a_table() -> Unreadable {
    Error::invalid_type(Unexpected::Other("a list"), &"keys with values")
}

/// The items of a list or the entries of a table, of which so many were read.
struct Unread<'a, T> {
    all: &'a [T],
    read: usize,
}

impl<'de> SeqAccess<'de> for Unread<'_, Contents> {
    type Error = Unreadable;

    fn next_element_seed<T: DeserializeSeed<'de>>(
        &mut self,
        seed: T,
    ) -> Result<Option<T::Value>, Unreadable> {
        let Some(item) = self.all.get(self.read) else { return Ok(None) };
        let place = self.read;
        self.read += 1;
        seed.deserialize(item).map(Some).map_err(|error| error.below(PathStep::Item(place)))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.all.len() - self.read)
    }
}

impl<'de> MapAccess<'de> for Unread<'_, (String, Contents)> {
    type Error = Unreadable;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, Unreadable> {
        let Some((key, _)) = self.all.get(self.read) else { return Ok(None) };
        let wrong =
            |error: Unreadable| Unreadable { is_key: true, ..error.below(PathStep::Key(key.clone())) };
        seed.deserialize(key.as_str().into_deserializer()).map(Some).map_err(wrong)
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, Unreadable> {
        let (key, value) = &self.all[self.read];
        self.read += 1;
        seed.deserialize(value).map_err(|error| error.below(PathStep::Key(key.clone())))
    }

    fn size_hint(&self) -> Option<usize> {
        Some(self.all.len() - self.read)
    }
}

struct Variant<'a> {
    name: &'a str,
    value: Option<&'a Contents>,
}

impl<'de> EnumAccess<'de> for Variant<'_> {
    type Error = Unreadable;
    type Variant = Self;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self), Unreadable> {
        seed.deserialize(self.name.into_deserializer()).map(|value| (value, self))
    }
}

impl<'de> VariantAccess<'de> for Variant<'_> {
    type Error = Unreadable;

    fn unit_variant(self) -> Result<(), Unreadable> {
        self.value.map_or(Ok(()), <()>::deserialize)
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, Unreadable> {
        seed.deserialize(self.value.unwrap_or(&Contents::Nothing))
    }

    fn tuple_variant<V: Visitor<'de>>(self, _: usize, visitor: V) -> Result<V::Value, Unreadable> {
        self.value.unwrap_or(&Contents::Nothing).deserialize_any(visitor)
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        _: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, Unreadable> {
        self.value.unwrap_or(&Contents::Nothing).deserialize_struct("", &[], visitor)
    }
}
