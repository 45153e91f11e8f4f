//! A study from its first files to its page: what it begins with, which stages run with which flags, and which of them are
//! up to date.
//!
//! [`starting`] writes the hand-written files of a new study. A [`Pipeline`] lists the stages of a study as command lines; a
//! [`RunRecord`] knows by digests which of them need not run again. Whoever has the stages runs them.

pub mod settings;
pub mod starting;
mod steps;

use std::collections::BTreeMap;
use std::ffi::OsString;
use std::path::{Path, PathBuf, absolute};

use files::{
    Digest, Error, Observed, Provenance, Trace, commit, read_document, read_hand_written, slashed,
    stage_document, trace,
};
use refusal::{Invalid, foreign};
use ship::model::VesselFile;
use steps::{StudyShape, measured, simulated, simulated_logs};
use study::documents::{RunDocument, RunStage};
use study::files::read_ingest;
use study::ingest_file::recordings::find;
use study::refuse;

pub use settings::StudySettings;
pub use steps::StudyStep;

/// The hand-written files that a study needs, what each is, and which of the two kinds of `new` write it.
const WRITTEN: [(&str, &str, &str); 4] = [
    ("vessel.toml", "the ship and its model", "--vessel <preset>"),
    ("dictionary.toml", "the maneuvers", "--vessel <preset>"),
    ("campaign.toml", "disturbances, noise and number of the simulated trials", "--vessel <preset>"),
    ("ingest.toml", "what is in the logs", "--vessel <preset> --logs <folder>"),
];

/// A study: its folders and stages.
#[derive(Debug)]
pub struct Pipeline {
    pub(crate) folders: Folders,
    dictionary: PathBuf,
    logs: PathBuf,
    /// The stages in the order in which they run.
    pub steps: Vec<StudyStep>,
}

impl Pipeline {
    /// The study in the folder `study` with these `settings`, whose results are in `out`, with the logs in `logs` or where its
    /// settings say.
    pub fn read(
        study: &Path,
        out: &Path,
        settings: &StudySettings,
        logs: Option<&Path>,
    ) -> Result<Self, Error> {
        let has = |name: &str| study.join(name).is_file();
        check_study(study)?;
        let mut shape = StudyShape {
            plans: plans(study)?,
            has_reference: has("reference.toml"),
            has_next: has("next/dictionary.toml") && has("next/campaign.toml"),
            next_is_charted: has("next/plan.toml"),
            has_regressors: has_regressors(study),
            recordings: 0,
        };
        let from_instruments = has("logs.toml");
        let folders = Folders { study: study.to_owned(), out: out.to_owned() };
        let mut pipeline =
            Self { folders, dictionary: PathBuf::new(), logs: PathBuf::new(), steps: Vec::new() };
        let of_study =
            |given: &Option<PathBuf>, usual: &str| study.join(given.as_deref().unwrap_or(Path::new(usual)));
        pipeline.dictionary = of_study(&settings.dictionary, "dictionary.toml");
        pipeline.logs = match logs {
            _ if from_instruments => out.join("logs"),
            Some(logs) => logs.to_owned(),
            None => of_study(&settings.logs, "logs"),
        };
        if !from_instruments && has("ingest.toml") {
            shape.recordings = recordings(study, &pipeline.logs);
        }
        pipeline.steps = if from_instruments {
            let flags = settings.selection.as_ref().map_or(Vec::new(), |asked| asked.over(""));
            [simulated_logs().to_vec(), measured(settings, &shape, Some(flags))].concat()
        } else if has("ingest.toml") {
            measured(settings, &shape, settings.selection.as_ref().map(|asked| asked.over("")))
        } else {
            simulated(settings, &shape)
        };
        pipeline.check()?;
        Ok(pipeline)
    }

    /// Keeps the stage called `name` and those that it needs.
    pub fn until(&mut self, name: &str) -> Result<(), Invalid> {
        let names = || self.steps.iter().map(|step| step.name.as_str());
        let Some(last) = names().position(|other| other == name) else {
            return Err(Invalid::unknown("stage", name, names()));
        };
        self.steps.truncate(last + 1);
        let mut needed: Vec<StudyStep> = Vec::new();
        for step in self.steps.drain(..).rev() {
            let is_read = |later: &StudyStep| reads(later, &step);
            if needed.is_empty() || needed.iter().any(is_read) {
                needed.push(step);
            }
        }
        needed.reverse();
        self.steps = needed;
        Ok(())
    }

