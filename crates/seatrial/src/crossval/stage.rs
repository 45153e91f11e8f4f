use std::path::{Path, PathBuf};

use artifact::{Provenance, commit, stage_document};
use identification::ScoreStatus;
use identification::pooled::{Part, Score, Window, Windows};
use serde_json::json;
use vessel::{DegreeOfFreedom, Lane, Vessel};

use super::{Fold, folds};
use crate::failure::Failure;
use crate::instruments::Removal;
use crate::ordered::ordered;
use crate::pooled::{
    Data, Method, NominalModel, Pool, PoolFlags, deviations, lost_instruments, unidentified,
};
use crate::progress::Progress;
use crate::stage::Summary;
use study::documents::{CrossvalDocument, EstimatorScore, FreeRunErrors, SourceScore};

/// What `validate cross` was asked for.
pub struct Wanted<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The runs.
    pub trajectories: &'a Path,
    /// What to pool, and how.
    pub flags: &'a PoolFlags,
    /// The estimators to compare.
    pub estimators: &'a [Method],
    /// How the instruments' mean is removed.
    pub removal: Removal,
    /// Whether estimated intercepts are simulated too.
    pub intercepts: bool,
    /// Length of the windows in samples; none: whole runs.
    pub window: Option<usize>,
    /// Number of folds; none: every source is left out on its own.
    pub folds: Option<usize>,
    /// The file to write.
    pub out: PathBuf,
    /// No progress.
    pub quiet: bool,
}

/// The data, cut for fitting and for simulating.
struct Study<'a> {
    wanted: &'a Wanted<'a>,
    pool: Pool<'a>,
    sources: Vec<String>,
    parts: Vec<Part>,
    /// Per source.
    windows: Vec<Vec<Window>>,
    std: [f64; 3],
}

/// One estimator in one fold.
struct Tried {
    /// Per source that was left out.
    scores: Vec<(usize, Score)>,
    used: [bool; 3],
    reason: Option<(ScoreStatus, String)>,
}

/// Leaves sources out, estimates from the others, simulates over those left out: crossval.json.
///
/// # Errors
/// Refused files; no window; no estimator that could be simulated.
pub fn cross(wanted: &Wanted, mut provenance: Provenance) -> Result<Summary, Failure> {
    let (vessel, flags) = (wanted.vessel, wanted.flags);
    let strength = flags.strength()?;
    let nominal = NominalModel::read(&flags.nominal(), vessel, &mut provenance)?;
    let data = Data::read(wanted.trajectories, vessel, flags, &mut provenance)?;
    let lifted = vessel.model.with_intercepts();
    let removal = wanted.removal;
    let pool = Pool {
        model: &vessel.model,
        lifted: &lifted,
        removal,
        strength,
        nominal: &nominal,
        constant: data.constant(),
    };
    let study = Study::new(wanted, pool, &data)?;
    let all = folds(study.sources.len(), wanted.folds);
    let progress = Progress::new("folds", all.len() * wanted.estimators.len(), wanted.quiet);
    let mut tried: Vec<Vec<Tried>> = wanted.estimators.iter().map(|_| Vec::new()).collect();
    let count = wanted.estimators.len();
    let work = |i: usize| {
        let found = study.fold(&all[i / count], wanted.estimators[i % count]);
        progress.advance(1);
        Ok::<_, Failure>((i % count, found))
    };
    ordered(0..all.len() * count, work, |(estimator, found)| {
        tried[estimator].push(found);
        Ok(())
    })?;
    let scores: Vec<EstimatorScore> =
        wanted.estimators.iter().zip(&tried).map(|(method, tried)| study.score(*method, tried)).collect();
    let document = study.document(all.len(), scores, data.rate_hz());
    note(wanted, strength, &mut provenance);
    commit(vec![stage_document(&wanted.out, &provenance, &document)?])?;
    Ok(summary(&wanted.out, &document))
}

