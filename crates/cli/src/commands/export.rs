//! `export`: a model for other tools.

use std::path::{Path, PathBuf};

use crate::compiler::compiled;
use clap::Parser;
use files::{Staged, commit};
use seatrial::export::{COMPILED_WITH, PLATFORM, Portable, Target};
use seatrial::exported::read_portable;
use serde_json::{Value, json};
use ship::model::Source;

use crate::cli::{Common, check_positive, choice, in_folder, only_folder_of};
use crate::failure::Failure;
use crate::stage::{Summary, Task};

/// Writes a model for other tools: Python, C, MATLAB, or a Functional Mock-up Unit
#[derive(Parser)]
#[command(name = "export", after_help = "Example:\n  export --model model.json --to fmu --out exported/")]
pub struct ExportArguments {
    /// The model, or a vessel; of an average each model, into a folder of its own
    #[arg(long, visible_alias = "vessel", value_name = "model.json|average.json|vessel.toml")]
    model: PathBuf,
    /// What for
    #[arg(long, value_parser = choice(&Target::ALL, Target::name, Target::description))]
    to: Target,
    /// Which values of a vessel.toml (default: the true ones where all are known, else the nominal ones)
    #[arg(long, value_parser = choice(&Source::ALL, Source::name, |own| ["The true ones", "The nominal ones"][own as usize]))]
    parameters: Option<Source>,
    /// The rate of its steps [Hz]: terms per sample take whole multiples of their own rate, or parts of it (default: their own)
    #[arg(long, visible_alias = "rate-hz", value_name = "HZ")]
    rate: Option<f64>,
    /// The C compiler that builds the unit's binary; without one the unit has its source alone
    #[arg(long, value_name = "PROGRAM", default_value = "cc")]
    compiler: String,
}

impl Task for ExportArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        check_positive("--rate", self.rate)?;
        let mut provenance = common.provenance("export");
        let all = read_portable(&self.model, self.parameters, self.rate, &mut provenance)?;
        let out = &common.out;
        if let [portable] = all.as_slice() {
            let (said, details) = self.written(portable, out)?;
            return Ok(Summary::of(out, said, details));
        }
        let names: Vec<String> = (1..=all.len()).map(|i| format!("model-{i}")).collect();
        only_folder_of(out, &names)?;
        let each = in_folder(out, || {
            all.iter()
                .zip(&names)
                .map(|(own, name)| self.written(own, &out.join(name)))
                .collect::<Result<Vec<_>, _>>()
        })?;
        let (said, details): (Vec<String>, Vec<Value>) = each.into_iter().unzip();
        let said =
            format!("{} models, whose trajectories are to be averaged: {}", all.len(), said.join("; "));
        Ok(Summary::of(out, said, json!({"models": details})))
    }
}

impl ExportArguments {
    /// Writes `portable` into the folder `out`.
    fn written(&self, portable: &Portable, out: &Path) -> Result<(String, Value), Failure> {
        let refused = |e| Failure::invalid(&self.model, &e);
        let names = portable.file_names(self.to);
        only_folder_of(out, &names)?;
        let unit = self.to == Target::Fmu;
        let build = || compiled(&self.compiler, &COMPILED_WITH, &portable.unit_sources());
        let library = if unit && PLATFORM.is_some() { build()? } else { None };
        let built = match &library {
            Some(_) => "; built for this system".to_owned(),
            None if unit => {
                format!("; its source alone: found no C compiler `{}` for this system", self.compiler)
            }
            None => String::new(),
        };
        let details = json!({"files": names, "renamed": portable.renamed(), "built": library.is_some()});
        let files = portable.files(self.to, library).map_err(refused)?;
        in_folder(out, || {
            let staged = names.iter().zip(&files).map(|(name, bytes)| Staged::bytes(out.join(name), bytes));
            Ok(commit(staged.collect::<Result<_, _>>()?)?)
        })?;
        Ok((format!("{}{built}", portable.summary()), details))
    }
}
