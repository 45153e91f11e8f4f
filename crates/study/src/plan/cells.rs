//! Cells of electronic charts, with their updates.

use std::collections::btree_map::Entry;
use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};

use chart::enc::{Cell, Feature, Identity, Listed, Purpose, VERDAT, identify, listed, vertical_datum};
use chart::{PolygonLayer, Rules, Tally};
use files::{Budget, Digest, Error, PROGRAM_BYTES, Provenance, Work};
use refusal::foreign;

use super::exchange_set::{CellFile, ExchangeSet, bytes, capitals, is_catalogue, note};
use crate::documents::{PlanChart, PlanChartClass};

/// Bytes of memory to read a byte of a file of polygons or objects.
pub(super) const PER_BYTE: u64 = 14;
/// Bytes per position of an object, from the cell to the chart.
const PER_PLACE: u64 = 72;

/// The base cells that a path names: one, or those of a folder or of a catalogue's; `None` for another file.
pub(super) fn cells_of(path: &Path) -> Result<Option<Vec<PathBuf>>, Error> {
    if path.is_dir() {
        return Ok(Some(below(path)?));
    }
    if is_catalogue(path) && path.is_file() {
        return Ok(Some(below(path.parent().unwrap_or(Path::new("")))?));
    }
    Ok(capitals(path).ends_with(".000").then(|| vec![path.to_path_buf()]))
}

/// The newest base cell of every name below a folder.
fn below(folder: &Path) -> Result<Vec<PathBuf>, Error> {
    let set = ExchangeSet::below(folder)?;
    let mut newest: BTreeMap<&str, (Age, &Path)> = BTreeMap::new();
    for file in set.files.iter().filter(|file| file.is_base() && !file.special) {
        let candidate = (age_of(&file.path)?, file.path.as_path());
        match newest.entry(file.stem()) {
            Entry::Vacant(free) => drop(free.insert(candidate)),
            Entry::Occupied(mut known) if candidate.0 > known.get().0 => drop(known.insert(candidate)),
            Entry::Occupied(known) if candidate.0 == known.get().0 => check_same(known.get().1, candidate.1)?,
            Entry::Occupied(_) => {}
        }
    }
    if newest.is_empty() {
        let expected = "a cell (`.000`), or GeoJSON or a grid by its own name";
        return Err(Error::refuse(folder, "folder", "no cell in it or below", expected, "name another one"));
    }
    Ok(newest.into_values().map(|(_, path)| path.to_path_buf()).collect())
}

fn check_same(one: &Path, other: &Path) -> Result<(), Error> {
    if files::read(one)? == files::read(other)? {
        return Ok(());
    }
    let given = format!("the same edition as {}, and other bytes", one.display());
    let remedy = "name the cell that is meant by its file, or move the other away";
    Err(Error::refuse(other, "cell", given, "each cell once", remedy))
}

/// Reads charts within a memory limit, and caches the folders that were searched.
pub(super) struct CellReader<'a> {
    pub budget: &'a Budget,
    pub provenance: &'a mut Provenance,
    /// Memory of the charts so far \[bytes\].
    pub bytes: u64,
    pub sets: BTreeMap<PathBuf, (ExchangeSet, Option<Catalogue>)>,
    /// The folder named in place of a cell: all files in it belong together.
    pub named: Option<PathBuf>,
}

