//! `estimate search`: a model structure found from recordings.

use std::path::{Path, PathBuf};

use clap::Parser;
use estimation::search::{AverageOptions, BootstrapOptions, Cut, SearchError, SearchOptions};
use files::{Provenance, commit, commit_with_document, stage_document, stage_set_document};
use seatrial::{AveragedSearch, ForceSearch, ForceSearchError, FoundStructure, PooledRuns, StructureSearch};
use serde_json::json;
use ship::model::Vessel;
use study::TermLists;
use study::documents::SearchDocument;
use study::files::read_any_vessel;

use crate::cli::{Common, member, none_given, samples};
use crate::failure::{Failure, WorkProgress};
use crate::inputs;
use crate::physical::{absent, note, settings, unfit};
use crate::pool::RunFlags;
use crate::stage::{Summary, Task};

/// Finds which terms a ship's model needs, from recordings of her; writes search.json and model.json. A ridge, chosen by
/// recordings that are left out, holds back the terms of a library. To a ship with forces it adds those that she lacks, if
/// recordings left out of all of it are followed better
#[derive(Parser)]
#[command(
    name = "search",
    after_help = "Example:\n  estimate search --vessel pipelines/esso-osaka/vessel.toml \
    --trajectories trajectories.parquet --recordings ingest.json --out search.json"
)]
pub struct SearchArguments {
    /// The vessel; its terms are the structure that the search begins with
    #[arg(long, visible_alias = "model", value_name = "vessel.toml")]
    vessel: PathBuf,
    #[command(flatten)]
    of: RunFlags,
    /// Begins with a core of some seven terms instead of the vessel's: resistance, drive and what steers. Of a ship with forces these are
    /// fitted too, and the average of both is written as average.json; one that diverges, or is far worse, is left out of it
    #[arg(long)]
    core: bool,
    /// Terms to search through instead of the library, or of the products that a ship with forces may lack: lists `surge`, `sway`
    /// and `yaw`
    #[arg(long, value_name = "terms.toml", conflicts_with = "core")]
    terms: Option<PathBuf>,
    /// Length of the windows that are fitted [s] [default: 60; of a ship with forces 100, at most]
    #[arg(long, value_name = "S")]
    fitted_window_s: Option<f64>,
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
    /// Each takes a few times as long as one fold of the search [default: 50]
    #[arg(long, value_name = "N", value_parser = clap::value_parser!(u32).range(0..=100_000))]
    bootstrap: Option<u32>,
    /// Finds K models of few terms besides, to be averaged: each structure on 70 % of the recordings, each model fitted to all;
    /// writes average.json. Takes about K times as long as --compact, since all are found again without each fold
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u32).range(2..=99))]
    average: Option<u32>,
    /// Of a ship with forces: forces that are added at most, one after the other [default: 3]
    #[arg(long, value_name = "K", value_parser = clap::value_parser!(u16).range(1..=50))]
    add_terms: Option<u16>,
}

/// The usual name of the document.
const MAIN: &str = "search.json";
/// Most forces that are added, by default.
const MOST_ADDED: u16 = 3;
/// Resamples, by default.
const RESAMPLES: u32 = 50;
/// Length of the windows of terms per sample \[s\], by default.
const WINDOW_S: f64 = 60.0;

impl Task for SearchArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let mut provenance = common.provenance("estimate");
        let given = read_any_vessel(&self.vessel, &mut provenance)?;
        let of_forces = Some(&given).filter(|vessel| vessel.model.forces.is_some()).cloned();
        match &of_forces {
            Some(ship) if !self.core => return self.forces(ship, (common, provenance)),
            Some(_) => self.check_averaged()?,
            None => absent([("--add-terms", self.add_terms.is_some())])?,
        }
        let read = || [&self.vessel].into_iter().chain(&self.terms).chain(self.of.inputs());
        let out = common.main_output(MAIN, read())?;
        let [single, several] = ["model.json", "average.json"].map(|name| member(&out, MAIN, name, read()));
        let (single, several) = (single?, several?);
        let in_samples = |flag: &str, s: f64| samples(flag, s, given.sample_rate_hz);
        let window = in_samples("--fitted-window-s", self.fitted_window_s.unwrap_or(WINDOW_S))?;
        let cut = Cut {
            window,
            every: window.div_ceil(4),
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
        let structure = match &of_forces {
            None => {
                let progress = WorkProgress::new("fits, at most", options.fits(), common.quiet);
                begun.find(&runs, &options, &|count| progress.advance(count))
            }
            Some(ship) => self.averaged((ship, &begun, &runs), &options, (common, &mut provenance))?,
        };
        let FoundStructure { search, model, average: averaged } =
            structure.map_err(|e| refused(self.of.file(), &e))?;
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
            options.bootstrap.map(|of| [("bootstrap", json!(of.resamples)), ("seed", json!(of.seed))]);
        let average = options.average.map(|of| [("average", json!(of.models)), ("seed", json!(of.seed))]);
        let core = self.core.then_some([("core", json!(true))]).into_iter().flatten();
        let settings = settings.into_iter().chain(core).chain(bootstrap.into_iter().chain(average).flatten());
        provenance.settings.extend(settings.map(|(key, value)| (key.to_owned(), value)));
        let mut members = vec![stage_document(single, &provenance, &model)?];
        if let Some(average) = &averaged {
            members.push(stage_document(&several, &provenance, average)?);
        }
        members.push(stage_set_document(&out, &provenance, &search, &members)?);
        commit(members)?;
        Ok(summary(&out, &search))
    }
}

