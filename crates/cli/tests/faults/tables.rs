//! Damage to tables that another program could have done: whole files with other values, columns, units or rows.

use files::{Column, Kind, Table};

use crate::damage::{Draw, damaged_bytes};
use crate::places::unsealed;
use crate::support::craft::{self, Whole};

/// The kind of a table by the prefix of its name.
const KINDS: [(&str, &str); 5] = [
    ("estimates", "estimates"),
    ("scores", "scores"),
    ("rounds-scores", "scores"),
    ("track", "track"),
    ("", "trajectories"),
];

/// A table damaged as a whole, or in a few bytes.
pub fn damaged(draw: &mut Draw, name: &str, bytes: &[u8]) -> Vec<u8> {
    if draw.below(4) == 0 || name.starts_with("tables/") && draw.below(2) == 0 {
        return damaged_bytes(draw, unsealed(bytes));
    }
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("table.parquet");
    std::fs::write(&path, bytes).unwrap();
    let (_, kind) = KINDS.iter().find(|(begins, _)| name.starts_with(begins)).unwrap();
    let mut whole = craft::read(&path, kind);
    if whole.blocks.is_empty() {
        return damaged_bytes(draw, unsealed(bytes));
    }
    change(draw, &mut whole);
    if whole.blocks.iter().flat_map(|block| &block.columns).any(|column| column.is_empty())
        || whole.blocks.is_empty()
        || whole.schema.columns.is_empty()
        || draw.below(2) == 0
    {
        let value = [f64::NAN, f64::INFINITY, 1e300, -1.0, 0.0][draw.below(5)];
        let column = draw.below(whole.schema.columns.len());
        let name = whole.schema.columns.get(column).map_or(String::new(), |column| column.name.clone());
        let rows = whole.blocks.iter().map(rows).min().unwrap_or(0);
        // In half of the cases no additional value is replaced.
        let name = if draw.below(2) == 0 || rows == 0 { String::new() } else { name };
        whole.write_foreign(&path, &name, draw.below(rows), value);
    } else {
        std::fs::remove_file(&path).unwrap();
        whole.write(&path);
    }
    std::fs::read(&path).unwrap()
}

fn rows(block: &Table) -> usize {
    block.columns.first().map_or(0, Column::len)
}

/// Changes something that stays a table.
fn change(draw: &mut Draw, whole: &mut Whole) {
    let column = draw.below(whole.schema.columns.len());
    let block = draw.below(whole.blocks.len());
    match draw.below(12) {
        0 => {
            let name = whole.schema.columns[column].name.clone();
            whole.schema.columns.retain(|c| c.name != name);
            whole.blocks.iter_mut().for_each(|block| drop(block.columns.remove(column)));
        }
        1 => whole.schema.columns[column].unit = ["m", "1", "deg", "rad/s", "N"][draw.below(5)].to_owned(),
        2 => whole.schema.columns[column].name = "strange".to_owned(),
        3 => {
            let other = draw.below(whole.schema.columns.len());
            whole.schema.columns.swap(column, other);
            whole.blocks.iter_mut().for_each(|block| block.columns.swap(column, other));
        }
        4 => drop(whole.blocks.remove(block)),
        5 => whole.blocks.push(whole.blocks[block].clone()),
        6 => {
            let rows = rows(&whole.blocks[block]);
            let (from, to) = (draw.below(rows), draw.below(rows + 1));
            for column in &mut whole.blocks[block].columns {
                *column = part(column, from.min(to), from.max(to));
            }
        }
        7 => whole.blocks.reverse(),
        _ => {
            let place = &mut whole.blocks[block].columns[column];
            *place = other_values(draw, place);
        }
    }
}

fn part(column: &Column, from: usize, to: usize) -> Column {
    match column.kind() {
        Kind::F64 => Column::nullable_f64(
            column.as_f64().unwrap()[from..to].to_vec(),
            (from..to).map(|row| !column.is_null(row)).collect(),
        ),
        Kind::I32 => Column::i32(column.as_i32().unwrap()[from..to].to_vec()),
        Kind::Text => {
            let (labels, codes) = column.text_codes().unwrap();
            Column::text(labels.to_vec(), codes[from..to].to_vec())
        }
    }
}

/// One value, or all of them, changed.
fn other_values(draw: &mut Draw, column: &Column) -> Column {
    let rows = column.len();
    let row = draw.below(rows);
    let all = draw.below(3) == 0;
    let of = |i: usize| all || i == row;
    match column.kind() {
        Kind::F64 => {
            let factor = [-1.0, 0.0, 1e-9, 1e9, 1e150, 1.0 + 1e-9][draw.below(6)];
            let changed = |(i, value): (usize, &f64)| if of(i) { value * factor } else { *value };
            let values = column.as_f64().unwrap().iter().enumerate().map(changed).collect();
            let absent = draw.below(8) == 0 && column.nulls() > 0;
            Column::nullable_f64(values, (0..rows).map(|i| !(column.is_null(i) || absent && of(i))).collect())
        }
        Kind::I32 => {
            let to = [0, -1, 1, 7, i32::MAX, i32::MIN][draw.below(6)];
            let values = column.as_i32().unwrap().iter().enumerate();
            Column::i32(values.map(|(i, value)| if of(i) { to } else { *value }).collect())
        }
        Kind::Text => {
            let (labels, codes) = column.text_codes().unwrap();
            let mut labels = labels.to_vec();
            labels.push(["", "x", "random", "\u{0}", "not identifiable"][draw.below(5)].to_owned());
            let last = labels.len() as u32 - 1;
            let codes = codes.iter().enumerate().map(|(i, code)| if of(i) { last } else { *code });
            Column::text(labels, codes.collect())
        }
    }
}
