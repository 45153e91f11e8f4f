//! Files of charts, and cells of electronic ones with their updates.

use std::collections::{BTreeMap, btree_map::Entry};
use std::path::{Path, PathBuf};

use artifact::{Budget, Digest, Error, PROGRAM_BYTES, Provenance, Work};
use chart::{PolygonLayer, Rules, Tally};
use enc::{Cell, Feature, vertical_datum};

use super::exchange_set::{CellFile, ExchangeSet, capitals, is_catalogue};
use super::updates::{Catalogue, Found, Updates};
use crate::documents::{PlanChart, PlanChartClass};

/// Bytes that it takes to read a byte of a file of polygons or objects.
pub(super) const PER_BYTE: u64 = 14;
/// Bytes that a place of an object takes, from the cell to the chart.
const PER_PLACE: u64 = 72;

/// The bytes of a chart's file, whose digest is noted.
pub(super) fn bytes(path: &Path, provenance: &mut Provenance) -> Result<Vec<u8>, Error> {
    let bytes = artifact::read(path)?;
    note(path, &bytes, provenance);
    Ok(bytes)
}

/// Notes the digest of a chart's file by its name; by a number behind it where another chart's file has the same.
fn note(path: &Path, bytes: &[u8], provenance: &mut Provenance) {
    let name = path.file_name().map_or(String::new(), |n| n.to_string_lossy().into_owned());
    let digest = Digest::of_bytes(bytes);
    let roles = (1..).map(|k| if k == 1 { format!("chart:{name}") } else { format!("chart:{name} ({k})") });
    for role in roles {
        let known = provenance.inputs.get(&role);
        if known.is_none_or(|known| *known == digest) {
            provenance.inputs.insert(role, digest);
            return;
        }
    }
}

/// The base cells that a path names: one, or those of a folder or of a catalogue's; `None` for another file.
///
/// # Errors
/// A folder that cannot be read or holds no cell; two base cells of one name and edition.
pub(super) fn cells_of(path: &Path) -> Result<Option<Vec<PathBuf>>, Error> {
    if path.is_dir() {
        return Ok(Some(below(path)?));
    }
    if is_catalogue(path) {
        return Ok(Some(below(path.parent().unwrap_or(Path::new("")))?));
    }
    Ok(capitals(path).ends_with(".000").then(|| vec![path.to_path_buf()]))
}

/// The newest base cell of every name below a folder.
fn below(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let set = ExchangeSet::below(folder)?;
    let mut newest: BTreeMap<&str, Found> = BTreeMap::new();
    for file in set.files.iter().filter(|file| file.is_base() && !file.special) {
        let found = Found::read(&file.path)?;
        match newest.entry(file.stem()) {
            Entry::Vacant(free) => drop(free.insert(found)),
            Entry::Occupied(mut known) if found.age() > known.get().age() => drop(known.insert(found)),
            Entry::Occupied(_) => {}
        }
    }
    if newest.is_empty() {
        let expected = "a cell (`.000`), or GeoJSON or a grid by its own name";
        return Err(Error::refuse(folder, "folder", "no cell in it or below", expected, "name another one"));
    }
    Ok(newest.into_values().map(|found| found.path).collect())
}

/// How charts are read: what they may take, what they took before, and the folders that were looked into.
pub(super) struct Reading<'a> {
    pub budget: &'a Budget,
    pub provenance: &'a mut Provenance,
    /// Memory of the charts so far \[bytes\].
    pub bytes: u64,
    pub sets: BTreeMap<PathBuf, ExchangeSet>,
}

