//! `seatrial verify`: whether the files in a folder are whole and belong together, and what was made of what.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::{Digest, Error, Inspected, Provenance, STUDY_ROLES, inspect};
use clap::Parser;

use crate::failure::Failure;
use crate::said::on_stdout;

/// Checks that the files in folders are whole and belong together, and prints what was made of what
#[derive(Parser)]
#[command(
    name = "verify",
    after_help = "A file that is not in the folder is shown by its role alone; name the hand-written ones with --study.\n\n\
    Example:\n  verify out/paper --study pipelines/paper"
)]
pub struct Verify {
    /// Folders that the stages wrote into, with those below them
    #[arg(required = true, value_name = "FOLDER")]
    folders: Vec<PathBuf>,
    /// Folder of the hand-written files, where the folders are of one study
    #[arg(long, value_name = "FOLDER")]
    study: Option<PathBuf>,
}

/// What was looked at.
#[derive(Default)]
struct Folder {
    /// Of each file, in their order: what it says about itself, or what is wrong with it.
    files: Vec<(PathBuf, Result<Inspected, Error>)>,
    /// Names of files by their digests.
    names: BTreeMap<Digest, String>,
    faults: Vec<String>,
}

impl Verify {
    /// Prints the graph and what is wrong.
    ///
    /// # Errors
    /// A folder that cannot be listed or has nothing to verify; files that are damaged or do not belong together.
    pub fn run(&self) -> Result<(), Failure> {
        self.folders.iter().try_for_each(|root| self.folder(root))
    }

    fn folder(&self, root: &Path) -> Result<(), Failure> {
        let mut folder = Folder::default();
        let known = self.written(&mut folder)?;
        folder.look(root, root)?;
        if folder.files.is_empty() {
            let (found, expected) = ("no document and no table", "files that the stages wrote");
            return Err(Failure::refuse(root, "files", found, expected, "name another folder"));
        }
        folder.compare(root, &known);
        folder.files.iter().for_each(|(path, found)| on_stdout(folder.line(root, path, found)));
        folder.faults.iter().for_each(|fault| on_stdout(format_args!("fault: {fault}")));
        let (files, faults) = (folder.files.len(), folder.faults.len());
        match faults {
            0 => {
                on_stdout(format_args!("{}: {files} files, whole and of one study", root.display()));
                Ok(())
            }
            _ => {
                let (found, expected) =
                    (format!("{faults} faults in {files} files"), "whole files of one study");
                Err(Failure::refuse(root, "files", &found, expected, "make again what is named above"))
            }
        }
    }

    /// What the hand-written files tell.
    fn written(&self, folder: &mut Folder) -> Result<Provenance, Failure> {
        let mut known = Provenance::default();
        let Some(study) = &self.study else { return Ok(known) };
        let mut found = 0;
        for role in STUDY_ROLES {
            let path = study.join(format!("{role}.toml"));
            if path.is_file() {
                let digest = Digest::of_file(&path)?;
                folder.names.insert(digest, path.display().to_string());
                known.written(role, &path, digest)?;
                found += 1;
            }
        }
        match found {
            0 => Err(Failure::refuse(
                study,
                "--study",
                "no vessel.toml, dictionary.toml or campaign.toml",
                "the folder of a study",
                "name another folder",
            )),
            _ => Ok(known),
        }
    }
}

impl Folder {
    /// Looks at all files below `folder`, those of a folder before those in folders of it.
    fn look(&mut self, root: &Path, folder: &Path) -> Result<(), Failure> {
        let fails = |e| Error::io(folder, "list", e);
        let entries = std::fs::read_dir(folder).map_err(fails)?;
        let mut paths: Vec<PathBuf> =
            entries.map(|entry| entry.map(|entry| entry.path())).collect::<Result<_, _>>().map_err(fails)?;
        paths.sort();
        let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) =
            paths.into_iter().partition(|path| path.is_dir());
        for path in files {
            let found = inspect(&path);
            if let Ok(Some(own)) = &found {
                self.names.insert(own.digest, relative(root, &path));
            }
            self.files.extend(found.transpose().map(|found| (path, found)));
        }
        folders.iter().filter(|path| !path.is_symlink()).try_for_each(|path| self.look(root, path))
    }

    /// Notes what is wrong: files that are damaged, and files that were made of different ones. Each folder has estimates and
    /// scores of its own and shares the rest with the folder above it, where that has files.
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
            // What stands in the folder is no mixture, whatever else plays its role there: `estimates-2.parquet`.
            let mut from = found.provenance.clone();
            from.inputs.retain(|_, digest| !self.names.contains_key(digest));
            from.origins.retain(|_, digest| !self.names.contains_key(digest));
            if let Err(error) = own.made(study::role_of(&name), path, found.digest, &from) {
                self.faults.push(error.to_string());
            }
        }
    }

    /// `design.json: design/1, of moments (moments.json)`.
    fn line(&self, root: &Path, path: &Path, found: &Result<Inspected, Error>) -> String {
        let name = relative(root, path);
        let Ok(found) = found else { return format!("{name}: damaged") };
        let input = |(role, digest): (&String, &Digest)| match self.names.get(digest) {
            Some(name) => format!("{role} ({name})"),
            None => role.clone(),
        };
        let logs = found.provenance.inputs.keys().filter(|role| role.starts_with("log:")).count();
        let others = found.provenance.inputs.iter().filter(|(role, _)| !role.starts_with("log:"));
        let mut inputs: Vec<String> = others.map(input).collect();
        if logs > 0 {
            inputs.push(format!("{logs} logs"));
        }
        let of = if inputs.is_empty() { String::new() } else { format!(", of {}", inputs.join(", ")) };
        let unsealed = if found.sealed { "" } else { ", edited by hand (no seal)" };
        format!("{name}: {}{unsealed}{of}", found.schema)
    }
}

fn relative(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).display().to_string()
}