impl CellReader<'_> {
    /// A cell with its updates, by the rules of its classes; and the treatment of its objects.
    pub(super) fn cell(&mut self, path: &Path, rules: &Rules) -> Result<(PolygonLayer, PlanChart), Error> {
        let root = self.look_around(path)?;
        let stem = capitals(path).trim_end_matches(".000").to_owned();
        let files = self.sets.get(&root).into_iter().flat_map(|(set, _)| set.of(&stem));
        let files: Vec<CellFile> = files.filter(|file| !is_same(&file.path, path)).cloned().collect();
        let before = self.bytes;
        self.account(path, &files)?;
        let base = ReadCell::read(path)?;
        let others = files.iter().map(other).collect::<Result<Vec<_>, _>>()?;
        let named = CellFile::at(path, &root);
        let bytes = [(&named, &base)].into_iter().chain(files.iter().zip(&others));
        let checked = self.check(&root, &stem, &bytes.collect::<Vec<_>>())?;
        let updates = Updates::of(&base, others)?;
        note(path, Digest::of_bytes(&base.bytes), self.provenance);
        let mut cell = Cell::read(&base.bytes).map_err(|e| Error::invalid(path, e))?;
        drop(base);
        for update in updates.files.values() {
            note(&update.path, Digest::of_bytes(&update.bytes), self.provenance);
            cell.update(&update.bytes).map_err(|e| Error::invalid(&update.path, e))?;
        }
        let objects = self.objects(path, &cell, before)?;
        let (scale, identity, datums) = (cell.scale(), cell.identity().clone(), cell.datums());
        // Frees a large structure that is not needed any more.
        drop(cell);
        let (layer, summary) = of_objects(path, &objects, Some(scale), rules)?;
        let parts = other_datums(&objects, datums.depths);
        let summary = PlanChart {
            edition: Some(identity.edition),
            update: Some(identity.update.into()),
            issued: Some(identity.issued),
            scale: Some(scale.into()),
            sounding_datum: Some(datum_of(datums.depths)),
            vertical_datum: Some(datum_of(datums.heights)),
            notes: updates.notes.into_iter().chain(checked).chain(parts).collect(),
            ..summary
        };
        Ok((layer, summary))
    }

    /// Searches the folders of a cell's set, unless done before, and returns the topmost.
    fn look_around(&mut self, path: &Path) -> Result<PathBuf, Error> {
        let root = ExchangeSet::root_of(path)?;
        let root = self.named.clone().filter(|named| root.starts_with(named)).unwrap_or(root);
        if let Entry::Vacant(free) = self.sets.entry(root.clone()) {
            let set = ExchangeSet::below(&root)?;
            let catalogue = Catalogue::of(&set, self.provenance)?;
            free.insert((set, catalogue));
        }
        Ok(root)
    }

    /// Counts the memory of the files before they are read.
    fn account(&mut self, path: &Path, others: &[CellFile]) -> Result<(), Error> {
        let length = std::fs::metadata(path).map_or(0, |about| about.len());
        let length = others.iter().fold(length, |sum, file| sum.saturating_add(file.length));
        self.bytes = self.bytes.saturating_add(length.saturating_mul(PER_BYTE));
        let (found, remedy) = (format!("{length} bytes"), "raise --memory-mib, or cut the chart to the area");
        let work = Work { file: path, thing: "file", found: &found, remedy };
        self.budget.memory(work, (PROGRAM_BYTES + self.bytes) as f64)
    }

    /// Checks all files of a cell against the catalogue of their set, and returns the result and what was left out.
    fn check(&self, root: &Path, stem: &str, files: &[(&CellFile, &ReadCell)]) -> Result<Vec<String>, Error> {
        let Some((set, catalogue)) = self.sets.get(root) else { return Ok(Vec::new()) };
        let closed = (set.closed > 0).then(|| format!("{} folders not looked into", set.closed));
        let agree = match catalogue {
            Some(catalogue) => catalogue.check(stem, files)?,
            None => "no CATALOG.031, so that no checksum was looked at".to_owned(),
        };
        Ok(closed.into_iter().chain([agree]).collect())
    }

    /// The objects of a cell, limited by memory.
    fn objects(&mut self, path: &Path, cell: &Cell, before: u64) -> Result<Vec<Feature>, Error> {
        let most = (self.budget.bytes() - (PROGRAM_BYTES + before) as f64).max(0.0) / PER_PLACE as f64;
        let objects = cell.features_within(most as u64).map_err(|e| Error::invalid(path, e))?;
        let places: u64 = objects.iter().map(|object| object.geometry.places()).sum();
        self.bytes = self.bytes.max(before + PER_PLACE * places);
        Ok(objects)
    }
}

