//! `estimate search`: a model structure found from recordings.

use std::path::{Path, PathBuf};

use artifact::{Provenance, commit, stage_document, stage_set_document};
use clap::{Args, Parser};
use model::Vessel;
use search::{AverageOptions, BootstrapOptions, Cut, NamedRoles, SearchError, SearchOptions};
use seatrial::{FoundStructure, StructureSearch};
use serde_json::json;
use study::TermLists;
use study::documents::SearchDocument;
use study::files::read_any_vessel;

use crate::cli::{Common, member, samples};
use crate::failure::Failure;
use crate::inputs;
use crate::pool::RunFlags;
use crate::progress::Progress;
use crate::stage::{Summary, Task};

/// Finds which terms a ship's model needs, from recordings of her; writes search.json and model.json. A ridge, chosen by
/// recordings that are left out, holds back the terms of a library
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
    /// With --compact: draws recordings again and repeats the search so often, for an interval of every parameter; 0 does not.
    /// Each takes a few times as long as one fold of the search
    #[arg(long, value_name = "N", default_value_t = 50, value_parser = clap::value_parser!(u32).range(0..=100_000))]
    bootstrap: u32,
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
    /// Propeller speeds with their signs
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    propeller: Vec<String>,
    /// Propeller speeds where they go ahead, else 0
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    ahead: Vec<String>,
    /// Propeller speeds where they go astern, else 0
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    astern: Vec<String>,
    /// Thrusts, where no propeller speed is logged
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    thrust: Vec<String>,
    /// Thrusters on port, by propeller speed or thrust, of which the library takes what they do with and against those of
    /// --starboard
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    port: Vec<String>,
    /// As many on starboard, in the same order
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    starboard: Vec<String>,
    /// Speed of the relative wind, of whose square the library takes products with cos and sin of its direction
    #[arg(long, value_name = "NAME")]
    wind: Option<String>,
    /// Where the relative wind comes from, as an angle from the bow to starboard
    #[arg(long, value_name = "NAME")]
    wind_from: Option<String>,
    /// Disturbances that a reflection between port and starboard leaves as they are
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    even: Vec<String>,
    /// Disturbances whose sign a reflection changes
    #[arg(long, value_name = "NAME,…", value_delimiter = ',')]
    odd: Vec<String>,
}

/// The usual name of the document.
const MAIN: &str = "search.json";

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("estimate");
        let given = read_any_vessel(&self.vessel, &mut provenance)?;
        StructureSearch::check(&given).map_err(|e| Failure::invalid(&self.vessel, &e))?;
        let read = || [&self.vessel].into_iter().chain(&self.terms).chain(self.of.inputs());
        let out = common.main_output(MAIN, read())?;
        let [single, several] = ["model.json", "average.json"].map(|name| member(&out, MAIN, name, read()));
        let (single, several) = (single?, several?);
        let in_samples = |flag: &str, s: f64| samples(flag, s, given.sample_rate_hz);
        let window = in_samples("--fitted-window-s", self.fitted_window_s)?;
        let every = self.every_s.map(|s| in_samples("--every-s", s)).transpose()?;
        let cut = Cut {
            window,
            every: every.unwrap_or(window.div_ceil(4)),
            scored: self.window_s.map(|s| in_samples("--window-s", s)).transpose()?,
        };
        let begun = self.begun(given, &mut provenance)?;
        let (runs, _) = self.of.read(&begun.vessel, &mut provenance, inputs::runs)?;
        let options = SearchOptions {
            cut,
            folds: usize::from(self.folds),
            ridges: SearchOptions::half_decades(),
            compact: self.compact,
            bootstrap: self.bootstrap(common),
            average: self.average.map(|models| AverageOptions { models, seed: common.seed.unwrap_or(1) }),
            rate_hz: begun.vessel.sample_rate_hz,
        };
        let progress = Progress::new("fits, at most", options.fits(), common.quiet);
        let found = begun.find(&runs, &options, &|count| progress.advance(count));
        let FoundStructure { search, model, average: averaged } =
            found.map_err(|e| refused(self.of.file(), &e))?;
        let settings = [
            ("fitted_window_samples", json!(cut.window)),
            ("every_samples", json!(cut.every)),
            ("window_samples", json!(cut.scored)),
            ("folds", json!(self.folds)),
            ("compact", json!(self.compact)),
            ("runs", json!(self.of.runs)),
            ("leave_out", json!(self.of.leave_out)),
        ];
        let bootstrap =
            options.bootstrap.map(|own| [("bootstrap", json!(own.resamples)), ("seed", json!(own.seed))]);
        let average = options.average.map(|own| [("average", json!(own.models)), ("seed", json!(own.seed))]);
        let settings = settings.into_iter().chain(bootstrap.into_iter().chain(average).flatten());
        provenance.settings.extend(settings.map(|(key, value)| (key.to_owned(), value)));
        let mut members = vec![stage_document(single, &provenance, &model)?];
        if let Some(average) = &averaged {
            members.push(stage_document(&several, &provenance, average)?);
        }
        let left = averaged.is_none() && artifact::is_member_of::<SearchDocument>(&out, &several);
        let main = stage_set_document(&out, &provenance, &search, &members)?;
        commit([main].into_iter().chain(members).collect())?;
        if left {
            // The average of an earlier search does not belong to this one.
            let _ = std::fs::remove_file(several);
        }
        Ok(Summary::of(
            &out,
            format!("{} terms; {}", search.terms.len(), search.statements.join("; ")),
            json!({"terms": search.terms.len(), "ridge": search.ridge, "statements": search.statements}),
        ))
    }
}

impl Arguments {
    /// The bootstrap over recordings, only for a search for few terms.
    fn bootstrap(&self, common: &Common) -> Option<BootstrapOptions> {
        let wanted = BootstrapOptions { resamples: self.bootstrap, seed: common.seed.unwrap_or(1) };
        (self.compact && self.bootstrap > 0).then_some(wanted)
    }

    /// The start of the search, and its candidate terms.
    fn begun(&self, vessel: Vessel, provenance: &mut Provenance) -> Result<StructureSearch, Failure> {
        let Some(path) = &self.terms else {
            let begun = StructureSearch::by_roles(vessel, &self.roles.named());
            return begun.map_err(|e| Failure::invalid(&self.vessel, &e));
        };
        let terms: TermLists = inputs::toml(path, "terms", provenance)?;
        StructureSearch::by_terms(vessel, &terms).map_err(|e| Failure::invalid(path, &e))
    }
}

impl RoleFlags {
    fn named(&self) -> NamedRoles {
        let Self { rudder, propeller, ahead, astern, thrust, port, starboard, wind, wind_from, even, odd } =
            self.clone();
        NamedRoles {
            rudders: rudder,
            propellers: propeller,
            ahead,
            astern,
            thrusts: thrust,
            ports: port,
            starboards: starboard,
            wind,
            wind_from,
            even,
            odd,
        }
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
        SearchError::NoResample => {
            answer("models that can be searched for again; add recordings, or set --bootstrap 0")
        }
        SearchError::NoAverage => answer("models that can be fitted; add recordings, or leave --average out"),
        SearchError::AllDiverge { .. } => answer(
            "one that no fold rejects; leave out recordings of another ship or load, shorten --fitted-window-s, or correct the base \
             structure",
        ),
        SearchError::Useless(_) => {
            answer("one that is better; log what moves the vessel, or correct the base structure")
        }
    }
}
