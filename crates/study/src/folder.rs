//! A folder of results: checks that its files are complete and belong together, and their dependencies.

use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};

use chart::{Bounds, Plane};
use files::{
    Digest, Error, Inspected, Provenance, STUDY_ROLES, budget, check_members, inspect, is_unfinished,
};
use refusal::{foreign, one_line, shortened};

use crate::plan::{ChartsError, Means, read_charts};
use crate::written::files::{read_ingest, read_plan};
use crate::written::ingest_file::recordings::find;
use crate::{invalid, refuse, role_of};

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
            let inspected = folder.files.iter().filter_map(|(path, file)| Some((path, file.as_ref().ok()?)));
            let outdated: Vec<String> =
                inspected.flat_map(|(path, inspected)| outdated(path, inspected, study)).collect();
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
            let given = "no vessel.toml, dictionary.toml or campaign.toml";
            return Err(refuse(study, "--study", given, "the folder of a study", "name another folder"));
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
        let (folders, files): (Vec<PathBuf>, Vec<PathBuf>) = paths.into_iter().partition(|p| p.is_dir());
        for path in files {
            self.files.extend(inspect(&path).transpose().map(|inspected| (path, inspected)));
        }
        folders.iter().filter(|path| !path.is_symlink()).try_for_each(|path| self.look(path))
    }

    /// Checks that files written together are together, without reading inspected files again.
    fn check_sets(&mut self) {
        let digests =
            self.files.iter().filter_map(|(path, file)| Some((path.clone(), file.as_ref().ok()?.digest)));
        let known: BTreeMap<PathBuf, Digest> = digests.collect();
        for (path, state) in &mut self.files {
            let Ok(inspected) = &*state else { continue };
            if let Err(mixed) = check_members(path, &inspected.members, |path| known.get(path).copied()) {
                *state = Err(mixed);
            }
        }
    }

    fn name(&mut self, root: &Path) {
        for (path, found) in &self.files {
            if let Ok(inspected) = found {
                self.names.insert(inspected.digest, relative(root, path));
            }
        }
    }

    /// Notes what is wrong: damaged files, and files that were made from different ones. Each folder has its own
    /// estimates and scores and shares the rest with its parent folder, if that has files.
    fn compare(&mut self, root: &Path, written: &Provenance) {
        let mut known: BTreeMap<&Path, Provenance> = BTreeMap::new();
        for (path, inspected) in &self.files {
            let inspected = match inspected {
                Ok(inspected) => inspected,
                Err(error) => {
                    self.faults.push(error.to_string());
                    continue;
                }
            };
            let folder = path.parent().unwrap_or(root);
            let above = || {
                let nearest = folder.ancestors().skip(1).find_map(|a| known.get(a)).unwrap_or(written);
                let mut provenance = nearest.clone();
                provenance.forget(&["estimates", "validation"]);
                provenance
            };
            let missing = if known.contains_key(folder) { None } else { Some(above()) };
            let provenance = known.entry(folder).or_insert_with(|| missing.unwrap_or_default());
            let name = path.file_name().unwrap_or_default().to_string_lossy();
            // Another file with the same role in the folder is no error: `estimates-2.parquet`.
            let mut from = inspected.provenance.clone();
            from.inputs.retain(|_, digest| !self.names.contains_key(digest));
            from.origins.retain(|_, digest| !self.names.contains_key(digest));
            if let Err(error) = provenance.made(role_of(&name), path, inspected.digest, &from) {
                self.faults.push(error.to_string());
            }
        }
    }

    /// `design.json: design/1, of moments (moments.json)`.
    fn line(&self, root: &Path, path: &Path, inspected: &Result<Inspected, Error>) -> String {
        let name = relative(root, path);
        let Ok(inspected) = inspected else { return format!("{name}: damaged") };
        let input = |(role, digest): (&String, &Digest)| match self.names.get(digest) {
            Some(name) => format!("{} ({name})", foreign(role)),
            None => foreign(role),
        };
        let logs = inspected.provenance.inputs.keys().filter(|role| role.starts_with("log:")).count();
        let others = inspected.provenance.inputs.iter().filter(|(role, _)| !role.starts_with("log:"));
        let mut inputs: Vec<String> = others.map(input).collect();
        if logs > 0 {
            inputs.push(format!("{logs} logs"));
        }
        let of = if inputs.is_empty() { String::new() } else { format!(", of {}", inputs.join(", ")) };
        let unsealed = if inspected.sealed { "" } else { ", edited by hand (no seal)" };
        format!("{name}: {}{unsealed}{of}", foreign(&inspected.schema))
    }
}

/// Maximum number of characters of a line.
const LONGEST: usize = 490;

fn relative(root: &Path, path: &Path) -> String {
    path.strip_prefix(root).unwrap_or(path).display().to_string()
}