/// A note on parts of a cell whose depths have another datum than `usual`.
fn other_datums(objects: &[Feature], usual: u8) -> Option<String> {
    let parts = objects.iter().filter(|object| chart::enc::class_name(object.class) == Some("M_SDAT"));
    let codes = parts.flat_map(|object| object.list(VERDAT)).filter(|code| *code != u16::from(usual));
    let names = codes.map(|code| datum_of(u8::try_from(code).unwrap_or_default()));
    let names: BTreeSet<String> = names.collect();
    (!names.is_empty()).then(|| format!("in parts depths are below {}", Vec::from_iter(names).join(", ")))
}

fn datum_of(code: u8) -> String {
    vertical_datum(code).map_or_else(|| format!("VERDAT {code}"), str::to_owned)
}

/// Reads another file of a cell, without following links.
fn other(file: &CellFile) -> Result<ReadCell, Error> {
    if !file.special {
        return ReadCell::read(&file.path);
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

/// Objects as a layer, and their treatment.
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
    let summary = PlanChart {
        file: path.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned()),
        classes: tallies.into_iter().map(|(class, tally)| (class, of(tally))).collect(),
        ..PlanChart::default()
    };
    Ok((layer, summary))
}

// Selects the updates of a cell, each once, checked against a catalogue.

/// A file of a cell, with its own identification.
struct ReadCell {
    path: PathBuf,
    bytes: Vec<u8>,
    identity: Identity,
}

impl ReadCell {
    fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        let identity = identify(&bytes).map_err(|e| Error::invalid(path, e))?;
        Ok(Self { path: path.to_path_buf(), bytes, identity })
    }

    fn age(&self) -> Age {
        age(&self.identity)
    }
}

/// Edition and update as numbers: the greater, the newer.
type Age = (Option<u32>, u32);

/// Bytes at the beginning of a file that identify it; its first records have some thousand.
const HEAD: u64 = 1 << 17;

/// The age of a file of a cell, by its first records.
fn age_of(path: &Path) -> Result<Age, Error> {
    let fails = |e| Error::io(path, "read", e);
    let mut head = Vec::new();
    files::open(path)?.take(HEAD).read_to_end(&mut head).map_err(fails)?;
    Ok(age(&identify(&head).map_err(|e| Error::invalid(path, e))?))
}

fn age(identity: &Identity) -> Age {
    (identity.edition.parse().ok(), identity.update)
}

/// The updates of a cell in their order, and notes on its other files.
#[derive(Default)]
struct Updates {
    files: BTreeMap<u32, ReadCell>,
    notes: Vec<String>,
    /// The number of files of other editions.
    others: BTreeMap<String, u32>,
}

impl Updates {
    /// The updates of `base` among the other files of its name.
    fn of(base: &ReadCell, others: Vec<ReadCell>) -> Result<Self, Error> {
        let mut updates = Self::default();
        for file in others.into_iter().filter(|file| file.bytes != base.bytes) {
            match file.identity.purpose {
                Purpose::Base => updates.other_base(base, &file)?,
                Purpose::Update => updates.update(base, file)?,
            }
        }
        for (edition, count) in &updates.others {
            let (edition, of) = (foreign(edition), foreign(&base.identity.edition));
            updates.notes.push(format!("{count} updates of edition {edition} not applied to edition {of}"));
        }
        if updates.files.is_empty() {
            let name = base.path.file_name().map_or_else(String::new, |n| n.to_string_lossy().into_owned());
            updates.notes.push(format!("no updates found beside {}", foreign(&name)));
        }
        Ok(updates)
    }

