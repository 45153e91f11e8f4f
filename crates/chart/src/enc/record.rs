//! Vector and feature records of a file.

use std::collections::BTreeMap;

use crate::enc::Invalid;
use crate::enc::iso8211::{Cursor, Lexical, Record};

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
        let Some(mut cursor) = Cursor::of(record, "VRID") else { return Ok(None) };
        let name = (cursor.u8()?, cursor.u32()?);
        let (version, code) = (cursor.u16()?, cursor.u8()?);
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
        let Some(mut cursor) = Cursor::of(record, "FRID") else { return Ok(None) };
        let (kind, number) = (cursor.u8()?, cursor.u32()?);
        let (primitive, _group) = (cursor.u8()?, cursor.u8()?);
        let (class, version, code) = (cursor.u16()?, cursor.u16()?, cursor.u8()?);
        if kind != FEATURE {
            return Err(refuse(record, format!("a feature record of kind {kind}"), "100"));
        }
        let instruction = instruction(record, code)?;
        // Changes refer to the record by its number; its id is stated only once.
        let id = match Cursor::of(record, "FOID") {
            None if instruction != Instruction::Insert => (0, 0, 0),
            _ => {
                let mut cursor = Cursor::needed(record, "FOID")?;
                (cursor.u16()?, cursor.u32()?, cursor.u16()?)
            }
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
    let Some(mut cursor) = Cursor::of(record, tag) else { return Ok(None) };
    let instruction = instruction(record, cursor.u8()?)?;
    Ok(Some(Splice { instruction, index: cursor.u16()?.into(), count: cursor.u16()?.into() }))
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

// The effect of update records on a cell (S-57, 3.1, part 3, 8).

/// The value of a deleted attribute.
const DELETED: &str = "\u{7f}";

/// A record that others change.
pub(crate) trait Versioned: Clone {
    /// Identifies the record within the cell.
    type Key: Ord + Clone;
    fn key(&self) -> Self::Key;
    fn named(&self) -> String;
    /// Its version, and what it does to the record of the version before.
    fn edition(&self) -> (u16, Instruction);
    /// Elements of this record's lists that `change` moves.
    fn moved(&self, change: &Self) -> u64;
    /// Applies `change`.
    fn modify(&mut self, change: Self) -> Result<(), Invalid>;
}

/// Inserts, deletes or modifies a record of the cell.
pub(crate) fn apply<T: Versioned>(all: &mut BTreeMap<T::Key, T>, change: T) -> Result<(), Invalid> {
    let (key, (version, instruction)) = (change.key(), change.edition());
    if instruction == Instruction::Insert {
        let named = change.named();
        return match all.insert(key, change) {
            None => Ok(()),
            Some(_) => Err(refuse_change(named, "the insertion of an existing record", "a new record")),
        };
    }
    let Some(record) = all.get_mut(&key) else {
        return Err(refuse_change(change.named(), "a change of a missing record", "a record of the cell"));
    };
    let next = record.edition().0.wrapping_add(1);
    if version != next {
        let version = format!("version {version}");
        return Err(refuse_change(change.named(), &version, &format!("version {next}, the next one")));
    }
    match instruction {
        Instruction::Delete => {
            all.remove(&key);
            Ok(())
        }
        _ => record.modify(change),
    }
}

/// Elements of lists that a change moves, before it is applied.
pub(crate) fn moved<T: Versioned>(all: &BTreeMap<T::Key, T>, change: &T) -> u64 {
    all.get(&change.key()).map_or(0, |record| record.moved(change))
}

/// As [`moved`], for one list: insertions and deletions move all elements behind them.
fn moved_in<T>(list: &[T], change: &Part<T>) -> u64 {
    let moves = |splice: &Splice| splice.instruction != Instruction::Modify;
    change.splice.filter(moves).map_or(0, |splice| list.len().saturating_sub(splice.index) as u64)
}

impl Versioned for Vector {
    type Key = (u8, u32);

    fn key(&self) -> (u8, u32) {
        self.name
    }

    fn named(&self) -> String {
        format!("vector record {}-{}", self.name.0, self.name.1)
    }

    fn edition(&self) -> (u16, Instruction) {
        (self.version, self.instruction)
    }

    fn moved(&self, change: &Self) -> u64 {
        moved_in(&self.ends.items, &change.ends) + moved_in(&self.points.items, &change.points)
    }

    fn modify(&mut self, change: Self) -> Result<(), Invalid> {
        let named = change.named();
        self.version = change.version;
        merge(&mut self.attributes, change.attributes);
        change_list(&mut self.ends.items, change.ends, &named)?;
        change_list(&mut self.points.items, change.points, &named)
    }
}

impl Versioned for Object {
    type Key = u32;

    fn key(&self) -> u32 {
        self.number
    }

    fn named(&self) -> String {
        format!("feature record {}", self.number)
    }

    fn edition(&self) -> (u16, Instruction) {
        (self.version, self.instruction)
    }

    fn moved(&self, change: &Self) -> u64 {
        moved_in(&self.pointers.items, &change.pointers)
    }

    fn modify(&mut self, change: Self) -> Result<(), Invalid> {
        let named = change.named();
        self.version = change.version;
        merge(&mut self.attributes, change.attributes);
        change_list(&mut self.pointers.items, change.pointers, &named)
    }
}

/// Sets attributes, and removes deleted ones.
fn merge(attributes: &mut Attributes, changes: Attributes) {
    for (code, value) in changes {
        match value == DELETED {
            true => attributes.remove(&code),
            false => attributes.insert(code, value),
        };
    }
}

/// Changes a part of a list, or without a splice all of it, if there is a change.
fn change_list<T>(list: &mut Vec<T>, change: Part<T>, named: &str) -> Result<(), Invalid> {
    let Some(Splice { instruction, index, count }) = change.splice else {
        if !change.items.is_empty() {
            *list = change.items;
        }
        return Ok(());
    };
    let from = index.wrapping_sub(1);
    let taken = if instruction == Instruction::Insert { 0 } else { count };
    let given = if instruction == Instruction::Delete { 0 } else { count };
    let fits = from.checked_add(taken).is_some_and(|end| end <= list.len());
    if !fits || change.items.len() != given {
        let places = format!(
            "{} for places {index} to {} of {}",
            change.items.len(),
            from.saturating_add(count),
            list.len()
        );
        return Err(refuse_change(named.to_owned(), &places, "a change within its list"));
    }
    list.splice(from..from + taken, change.items);
    Ok(())
}

fn refuse_change(thing: String, found: &str, expected: &str) -> Invalid {
    Invalid::new(
        thing,
        found,
        expected,
        "take base cell and updates of one edition, as their producer issued them",
    )
}
