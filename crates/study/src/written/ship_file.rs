//! A ship with forces as she is written: in a `vessel.toml`, as a preset, or in the `model.json` of a fit.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Error, Provenance, read_document};
use refusal::Invalid;
use serde::Serialize;
use ship::model::VesselFile;
use toml::{Table, Value};

use crate::documents::{FittedParameter, ModelDocument};

/// A ship as written.
#[derive(Clone, Debug)]
pub struct ShipFile {
    /// The file; estimates of a fit stand as nominal values.
    pub file: VesselFile,
    /// The free numbers of a fit.
    pub fitted: Option<Vec<FittedParameter>>,
}

/// The ship at `path`, a file in TOML or JSON, or else the preset of this name. Notes the digest of a file.
///
/// # Errors
/// A file that is refused; a model without forces.
pub fn read_ship(path: &Path, provenance: &mut Provenance) -> Result<ShipFile, Error> {
    match path.extension().and_then(|extension| extension.to_str()) {
        Some("json") => {
            let model = read_document::<ModelDocument>(path)?;
            provenance.written("vessel", path, model.digest)?;
            let file = model.data.forces_file().map_err(|e| crate::invalid(path, &e))?;
            Ok(ShipFile { file, fitted: model.data.forces.map(|forces| forces.parameters) })
        }
        Some("toml") => Ok(ShipFile { file: provenance.read_toml("vessel", "vessel", path)?, fitted: None }),
        _ => {
            let preset = Some(path.to_string_lossy().into_owned());
            Ok(ShipFile { file: VesselFile { preset, ..VesselFile::default() }, fitted: None })
        }
    }
}

// A ship with forces as the text of a `vessel.toml`, with comments.

/// What comments say.
#[derive(Clone, Debug, Default)]
pub struct Notes {
    /// Sentences above the file, a paragraph each.
    pub head: Vec<String>,
    /// Comments behind numbers, by the names of parameters or by component and key, such as `rudder.ell`.
    pub numbers: BTreeMap<String, String>,
}

/// Most characters of a line of comments.
const WIDTH: usize = 118;

/// Keys in the order in which they are read; others follow by name.
const ORDER: &str = "\
    name parameter term input unit behind nominal prime value prior bounds fixed tied_to factor follows \
    range lag_s rate_per_s length_m draught_m speed_m_s area mass_kg x_g_m gyration_m inertia_kg_m2 \
    coriolis diameter_m thrust wake wake_change wake_ratio area_m2 height_m lift_slope epsilon kappa \
    gamma ell deduction interaction interaction_x_m x_m y_m";

/// The text of `file`, a complete ship with forces.
///
/// # Errors
/// A ship that TOML cannot state.
pub fn vessel_text(file: &VesselFile, notes: &Notes) -> Result<String, Invalid> {
    let mut text: String = notes.head.iter().flat_map(|paragraph| wrapped(paragraph)).collect();
    let all = [
        ("name", table_of(&file.name)?),
        ("unusual", table_of(&file.unusual)?),
        ("model", table_of(&file.model)?),
        ("sample_rate_hz", table_of(&file.sample_rate_hz)?),
        ("density_kg_m3", table_of(&file.density_kg_m3)?),
        ("step_s", table_of(&file.step_s)?),
    ];
    for (key, value) in all.into_iter().filter_map(|(key, value)| Some((key, value?))) {
        text += &line("", key, &value, notes);
    }
    for (key, terms) in [("surge", &file.surge), ("sway", &file.sway), ("yaw", &file.yaw)] {
        text += &terms_text(key, &items(terms)?, notes);
    }
    text += &tables("input", &items(&file.input)?, notes);
    text += &tables("measured", &items(&file.measured)?, notes);
    text += &tables("derived", &items(&file.derived)?, notes);
    if let Some(Value::Table(mut ship)) = table_of(&file.ship)? {
        let added = ship.remove("added_mass");
        text += &format!("\n[ship]\n{}", lines("ship", &ship, notes));
        if let Some(Value::Table(added)) = added {
            text += &format!("\n[ship.added_mass]\n{}", lines("ship.added_mass", &added, notes));
        }
    }
    text += &tables("propeller", &items(&file.propeller)?, notes);
    text += &tables("rudder", &items(&file.rudder)?, notes);
    text += &tables("thruster", &items(&file.thruster)?, notes);
    text += &tables("wind", &items(&file.wind)?, notes);
    text += &tables("crossflow", &items(&file.crossflow)?, notes);
    Ok(text)
}