    fn other_base(&mut self, base: &ReadCell, other: &ReadCell) -> Result<(), Error> {
        let name = |file: &ReadCell| {
            format!("edition {}, update {}", foreign(&file.identity.edition), file.identity.update)
        };
        let same = (&other.identity.edition, other.identity.update)
            == (&base.identity.edition, base.identity.update);
        if same || other.age().0 > base.age().0 {
            let given = format!("{}, and {} with {}", name(base), other.path.display(), name(other));
            let (expected, remedy) =
                ("the newest base cell, once", "name the newest, and move the other away");
            return Err(Error::refuse(&base.path, "cell", given, expected, remedy));
        }
        self.notes.push(format!("another base cell ({}) not used", name(other)));
        Ok(())
    }

    fn update(&mut self, base: &ReadCell, file: ReadCell) -> Result<(), Error> {
        let edition = &file.identity.edition;
        // Edition 0 cancels the cell.
        if *edition != base.identity.edition && edition != "0" {
            *self.others.entry(edition.clone()).or_default() += 1;
            return Ok(());
        }
        let number = file.identity.update;
        if let Some(known) = self.files.get(&number).filter(|known| known.bytes != file.bytes) {
            let given = format!("another update {number} than {}", known.path.display());
            let remedy = "keep the one of the newest exchange set, and move the other away";
            return Err(Error::refuse(&file.path, "update", given, "each update once", remedy));
        }
        self.files.entry(number).or_insert(file);
        Ok(())
    }
}

/// The catalogue of an exchange set; empty if there is none.
pub(super) struct Catalogue {
    file: PathBuf,
    listed: Vec<Listed>,
}

impl Catalogue {
    fn of(set: &ExchangeSet, provenance: &mut Provenance) -> Result<Option<Self>, Error> {
        let Some(file) = set.catalogue.clone() else { return Ok(None) };
        let listed = listed(&bytes(&file, provenance)?).map_err(|e| Error::invalid(&file, e))?;
        Ok(Some(Self { file, listed }))
    }

    /// Refuses files of a cell that are missing or changed since the catalogue was made, and reports how many agree.
    fn check(&self, stem: &str, files: &[(&CellFile, &ReadCell)]) -> Result<String, Error> {
        let of_cell = |entry: &&Listed| entry.name().strip_prefix(stem).is_some_and(is_number);
        let of_cell: Vec<&Listed> = self.listed.iter().filter(of_cell).collect();
        let places: BTreeSet<&[String]> = of_cell.iter().map(|entry| &entry.place[..]).collect();
        // A file may be at another path than listed, but for one entry only.
        let stands_for = |file: &CellFile, entry: &Listed| {
            file.place == entry.place || (file.name() == entry.name() && !places.contains(&file.place[..]))
        };
        if let Some(missing) = of_cell.iter().find(|e| !files.iter().any(|(file, _)| stands_for(file, e))) {
            let given = format!("no file {}, which it lists", foreign(&missing.place.join("/")));
            let remedy = "copy the exchange set again, as a whole";
            return Err(Error::refuse(&self.file, "exchange set", given, "all files of the cell", remedy));
        }
        let mut agree = 0;
        for (file, ReadCell { bytes, .. }) in files {
            let listed: Vec<&&Listed> = of_cell.iter().filter(|entry| stands_for(file, entry)).collect();
            if !listed.is_empty() && !listed.iter().any(|entry| entry.agrees(bytes)) {
                let given = format!("CRC-32 {:08X}", chart::enc::crc(bytes));
                let expected =
                    format!("{:08X}, as {} says", listed[0].crc.unwrap_or_default(), self.file.display());
                let remedy =
                    "copy the exchange set again, as a whole: the file is damaged, or not of this set";
                return Err(Error::refuse(&file.path, "file", given, expected, remedy));
            }
            agree += usize::from(listed.iter().any(|entry| entry.crc.is_some()));
        }
        Ok(match files.len() - agree {
            0 => format!("all {agree} files agree with CATALOG.031"),
            rest => format!("{agree} files agree with CATALOG.031, {rest} have no checksum there"),
        })
    }
}

/// Whether the rest of a name is the number of a cell's file.
fn is_number(suffix: &str) -> bool {
    suffix.strip_prefix('.').is_some_and(|n| n.len() == 3 && n.bytes().all(|b| b.is_ascii_digit()))
}
