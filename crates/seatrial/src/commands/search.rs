//! `estimate search`: a model structure found from recordings.

use std::path::{Path, PathBuf};

use artifact::{Provenance, commit, stage_document, stage_set_document};
use clap::{Args, Parser};
use identification::search::{
    AverageOptions, Cut, NamedRoles, Roles, SearchError, SearchOptions, library, listed, search,
};
use serde_json::json;
use study::TermLists;
use study::documents::{AverageDocument, ModelDocument, SearchDocument};
use study::files::read_vessel;
use validation::comparison::Magnitudes;
use vessel::Model;

use super::earlier::is_of;
use crate::cli::{Common, member, samples};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::RunFlags;
use crate::progress::Progress;
use crate::stage::{Summary, Task};

/// Finds a model that generalises: a library of terms beside the vessel's own, held back by a ridge that recordings left out
/// choose; writes search.json and model.json
#[derive(Parser)]
#[command(
    name = "search",
    after_help = "Example:\n  estimate search --vessel pipelines/esso-osaka/vessel.toml \
    --trajectories trajectories.parquet --recordings ingest.json --out search.json"
)]
pub struct Arguments {
    /// The vessel; its terms are the structure that the search begins with
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    #[command(flatten)]
    of: RunFlags,
    #[command(flatten)]
    roles: RoleFlags,
    /// Terms to search through instead of the library: lists `surge`, `sway` and `yaw`
    #[arg(long, value_name = "terms.toml")]
    terms: Option<PathBuf>,
    /// Length of the windows that are fitted [s]
    #[arg(long, value_name = "S", default_value_t = 60.0)]
    fitted_window_s: f64,
    /// From the start of one window to that of the next [s] (default: a quarter of a window)
    #[arg(long, value_name = "S")]
    every_s: Option<f64>,
    /// Scores models over windows of this length, side by side [s]; whole runs without it
    #[arg(long, value_name = "S")]
    window_s: Option<f64>,
    /// Folds that the recordings are dealt into
    #[arg(long, value_name = "N", default_value_t = 6, value_parser = clap::value_parser!(u16).range(3..))]
    folds: u16,
    /// Keeps few terms: the fewest that follow recordings left out within a standard error of the best
    #[arg(long)]
    compact: bool,
    /// Finds K models of few terms besides, to be averaged: each structure on 70 % of the recordings, each model fitted to all;
    /// writes average.json. Takes about K times as long as --compact, since all are found again without each fold
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(2..=99))]
    average: Option<u32>,
}

/// What channels are to the library; those that are not named are found by unit and name.
#[derive(Clone, Debug, Args)]
struct RoleFlags {
    /// Channels that steer
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    rudder: Vec<String>,
    /// Propeller speed with its sign
    #[arg(long, value_name = "NAME")]
    propeller: Option<String>,
    /// Propeller speed where it goes ahead, else 0
    #[arg(long, value_name = "NAME")]
    ahead: Option<String>,
    /// Propeller speed where it goes astern, else 0
    #[arg(long, value_name = "NAME")]
    astern: Option<String>,
    /// Thrust, where no propeller speed is logged
    #[arg(long, value_name = "NAME")]
    thrust: Option<String>,
    /// Disturbances that a reflection between port and starboard leaves as they are
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    even: Vec<String>,
    /// Disturbances whose sign a reflection changes
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    odd: Vec<String>,
}

