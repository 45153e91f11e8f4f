//! A study's folders and stages.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::{Digest, Error, Provenance, read_to_string};
use model::VesselFile;
use refusal::{Invalid, foreign};

use study::files::read_ingest;
use study::ingest_file::recordings::find;
use study::{invalid, refuse};

use crate::settings::Settings;
use crate::steps::{Shape, Step, measured, simulated, simulated_logs};

/// Files of a study's folder that its page shows.
const SHOWN: [&str; 4] = ["vessel", "dictionary", "campaign", "reference"];

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
    study: PathBuf,
    dictionary: PathBuf,
    logs: PathBuf,
    out: PathBuf,
    /// The stages in the order in which they run.
    pub steps: Vec<Step>,
}

impl Pipeline {
    /// The study in the folder `study` with these `settings`, whose results are in `out`, with the logs in `logs` or where its
    /// settings say.
    ///
    /// # Errors
    /// No such folder, no study in it, a missing file.
    pub fn read(study: &Path, out: &Path, settings: &Settings, logs: Option<&Path>) -> Result<Self, Error> {
        let has = |name: &str| study.join(name).is_file();
        check_study(study)?;
        let shape = Shape {
            plans: plans(study)?,
            has_reference: has("reference.toml"),
            next_is_charted: has("next/plan.toml"),
            is_of_forces: is_of_forces(study),
        };
        let from_instruments = has("logs.toml");
        let steps = if from_instruments {
            let selection = "--estimator iv --nominal least-squares --realizations 500";
            let settings = settings.selecting();
            [simulated_logs().to_vec(), measured(&settings, &shape, selection)].concat()
        } else if has("ingest.toml") {
            measured(settings, &shape, "--estimator iv --nominal least-squares")
        } else {
            simulated(settings, &shape)
        };
        let own = |name: &str| settings.path(name, study);
        let logs =
            if from_instruments { Some(out.join("logs")) } else { logs.map(Path::to_owned).or(own("LOGS")) };
        let pipeline = Self {
            study: study.to_owned(),
            dictionary: own("DICTIONARY").unwrap_or_else(|| study.join("dictionary.toml")),
            logs: logs.unwrap_or_else(|| study.join("logs")),
            out: out.to_owned(),
            steps,
        };
        pipeline.check()?;
        Ok(pipeline)
    }

    /// Keeps the stage called `name` and those that it needs.
    ///
    /// # Errors
    /// No such stage.
    pub fn until(&mut self, name: &str) -> Result<(), Invalid> {
        let names = || self.steps.iter().map(|step| step.name.as_str());
        let Some(last) = names().position(|own| own == name) else {
            return Err(Invalid::unknown("stage", name, names()));
        };
        self.steps.truncate(last + 1);
        let mut needed: Vec<Step> = Vec::new();
        for step in self.steps.drain(..).rev() {
            let is_read = |later: &Step| reads(later, &step);
            if needed.is_empty() || needed.iter().any(is_read) {
                needed.push(step);
            }
        }
        needed.reverse();
        self.steps = needed;
        Ok(())
    }

    /// The path or word that `word` of a command line stands for.
    pub fn resolved(&self, word: &str) -> String {
        let folders = [
            ("{study}", &self.study),
            ("{dictionary}", &self.dictionary),
            ("{logs}", &self.logs),
            ("{out}", &self.out),
        ];
        folders
            .iter()
            .fold(word.to_owned(), |word, (name, path)| word.replace(name, &path.display().to_string()))
    }

    /// The main file of `step`.
    pub fn main(&self, step: &Step) -> PathBuf {
        PathBuf::from(self.resolved(&step.outputs[0]))
    }