    /// The path or word that `word` of a command line stands for.
    pub fn resolved(&self, word: &str) -> OsString {
        let Folders { study, out } = &self.folders;
        let paths = [("study", study), ("dictionary", &self.dictionary), ("logs", &self.logs), ("out", out)];
        let mut parts = word.split('\0');
        let mut whole = OsString::from(parts.next().unwrap_or_default());
        for part in parts {
            let named = paths.iter().find_map(|(name, path)| Some((path, part.strip_prefix(name)?)));
            let (path, rest) = named.map_or((Path::new(""), part), |(path, rest)| (path.as_path(), rest));
            whole.push(path);
            whole.push(rest);
        }
        whole
    }

    /// The main file of `step`.
    pub fn main(&self, step: &StudyStep) -> PathBuf {
        PathBuf::from(self.resolved(&step.outputs[0]))
    }

    /// Traces what the next stage reads and writes.
    pub fn trace(&self) -> Result<(), Error> {
        trace(&self.folders.study, &self.folders.out)
    }

    /// `words` as they stand in a record.
    pub(crate) fn recorded(&self, words: &[String]) -> Vec<String> {
        let key = |path: &Path| self.folders.key(path);
        let paths = [("\0dictionary", key(&self.dictionary)), ("\0logs", key(&self.logs))];
        let recorded = |word: &String| {
            let replace = word.replace('{', "{{").replace("\0study", "{study}").replace("\0out", "{out}");
            paths.iter().fold(replace, |word, (name, path)| word.replace(name, path))
        };
        words.iter().map(recorded).collect()
    }

    /// Refuses a study that lacks a file that no stage writes.
    fn check(&self) -> Result<(), Error> {
        let written: Vec<&String> = self.steps.iter().flat_map(|step| &step.outputs).collect();
        let read = self.steps.iter().flat_map(StudyStep::inputs);
        for word in
            read.filter(|word| !word.starts_with("\0out") && !written.iter().any(|output| output == word))
        {
            let path = PathBuf::from(self.resolved(word));
            if word == "\0logs"
                && !path.is_dir()
                && !written.iter().any(|output| output.starts_with("\0out/logs/"))
            {
                let remedy = "name it with --logs, or write logs = \"<folder>\" into study.toml";
                return Err(refuse(&path, "--logs", "no such folder", "the folder of the logs", remedy));
            }
            if path.extension().is_some() && !path.exists() {
                return Err(lacking(&path));
            }
        }
        Ok(())
    }
}

/// Whether `later` reads what `step` writes.
fn reads(later: &StudyStep, step: &StudyStep) -> bool {
    let is_page = later.words.first().is_some_and(|word| word == "report");
    let logs = later.inputs().any(|word| word == "\0logs") && step.name == "logs";
    is_page || logs || later.inputs().any(|word| step.outputs.iter().any(|output| output == word))
}

/// Refuses what is no folder, and a folder without any file of a study.
fn check_study(study: &Path) -> Result<(), Error> {
    let remedy = "`seatrial new <folder> --vessel <preset>` writes a study";
    if !study.is_dir() {
        return Err(refuse(study, "study", "no such folder", "a folder with vessel.toml", remedy));
    }
    if WRITTEN.iter().all(|(name, ..)| !study.join(name).exists()) {
        let expected = "vessel.toml, dictionary.toml and campaign.toml, or vessel.toml and ingest.toml";
        return Err(refuse(study, "study", "none of a study's files", expected, remedy));
    }
    Ok(())
}

/// A refusal of a study without the hand-written file at `path`.
fn lacking(path: &Path) -> Error {
    let name = path.file_name().unwrap_or_default().to_string_lossy().into_owned();
    let (expected, remedy) = match WRITTEN.iter().find(|(file, ..)| *file == name) {
        Some((_, what, flags)) => {
            (*what, format!("write it; `seatrial new <folder> {flags}` writes one to begin with"))
        }
        None => ("the file that its stage reads", format!("write {}", foreign(&name))),
    };
    refuse(path, "file", "no such file", expected, &remedy)
}

/// Whether the model in the folder `study` has regressors; a file that cannot be read is refused by the stage that needs it.
fn has_regressors(study: &Path) -> bool {
    let vessel = read_hand_written(study.join("vessel.toml"));
    !vessel.is_ok_and(|text| text.parse::<VesselFile>().is_ok_and(|vessel| vessel.is_of_forces()))
}

/// How many recordings the `logs` of a study are; none where a file is refused, as by the stage that needs it.
fn recordings(study: &Path, logs: &Path) -> usize {
    let file = study.join("ingest.toml");
    let read = || {
        let config = read_ingest(&file, &mut Provenance::default()).ok()?;
        Some(find(&config, &config.naming().ok()?, &file, logs).ok()?.len())
    };
    read().unwrap_or(0)
}

