//! The effect of update records on a cell (S-57, 3.1, part 3, 8).

use std::collections::BTreeMap;

use crate::enc::Invalid;
use crate::enc::record::{Attributes, Instruction, Object, Part, Splice, Vector};

/// The value of a deleted attribute.
const DELETED: &str = "\u{7f}";

/// A record that others change.
pub(crate) trait Versioned: Clone {
    /// Identifies the record within the cell.
    type Key: Ord + Clone;
    fn key(&self) -> Self::Key;
    fn named(&self) -> String;
    fn version(&self) -> u16;
    fn instruction(&self) -> Instruction;
    /// Elements of this record's lists that `change` moves.
    fn moved(&self, change: &Self) -> u64;
    /// Applies `change`.
    fn modify(&mut self, change: Self) -> Result<(), Invalid>;
}

/// Inserts, deletes or modifies a record of the cell.
pub(crate) fn apply<T: Versioned>(all: &mut BTreeMap<T::Key, T>, change: T) -> Result<(), Invalid> {
    let key = change.key();
    if change.instruction() == Instruction::Insert {
        let named = change.named();
        return match all.insert(key, change) {
            None => Ok(()),
            Some(_) => Err(refuse(named, "the insertion of an existing record", "a new record")),
        };
    }
    let Some(own) = all.get_mut(&key) else {
        return Err(refuse(change.named(), "a change of a missing record", "a record of the cell"));
    };
    let next = own.version().wrapping_add(1);
    if change.version() != next {
        let found = format!("version {}", change.version());
        return Err(refuse(change.named(), &found, &format!("version {next}, the next one")));
    }
    match change.instruction() {
        Instruction::Delete => {
            all.remove(&key);
            Ok(())
        }
        _ => own.modify(change),
    }
}

/// Elements of lists that a change moves, before it is applied.
pub(crate) fn moved<T: Versioned>(all: &BTreeMap<T::Key, T>, change: &T) -> u64 {
    all.get(&change.key()).map_or(0, |own| own.moved(change))
}

/// As [`moved`], for one list: insertions and deletions move all elements behind them.
fn moved_in<T>(own: &[T], change: &Part<T>) -> u64 {
    let moves = |splice: &Splice| splice.instruction != Instruction::Modify;
    change.splice.filter(moves).map_or(0, |splice| own.len().saturating_sub(splice.index) as u64)
}

impl Versioned for Vector {
    type Key = (u8, u32);

    fn key(&self) -> (u8, u32) {
        self.name
    }

    fn named(&self) -> String {
        format!("vector record {}-{}", self.name.0, self.name.1)
    }

    fn version(&self) -> u16 {
        self.version
    }

    fn instruction(&self) -> Instruction {
        self.instruction
    }

    fn moved(&self, change: &Self) -> u64 {
        moved_in(&self.ends.items, &change.ends) + moved_in(&self.points.items, &change.points)
    }

    fn modify(&mut self, change: Self) -> Result<(), Invalid> {
        let named = change.named();
        self.version = change.version;
        merge(&mut self.attributes, change.attributes);
        splice(&mut self.ends.items, change.ends, &named)?;
        splice(&mut self.points.items, change.points, &named)
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

    fn version(&self) -> u16 {
        self.version
    }

    fn instruction(&self) -> Instruction {
        self.instruction
    }

    fn moved(&self, change: &Self) -> u64 {
        moved_in(&self.pointers.items, &change.pointers)
    }

    fn modify(&mut self, change: Self) -> Result<(), Invalid> {
        let named = change.named();
        self.version = change.version;
        merge(&mut self.attributes, change.attributes);
        splice(&mut self.pointers.items, change.pointers, &named)
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
fn splice<T>(own: &mut Vec<T>, change: Part<T>, named: &str) -> Result<(), Invalid> {
    let Some(Splice { instruction, index, count }) = change.splice else {
        if !change.items.is_empty() {
            *own = change.items;
        }
        return Ok(());
    };
    let from = index.wrapping_sub(1);
    let taken = if instruction == Instruction::Insert { 0 } else { count };
    let given = if instruction == Instruction::Delete { 0 } else { count };
    let fits = from.checked_add(taken).is_some_and(|end| end <= own.len());
    if !fits || change.items.len() != given {
        let found = format!(
            "{} for places {index} to {} of {}",
            change.items.len(),
            from.saturating_add(count),
            own.len()
        );
        return Err(refuse(named.to_owned(), &found, "a change within its list"));
    }
    own.splice(from..from + taken, change.items);
    Ok(())
}

fn refuse(thing: String, found: &str, expected: &str) -> Invalid {
    Invalid::new(
        thing,
        found,
        expected,
        "take base cell and updates of one edition, as their producer issued them",
    )
}
