//! Which stages of a study are up to date.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use files::{Digest, Error, Observed, Provenance, Trace, commit, read_document, stage_document};

use study::documents::{RunDocument, RunStage};
use study::refuse;

use crate::pipeline::folders::Folders;
use crate::pipeline::stages::Pipeline;
use crate::pipeline::steps::Step;

/// `run.json` beside the results: the stages as they ran.
#[derive(Debug)]
pub struct Record {
    file: PathBuf,
    /// The program and its version.
    program: String,
    /// The program's digest; without one nothing is known to be up to date.
    digest: Option<Digest>,
    document: RunDocument,
}

impl Record {
    /// The record in the folder `out` for `program`, whose file has this `digest`. Without one, or if it cannot be read, no stage
    /// is up to date.
    pub fn read(out: &Path, program: String, digest: Option<Digest>) -> Self {
        let file = out.join("run.json");
        let document = read_document::<RunDocument>(&file).map(|loaded| loaded.data).unwrap_or_default();
        Self { file, program, digest, document }
    }

    /// Whether `step` ran by this program with these `words`, and what it read and wrote is as it was.
    pub fn is_current(&self, pipeline: &Pipeline, step: &Step, words: &[String]) -> bool {
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
            let found = match (before, now) {
                (Some(_), None) => "nothing there",
                (None, _) => "something that was not there",
                _ => "another content",
            };
            let expected = format!("what the stage `{name}` read or wrote");
            let remedy =
                "`seatrial run` runs the stage again; remove its results if it is not wanted any more";
            let (thing, found) = match what {
                Observed::File(_) => ("digest".to_owned(), found),
                Observed::Names(_, pattern) => (format!("files `{pattern}`"), "others than there were"),
                Observed::Place(_) => ("folder".to_owned(), "it in another place"),
            };
            refuse(what.path(), &thing, found, &expected, remedy).to_string()
        };
        let stages = self.document.stages.iter();
        stages
            .flat_map(|(name, stage)| changed(stage, folders).map(move |(what, own)| fault(name, own, &what)))
            .collect()
    }

    /// Notes that `step` has run with these `words`, and its `trace`.
    ///
    /// # Errors
    /// Outputs that cannot be read; a record that cannot be written.
    pub fn note(
        &mut self,
        pipeline: &Pipeline,
        step: &Step,
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
    ///
    /// # Errors
    /// A file that cannot be removed; a record that cannot be written.
    pub fn forget(&mut self, pipeline: &Pipeline, step: &Step) -> Result<(), Error> {
        let before = self.document.stages.remove(&step.name).map(|known| known.outputs).unwrap_or_default();
        let recorded = before.keys().map(|key| pipeline.folders.observed(key).path().to_owned());
        let stated = step.outputs.iter().map(|output| PathBuf::from(pipeline.resolved(output)));
        for file in recorded.chain(stated).filter(|own| own.is_file()) {
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