impl Reading<'_> {
    /// A cell, its updates applied, by the rules of its classes; and what became of its objects.
    ///
    /// # Errors
    /// Files that cannot be read, do not fit in the memory, are damaged, or are refused; each names itself.
    pub(super) fn cell(&mut self, path: &Path, rules: &Rules) -> Result<(PolygonLayer, PlanChart), Error> {
        let set = self.set(path)?;
        let stem = capitals(path).trim_end_matches(".000").to_owned();
        let files: Vec<CellFile> = set.of(&stem).filter(|file| !is_same(&file.path, path)).cloned().collect();
        let before = self.bytes;
        self.account(path, &files)?;
        let base = Found::read(path)?;
        let others = files.iter().map(|file| other(file)).collect::<Result<Vec<_>, _>>()?;
        let checked = self.check(path, &stem, &base, (&files, &others))?;
        let updates = Updates::of(&base, others)?;
        note(path, &base.bytes, self.provenance);
        let mut cell = Cell::read(&base.bytes).map_err(|e| Error::invalid(path, e))?;
        drop(base);
        for update in updates.files.values() {
            note(&update.path, &update.bytes, self.provenance);
            cell.update(&update.bytes).map_err(|e| Error::invalid(&update.path, e))?;
        }
        let objects = self.objects(path, &cell, before)?;
        let (scale, identity, datums) = (cell.scale(), cell.identity().clone(), cell.datums());
        // Large, and not needed any more.
        drop(cell);
        let (layer, told) = of_objects(path, &objects, Some(scale), rules)?;
        let datum = |code: u8| vertical_datum(code).map_or_else(|| format!("VERDAT {code}"), str::to_owned);
        let told = PlanChart {
            edition: Some(identity.edition),
            update: Some(identity.update.into()),
            issued: Some(identity.issued),
            scale: Some(scale.into()),
            sounding_datum: Some(datum(datums.depths)),
            vertical_datum: Some(datum(datums.heights)),
            notes: updates.notes.into_iter().chain(checked).collect(),
            ..told
        };
        Ok((layer, told))
    }

    /// The folders around a cell, looked into once.
    fn set(&mut self, path: &Path) -> Result<&ExchangeSet, Error> {
        let root = ExchangeSet::root_of(path)?;
        Ok(match self.sets.entry(root) {
            Entry::Occupied(known) => known.into_mut(),
            Entry::Vacant(free) => {
                let set = ExchangeSet::below(free.key())?;
                free.insert(set)
            }
        })
    }

    /// Counts what the files take, before they are read.
    fn account(&mut self, path: &Path, others: &[CellFile]) -> Result<(), Error> {
        let length = std::fs::metadata(path).map_or(0, |about| about.len());
        let length = others.iter().fold(length, |sum, file| sum.saturating_add(file.length));
        self.bytes = self.bytes.saturating_add(length.saturating_mul(PER_BYTE));
        let (found, remedy) = (format!("{length} bytes"), "raise --memory-mib, or cut the chart to the area");
        let work = Work { file: path, thing: "file", found: &found, remedy };
        self.budget.memory(work, (PROGRAM_BYTES + self.bytes) as f64)
    }

    /// Checks all files of a cell against the catalogue of their set, and says what came of it and what was left out.
    fn check(
        &mut self,
        path: &Path,
        stem: &str,
        base: &Found,
        (files, others): (&[CellFile], &[Found]),
    ) -> Result<Vec<String>, Error> {
        let provenance = &mut *self.provenance;
        let Some(set) = ExchangeSet::root_of(path).ok().and_then(|root| self.sets.get(&root)) else {
            return Ok(Vec::new());
        };
        let closed = (set.closed > 0).then(|| format!("{} folders not looked into", set.closed));
        let named = CellFile::at(path, &set.root);
        let others = files.iter().zip(others).map(|(file, found)| (file, &found.bytes[..]));
        let all: Vec<(&CellFile, &[u8])> = [(&named, &base.bytes[..])].into_iter().chain(others).collect();
        let agree = match Catalogue::of(set, provenance)? {
            Some(catalogue) => catalogue.check(stem, &all)?,
            None => "no CATALOG.031, so that no checksum was looked at".to_owned(),
        };
        Ok(closed.into_iter().chain([agree]).collect())
    }

    /// The objects of a cell, as many as fit.
    fn objects(&mut self, path: &Path, cell: &Cell, before: u64) -> Result<Vec<Feature>, Error> {
        let most = (self.budget.bytes() - (PROGRAM_BYTES + before) as f64).max(0.0) / PER_PLACE as f64;
        let objects = cell.features_within(most as u64).map_err(|e| Error::invalid(path, e))?;
        let places: u64 = objects.iter().map(|object| object.geometry.places()).sum();
        self.bytes = self.bytes.max(before + PER_PLACE * places);
        Ok(objects)
    }
}

/// Another file of a cell: read, but never along a link.
fn other(file: &CellFile) -> Result<Found, Error> {
    if !file.special {
        return Found::read(&file.path);
    }
    let (found, remedy) = ("a link, a pipe or a device", "copy the file itself there, or take it away");
    Err(Error::refuse(&file.path, "update", found, "a file", remedy))
}

fn is_same(a: &Path, b: &Path) -> bool {
    a.file_name() == b.file_name() && a.parent().zip(b.parent()).is_some_and(|(a, b)| same_folder(a, b))
}

fn same_folder(a: &Path, b: &Path) -> bool {
    let b = if b.as_os_str().is_empty() { Path::new(".") } else { b };
    b.canonicalize().is_ok_and(|b| a == b)
}

/// Objects as a layer, and what became of them.
pub(super) fn of_objects(
    path: &Path,
    objects: &[Feature],
    scale: Option<u32>,
    rules: &Rules,
) -> Result<(PolygonLayer, PlanChart), Error> {
    let (layer, tallies) =
        PolygonLayer::from_objects(objects, scale, rules).map_err(|e| Error::invalid(path, e))?;
    let of = |tally: Tally| PlanChartClass {
        objects: tally.objects,
        avoided: tally.avoided,
        maneuvers_avoid: tally.maneuvers_avoid,
        ignored: tally.ignored,
        reasons: tally.reasons.into_iter().map(|(why, count)| (why.reason().to_owned(), count)).collect(),
    };
    let told = PlanChart {
        file: path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned()),
        edition: None,
        update: None,
        issued: None,
        scale: None,
        sounding_datum: None,
        vertical_datum: None,
        notes: Vec::new(),
        classes: tallies.into_iter().map(|(class, tally)| (class, of(tally))).collect(),
    };
    Ok((layer, told))
}