// Documents whose files in the study are not what they were made of any more.

/// Digests of inputs by their roles, now; `None` if it is not known where they are.
type Now = Option<BTreeMap<String, Digest>>;

/// Files that the document or table `found` at `path` was made of and that are not so in the folder `study`, one line each.
fn outdated(path: &Path, found: &Inspected, study: &Path) -> Vec<String> {
    let made = &found.provenance;
    let now = match found.schema.split('/').next() {
        Some("plan") => of_plan(path, made, study),
        Some("ingest") => of_logs(study),
        // What was made of these has their roles.
        _ => Ok(Some(made.inputs.clone())),
    };
    let mut now = match now {
        Ok(Some(now)) => now,
        Ok(None) => return Vec::new(),
        Err(error) => return vec![error.to_string()],
    };
    // Tables of a dictionary have names relative to the study; what is not there is elsewhere.
    let tables = made.inputs.keys().filter_map(|role| Some((role, role.strip_prefix("inputs:")?)));
    now.extend(tables.filter_map(|(role, n)| Some((role.clone(), Digest::of_file(study.join(n)).ok()?))));
    // With values that were replaced on the command line, the digest is of what was read instead.
    let is_changed = |role: &str| made.settings.contains_key("set") && ["plan", "config"].contains(&role);
    let kinds = ["chart:", "tide", "log:"];
    let before = made.inputs.keys().filter(|role| kinds.iter().any(|kind| role.starts_with(kind)));
    let roles: BTreeSet<&String> = before.chain(now.keys()).collect();
    let differs = |role: &&String| !is_changed(role) && made.inputs.get(*role) != now.get(*role);
    let fault = |role: &String| {
        let given = match (made.inputs.get(role), now.get(role)) {
            (Some(_), Some(_)) => "another content in the study",
            (Some(_), None) => "no such file in the study",
            _ => "it in the study, where it was not",
        };
        refuse(path, role, given, "the files that this was made of", "run its stage again").to_string()
    };
    roles.into_iter().filter(differs).map(fault).collect()
}

/// The files of the plan at `path`: plan.toml, or that called as the plan or its folder.
fn of_plan(path: &Path, made: &Provenance, study: &Path) -> Result<Now, Error> {
    let folders = [path.file_stem(), path.parent().and_then(Path::file_name)].into_iter().flatten();
    let mut names = folders.map(|name| name.to_string_lossy().into_owned());
    let name = names.find(|name| name.starts_with("plan-")).unwrap_or_else(|| "plan".to_owned());
    let file = study.join(format!("{name}.toml"));
    if !file.is_file() {
        return Ok(None);
    }
    let mut now = Provenance::default();
    let config = read_plan(&file, &mut now)?;
    // The charts of another plan.toml say nothing.
    if made.inputs.get("plan") != now.inputs.get("plan") && !made.settings.contains_key("set") {
        let charts = made.inputs.iter().filter(|(role, _)| *role != "plan");
        now.inputs.extend(charts.map(|(role, digest)| (role.clone(), *digest)));
        return Ok(Some(now.inputs));
    }
    let plane = Plane::new(config.start.longitude_deg, config.start.latitude_deg);
    let plane = plane.map_err(|wrong| invalid(&file, &wrong))?;
    let bounds = Bounds::new([-50.0; 2], [50.0; 2]).map_err(|wrong| invalid(&file, &wrong))?;
    let means = Means { area: (&plane, &bounds), budget: budget(), keep_going: &|| true };
    match read_charts(&file, &config, &means, &mut now) {
        Err(ChartsError::Refused(error)) => return Err(error),
        Err(ChartsError::OutOfTime) | Ok(_) => {}
    }
    if let Some(tide) = &config.tide {
        now.inputs.insert("tide".to_owned(), Digest::of_file(study.join(&tide.file))?);
    }
    Ok(Some(now.inputs))
}

/// ingest.toml and the logs that it names, in the folder `logs` of the study or the study itself.
fn of_logs(study: &Path) -> Result<Now, Error> {
    let file = study.join("ingest.toml");
    if !file.is_file() {
        return Ok(None);
    }
    let mut now = Provenance::default();
    let config = read_ingest(&file, &mut now)?;
    let naming = config.naming().map_err(|wrong| invalid(&file, &wrong))?;
    let folders = [study.join("logs"), study.to_owned()];
    let Some(folder) = folders.iter().find(|folder| find(&config, &naming, &file, folder).is_ok()) else {
        return Ok(None);
    };
    for name in
        find(&config, &naming, &file, folder)?.iter().flat_map(|recording| recording.files.iter().flatten())
    {
        now.inputs.insert(format!("log:{name}"), Digest::of_file(folder.join(name))?);
    }
    Ok(Some(now.inputs))
}
