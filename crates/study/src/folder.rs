//! A folder of results: checks that its files are complete and belong together, and their dependencies.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use files::{Digest, Error, Inspected, Provenance, STUDY_ROLES, check_members, inspect, is_unfinished};
use refusal::{foreign, one_line, shortened};

use crate::outdated::outdated;
use crate::{refuse, role_of};

/// The files of a folder and of those below it.
#[derive(Default)]
pub struct Folder {
    /// Each file in order, with its own metadata, or its error.
    files: Vec<(PathBuf, Result<Inspected, Error>)>,
    /// How many unfinished files are in it, and in those below it.
    unfinished: Vec<(PathBuf, usize)>,
    /// Names of files by their digests.
    names: BTreeMap<Digest, String>,
    /// The errors, one line each.
    pub faults: Vec<String>,
}

impl Folder {
    /// Inspects all files below `root`, and the hand-written ones of their `study`.
    ///
    /// # Errors
    /// A folder that cannot be listed, has no file of any stage, or is not a study's.
    pub fn read(root: &Path, study: Option<&Path>) -> Result<Self, Error> {
        let mut folder = Self::default();
        let known = study.map_or(Ok(Provenance::default()), |study| folder.written(study))?;
        folder.look(root)?;
        if folder.files.is_empty() {
            let (found, expected) = ("no document and no table", "files that the stages wrote");
            return Err(refuse(root, "files", found, expected, "name another folder"));
        }
        folder.check_sets();
        folder.name(root);
        folder.compare(root, &known);
        // The record of `run` knows more than the documents.
        if let Some(study) = study.filter(|_| !root.join("run.json").is_file()) {
            let found = folder.files.iter().filter_map(|(path, found)| Some((path, found.as_ref().ok()?)));
            let outdated: Vec<String> =
                found.flat_map(|(path, found)| outdated(path, found, study)).collect();
            folder.faults.extend(outdated);
        }
        Ok(folder)
    }

    /// Number of files.
    pub fn count(&self) -> usize {
        self.files.len()
    }

    /// A line for each file: its kind and its inputs; and for each folder with unfinished files.
    pub fn lines(&self, root: &Path) -> impl Iterator<Item = String> {
        let files = self.files.iter().map(move |(path, found)| self.line(root, path, found));
        let unfinished = self.unfinished.iter().map(|(folder, count)| {
            let folder = folder.display();
            format!("{folder}: {count} unfinished, removed by the next stage that writes here if its process has ended")
        });
        files.chain(unfinished).map(|line| shortened(&one_line(&line), LONGEST))
    }

    /// The provenance of the hand-written files.
    fn written(&mut self, study: &Path) -> Result<Provenance, Error> {
        let mut known = Provenance::default();
        for role in STUDY_ROLES {
            let path = study.join(format!("{role}.toml"));
            if path.is_file() {
                let digest = Digest::of_file(&path)?;
                self.names.insert(digest, path.display().to_string());
                known.written(role, &path, digest)?;
            }
        }
        if known.inputs.is_empty() {
            let found = "no vessel.toml, dictionary.toml or campaign.toml";
            return Err(refuse(study, "--study", found, "the folder of a study", "name another folder"));
        }
        Ok(known)
    }

    /// Inspects all files below `folder`, those of a folder before those in its subfolders.
    fn look(&mut self, folder: &Path) -> Result<(), Error> {
        let fails = |e| Error::io(folder, "list", e);
        let entries = std::fs::read_dir(folder).map_err(fails)?;
        let mut paths: Vec<PathBuf> =
            entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(fails)?;
        paths.sort();
        let count = paths.iter().filter(|path| is_unfinished(path)).count();
        self.unfinished.extend((count > 0).then(|| (folder.to_owned(), count)));
        paths.retain(|path| !is_unfinished(path));
        let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) =
            paths.into_iter().partition(|path| path.is_dir());
        for path in files {
            self.files.extend(inspect(&path).transpose().map(|found| (path, found)));
        }
        folders.iter().filter(|path| !path.is_symlink()).try_for_each(|path| self.look(path))
    }

    /// Checks that files written together are together, without reading inspected files again.
    fn check_sets(&mut self) {
        let found =
            self.files.iter().filter_map(|(path, found)| Some((path.clone(), found.as_ref().ok()?.digest)));
        let known: BTreeMap<PathBuf, Digest> = found.collect();
        for (path, found) in &mut self.files {
            let Ok(own) = &*found else { continue };
            if let Err(mixed) = check_members(path, &own.members, |path| known.get(path).copied()) {
                *found = Err(mixed);
            }
        }
    }

    fn name(&mut self, root: &Path) {
        for (path, found) in &self.files {
            if let Ok(own) = found {
                self.names.insert(own.digest, relative(root, path));
            }
        }
    }

    /// Notes what is wrong: damaged files, and files that were made from different ones. Each folder has its own
    /// estimates and scores and shares the rest with its parent folder, if that has files.
    fn compare(&mut self, root: &Path, written: &Provenance) {
        let mut known: BTreeMap<&Path, Provenance> = BTreeMap::new();
        for (path, found) in &self.files {
            let found = match found {
                Ok(found) => found,
                Err(error) => {
                    self.faults.push(error.to_string());
                    continue;
                }
            };
            let folder = path.parent().unwrap_or(root);
            let above = || {
                let nearest =
                    folder.ancestors().skip(1).find_map(|above| known.get(above)).unwrap_or(written);
                let mut own = nearest.clone();
                own.forget(&["estimates", "validation"]);
                own
            };
            let own = if known.contains_key(folder) { None } else { Some(above()) };
            let own = known.entry(folder).or_insert_with(|| own.unwrap_or_default());
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            // Another file with the same role in the folder is no error: `estimates-2.parquet`.
            let mut from = found.provenance.clone();
            from.inputs.retain(|_, digest| !self.names.contains_key(digest));
            from.origins.retain(|_, digest| !self.names.contains_key(digest));
            if let Err(error) = own.made(role_of(&name), path, found.digest, &from) {
                self.faults.push(error.to_string());
            }
        }
    }

    /// `design.json: design/1, of moments (moments.json)`.
    fn line(&self, root: &Path, path: &Path, found: &Result<Inspected, Error>) -> String {
        let name = relative(root, path);
        let Ok(found) = found else { return format!("{name}: damaged") };
        let input = |(role, digest): (&String, &Digest)| match self.names.get(digest) {
            Some(name) => format!("{} ({name})", foreign(role)),
            None => foreign(role),
        };
        let logs = found.provenance.inputs.keys().filter(|role| role.starts_with("log:")).count();
        let others = found.provenance.inputs.iter().filter(|(role, _)| !role.starts_with("log:"));
        let mut inputs: Vec<String> = others.map(input).collect();
        if logs > 0 {
            inputs.push(format!("{logs} logs"));
        }
        let of = if inputs.is_empty() { String::new() } else { format!(", of {}", inputs.join(", ")) };
        let unsealed = if found.sealed { "" } else { ", edited by hand (no seal)" };
        format!("{name}: {}{unsealed}{of}", foreign(&found.schema))
    }
}

/// Maximum number of characters of a line.
const LONGEST: usize = 490;

fn relative(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).display().to_string()
}
