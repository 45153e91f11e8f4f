//! Binary messages. Common Data Representation, version 1, as ROS 2 writes it (OMG, Data Distribution Service
//! Interoperability Wire Protocol): consecutive values, each aligned to its size, after four bytes that state the
//! byte order. Or packed as ROS 1 and ULog have them: without either, least significant byte first.

use std::collections::{BTreeMap, BTreeSet};

use super::Effort;
use super::definition::{PathStep, Primitive, Shape, Wrong};

/// Bytes of a message, and the read position.
pub(crate) struct Cursor<'a> {
    /// The bytes after the first four.
    data: &'a [u8],
    at: usize,
    is_little: bool,
    is_aligned: bool,
    effort: &'a Effort,
}

impl<'a> Cursor<'a> {
    /// At the first value of a message in CDR.
    pub(crate) fn cdr(message: &'a [u8], effort: &'a Effort) -> Result<Self, Wrong> {
        match message.split_at_checked(4) {
            Some(([0, order @ (0 | 1), ..], data)) => {
                Ok(Self { data, at: 0, is_little: *order == 1, is_aligned: true, effort })
            }
            Some((head, _)) => {
                let representation =
                    format!("the representation {:#06x}", u16::from_be_bytes([head[0], head[1]]));
                Err((representation, "plain CDR, 0x0000 or 0x0001".to_owned()))
            }
            None => Err((format!("{} bytes", message.len()), "at least 4".to_owned())),
        }
    }

    /// At the first value of a packed message.
    pub(crate) fn packed(data: &'a [u8], effort: &'a Effort) -> Self {
        Self { data, at: 0, is_little: true, is_aligned: false, effort }
    }

    /// The next `N` bytes, in CDR aligned to `N`, least significant first.
    fn take<const N: usize>(&mut self) -> Option<[u8; N]> {
        if self.is_aligned {
            self.at = self.at.next_multiple_of(N);
        }
        let mut bytes: [u8; N] = self.data.get(self.at..self.at + N)?.try_into().ok()?;
        self.at += N;
        if !self.is_little {
            bytes.reverse();
        }
        Some(bytes)
    }

    fn number(&mut self, kind: Primitive) -> Option<f64> {
        Some(match kind {
            Primitive::U8 => f64::from(u8::from_le_bytes(self.take()?)),
            Primitive::I8 => f64::from(i8::from_le_bytes(self.take()?)),
            Primitive::U16 => f64::from(u16::from_le_bytes(self.take()?)),
            Primitive::I16 => f64::from(i16::from_le_bytes(self.take()?)),
            Primitive::U32 => f64::from(u32::from_le_bytes(self.take()?)),
            Primitive::I32 => f64::from(i32::from_le_bytes(self.take()?)),
            Primitive::U64 => u64::from_le_bytes(self.take()?) as f64,
            Primitive::I64 => i64::from_le_bytes(self.take()?) as f64,
            Primitive::F32 => f64::from(f32::from_le_bytes(self.take()?)),
            Primitive::F64 => f64::from_le_bytes(self.take()?),
        })
    }

    fn length(&mut self) -> Option<usize> {
        usize::try_from(u32::from_le_bytes(self.take()?)).ok()
    }

    fn skip(&mut self, bytes: usize) -> Option<()> {
        self.at = self.at.checked_add(bytes).filter(|at| *at <= self.data.len())?;
        Some(())
    }
}

/// A shape, and where its wanted numbers go.
pub(crate) struct Node {
    kind: ValueKind,
    /// Indices in the row.
    slots: Vec<usize>,
}

enum ValueKind {
    Number(Primitive),
    Text,
    Padding(usize),
    Fields(Vec<Node>),
    List {
        of: Box<Node>,
        len: Option<usize>,
        /// Elements with wanted numbers.
        wanted: BTreeMap<usize, Node>,
    },
}

