//! Sums of runs, merged.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::{Error, Loaded, Provenance, read_document};
use identification::pooled::RunSums;
use vessel::Vessel;

use crate::documents::SumsDocument;

/// What the sums are usually called.
pub const MAIN: &str = "sums.json";

/// The sums of several files together.
pub struct MergedSums {
    /// The first file's, and what of it holds for all: how they were made; the designs of all.
    pub about: SumsDocument,
    /// The sums.
    pub sums: RunSums,
    /// Number of runs.
    pub runs: u64,
}

/// The sums of all `files`, which were made for `vessel`; they become inputs. Files come in the order of their digests, so that
/// the same files give the same in any order.
///
/// # Errors
/// Files that are refused; sums that were made otherwise than the others; runs that are in several files.
pub fn merged(files: &[PathBuf], vessel: &Vessel, provenance: &mut Provenance) -> Result<MergedSums, Error> {
    let read = |path: &'_ PathBuf| read_document::<SumsDocument>(path).map(|loaded| (path.clone(), loaded));
    let mut all: Vec<(PathBuf, Loaded<SumsDocument>)> = files.iter().map(read).collect::<Result<_, _>>()?;
    all.sort_by_key(|(_, loaded)| loaded.digest.to_string());
    let (mut sums, mut runs, mut known) = (RunSums::default(), 0_u64, BTreeMap::new());
    for (i, (path, loaded)) in all.iter().enumerate() {
        provenance.made(&format!("sums {}", i + 1), path, loaded.digest, &loaded.provenance)?;
        loaded.data.check_vessel(vessel).map_err(|e| Error::invalid(path, e))?;
        let (first, about) = (&all[0].0, &all[0].1.data);
        if let Some([thing, expected, found]) = about.difference(&loaded.data) {
            let expected = format!("{expected} as in {}", first.display());
            let remedy = "name sums that were made alike";
            return Err(crate::refuse(path, &thing, &found, &expected, remedy));
        }
        let of = loaded.provenance.inputs.get("trajectories").copied();
        check_new(path, &loaded.data.runs, known.entry(of).or_default())?;
        runs = loaded
            .data
            .runs
            .iter()
            .fold(runs, |runs: u64, [first, last]| runs.saturating_add(last - first).saturating_add(1));
        sums.merge(&loaded.data.sums());
    }
    let mut designs: Vec<String> = all.iter().flat_map(|(_, own)| own.data.designs.clone()).collect();
    designs.sort_unstable();
    designs.dedup();
    let Some((_, first)) = all.into_iter().next() else { unreachable!("there is a file to merge") };
    Ok(MergedSums { about: SumsDocument { designs, ..first.data }, sums, runs })
}

/// The runs of some trajectories that were added up, and the file with their sums.
type Added = Vec<([u64; 2], PathBuf)>;

/// Refuses runs of trajectories that are among the `known` ones of these, and takes them among them.
fn check_new(path: &Path, runs: &[[u64; 2]], known: &mut Added) -> Result<(), Error> {
    for [first, last] in runs {
        let twice = known.iter().find(|([low, high], _)| first <= high && low <= last);
        if let Some(([low, _], other)) = twice {
            let found =
                format!("run number {} that {} holds too", first.max(low).saturating_add(1), other.display());
            let expected = "each run of the trajectories once";
            return Err(crate::refuse(path, "`runs`", &found, expected, "name each run's sums once"));
        }
        known.push(([*first, *last], path.to_owned()));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn runs_in_two_files_are_seen() {
        let mut known = Added::new();
        let mut check = |name: &str, runs: &[[u64; 2]]| check_new(Path::new(name), runs, &mut known);
        check("a", &[[0, 3], [7, 7]]).unwrap();
        check("b", &[[4, 6], [8, 9]]).unwrap();
        let refused = check("c", &[[10, 12], [6, 7]]).unwrap_err().to_string();
        assert!(refused.contains("c: `runs`: found run number 8 that a holds too"), "{refused}");
    }
}
