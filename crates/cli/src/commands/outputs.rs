//! `report`: a study on one page. `export`: a model for other tools.

use std::path::{Path, PathBuf};

use clap::Parser;
use files::{Staged, commit};
use report::{Sources, load, render};
use seatrial::export::{COMPILED_WITH, PLATFORM, Portable, Target, read_portable};
use serde_json::{Value, json};
use ship::model::Source;

use crate::cli::{Allowed, Common, check_positive, choice, folder_of, in_folder, only_folder_of};
use crate::compiler::compiled;
use crate::failure::Failure;
use crate::stage::{Summary, Task};

/// Inputs that an output could overwrite: none, since only folders are read.
const NO_FILES: [&Path; 0] = [];

/// Puts a study's results on one page in HTML, to read, zoom and filter, with its figures as SVG beside it
#[derive(Parser)]
#[command(
    name = "report",
    after_help = "Example:\n  report --study pipelines/paper --results out/paper --out out/paper/report.html"
)]
pub struct ReportArguments {
    /// Folder of the study's hand-written files
    #[arg(long, value_name = "FOLDER")]
    study: PathBuf,
    /// The maneuvers, where they are not in the study's folder
    #[arg(long, value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Folder that the stages wrote into; what is missing there is said on the page
    #[arg(long, value_name = "FOLDER")]
    results: PathBuf,
    /// Results of studies that compare estimators, to be put side by side
    #[arg(long, value_name = "FOLDER", num_args = 1..)]
    scenarios: Vec<PathBuf>,
}

impl Task for ReportArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let study = load(&Sources {
            study: self.study.clone(),
            dictionary: self.dictionary.clone(),
            results: self.results.clone(),
            scenarios: self.scenarios.clone(),
            allow_mixed: common.allow.contains(&Allowed::Mixed),
            changes: common.changes(),
        })?;
        let page = render(&study);
        let out = common.main_output("report.html", NO_FILES)?;
        let figures = folder_of(&out).join("figures");
        in_folder(&figures, || {
            let html = std::iter::once_with(|| Staged::bytes(&out, page.html.as_bytes()));
            let svg =
                page.figures.iter().map(|(name, svg)| Staged::bytes(figures.join(name), svg.as_bytes()));
            Ok(commit(svg.chain(html).collect::<Result<_, _>>()?)?)
        })?;
        let figures = page.figures.len();
        Ok(Summary::of(&out, format!("{figures} figures"), json!({"figures": figures})))
    }
}

/// Writes a model for other tools: Python, C, MATLAB, or a Functional Mock-up Unit, which the C compiler `cc` builds, or CC
#[derive(Parser)]
#[command(name = "export", after_help = "Example:\n  export --model model.json --to fmu --out exported/")]
pub struct ExportArguments {
    /// The model, or a vessel; of an average each model, into a folder of its own
    #[arg(long, visible_alias = "vessel", value_name = "model.json|vessel.toml")]
    model: PathBuf,
    /// What for
    #[arg(long, value_parser = choice(&Target::ALL, Target::name, Target::description))]
    to: Target,
    /// Which values of a vessel.toml (default: the true ones where all are known, else the nominal ones)
    #[arg(long, value_parser = choice(&Source::ALL, Source::name, |source| ["The true ones", "The nominal ones"][source as usize]))]
    parameters: Option<Source>,
    /// The rate of its steps [Hz]: terms per sample take whole multiples of their own rate, or parts of it (default: their own)
    #[arg(long, visible_alias = "rate-hz", value_name = "HZ")]
    rate: Option<f64>,
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
                .map(|(model, name)| self.written(model, &out.join(name)))
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
        let compiler = std::env::var("CC").unwrap_or("cc".to_owned());
        let build = || compiled(&compiler, &COMPILED_WITH, &portable.unit_sources());
        let library = if unit && PLATFORM.is_some() { build()? } else { None };
        let built = match &library {
            Some(_) => "; built for this system".to_owned(),
            None if unit => {
                format!("; its source alone: found no C compiler `{compiler}` for this system")
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