impl Node {
    /// Numbers of `shape` at the `wanted` paths, each with its index in the row.
    pub(crate) fn new(shape: &Shape, wanted: &[(usize, &[PathStep])]) -> Result<Self, usize> {
        let ends: Vec<usize> =
            wanted.iter().filter(|(_, path)| path.is_empty()).map(|(slot, _)| *slot).collect();
        let is_number = matches!(shape, Shape::Number(_));
        if let Some((slot, _)) = wanted.iter().find(|(_, path)| path.is_empty() != is_number) {
            return Err(*slot);
        }
        let kind = match shape {
            Shape::Number(kind) => ValueKind::Number(*kind),
            Shape::Text => wanted.first().map_or(Ok(ValueKind::Text), |(slot, _)| Err(*slot))?,
            Shape::Padding(bytes) => {
                wanted.first().map_or(Ok(ValueKind::Padding(*bytes)), |(slot, _)| Err(*slot))?
            }
            Shape::Fields(fields) => {
                let known: BTreeSet<&str> = fields.iter().map(|(name, _)| name.as_str()).collect();
                let mut below: BTreeMap<&str, Vec<(usize, &[PathStep])>> = BTreeMap::new();
                for (slot, path) in wanted {
                    match &path[0] {
                        PathStep::Name(name) if known.contains(name.as_str()) => {
                            below.entry(name).or_default().push((*slot, &path[1..]));
                        }
                        _ => return Err(*slot),
                    }
                }
                let of = |name: &str| below.get(name).map_or(&[][..], Vec::as_slice);
                let node = |(name, shape): &(String, Shape)| Self::new(shape, of(name));
                ValueKind::Fields(fields.iter().map(node).collect::<Result<_, _>>()?)
            }
            Shape::List(of, len) => {
                let mut below: BTreeMap<usize, Vec<(usize, &[PathStep])>> = BTreeMap::new();
                for (slot, path) in wanted {
                    match path[0] {
                        PathStep::Index(i) if len.is_none_or(|len| i < len) => {
                            below.entry(i).or_default().push((*slot, &path[1..]));
                        }
                        _ => return Err(*slot),
                    }
                }
                let node = |(i, wanted): (usize, Vec<_>)| Self::new(of, &wanted).map(|node| (i, node));
                let elements = below.into_iter().map(node).collect::<Result<_, _>>()?;
                ValueKind::List { of: Box::new(Self::new(of, &[])?), len: *len, wanted: elements }
            }
        };
        Ok(Self { kind, slots: ends })
    }

    /// Reads the next value and puts the wanted numbers into `row`; `None` where the message ends early, or where it has
    /// more elements without bytes than are paid for.
    pub(crate) fn read(&self, cursor: &mut Cursor, row: &mut [f64]) -> Option<()> {
        let start = cursor.at;
        match &self.kind {
            ValueKind::Number(kind) => {
                let value = cursor.number(*kind)?;
                self.slots.iter().for_each(|slot| row[*slot] = value);
            }
            ValueKind::Text => {
                let length = cursor.length()?;
                cursor.skip(length)?;
            }
            ValueKind::Padding(bytes) => {
                cursor.skip((*bytes).min(cursor.data.len().saturating_sub(cursor.at)))?
            }
            // In CDR a message without fields still has one byte.
            ValueKind::Fields(fields) if fields.is_empty() => cursor.skip(usize::from(cursor.is_aligned))?,
            ValueKind::Fields(fields) => fields.iter().try_for_each(|field| field.read(cursor, row))?,
            ValueKind::List { of, len, wanted } => {
                let len = len.map_or_else(|| cursor.length(), Some)?;
                (0..len).try_for_each(|i| wanted.get(&i).unwrap_or(of).read(cursor, row))?;
            }
        }
        // What takes bytes ends with the message.
        if cursor.at == start { cursor.effort.step() } else { Some(()) }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::bag::definition::{Dialect, definition, steps};

    /// `uint8 a = 7`, `string s = "hi"`, `float64[] w = [1.5, -2]`, `int16 b = -3`, `float32 c = 0.25` as fastcdr writes them.
    fn message(is_little: bool) -> Vec<u8> {
        let order = |mut bytes: Vec<u8>| {
            if !is_little {
                bytes.reverse();
            }
            bytes
        };
        let mut data = vec![0, u8::from(is_little), 0, 0, 7, 0, 0, 0];
        data.extend(order(3_u32.to_le_bytes().to_vec()));
        data.extend(b"hi\0\0");
        data.extend(order(2_u32.to_le_bytes().to_vec()));
        for value in [1.5_f64, -2.0] {
            data.extend(order(value.to_le_bytes().to_vec()));
        }
        data.extend(order((-3_i16).to_le_bytes().to_vec()));
        data.extend([0, 0]);
        data.extend(order(0.25_f32.to_le_bytes().to_vec()));
        data
    }

    #[test]
    fn values_are_aligned_to_their_size_in_either_order_of_bytes() {
        let shape = definition(
            "a/A",
            "uint8 a\nstring s\nfloat64[] w\nint16 b\nfloat32 c\n",
            Dialect::Ros2,
            &Effort::new(0.0),
        )
        .unwrap();
        let paths = ["a", "w[1]", "b", "c", "w[5]"].map(|path| steps(path).unwrap());
        let wanted: Vec<(usize, &[PathStep])> = paths.iter().map(Vec::as_slice).enumerate().collect();
        let node = Node::new(&shape, &wanted).unwrap();
        let effort = Effort::new(0.0);
        for is_little in [true, false] {
            let data = message(is_little);
            let mut row = [f64::NAN; 5];
            node.read(&mut Cursor::cdr(&data, &effort).unwrap(), &mut row).unwrap();
            assert_eq!(row[..4], [7.0, -2.0, -3.0, 0.25]);
            assert!(row[4].is_nan(), "there are two weights");
            let short = &data[..data.len() - 1];
            assert_eq!(node.read(&mut Cursor::cdr(short, &effort).unwrap(), &mut row), None);
        }
        for path in ["s", "d", "w", "a.x", "a[0]"] {
            let path = steps(path).unwrap();
            assert!(Node::new(&shape, &[(3, &path)]).is_err_and(|slot| slot == 3), "{path:?}");
        }
    }
}
