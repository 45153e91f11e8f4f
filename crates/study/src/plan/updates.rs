//! Selects the updates of a cell, each once, checked against a catalogue.

use std::collections::{BTreeMap, BTreeSet};
use std::io::Read;
use std::path::{Path, PathBuf};

use chart::enc::{Identity, Listed, Purpose, identify, listed};
use files::{Error, Provenance};
use refusal::foreign;

use super::chart_file::bytes;
use super::exchange_set::{CellFile, ExchangeSet};

/// A file of a cell, with its own identification.
pub(super) struct Found {
    pub path: PathBuf,
    pub bytes: Vec<u8>,
    identity: Identity,
}

impl Found {
    pub(super) fn read(path: &Path) -> Result<Self, Error> {
        let bytes = files::read(path)?;
        let identity = identify(&bytes).map_err(|e| Error::invalid(path, e))?;
        Ok(Self { path: path.to_path_buf(), bytes, identity })
    }

    fn age(&self) -> Age {
        age(&self.identity)
    }
}

/// Edition and update as numbers: the greater, the newer.
pub(super) type Age = (Option<u32>, u32);

/// Bytes at the beginning of a file that identify it; its first records have some thousand.
const HEAD: u64 = 1 << 17;

/// The age of a file of a cell, by its first records.
pub(super) fn age_of(path: &Path) -> Result<Age, Error> {
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
pub(super) struct Updates {
    pub files: BTreeMap<u32, Found>,
    pub notes: Vec<String>,
    /// The number of files of other editions.
    others: BTreeMap<String, u32>,
}

impl Updates {
    /// The updates of `base` among the other files of its name.
    ///
    /// # Errors
    /// A newer edition of the cell; two different files with the same identification.
    pub(super) fn of(base: &Found, others: Vec<Found>) -> Result<Self, Error> {
        let mut own = Self::default();
        for file in others.into_iter().filter(|file| file.bytes != base.bytes) {
            match file.identity.purpose {
                Purpose::Base => own.other_base(base, &file)?,
                Purpose::Update => own.update(base, file)?,
            }
        }
        for (edition, count) in &own.others {
            let (edition, of) = (foreign(edition), foreign(&base.identity.edition));
            own.notes.push(format!("{count} updates of edition {edition} not applied to edition {of}"));
        }
        if own.files.is_empty() {
            let name =
                base.path.file_name().map_or_else(String::new, |name| name.to_string_lossy().into_owned());
            own.notes.push(format!("no updates found beside {}", foreign(&name)));
        }
        Ok(own)
    }

    fn other_base(&mut self, base: &Found, other: &Found) -> Result<(), Error> {
        let name = |file: &Found| {
            format!("edition {}, update {}", foreign(&file.identity.edition), file.identity.update)
        };
        let same = (&other.identity.edition, other.identity.update)
            == (&base.identity.edition, base.identity.update);
        if same || other.age().0 > base.age().0 {
            let found = format!("{}, and {} with {}", name(base), other.path.display(), name(other));
            let (expected, remedy) =
                ("the newest base cell, once", "name the newest, and move the other away");
            return Err(Error::refuse(&base.path, "cell", found, expected, remedy));
        }
        self.notes.push(format!("another base cell ({}) not used", name(other)));
        Ok(())
    }

    fn update(&mut self, base: &Found, file: Found) -> Result<(), Error> {
        let edition = &file.identity.edition;
        // Edition 0 cancels the cell.
        if *edition != base.identity.edition && edition != "0" {
            *self.others.entry(edition.clone()).or_default() += 1;
            return Ok(());
        }
        let number = file.identity.update;
        if let Some(known) = self.files.get(&number).filter(|known| known.bytes != file.bytes) {
            let found = format!("another update {number} than {}", known.path.display());
            let remedy = "keep the one of the newest exchange set, and move the other away";
            return Err(Error::refuse(&file.path, "update", found, "each update once", remedy));
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
    pub(super) fn of(set: &ExchangeSet, provenance: &mut Provenance) -> Result<Option<Self>, Error> {
        let Some(file) = set.catalogue.clone() else { return Ok(None) };
        let listed = listed(&bytes(&file, provenance)?).map_err(|e| Error::invalid(&file, e))?;
        Ok(Some(Self { file, listed }))
    }

    /// Refuses files of a cell that are missing or changed since the catalogue was made, and reports how many agree.
    pub(super) fn check(&self, stem: &str, files: &[(&CellFile, &Found)]) -> Result<String, Error> {
        let of_cell = |own: &&Listed| own.name().strip_prefix(stem).is_some_and(is_number);
        let own: Vec<&Listed> = self.listed.iter().filter(of_cell).collect();
        let places: BTreeSet<&[String]> = own.iter().map(|own| &own.place[..]).collect();
        // A file may be at another path than listed, but for one entry only.
        let stands_for = |file: &CellFile, own: &Listed| {
            file.place == own.place || (file.name() == own.name() && !places.contains(&file.place[..]))
        };
        if let Some(missing) = own.iter().find(|own| !files.iter().any(|(file, _)| stands_for(file, own))) {
            let found = format!("no file {}, which it lists", foreign(&missing.place.join("/")));
            let remedy = "copy the exchange set again, as a whole";
            return Err(Error::refuse(&self.file, "exchange set", found, "all files of the cell", remedy));
        }
        let mut agree = 0;
        for (file, Found { bytes, .. }) in files {
            let listed: Vec<&&Listed> = own.iter().filter(|own| stands_for(file, own)).collect();
            if !listed.is_empty() && !listed.iter().any(|own| own.agrees(bytes)) {
                let found = format!("CRC-32 {:08X}", chart::enc::crc(bytes));
                let expected =
                    format!("{:08X}, as {} says", listed[0].crc.unwrap_or_default(), self.file.display());
                let remedy =
                    "copy the exchange set again, as a whole: the file is damaged, or not of this set";
                return Err(Error::refuse(&file.path, "file", found, expected, remedy));
            }
            agree += usize::from(listed.iter().any(|own| own.crc.is_some()));
        }
        Ok(match files.len() - agree {
            0 => format!("all {agree} files agree with CATALOG.031"),
            rest => format!("{agree} files agree with CATALOG.031, {rest} have no checksum there"),
        })
    }
}

/// Whether the rest of a name is the number of a cell's file.
fn is_number(suffix: &str) -> bool {
    suffix.strip_prefix('.').is_some_and(|own| own.len() == 3 && own.bytes().all(|b| b.is_ascii_digit()))
}
