//! `estimate --structure library|few|average`: a model structure found from recordings.

use std::path::Path;

use estimation::runs::AdditionalUnknowns;
use estimation::search::{AverageOptions, BootstrapOptions, Cut, SearchError, SearchOptions};
use files::{Provenance, commit_with_document, stage_document};
use regression::MeanRemoval;
use seatrial::{AveragedSearch, FoundStructure, PooledRuns, StructureSearch};
use serde_json::json;
use ship::model::Vessel;
use study::documents::{ChosenStructure, EstimateDocument, ModelStructure};
use study::files::read_any_vessel;

use super::estimate_forces::settings;
use crate::cli::{Common, samples};
use crate::failure::{Failure, WorkProgress};
use crate::inputs;
use crate::pool::{EstimateArguments, Folds, SetPaths, besides, note};
use crate::stage::Summary;

/// Models of few terms that are averaged.
const AVERAGED: u32 = 10;
/// Resamples, by default.
const RESAMPLES: u32 = 50;
/// Length of the windows of terms per sample \[s\], by default.
const WINDOW_S: f64 = 60.0;

/// Finds the model of recordings: of terms that a ridge, chosen by recordings left out, holds back; of a ship with forces those
/// that she lacks, or the average of these and of terms.
pub(super) fn searched(
    asked: &EstimateArguments,
    structure: ChosenStructure,
    common: &Common,
) -> Result<Summary, Failure> {
    let mut provenance = common.provenance("estimate");
    let vessel = read_any_vessel(&asked.flags.vessel, &mut provenance)?;
    let search = Searching { asked, structure, common };
    search.check()?;
    let written = SetPaths::of(common, asked, false)?;
    let promised = asked.promised(common)?;
    let FoundStructure { search: mut summary, model } = search.terms(vessel, &mut provenance)?;
    summary.statements.extend(study::noted_contradicting(&provenance));
    let promise = asked.promise(promised, Some(&model), &mut provenance)?;
    let said = format!("{} terms; {}", summary.terms.len(), summary.statements.join("; "));
    let details =
        json!({"terms": summary.terms.len(), "ridge": summary.ridge, "statements": summary.statements});
    let document = EstimateDocument {
        structure: Some(search.structure),
        search: Some(summary),
        promise,
        ..EstimateDocument::new(model.estimator, model.mean_removal)
    };
    let member = stage_document(&written.model, &provenance, &model)?;
    commit_with_document(member, &written.document, &provenance, &document)?;
    Ok(Summary::of(&written.document, said, details).also(besides(None, document.promise.as_ref())))
}

/// A search with its flags.
struct Searching<'a> {
    asked: &'a EstimateArguments,
    structure: ChosenStructure,
    common: &'a Common,
}