/// Names of the files `plan.toml` and `plan-<name>.toml` in `study`, without `.toml`, sorted.
fn plans(study: &Path) -> Result<Vec<String>, Error> {
    let entries = std::fs::read_dir(study).map_err(|e| Error::io(study, "list", e))?;
    let mut plans = Vec::new();
    for entry in entries.flatten() {
        let name = entry.file_name();
        let text = name.to_string_lossy();
        let Some(plan) = text.strip_suffix(".toml") else { continue };
        if plan != "plan" && !plan.starts_with("plan-") {
            continue;
        }
        if name.to_str().is_none() {
            let (found, expected) = ("a plan whose name is not UTF-8", "a name in UTF-8");
            return Err(refuse(&entry.path(), "file", found, expected, "rename it"));
        }
        plans.push(plan.to_owned());
    }
    plans.sort();
    Ok(plans)
}

/// The folders of a study and of its results, by which a record names files.
#[derive(Debug)]
pub struct Folders {
    /// The hand-written files.
    pub study: PathBuf,
    /// The results.
    pub out: PathBuf,
}

/// The names of these folders in a record.
const OUT: &str = "{out}";
const STUDY: &str = "{study}";

impl Folders {
    /// How a record names `path`: relative to these folders where it is below them.
    pub(crate) fn key(&self, path: &Path) -> String {
        let whole = absolute(path).unwrap_or_else(|_| path.to_owned());
        for (name, folder) in [(OUT, &self.out), (STUDY, &self.study)] {
            for base in [absolute(folder).ok(), folder.canonicalize().ok()].into_iter().flatten() {
                if let Ok(rest) = whole.strip_prefix(base) {
                    return slashed(&Path::new(name).join(rest)).trim_end_matches('/').to_owned();
                }
            }
        }
        // Folders above are where they are from the study.
        let study = self.study.canonicalize().unwrap_or_default();
        match study.strip_prefix(&whole) {
            Ok(below) => STUDY.to_owned() + &"/..".repeat(below.components().count()),
            Err(_) => slashed(&whole),
        }
    }

    /// The way from the results to the study.
    fn way(&self) -> Option<String> {
        let [study, out] = [&self.study, &self.out].map(|folder| folder.canonicalize());
        let (study, out) = (study.ok()?, out.ok()?);
        let shared = study.components().zip(out.components()).take_while(|(one, other)| one == other).count();
        let rest: PathBuf = study.components().skip(shared).collect();
        Some("../".repeat(out.components().count() - shared) + &slashed(&rest))
    }

    /// The path that a record names `key`.
    fn path(&self, key: &str) -> PathBuf {
        let below = |(name, folder): (&str, &PathBuf)| {
            let rest = key.strip_prefix(name)?;
            Some(if rest.is_empty() { folder.clone() } else { folder.join(rest.strip_prefix('/')?) })
        };
        let folders = [(OUT, &self.out), (STUDY, &self.study)];
        folders.into_iter().find_map(below).unwrap_or_else(|| key.into())
    }

    /// How a record names an observation.
    pub(crate) fn noted(&self, what: &Observed) -> String {
        let path = self.key(what.path());
        match what {
            Observed::File(_) => path,
            Observed::Names(_, pattern) => format!("names {pattern} in {path}"),
            Observed::Place(_) => format!("place of {path}"),
        }
    }

    /// The observation that a record names `key`.
    pub(crate) fn observed(&self, key: &str) -> Observed {
        let names = key.strip_prefix("names ").and_then(|rest| rest.split_once(" in "));
        match (names, key.strip_prefix("place of ")) {
            (Some((pattern, folder)), _) => Observed::Names(self.path(folder), pattern.to_owned()),
            (_, Some(folder)) => Observed::Place(self.path(folder)),
            _ => Observed::File(self.path(key)),
        }
    }
}

/// `run.json` beside the results: the stages as they ran.
#[derive(Debug)]
pub struct RunRecord {
    file: PathBuf,
    /// The program and its version.
    program: String,
    /// The program's digest; without one nothing is known to be up to date.
    digest: Option<Digest>,
    document: RunDocument,
}

impl RunRecord {
    /// The record in the folder `out` for `program`, whose file has this `digest`. Without one, or if it cannot be read, no stage
    /// is up to date.
    pub fn read(out: &Path, program: String, digest: Option<Digest>) -> Self {
        let file = out.join("run.json");
        let document = read_document::<RunDocument>(&file).map(|loaded| loaded.data).unwrap_or_default();
        Self { file, program, digest, document }
    }

    /// Notes of which study these are the results.
    ///
    /// # Errors
    /// Results of another study.
    pub fn belong_to(&mut self, pipeline: &Pipeline) -> Result<(), Error> {
        let study = pipeline.folders.way().map(|way| Digest::of_bytes(way.as_bytes()));
        if self.document.study.is_some_and(|known| study != Some(known)) {
            let (found, expected) = ("the results of another study", "none, or those of this one");
            let remedy = "name another folder with --out, or remove this one";
            return Err(refuse(&self.file, "`data.study`", found, expected, remedy));
        }
        self.document.study = study;
        Ok(())
    }

