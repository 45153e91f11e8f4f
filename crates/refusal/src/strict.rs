//! Strict reading of files that people write: refuses what serde accepts in data between programs.

use std::collections::BTreeSet;
use std::fmt;

use serde::de::{
    Deserialize, DeserializeSeed, Deserializer, EnumAccess, Error, IgnoredAny, MapAccess, SeqAccess,
    Unexpected, VariantAccess, Visitor,
};

/// A deserializer, or one nested in it, that is read [`strictly`].
struct Strict<'a, D> {
    inner: D,
    /// The keys so far, where a key is read.
    keys: Option<&'a mut BTreeSet<String>>,
}

fn strict<'a, D>(inner: D) -> Strict<'a, D> {
    Strict { inner, keys: None }
}

/// Reads `T` from `deserializer`. A list in place of a table is refused, because its values would be identified by position
/// alone; so are a key that occurs twice, because the first value would be lost, and surplus values of a list.
///
/// # Errors
/// These, and those of `T`.
pub fn strictly<'de, T: Deserialize<'de>, D: Deserializer<'de>>(deserializer: D) -> Result<T, D::Error> {
    T::deserialize(strict(deserializer))
}

/// A visitor; `keyed` where only a table is accepted.
struct Taking<'a, V> {
    visitor: V,
    keyed: bool,
    keys: Option<&'a mut BTreeSet<String>>,
}

fn taking<'a, V>(visitor: V, keyed: bool) -> Taking<'a, V> {
    Taking { visitor, keyed, keys: None }
}

/// Refuses a `key` that occurred before.
fn once<E: Error>(keys: Option<&mut BTreeSet<String>>, key: &str) -> Result<(), E> {
    match keys.is_none_or(|known| known.insert(key.to_owned())) {
        true => Ok(()),
        false => Err(E::custom(format_args!("key `{key}` twice, expected every key once"))),
    }
}

macro_rules! hand_on {
    ($($method:ident($($name:ident: $Type:ty),*);)+) => {
        $(fn $method<V: Visitor<'de>>(self, $($name: $Type,)* visitor: V) -> Result<V::Value, D::Error> {
            self.inner.$method($($name,)* Taking { visitor, keyed: false, keys: self.keys })
        })+
    };
}

impl<'de, D: Deserializer<'de>> Deserializer<'de> for Strict<'_, D> {
    type Error = D::Error;

    hand_on! {
        deserialize_any();
        deserialize_option();
        deserialize_newtype_struct(name: &'static str);
        deserialize_enum(name: &'static str, variants: &'static [&'static str]);
    }

    // TOML and JSON are self-describing.
    serde::forward_to_deserialize_any! {
        bool i8 i16 i32 i64 i128 u8 u16 u32 u64 u128 f32 f64 char str string bytes byte_buf
        unit unit_struct seq tuple tuple_struct map identifier ignored_any
    }

    fn deserialize_struct<V: Visitor<'de>>(
        self,
        name: &'static str,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, D::Error> {
        self.inner.deserialize_struct(name, fields, taking(visitor, true))
    }

    fn is_human_readable(&self) -> bool {
        self.inner.is_human_readable()
    }
}

macro_rules! take {
    ($($method:ident($Type:ty)$(, if $unlike:ident)?;)+) => {
        $(fn $method<E: Error>(self, value: $Type) -> Result<V::Value, E> {
            $($unlike(self.keys, value.as_ref())?;)?
            self.visitor.$method(value)
        })+
    };
}

impl<'de, V: Visitor<'de>> Visitor<'de> for Taking<'_, V> {
    type Value = V::Value;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        self.visitor.expecting(f)
    }

    take! {
        visit_bool(bool);
        visit_i64(i64);
        visit_i128(i128);
        visit_u64(u64);
        visit_u128(u128);
        visit_f64(f64);
        visit_char(char);
        visit_bytes(&[u8]);
        visit_borrowed_bytes(&'de [u8]);
        visit_byte_buf(Vec<u8>);
        visit_str(&str), if once;
        visit_borrowed_str(&'de str), if once;
        visit_string(String), if once;
    }

    fn visit_none<E: Error>(self) -> Result<V::Value, E> {
        self.visitor.visit_none()
    }

    fn visit_unit<E: Error>(self) -> Result<V::Value, E> {
        self.visitor.visit_unit()
    }

    fn visit_some<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_some(strict(deserializer))
    }

    fn visit_newtype_struct<D: Deserializer<'de>>(self, deserializer: D) -> Result<V::Value, D::Error> {
        self.visitor.visit_newtype_struct(strict(deserializer))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut items: A) -> Result<V::Value, A::Error> {
        // An internally tagged enum is read by `deserialize_any`; serde mentions it in the expectation.
        let expecting = (&self.visitor as &dyn serde::de::Expected).to_string();
        if self.keyed || expecting.starts_with("internally tagged enum") {
            return Err(A::Error::invalid_type(Unexpected::Other("a list"), &"keys with values"));
        }
        let value = self.visitor.visit_seq(strict(&mut items))?;
        match items.next_element::<IgnoredAny>()? {
            None => Ok(value),
            Some(_) => Err(A::Error::custom(format_args!("a value too many, expected {expecting}"))),
        }
    }

    fn visit_map<A: MapAccess<'de>>(self, entries: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_map(Entries { entries, known: BTreeSet::new() })
    }