/// What the document is usually called.
const MAIN: &str = "search.json";

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("estimate");
        let vessel = read_vessel(&self.vessel, &mut provenance)?;
        let read = || [&self.vessel].into_iter().chain(&self.terms).chain(self.of.inputs());
        let out = common.main_output(MAIN, read())?;
        let [single, several] = ["model.json", "average.json"].map(|name| member(&out, MAIN, name, read()));
        let (single, several) = (single?, several?);
        let in_samples = |flag: &str, s: f64| samples(flag, s, vessel.sample_rate_hz);
        let window = in_samples("--fitted-window-s", self.fitted_window_s)?;
        let every = self.every_s.map(|s| in_samples("--every-s", s)).transpose()?;
        let cut = Cut {
            window,
            every: every.unwrap_or(window.div_ceil(4)),
            scored: self.window_s.map(|s| in_samples("--window-s", s)).transpose()?,
        };
        let library = self.library(&vessel.model, &mut provenance)?;
        let (runs, _) = self.of.read(&vessel, &mut provenance, inputs::runs)?;
        let options = SearchOptions {
            cut,
            folds: usize::from(self.folds),
            ridges: SearchOptions::half_decades(),
            compact: self.compact,
            average: self.average.map(|models| AverageOptions { models, seed: common.seed.unwrap_or(1) }),
            rate_hz: vessel.sample_rate_hz,
        };
        let each = 1 + self.average.unwrap_or(0) as usize;
        let fits =
            options.folds * (options.folds + 1) / 2 * options.ridges.len() + each * (options.folds + 1);
        let progress = Progress::new("fits, at most", fits, common.quiet);
        let done = |count: usize| progress.advance(count);
        let found = search(&vessel.model, &library, &runs, &options, &done);
        let found = found.map_err(|e| refused(self.of.file(), &e))?;
        let settings = [
            ("fitted_window_samples", json!(cut.window)),
            ("every_samples", json!(cut.every)),
            ("window_samples", json!(cut.scored)),
            ("folds", json!(self.folds)),
            ("compact", json!(self.compact)),
            ("runs", json!(self.of.runs)),
            ("leave_out", json!(self.of.leave_out)),
        ];
        let average = options.average.map(|own| [("average", json!(own.models)), ("seed", json!(own.seed))]);
        let settings = settings.into_iter().chain(average.into_iter().flatten());
        provenance.settings.extend(settings.map(|(key, value)| (key.to_owned(), value)));
        let document = SearchDocument::new(&vessel, &options, &found);
        let Ok(magnitudes) = Magnitudes::of(&vessel.model, &runs, vessel.sample_rate_hz);
        let model = ModelDocument { magnitudes, ..ModelDocument::searched(&vessel, &found) };
        let mut members = vec![stage_document(single, &provenance, &model)?];
        if let Some(found_all) = &found.average {
            let average = AverageDocument::new(&vessel, found_all, found.samples, model.magnitudes.as_ref());
            members.push(stage_document(&several, &provenance, &average)?);
        }
        let left = found.average.is_none() && is_of::<SearchDocument>(&out, &several);
        let main = stage_set_document(&out, &provenance, &document, &members)?;
        commit([main].into_iter().chain(members).collect())?;
        if left {
            // The average of an earlier search is not this one's.
            let _ = std::fs::remove_file(several);
        }
        Ok(Summary::of(
            &out,
            format!("{} terms; {}", document.terms.len(), found.statements.join("; ")),
            json!({"terms": document.terms.len(), "ridge": document.ridge, "statements": found.statements}),
        ))
    }
}

impl Arguments {
    /// The structure with all terms that are searched through.
    fn library(&self, base: &Model, provenance: &mut Provenance) -> Result<Model, Failure> {
        if let Some(path) = &self.terms {
            let TermLists { surge, sway, yaw } = inputs::toml(path, "terms", provenance)?;
            return listed(base, [&surge, &sway, &yaw]).map_err(|e| Failure::invalid(path, &e));
        }
        let roles = Roles::new(base, &self.roles.named()).map_err(|e| Failure::invalid(&self.vessel, &e))?;
        Ok(library(base, &roles))
    }
}

impl RoleFlags {
    fn named(&self) -> NamedRoles {
        let Self { rudder, propeller, ahead, astern, thrust, even, odd } = self.clone();
        NamedRoles { rudders: rudder, propeller, ahead, astern, thrust, even, odd }
    }
}

/// Why nothing was found in runs of `file`.
fn refused(file: &Path, error: &SearchError) -> Failure {
    let answer = |expected: &str| {
        Failure::NoAnswer(format!("{}: search: found that {error}, expected {expected}", file.display()))
    };
    match error {
        SearchError::FewRecordings { recordings, folds } => Failure::refuse(
            file,
            "recordings",
            &recordings.to_string(),
            &format!("at least as many as folds, {folds}"),
            "name ingest.json with --recordings, add recordings, or ask for fewer --folds",
        ),
        SearchError::FewForAverage { recordings, needed } => Failure::refuse(
            file,
            "recordings",
            &recordings.to_string(),
            &format!("at least {needed} for --average, of which 70 % without any fold are as many as folds"),
            "add recordings, or ask for fewer --folds",
        ),
        SearchError::NoWindow => Failure::refuse(
            file,
            "windows",
            "no run as long as a window",
            "at least one",
            "shorten --window-s",
        ),
        SearchError::NoAverage => answer("models that can be fitted; add recordings, or leave --average out"),
        SearchError::AllDiverge(_) => {
            answer("one that no fold rejects; shorten --fitted-window-s, or correct the base structure")
        }
        SearchError::Useless(_) => {
            answer("one that is better; log what moves the vessel, or correct the base structure")
        }
    }
}