impl<'a> Study<'a> {
    fn new(wanted: &'a Wanted<'a>, pool: Pool<'a>, data: &Data) -> Result<Self, Failure> {
        let sources = data.sources();
        if sources.len() < 2 {
            return Err(Failure::refuse(
                wanted.trajectories,
                "runs or recordings",
                "one",
                "at least two, so that one can be left out",
                "add runs",
            ));
        }
        let width = wanted.vessel.model.exogenous();
        let stretches = data.stretches();
        let windows: Vec<Vec<Window>> = sources
            .iter()
            .map(|source| {
                let own = stretches.iter().filter(|stretch| stretch.source == *source);
                own.flat_map(|stretch| stretch.windows(width, wanted.window)).collect()
            })
            .collect();
        if windows.iter().all(Vec::is_empty) {
            return Err(Failure::refuse(
                wanted.trajectories,
                "windows",
                "no run as long as a window",
                "at least one",
                "shorten --window-s",
            ));
        }
        let std = deviations(windows.iter().flatten().map(|w| w.measured.as_slice()));
        Ok(Self { wanted, pool, sources, parts: data.parts(wanted.vessel), windows, std })
    }

    fn fold(&self, fold: &Fold, method: Method) -> Tried {
        let left_out = |part: &&Part| fold.left_out.iter().any(|i| self.sources[*i] == part.source);
        let mut parts: Vec<Part> = self.parts.iter().filter(|part| !left_out(part)).cloned().collect();
        let mut tried = Tried { scores: Vec::new(), used: [false; 3], reason: None };
        let without: Vec<&str> = fold.left_out.iter().map(|i| self.sources[*i].as_str()).collect();
        let without = format!("without {}", without.join(", "));
        let found = match self.pool.estimate(&mut parts, method) {
            Ok(found) => found,
            Err(diverged) => {
                let part = &parts[diverged.part];
                let lost = lost_instruments(&part.label, &part.source, diverged);
                tried.reason = Some((ScoreStatus::Diverged, format!("{without}: {lost}")));
                return tried;
            }
        };
        tried.used =
            [0, 1, 2].map(|d: usize| found.used[d].by_instruments() && found.degrees[d].solution.is_some());
        let Some(theta) = found.theta() else {
            let why = DegreeOfFreedom::ALL.into_iter().filter_map(|d| {
                unidentified(
                    d,
                    &self.pool.model.degrees[d as usize],
                    &found.degrees[d as usize].status,
                    self.pool.constant,
                )
            });
            let why = why.collect::<Vec<_>>().join("; ");
            tried.reason = Some((ScoreStatus::NotIdentifiable, format!("{without}: {why}")));
            return tried;
        };
        let intercepts = if self.wanted.intercepts { found.intercepts() } else { [0.0; 3] };
        let theta = self.pool.lifted.layout().woven(&theta, intercepts);
        let lanes: Vec<Lane> = theta.into_iter().map(Lane::splat).collect();
        tried.scores = fold.left_out.iter().map(|source| (*source, self.simulate(*source, &lanes))).collect();
        tried
    }

    fn simulate(&self, source: usize, model: &[Lane]) -> Score {
        let windows = Windows::new(self.pool.lifted, &self.windows[source]);
        let mut score = Score::default();
        for i in 0..windows.len() {
            score.add(windows.run(model, i)[0], windows.samples(i));
        }
        score
    }

    fn score(&self, method: Method, tried: &[Tried]) -> EstimatorScore {
        let mut whole = Score::default();
        let mut sources = Vec::new();
        for (source, score) in tried.iter().flat_map(|t| &t.scores) {
            whole.merge(score);
            let std = deviations(self.windows[*source].iter().map(|w| w.measured.as_slice()));
            sources.push((
                *source,
                SourceScore {
                    source: self.sources[*source].clone(),
                    windows: self.windows[*source].len() as u64,
                    diverged: score.diverged,
                    errors: score.rmse().map(|rmse| FreeRunErrors::new(rmse, std)),
                },
            ));
        }
        sources.sort_by_key(|(place, _)| *place);
        let reason = tried.iter().find_map(|t| t.reason.clone());
        let failed = tried.iter().filter(|t| t.reason.is_some()).count();
        let rmse = whole.rmse().filter(|_| reason.is_none());
        let (status, reason) = match reason {
            Some((status, why)) => (status, Some(format!("{failed} of {} folds, {why}", tried.len()))),
            None if whole.diverged > 0 => {
                (ScoreStatus::Diverged, Some(format!("{} windows diverge", whole.diverged)))
            }
            None => (ScoreStatus::Scored, None),
        };
        let norm = |rmse: [f64; 3]| (0..3).map(|d| (rmse[d] / self.std[d]).powi(2)).sum::<f64>().sqrt();
        EstimatorScore {
            name: method,
            status,
            reason,
            errors: rmse.map(|rmse| FreeRunErrors::new(rmse, self.std)),
            error_norm: rmse.map(norm).filter(|norm| norm.is_finite()),
            diverged: whole.diverged,
            by_instruments: [0, 1, 2].map(|d: usize| tried.iter().filter(|t| t.used[d]).count() as u64),
            sources: sources.into_iter().map(|(_, score)| score).collect(),
        }
    }