    /// Whether `step` ran by this program with these `words`, and what it read and wrote is as it was.
    pub fn is_current(&self, pipeline: &Pipeline, step: &StudyStep, words: &[String]) -> bool {
        let Some(known) = self.document.stages.get(&step.name) else { return false };
        let is_same_program =
            known.program == self.program && known.digest == self.digest && known.digest.is_some();
        is_same_program
            && known.command == pipeline.recorded(words)
            && changed(known, &pipeline.folders).next().is_none()
    }

    /// What is not as the stages read or left it, each in a line.
    pub fn faults(&self, folders: &Folders) -> Vec<String> {
        let fault = |name: &str, [before, now]: [Option<Digest>; 2], what: &Observed| {
            let state = match (before, now) {
                (Some(_), None) => "nothing there",
                (None, _) => "something that was not there",
                _ => "another content",
            };
            let expected = format!("what the stage `{name}` read or wrote");
            let remedy =
                "`seatrial run` runs the stage again; remove its results if it is not wanted any more";
            let (thing, found) = match what {
                Observed::File(_) => ("digest".to_owned(), state),
                Observed::Names(_, pattern) => (format!("files `{pattern}`"), "others than there were"),
                Observed::Place(_) => ("folder".to_owned(), "it in another place"),
            };
            refuse(what.path(), &thing, found, &expected, remedy).to_string()
        };
        let stages = self.document.stages.iter();
        stages
            .flat_map(|(name, stage)| {
                changed(stage, folders).map(move |(what, outputs)| fault(name, outputs, &what))
            })
            .collect()
    }

    /// Notes that `step` has run with these `words`, and its `trace`.
    pub fn note(
        &mut self,
        pipeline: &Pipeline,
        step: &StudyStep,
        words: &[String],
        trace: &Trace,
    ) -> Result<(), Error> {
        let folders = &pipeline.folders;
        let digest = |path: &PathBuf| Ok((folders.key(path), Digest::of_file(path)?));
        let outputs = trace.outputs.iter().map(digest).collect::<Result<BTreeMap<_, _>, Error>>()?;
        let before = self.document.stages.remove(&step.name).map(|known| known.outputs).unwrap_or_default();
        let mut inputs = BTreeMap::new();
        for (what, digest) in &trace.inputs {
            let key = folders.noted(what);
            // What the stage wrote, now or before, is no input, though it may look at it.
            if outputs.contains_key(&key) || before.contains_key(&key) {
                continue;
            }
            if what.path().is_relative() && !folders.key(what.path()).starts_with('{') {
                // Elsewhere this path names another file.
                let here = Observed::Place(PathBuf::from("."));
                inputs.insert("place of .".to_owned(), here.digest(&folders.study));
            }
            inputs.insert(key, *digest);
        }
        let ran = RunStage {
            program: self.program.clone(),
            digest: self.digest,
            command: pipeline.recorded(words),
            inputs,
            outputs,
        };
        self.document.stages.insert(step.name.clone(), ran);
        self.write()
    }

    /// Forgets `step`, and removes what it wrote.
    pub fn forget(&mut self, pipeline: &Pipeline, step: &StudyStep) -> Result<(), Error> {
        let before = self.document.stages.remove(&step.name).map(|known| known.outputs).unwrap_or_default();
        let recorded = before.keys().map(|key| pipeline.folders.observed(key).path().to_owned());
        let stated = step.outputs.iter().map(|output| PathBuf::from(pipeline.resolved(output)));
        for file in recorded.chain(stated).filter(|file| file.is_file()) {
            std::fs::remove_file(&file).map_err(|e| Error::io(&file, "remove", e))?;
        }
        self.write()
    }

    fn write(&self) -> Result<(), Error> {
        let provenance = Provenance { producer: self.program.clone(), ..Provenance::default() };
        commit(vec![stage_document(&self.file, &provenance, &self.document)?])
    }
}

/// What is not as `stage` read or left it, with its digests before and now.
fn changed(stage: &RunStage, folders: &Folders) -> impl Iterator<Item = (Observed, [Option<Digest>; 2])> {
    let outputs = stage.outputs.iter().map(|(key, digest)| (key, Some(*digest)));
    let all = stage.inputs.iter().map(|(key, digest)| (key, *digest)).chain(outputs);
    all.filter_map(|(key, before)| {
        let what = folders.observed(key);
        let now = what.digest(&folders.study);
        (now != before).then_some((what, [before, now]))
    })
}