    /// Digests of the files that `step` reads. A folder stands for the files in it that the stage reads, and a hand-written file
    /// for those that it names, too.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn inputs(&self, step: &Step) -> Result<BTreeMap<String, Digest>, Error> {
        let mut files: Vec<String> = Vec::new();
        for word in step.inputs() {
            match word {
                "{study}" => {
                    let shown = SHOWN.iter().map(|role| format!("{{study}}/{role}.toml"));
                    files.extend(shown.filter(|file| Path::new(&self.resolved(file)).is_file()));
                }
                "{logs}" => files.extend(self.log_files()?),
                _ if word.starts_with("{out}") && Path::new(&self.resolved(word)).is_dir() => {
                    let others = self.steps.iter().take_while(|other| other.name != step.name);
                    files.extend(others.flat_map(|other| other.outputs.iter().cloned()));
                }
                _ => {
                    files.push(word.to_owned());
                    files.extend(named_in(Path::new(&self.resolved(word))));
                }
            }
        }
        self.digests(&files)
    }

    /// Digests of `files`, by the words that stand for their paths.
    ///
    /// # Errors
    /// A file that cannot be read.
    pub fn digests(&self, files: &[String]) -> Result<BTreeMap<String, Digest>, Error> {
        files.iter().map(|file| Ok((file.clone(), Digest::of_file(self.resolved(file))?))).collect()
    }

    /// The logs that ingest.toml names.
    fn log_files(&self) -> Result<Vec<String>, Error> {
        let file = self.study.join("ingest.toml");
        let config = read_ingest(&file, &mut Provenance::default())?;
        let naming = config.naming().map_err(|wrong| invalid(&file, &wrong))?;
        let sources = find(&config, &naming, &file, &self.logs)?;
        Ok(sources
            .iter()
            .flat_map(|own| own.files.iter().flatten())
            .map(|name| format!("{{logs}}/{name}"))
            .collect())
    }

    /// Refuses a study that lacks a file that no stage writes.
    fn check(&self) -> Result<(), Error> {
        let written: Vec<&String> = self.steps.iter().flat_map(|step| &step.outputs).collect();
        let read = self.steps.iter().flat_map(Step::inputs);
        for word in read.filter(|word| !word.starts_with("{out}") && !written.iter().any(|own| own == word)) {
            let path = PathBuf::from(self.resolved(word));
            if word == "{logs}" && !path.is_dir() && !written.iter().any(|own| own.starts_with("{out}/logs/"))
            {
                let remedy = "name it with --logs, or write LOGS = <folder> into study.mk";
                return Err(refuse(&path, "--logs", "no such folder", "the folder of the logs", remedy));
            }
            if path.extension().is_some() && !path.is_file() {
                return Err(lacking(&path));
            }
        }
        Ok(())
    }
}

/// The files that the hand-written file at `path` names, such as tables of inputs and charts; those of a folder that it names.
fn named_in(path: &Path) -> Vec<String> {
    let text =
        std::fs::read_to_string(path).ok().filter(|_| path.extension().is_some_and(|end| end == "toml"));
    // What cannot be parsed is refused by its stage.
    let Some(Ok(table)) = text.map(|text| text.parse::<toml::Table>()) else { return Vec::new() };
    let (mut named, folder) = (Vec::new(), path.parent().unwrap_or(Path::new("")));
    let mut left: Vec<&toml::Value> = table.values().collect();
    while let Some(value) = left.pop() {
        match value {
            toml::Value::String(name) => named.push(folder.join(name)),
            toml::Value::Array(items) => left.extend(items),
            toml::Value::Table(table) => left.extend(table.values()),
            _ => {}
        }
    }
    let within = |path: &PathBuf| {
        let entries = std::fs::read_dir(path).into_iter().flatten();
        entries.filter_map(|entry| Some(entry.ok()?.path())).collect::<Vec<_>>()
    };
    let below: Vec<PathBuf> = named.iter().filter(|path| path.is_dir()).flat_map(within).collect();
    let files = named.into_iter().chain(below).filter(|path| path.is_file());
    files.map(|path| path.display().to_string()).collect()
}

/// Whether `later` reads what `step` writes.
fn reads(later: &Step, step: &Step) -> bool {
    let is_page = later.words.first().is_some_and(|word| word == "report");
    let logs = later.inputs().any(|word| word == "{logs}") && step.name == "logs";
    is_page || logs || later.inputs().any(|word| step.outputs.iter().any(|own| own == word))
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
    let (expected, remedy) = match WRITTEN.iter().find(|(own, ..)| *own == name) {
        Some((_, what, flags)) => {
            (*what, format!("write it; `seatrial new <folder> {flags}` writes one to begin with"))
        }
        None => ("the file that its stage reads", format!("write {}", foreign(&name))),
    };
    refuse(path, "file", "no such file", expected, &remedy)
}

/// Whether forces describe the ship in the folder `study`; a file that cannot be read is refused by the stage that needs it.
fn is_of_forces(study: &Path) -> bool {
    let vessel = read_to_string(study.join("vessel.toml"));
    vessel.is_ok_and(|text| text.parse::<VesselFile>().is_ok_and(|vessel| vessel.is_of_forces()))
}

/// Names of the files `plan.toml` and `plan-<name>.toml` in `study`, without `.toml`, sorted.
fn plans(study: &Path) -> Result<Vec<String>, Error> {
    let entries = std::fs::read_dir(study).map_err(|e| Error::io(study, "list", e))?;
    let names = entries.filter_map(|entry| entry.ok()?.file_name().into_string().ok());
    let plans = names.filter_map(|name| name.strip_suffix(".toml").map(str::to_owned));
    let mut plans: Vec<String> = plans.filter(|name| name == "plan" || name.starts_with("plan-")).collect();
    plans.sort();
    Ok(plans)
}