    fn visit_enum<A: EnumAccess<'de>>(self, data: A) -> Result<V::Value, A::Error> {
        self.visitor.visit_enum(strict(data))
    }
}

impl<'de, A: SeqAccess<'de>> SeqAccess<'de> for Strict<'_, A> {
    type Error = A::Error;

    fn next_element_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<Option<T::Value>, A::Error> {
        self.inner.next_element_seed(strict(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.inner.size_hint()
    }
}

impl<'de, T: DeserializeSeed<'de>> DeserializeSeed<'de> for Strict<'_, T> {
    type Value = T::Value;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<T::Value, D::Error> {
        self.inner.deserialize(Strict { inner: deserializer, keys: self.keys })
    }
}

/// The entries of a map, each key once.
struct Entries<A> {
    entries: A,
    known: BTreeSet<String>,
}

impl<'de, A: MapAccess<'de>> MapAccess<'de> for Entries<A> {
    type Error = A::Error;

    fn next_key_seed<K: DeserializeSeed<'de>>(&mut self, seed: K) -> Result<Option<K::Value>, A::Error> {
        self.entries.next_key_seed(Strict { inner: seed, keys: Some(&mut self.known) })
    }

    fn next_value_seed<T: DeserializeSeed<'de>>(&mut self, seed: T) -> Result<T::Value, A::Error> {
        self.entries.next_value_seed(strict(seed))
    }

    fn size_hint(&self) -> Option<usize> {
        self.entries.size_hint()
    }
}

impl<'de, A: EnumAccess<'de>> EnumAccess<'de> for Strict<'_, A> {
    type Error = A::Error;
    type Variant = Strict<'static, A::Variant>;

    fn variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<(T::Value, Self::Variant), A::Error> {
        self.inner.variant_seed(seed).map(|(value, variant)| (value, strict(variant)))
    }
}

impl<'de, A: VariantAccess<'de>> VariantAccess<'de> for Strict<'_, A> {
    type Error = A::Error;

    fn unit_variant(self) -> Result<(), A::Error> {
        self.inner.unit_variant()
    }

    fn newtype_variant_seed<T: DeserializeSeed<'de>>(self, seed: T) -> Result<T::Value, A::Error> {
        self.inner.newtype_variant_seed(strict(seed))
    }

    fn tuple_variant<V: Visitor<'de>>(self, length: usize, visitor: V) -> Result<V::Value, A::Error> {
        self.inner.tuple_variant(length, taking(visitor, false))
    }

    fn struct_variant<V: Visitor<'de>>(
        self,
        fields: &'static [&'static str],
        visitor: V,
    ) -> Result<V::Value, A::Error> {
        self.inner.struct_variant(fields, taking(visitor, true))
    }
}