/// A value; none where there is none.
fn table_of<T: Serialize>(value: &Option<T>) -> Result<Option<Value>, Invalid> {
    value.as_ref().map(value_of).transpose()
}

fn value_of<T: Serialize>(value: &T) -> Result<Value, Invalid> {
    Value::try_from(value).map_err(|e| {
        Invalid::new("the ship", e.to_string(), "a ship that TOML can state", "report this as a defect")
    })
}

fn items<T: Serialize>(all: &[T]) -> Result<Vec<Table>, Invalid> {
    let table = |item: &T| match value_of(item)? {
        Value::Table(table) => Ok(table),
        _ => Ok(Table::new()),
    };
    all.iter().map(table).collect()
}

/// The terms of an equation, one a line.
fn terms_text(key: &str, terms: &[Table], notes: &Notes) -> String {
    if terms.is_empty() {
        return String::new();
    }
    let term = |table: &Table| {
        let name = table.get("parameter").and_then(Value::as_str).unwrap_or_default();
        format!("  {},{}\n", inline(&Value::Table(table.clone())), note(notes, &[name.to_owned()]))
    };
    format!("\n{key} = [\n{}]\n", terms.iter().map(term).collect::<String>())
}

/// Tables of a list.
fn tables(key: &str, all: &[Table], notes: &Notes) -> String {
    let table = |table: &Table| {
        let name = table.get("name").and_then(Value::as_str).unwrap_or_default();
        format!("\n[[{key}]]\n{}", lines(name, table, notes))
    };
    all.iter().map(table).collect()
}

fn lines(owner: &str, table: &Table, notes: &Notes) -> String {
    sorted(table).into_iter().map(|(key, value)| line(owner, key, value, notes)).collect()
}

fn line(owner: &str, key: &str, value: &Value, notes: &Notes) -> String {
    let name = if owner.is_empty() { key.to_owned() } else { format!("{owner}.{key}") };
    let names = [format!("{name}.0"), name];
    format!("{key} = {}{}\n", inline(value), note(notes, &names))
}

fn note(notes: &Notes, names: &[String]) -> String {
    let note = names.iter().find_map(|name| notes.numbers.get(name));
    note.map_or(String::new(), |note| format!("  # {note}"))
}

/// The entries of a table in their order.
fn sorted(table: &Table) -> Vec<(&String, &Value)> {
    let mut all: Vec<_> = table.iter().collect();
    all.sort_by_key(|(key, _)| ORDER.split(' ').position(|known| known == *key).unwrap_or(usize::MAX));
    all
}

/// A value on one line.
fn inline(value: &Value) -> String {
    match value {
        Value::Table(table) => {
            let all = sorted(table).into_iter().map(|(key, value)| format!("{key} = {}", inline(value)));
            format!("{{ {} }}", all.collect::<Vec<_>>().join(", "))
        }
        Value::Array(all) => format!("[{}]", all.iter().map(inline).collect::<Vec<_>>().join(", ")),
        other => other.to_string(),
    }
}

/// A paragraph as lines of comments.
fn wrapped(paragraph: &str) -> Vec<String> {
    let mut lines = vec![String::from("#")];
    for word in paragraph.split_whitespace() {
        let last = lines.last().map_or(0, |line| line.chars().count());
        if last + 1 + word.chars().count() > WIDTH {
            lines.push(String::from("#"));
        }
        if let Some(last) = lines.last_mut() {
            last.push(' ');
            last.push_str(word);
        }
    }
    lines.into_iter().map(|line| line + "\n").collect()
}
