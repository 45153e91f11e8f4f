//! A cell: its base file, then its updates.

use std::collections::BTreeMap;

use refusal::foreign;

use crate::enc::dataset::{Parameters, Structure, identity, parameters};
use crate::enc::iso8211::{first_records, records};
use crate::enc::record::{CONNECTED, EDGE, ISOLATED, Name, Object, Vector, apply, moved};
use crate::enc::topology::{Topology, stored};
use crate::enc::{Datums, Feature, Identity, Invalid, Purpose, iso8211};

/// How often objects may use the stored places, on average: real cells stay below ten.
const MOST_USES: u64 = 64;
/// Places that any cell may have.
const ALWAYS: u64 = 1_000_000;
/// Most places and pointers that one update may move within their lists.
const MOST_MOVED: u64 = 1_000_000_000;

/// A cell with its updates applied.
#[derive(Clone, Debug)]
pub struct Cell {
    identity: Identity,
    parameters: Parameters,
    vectors: BTreeMap<Name, Vector>,
    objects: BTreeMap<u32, Object>,
}

impl Cell {
    /// Reads the base file of a cell (`.000`).
    ///
    /// # Errors
    /// Files that are not ISO 8211, cut off or encrypted; another product than a binary ENC of S-57; an
    /// update; inconsistent records.
    pub fn read(file: &[u8]) -> Result<Self, Invalid> {
        let (identity, changes) = read(file)?;
        if identity.purpose == Purpose::Update {
            let update = format!("update {} of edition {}", identity.update, identity.edition);
            return Err(Invalid::new(
                "cell",
                update,
                "a base cell",
                "name the `.000` file, with its updates beside it",
            ));
        }
        let Some(parameters) = changes.parameters else {
            let remedy = "download or copy the file again";
            return Err(Invalid::new("cell", "no field DSPM", "its datum and units", remedy));
        };
        let mut cell = Self { identity, parameters, vectors: BTreeMap::new(), objects: BTreeMap::new() };
        cell.take(changes.vectors, changes.objects)?;
        Ok(cell)
    }

    /// Applies the next update. One that the base file already contains, as a new issue does, changes nothing.
    ///
    /// # Errors
    /// As [`Cell::read`]; an update that is not the next one, or of another edition; changes of missing
    /// records. The cell must not be used afterwards.
    pub fn update(&mut self, file: &[u8]) -> Result<(), Invalid> {
        let (identity, changes) = read(file)?;
        let current = &self.identity;
        let named = format!("update {} of edition {}", identity.update, identity.edition);
        let refuse = |named: String| {
            let expected = format!("update {} of edition {}", current.update + 1, current.edition);
            let remedy =
                "put all updates of the cell's edition beside it, or take its exchange set as a whole";
            Err(Invalid::new("update", named, expected, remedy))
        };
        if identity.purpose == Purpose::Base {
            return refuse(format!("a base cell of edition {}", identity.edition));
        }
        if identity.edition == current.edition && identity.update <= current.update {
            return Ok(());
        }
        if identity.edition == "0" {
            return refuse("the cell's cancellation".to_owned());
        }
        if identity.edition != current.edition || identity.update != current.update + 1 {
            return refuse(named);
        }
        if stem(&identity.name) != stem(&current.name) {
            return refuse(format!("{named} of the cell `{}`", foreign(&identity.name)));
        }
        if changes.parameters.is_some_and(|units| units != self.parameters) {
            return refuse(format!("{named} in other units (DSPM)"));
        }
        (self.identity.update, self.identity.issued) = (identity.update, identity.issued);
        self.take(changes.vectors, changes.objects)
    }

    /// The identity of the cell, with the number and date of its last update.
    pub fn identity(&self) -> &Identity {
        &self.identity
    }

    /// Compilation scale: 1 to this.
    pub fn scale(&self) -> u32 {
        self.parameters.scale
    }

    /// The datums of its heights and depths.
    pub fn datums(&self) -> Datums {
        self.parameters.datums
    }

