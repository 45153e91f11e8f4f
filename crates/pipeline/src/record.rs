//! Which stages of a study are up to date.

use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::{Digest, Error, Provenance, commit, read_document, stage_document};

use study::documents::{RunDocument, RunStage};

use crate::pipeline::Pipeline;
use crate::steps::Step;

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

    /// Whether `step` ran by this program with these `words` and `inputs`, and its outputs are as it left them.
    ///
    /// # Errors
    /// An output that cannot be read.
    pub fn is_current(
        &self,
        pipeline: &Pipeline,
        step: &Step,
        words: &[String],
        inputs: &BTreeMap<String, Digest>,
    ) -> Result<bool, Error> {
        let is_there = |file: &String| Path::new(&pipeline.resolved(file)).is_file();
        let Some(known) = self.document.stages.get(&step.name) else { return Ok(false) };
        let is_same_program =
            known.program == self.program && known.digest == self.digest && known.digest.is_some();
        let is_same = is_same_program && known.command == words && known.inputs == *inputs;
        Ok(is_same && step.outputs.iter().all(is_there) && pipeline.digests(&step.outputs)? == known.outputs)
    }

    /// Notes that `step` has run with these `words` and `inputs`.
    ///
    /// # Errors
    /// Outputs that cannot be read; a record that cannot be written.
    pub fn note(
        &mut self,
        pipeline: &Pipeline,
        step: &Step,
        words: &[String],
        inputs: BTreeMap<String, Digest>,
    ) -> Result<(), Error> {
        let outputs = pipeline.digests(&step.outputs)?;
        let ran = RunStage {
            program: self.program.clone(),
            digest: self.digest,
            command: words.to_vec(),
            inputs,
            outputs,
        };
        self.document.stages.insert(step.name.clone(), ran);
        let provenance = Provenance { producer: self.program.clone(), ..Provenance::default() };
        commit(vec![stage_document(&self.file, &provenance, &self.document)?])
    }
}
