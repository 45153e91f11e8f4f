//! Vector and feature records of a file.

use std::collections::BTreeMap;

use crate::enc::Invalid;
use crate::enc::cursor::{Cursor, Lexical};
use crate::enc::iso8211::Record;

/// Kind and number of a vector record.
pub(crate) type Name = (u8, u32);
/// Vector records: isolated node, connected node, edge.
pub(crate) const ISOLATED: u8 = 110;
pub(crate) const CONNECTED: u8 = 120;
pub(crate) const EDGE: u8 = 130;
/// Feature records.
const FEATURE: u8 = 100;

/// An update's instruction for a record, or for a part of its list.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Instruction {
    Insert,
    Delete,
    Modify,
}

/// The part of a list that an update changes.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Splice {
    pub instruction: Instruction,
    /// The first place, from 1.
    pub index: usize,
    pub count: usize,
}

/// From a feature to a vector record, or from an edge to its ends.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Pointer {
    pub name: Name,
    /// Along the edge (1), against it (2), or neither (255).
    pub orientation: u8,
    /// Outside (1), inside (2), outside along the limit of the data (3).
    pub usage: u8,
    /// Beginning (1) or end (2) of an edge; 0 from features.
    pub topology: u8,
}

/// A list, and the part of the previous list that it replaces; all of it without a splice.
#[derive(Clone, Debug)]
pub(crate) struct Part<T> {
    pub splice: Option<Splice>,
    pub items: Vec<T>,
}

/// Attributes by code, as text.
pub(crate) type Attributes = BTreeMap<u16, String>;

/// A node or an edge.
#[derive(Clone, Debug)]
pub(crate) struct Vector {
    pub name: Name,
    pub version: u16,
    pub instruction: Instruction,
    pub attributes: Attributes,
    pub ends: Part<Pointer>,
    /// Latitude, longitude, depth, in the cell's units.
    pub points: Part<[i32; 3]>,
}

/// An object.
#[derive(Clone, Debug)]
pub(crate) struct Object {
    pub number: u32,
    pub version: u16,
    pub instruction: Instruction,
    /// Point (1), line (2), area (3), or none (255).
    pub primitive: u8,
    pub class: u16,
    /// Producer, number, subdivision: the same in all updates and editions.
    pub id: (u16, u32, u16),
    pub attributes: Attributes,
    pub pointers: Part<Pointer>,
}

impl Vector {
    /// `None` for a record of another kind.
    pub(crate) fn read(record: &Record<'_>) -> Result<Option<Self>, Invalid> {
        let Some(mut own) = Cursor::of(record, "VRID") else { return Ok(None) };
        let name = (own.u8()?, own.u32()?);
        let (version, code) = (own.u16()?, own.u8()?);
        if ![ISOLATED, CONNECTED, EDGE].contains(&name.0) {
            let expected = "nodes (110, 120) and edges (130), as in every ENC";
            return Err(refuse(record, format!("a vector record of kind {}", name.0), expected));
        }
        let mut points = pairs(record, "SG2D", |c| Ok([c.i32()?, c.i32()?, 0]))?;
        points.extend(pairs(record, "SG3D", |c| Ok([c.i32()?, c.i32()?, c.i32()?]))?);
        Ok(Some(Self {
            name,
            version,
            instruction: instruction(record, code)?,
            attributes: attributes(record, "ATTV", Lexical::Latin)?,
            ends: Part {
                splice: splice(record, "VRPC")?,
                items: pairs(record, "VRPT", |c| pointer(c, true))?,
            },
            points: Part { splice: splice(record, "SGCC")?, items: points },
        }))
    }
}

impl Object {
    /// `None` for a record of another kind.
    pub(crate) fn read(record: &Record<'_>, national: Lexical) -> Result<Option<Self>, Invalid> {
        let Some(mut own) = Cursor::of(record, "FRID") else { return Ok(None) };
        let (kind, number) = (own.u8()?, own.u32()?);
        let (primitive, _group) = (own.u8()?, own.u8()?);
        let (class, version, code) = (own.u16()?, own.u16()?, own.u8()?);
        if kind != FEATURE {
            return Err(refuse(record, format!("a feature record of kind {kind}"), "100"));
        }
        let instruction = instruction(record, code)?;
        // Changes refer to the record by its number; its id is stated only once.
        let id = match Cursor::of(record, "FOID") {
            None if instruction != Instruction::Insert => (0, 0, 0),
            _ => identifier(Cursor::needed(record, "FOID")?)?,
        };
        let mut all = attributes(record, "ATTF", Lexical::Latin)?;
        all.extend(attributes(record, "NATF", national)?);
        Ok(Some(Self {
            number,
            version,
            instruction,
            primitive,
            class,
            id,
            attributes: all,
            pointers: Part {
                splice: splice(record, "FSPC")?,
                items: pairs(record, "FSPT", |c| pointer(c, false))?,
            },
        }))
    }
}

fn identifier(mut cursor: Cursor<'_>) -> Result<(u16, u32, u16), Invalid> {
    Ok((cursor.u16()?, cursor.u32()?, cursor.u16()?))
}

/// All groups of subfields of a field; empty where the record lacks it.
fn pairs<T>(
    record: &Record<'_>,
    tag: &'static str,
    mut one: impl FnMut(&mut Cursor<'_>) -> Result<T, Invalid>,
) -> Result<Vec<T>, Invalid> {
    let mut all = Vec::new();
    let Some(mut cursor) = Cursor::of(record, tag) else { return Ok(all) };
    while !cursor.is_empty() {
        all.push(one(&mut cursor)?);
    }
    Ok(all)
}

fn pointer(cursor: &mut Cursor<'_>, topology: bool) -> Result<Pointer, Invalid> {
    let name = (cursor.u8()?, cursor.u32()?);
    let (orientation, usage) = (cursor.u8()?, cursor.u8()?);
    let topology = if topology { cursor.u8()? } else { 0 };
    cursor.u8()?;
    Ok(Pointer { name, orientation, usage, topology })
}

fn attributes(record: &Record<'_>, tag: &'static str, lexical: Lexical) -> Result<Attributes, Invalid> {
    let mut all = Attributes::new();
    let Some(mut cursor) = Cursor::of_text(record, tag, lexical) else { return Ok(all) };
    while !cursor.is_empty() {
        all.insert(cursor.u16()?, cursor.text(lexical)?);
    }
    Ok(all)
}

fn splice(record: &Record<'_>, tag: &'static str) -> Result<Option<Splice>, Invalid> {
    let Some(mut own) = Cursor::of(record, tag) else { return Ok(None) };
    let instruction = instruction(record, own.u8()?)?;
    Ok(Some(Splice { instruction, index: own.u16()?.into(), count: own.u16()?.into() }))
}

fn instruction(record: &Record<'_>, code: u8) -> Result<Instruction, Invalid> {
    match code {
        1 => Ok(Instruction::Insert),
        2 => Ok(Instruction::Delete),
        3 => Ok(Instruction::Modify),
        other => Err(refuse(record, format!("instruction {other}"), "1 (insert), 2 (delete) or 3 (modify)")),
    }
}

fn refuse(record: &Record<'_>, found: String, expected: &str) -> Invalid {
    Invalid::new(format!("record {}", record.number), found, expected, "download or copy the file again")
}