fn summary(out: &Path, search: &SearchDocument) -> Summary {
    Summary::of(
        out,
        format!("{} terms; {}", search.terms.len(), search.statements.join("; ")),
        json!({"terms": search.terms.len(), "ridge": search.ridge, "statements": search.statements}),
    )
}

impl SearchArguments {
    /// Searches for forces that `vessel` lacks.
    fn forces(
        &self,
        vessel: &Vessel,
        (common, mut provenance): (&Common, Provenance),
    ) -> Result<Summary, Failure> {
        self.check_forces()?;
        let read = || [&self.vessel].into_iter().chain(&self.terms).chain(self.of.inputs());
        let out = common.main_output(MAIN, read())?;
        let single = member(&out, MAIN, "model.json", read())?;
        let terms: Option<TermLists> =
            self.terms.as_ref().map(|path| inputs::toml(path, "terms", &mut provenance)).transpose()?;
        let listed = terms.map(|term| [term.surge, term.sway, term.yaw]);
        let rate_hz = vessel.sample_rate_hz;
        let window = ("--fitted-window-s", self.fitted_window_s);
        let search = ForceSearch {
            vessel,
            settings: settings(1.0 / rate_hz, window, None)?,
            scored: self.window_s.map(|s| samples("--window-s", s, rate_hz)).transpose()?,
            folds: usize::from(self.folds),
            most_added: usize::from(self.add_terms.unwrap_or(MOST_ADDED)),
            listed: listed.as_ref(),
        };
        let of = self.terms.as_ref().unwrap_or(&self.vessel);
        search.check().map_err(|e| Failure::invalid(of, &e))?;
        let runs = self.of.read_of_forces(vessel, &mut provenance)?;
        let progress = WorkProgress::new("searches", search.searches(), common.quiet);
        let structure = search.find(&runs, &|count| progress.advance(count));
        let FoundStructure { search: document, model, .. } = structure.map_err(|e| self.unfound(e))?;
        let noted = [
            ("fitted_window_s", json!(search.settings.window_s)),
            ("window_samples", json!(search.scored)),
            ("folds", json!(self.folds)),
            ("add_terms", json!(search.most_added)),
            ("runs", json!(self.of.runs)),
            ("leave_out", json!(self.of.leave_out)),
        ];
        note(noted, &mut provenance);
        let member = stage_document(single, &provenance, &model)?;
        commit_with_document(member, &out, &provenance, &document)?;
        Ok(summary(&out, &document))
    }

    /// Searches from the core of `ship`, and fits her forces to the same runs.
    fn averaged(
        &self,
        (ship, begun, runs): (&Vessel, &StructureSearch, &PooledRuns),
        options: &SearchOptions,
        (common, provenance): (&Common, &mut Provenance),
    ) -> Result<Result<FoundStructure, SearchError>, Failure> {
        let settings = settings(1.0 / ship.sample_rate_hz, ("--fitted-window-s", None), None)?;
        let of_forces = self.of.read_of_forces(ship, provenance)?;
        let averaged_search = AveragedSearch { search: begun, options, vessel: ship, settings };
        let progress = WorkProgress::new("fits, at most", averaged_search.fits(), common.quiet);
        Ok(averaged_search.find([runs, &of_forces], &|count| progress.advance(count)))
    }

    /// Refuses flags of an average of other models, and what the folds choose.
    fn check_averaged(&self) -> Result<(), Failure> {
        let flags = [("--average", self.average.is_some()), ("--add-terms", self.add_terms.is_some())];
        none_given(flags, "the core of a ship with forces, which is averaged with these", "it without --core")
    }

    /// Refuses flags that need terms per sample.
    fn check_forces(&self) -> Result<(), Failure> {
        let flags = [
            ("--compact", self.compact),
            ("--bootstrap", self.bootstrap.is_some()),
            ("--average", self.average.is_some()),
        ];
        let ship = "a ship with forces, which is searched for missing products one by one";
        none_given(flags, ship, "terms per sample")
    }

    /// Why nothing was found.
    fn unfound(&self, error: ForceSearchError) -> Failure {
        match error {
            ForceSearchError::Search(error) => refused(self.of.file(), &error),
            ForceSearchError::Physical(error) => unfit(error, &self.vessel, self.of.file()),
            ForceSearchError::FewLeft { left, least, folds } => Failure::refuse(
                self.of.file(),
                "recordings",
                &format!("{left} without the largest of {folds} folds"),
                &format!("at least {least}, which verify what is added"),
                "name ingest.json with --recordings, add recordings, or ask for more --folds",
            ),
        }
    }

    /// The bootstrap over recordings, only for a search for few terms.
    fn bootstrap(&self, common: &Common) -> Option<BootstrapOptions> {
        let (resamples, seed) = (self.bootstrap.unwrap_or(RESAMPLES), common.seed.unwrap_or(1));
        (self.compact && resamples > 0).then_some(BootstrapOptions { resamples, seed })
    }

    /// The start of the search, and its candidate terms.
    fn begun(&self, vessel: Vessel, provenance: &mut Provenance) -> Result<StructureSearch, Failure> {
        let Some(path) = &self.terms else {
            let begun = match self.core {
                true => StructureSearch::by_core(&vessel),
                false => StructureSearch::by_roles(vessel),
            };
            return begun.map_err(|e| Failure::invalid(&self.vessel, &e));
        };
        let terms: TermLists = inputs::toml(path, "terms", provenance)?;
        StructureSearch::by_terms(vessel, &terms).map_err(|e| Failure::invalid(path, &e))
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
        SearchError::NoWindow => {
            let (lacking, remedy) = ("no run as long as a window", "shorten --window-s");
            Failure::refuse(file, "windows", lacking, "at least one", remedy)
        }
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