    /// All objects, in the order of their record numbers.
    ///
    /// # Errors
    /// Objects with missing nodes or edges, or with rings that do not close; more places than
    /// [`Cell::features_within`] ever allows.
    pub fn features(&self) -> Result<Vec<Feature>, Invalid> {
        self.features_within(u64::MAX)
    }

    /// All objects, with at most `most_places` places in total; objects that use the stored places more than
    /// 64 times on average are never read.
    ///
    /// # Errors
    /// As [`Cell::features`]; more places.
    pub fn features_within(&self, most_places: u64) -> Result<Vec<Feature>, Invalid> {
        let most = (MOST_USES * stored(&self.vectors)).max(ALWAYS).min(most_places);
        let topology = Topology::new(&self.vectors, self.parameters, most);
        self.objects.values().map(|object| topology.feature(object)).collect()
    }

    fn take(&mut self, vectors: Vec<Vector>, objects: Vec<Object>) -> Result<(), Invalid> {
        let mut all = 0;
        for vector in vectors {
            all += moved(&self.vectors, &vector);
            check_moved(all)?;
            apply(&mut self.vectors, vector)?;
        }
        for object in objects {
            all += moved(&self.objects, &object);
            check_moved(all)?;
            apply(&mut self.objects, object)?;
        }
        Ok(())
    }
}

/// The identity that a file states, whether cell or update; its other records are not read.
///
/// # Errors
/// As [`Cell::read`].
pub fn identify(file: &[u8]) -> Result<Identity, Invalid> {
    let records = first_records(file, 2)?;
    let [descriptive, first] = &records[..] else { return Err(broken("no data records")) };
    iso8211::check(descriptive)?;
    Ok(identity(first)?.0)
}

/// A cell's name without the suffix that numbers its updates.
fn stem(name: &str) -> String {
    let name = name.trim();
    name.rsplit_once('.').map_or(name, |(stem, _)| stem).to_ascii_uppercase()
}

fn check_moved(all: u64) -> Result<(), Invalid> {
    if all <= MOST_MOVED {
        return Ok(());
    }
    let changes = format!("changes that move more than {MOST_MOVED} places and pointers along their lists");
    Err(Invalid::new("update", changes, "changes of a chart", "report it to the chart's producer"))
}

/// The contents of a file besides its identity.
#[derive(Default)]
struct Changes {
    parameters: Option<Parameters>,
    vectors: Vec<Vector>,
    objects: Vec<Object>,
}

impl Changes {
    /// Refuses a file that ends between two records.
    fn check(&self, structure: &Structure) -> Result<(), Invalid> {
        let nodes = |kind: u8| self.vectors.iter().filter(|vector| vector.name.0 == kind).count();
        let counts = [self.objects.len(), nodes(ISOLATED), nodes(CONNECTED), nodes(EDGE)];
        let names = ["objects", "isolated nodes", "connected nodes", "edges"];
        for ((name, count), stated) in names.iter().zip(counts).zip(structure.records) {
            if count < stated as usize {
                let expected = format!("the {stated} that it states");
                let remedy = "download or copy the file again: it is cut off";
                return Err(Invalid::new("cell", format!("{count} {name}"), expected, remedy));
            }
        }
        Ok(())
    }
}

fn read(file: &[u8]) -> Result<(Identity, Changes), Invalid> {
    let records = records(file)?;
    let (descriptive, data) = records.split_first().ok_or_else(|| broken("no records"))?;
    iso8211::check(descriptive)?;
    let first = data.first().ok_or_else(|| broken("no data records"))?;
    let (identity, structure) = identity(first)?;
    let mut changes = Changes::default();
    for record in &data[1..] {
        if record.field("DSPM").is_some() {
            changes.parameters = Some(parameters(record)?);
        }
        changes.vectors.extend(Vector::read(record)?);
        changes.objects.extend(Object::read(record, structure.national)?);
    }
    changes.check(&structure)?;
    Ok((identity, changes))
}

fn broken(found: &str) -> Invalid {
    let expected = "an identification, nodes, edges, objects";
    Invalid::new("cell", found, expected, "download or copy the file again")
}