impl Searching<'_> {
    fn kind(&self) -> ModelStructure {
        self.structure.chosen
    }

    /// Refuses flags that a search does not have.
    fn check(&self) -> Result<(), Failure> {
        let (asked, flags, kind) = (self.asked, &self.asked.flags, self.kind());
        let is_few = kind == ModelStructure::Few;
        asked.check_none(
            kind,
            [
                ("--estimator", !asked.estimator.is_empty()),
                ("--part-s", flags.part_s.is_some()),
                ("--prior", flags.prior.is_some()),
                ("--mean-removal", flags.mean_removal != MeanRemoval::Complete),
                ("--reference", asked.reference.is_some()),
                ("--bootstrap", asked.bootstrap.is_some() && !is_few),
                (
                    "--unknown-current or --intercepts",
                    asked.additional.unknown() != AdditionalUnknowns::default(),
                ),
                ("--shard or --gather", asked.sharding.shard.is_some() || asked.sharding.gathers()),
            ],
        )
    }

    /// How many folds recordings are dealt into.
    fn folds(&self) -> Result<u16, Failure> {
        match self.asked.folds {
            None => Ok(6),
            Some(Folds(Some(count @ 3..))) => Ok(count),
            Some(_) => Err(Failure::Usage(
                "--folds: found a search, expected a whole number from 3 on; correct it".to_owned(),
            )),
        }
    }

    /// The terms that the recordings support; beside forces, the average of both.
    fn terms(&self, given: Vessel, provenance: &mut Provenance) -> Result<FoundStructure, Failure> {
        let (asked, of, common) = (self.asked, &self.asked.flags.of, self.common);
        let averaged = self.kind() == ModelStructure::Average && !given.model.has_regressors();
        let with_forces = averaged.then(|| given.clone());
        let fitted_s = asked.fitted_window_s.unwrap_or(WINDOW_S);
        let window = samples("--fitted-window-s", fitted_s, given.sample_rate_hz)?;
        let cut = Cut { window, every: window.div_ceil(4), scored: asked.scored(&given)? };
        let is_averaged = self.kind() == ModelStructure::Average && !averaged;
        let (folds, seed) = (self.folds()?, common.seed.unwrap_or(1));
        let begun = self.begun(given)?;
        let (runs, _) = of.read(&begun.vessel, provenance, inputs::runs)?;
        let options = SearchOptions {
            cut,
            folds: usize::from(folds),
            ridges: SearchOptions::half_decades(),
            compact: self.kind() == ModelStructure::Few,
            bootstrap: self.bootstrap(),
            average: is_averaged.then_some(AverageOptions { models: AVERAGED, seed }),
            rate_hz: begun.vessel.sample_rate_hz,
        };
        let structure = match &with_forces {
            None => {
                let progress = WorkProgress::new("fits, at most", options.fits(), common.quiet);
                begun.find(&runs, &options, &|count| progress.advance(count))
            }
            Some(ship) => self.averaged((ship, &begun, &runs), &options, provenance)?,
        };
        let structure = structure.map_err(|e| refused(of.file(), &e))?;
        let bootstrap =
            options.bootstrap.map(|of| [("bootstrap", json!(of.resamples)), ("seed", json!(of.seed))]);
        let average = options.average.map(|of| [("average", json!(of.models)), ("seed", json!(of.seed))]);
        let settings = [
            ("fitted_window_samples", json!(cut.window)),
            ("every_samples", json!(cut.every)),
            ("window_samples", json!(cut.scored)),
            ("folds", json!(folds)),
            ("structure", json!(self.kind())),
            ("runs", json!(of.runs)),
            ("leave_out", json!(of.leave_out)),
        ];
        note(settings.into_iter().chain(bootstrap.into_iter().chain(average).flatten()), provenance);
        Ok(structure)
    }

    /// Searches from the core of `ship`, and fits her forces to the same runs.
    fn averaged(
        &self,
        (ship, begun, runs): (&Vessel, &StructureSearch, &PooledRuns),
        options: &SearchOptions,
        provenance: &mut Provenance,
    ) -> Result<Result<FoundStructure, SearchError>, Failure> {
        let settings = settings(1.0 / ship.sample_rate_hz, ("--fitted-window-s", None), None)?;
        let (of_ship, _) = self.asked.flags.of.read(ship, provenance, inputs::runs)?;
        let averaged_search = AveragedSearch { search: begun, options, vessel: ship, settings };
        let progress = WorkProgress::new("fits, at most", averaged_search.fits(), self.common.quiet);
        Ok(averaged_search.find([runs, &of_ship], &|count| progress.advance(count)))
    }

    /// The bootstrap over recordings, only for a search for few terms.
    fn bootstrap(&self) -> Option<BootstrapOptions> {
        let (resamples, seed) = (self.asked.bootstrap.unwrap_or(RESAMPLES), self.common.seed.unwrap_or(1));
        (self.kind() == ModelStructure::Few && resamples > 0).then_some(BootstrapOptions { resamples, seed })
    }

    /// The start of the search, and its candidate terms.
    fn begun(&self, vessel: Vessel) -> Result<StructureSearch, Failure> {
        let begun = match vessel.model.has_regressors() {
            true => StructureSearch::by_roles(vessel),
            false => StructureSearch::by_core(&vessel),
        };
        begun.map_err(|e| Failure::invalid(&self.asked.flags.vessel, &e))
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
            "put the ingest.json of the trajectories beside them, add recordings, or ask for fewer --folds",
        ),
        SearchError::FewForAverage { recordings, needed } => Failure::refuse(
            file,
            "recordings",
            &recordings.to_string(),
            &format!("at least {needed} for `average`, of which 70 % without any fold are as many as folds"),
            "add recordings, or ask for fewer --folds",
        ),
        SearchError::NoWindow => {
            let (lacking, remedy) = ("no run as long as a window", "shorten --window-s");
            Failure::refuse(file, "windows", lacking, "at least one", remedy)
        }
        SearchError::NoResample => {
            answer("models that can be searched for again; add recordings, or set --bootstrap 0")
        }
        SearchError::NoAverage => {
            answer("models that can be fitted; add recordings, or take another --structure")
        }
        SearchError::AllDiverge { .. } => answer(
            "one that no fold rejects; leave out recordings of another ship or load, shorten --fitted-window-s, or correct the base \
             structure",
        ),
        SearchError::Useless(_) => {
            answer("one that is better; log what moves the vessel, or correct the base structure")
        }
    }
}