    fn document(&self, folds: usize, estimators: Vec<EstimatorScore>, rate_hz: f64) -> CrossvalDocument {
        let best = estimators
            .iter()
            .filter_map(|e| e.error_norm.map(|norm| (norm, e)))
            .min_by(|a, b| a.0.total_cmp(&b.0))
            .map(|(_, e)| e);
        CrossvalDocument {
            mean_removal: self.wanted.removal,
            nominal: self.wanted.flags.nominal().to_string(),
            prior: self.pool.strength,
            intercepts: self.wanted.intercepts,
            window_s: self.wanted.window.map(|samples| samples as f64 / rate_hz),
            windows: self.windows.iter().map(|w| w.len() as u64).sum(),
            samples: self.windows.iter().flatten().map(|w| w.samples() as u64).sum(),
            folds: folds as u64,
            std_u: self.std[0],
            std_v: self.std[1],
            std_r: self.std[2],
            recommended: best.map(|e| e.name),
            statements: statements(best, &estimators),
            estimators,
        }
    }
}

fn statements(best: Option<&EstimatorScore>, estimators: &[EstimatorScore]) -> Vec<String> {
    let mut out = Vec::new();
    if let Some((best, errors)) = best.and_then(|e| e.errors.map(|errors| (e, errors))) {
        out.push(format!("recommended: {} (fit {})", best.name, fits(&errors)));
        for other in estimators.iter().filter(|e| e.name != best.name) {
            if let Some(errors) = other.errors {
                let more = |d: usize| errors.fits()[d].zip(best.errors.and_then(|b| b.fits()[d]));
                let ahead: Vec<String> = [("u", 0), ("v", 1), ("r", 2)]
                    .into_iter()
                    .filter_map(|(name, d)| more(d).map(|(o, b)| format!("{name} {:+.2}", b - o)))
                    .collect();
                out.push(format!("{} over {}: {} points of fit", best.name, other.name, ahead.join(", ")));
            }
        }
    }
    for failed in estimators.iter().filter(|e| e.status != ScoreStatus::Scored) {
        let reason = failed.reason.as_deref().unwrap_or("");
        out.push(format!("{}: {}: {reason}", failed.name, failed.status));
    }
    out
}

/// `u 78.9 %, v 73.2 %, r 72.0 %`.
fn fits(errors: &FreeRunErrors) -> String {
    let one = |(name, fit): (&str, Option<f64>)| match fit {
        Some(fit) => format!("{name} {fit:.2} %"),
        None => format!("{name} –"),
    };
    ["u", "v", "r"].into_iter().zip(errors.fits()).map(one).collect::<Vec<_>>().join(", ")
}

fn note(wanted: &Wanted, strength: f64, provenance: &mut Provenance) {
    let names = wanted.estimators;
    let settings = [
        ("estimators", json!(names)),
        ("mean_removal", json!(wanted.removal)),
        ("prior", json!(strength)),
        ("intercepts", json!(wanted.intercepts)),
        ("window_samples", json!(wanted.window)),
        ("folds", json!(wanted.folds)),
    ];
    wanted.flags.note(settings, provenance);
}

fn summary(out: &Path, document: &CrossvalDocument) -> Summary {
    let said = document.statements.join("; ");
    Summary {
        line: format!("{}: {} windows, {} folds; {said}", out.display(), document.windows, document.folds),
        json: json!({"out": out, "windows": document.windows, "folds": document.folds,
            "recommended": document.recommended, "statements": document.statements}),
    }
}
