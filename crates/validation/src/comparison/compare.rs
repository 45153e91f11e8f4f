use estimation::pooled::{Covered, deviations, lies_above};
use numerics::statistics::paired_median;
use refusal::listed;
use regression::pooled::{Part, PooledRuns};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::RunView;
use ship::model::DegreeOfFreedom;

use super::bands::{Banded, Bands, Counter, EstimatedErrors, Inside, Outside, Spread, Spreads};
use super::simulated::{ComparedModel, Contestant, Difference, Ship, Simulated, Standing, Trajectory};
use super::validity::{ErrorCorrelations, Magnitudes, Validity, error_correlations};
use crate::crossval::CrossError;

/// Options of a comparison.
#[derive(Clone, Copy, Debug)]
pub struct CompareOptions<'a> {
    /// Name of the vessel.
    pub vessel: &'a str,
    /// Length of the windows in samples; `None`: whole runs.
    pub window: Option<usize>,
    /// The estimated errors of the first model: none, its own, or one for each of the models that are averaged.
    pub known: &'a [EstimatedErrors<'a>],
    /// The ranges that the first model was fitted on; of several, the first one with the most channels.
    pub covered: &'a [Covered],
    /// The magnitudes of the motions that it was fitted to, if known.
    pub magnitudes: Option<&'a Magnitudes>,
    /// The sampling rate \[Hz\].
    pub rate_hz: f64,
}

/// A model beside others on recordings that it was not fitted to.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Compared {
    /// Name of the vessel.
    pub vessel: String,
    /// Length of the windows \[s\]; null: whole runs.
    pub window_s: Option<f64>,
    /// Number of windows that were simulated.
    pub windows: u64,
    /// Their samples.
    pub samples: u64,
    /// Standard deviations of the measured states over the windows.
    pub std_u: f64,
    /// Of sway speed.
    pub std_v: f64,
    /// Of yaw rate.
    pub std_r: f64,
    /// The verdict first, then what to know, in words.
    pub statements: Vec<String>,
    /// The model, then what it is compared with.
    pub models: Vec<ComparedModel>,
    /// The others against the model.
    pub differences: Vec<Difference>,
    /// Shares of the samples inside the model's 95 % bands; null where its errors are not known.
    pub bands: Option<Bands>,
    /// How far the models of an average are apart; absent for a single model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub spread: Option<Spread>,
    /// Channels that leave the range that the model was fitted on.
    pub outside: Vec<Outside>,
    /// How the model's errors correlate with themselves and with inputs: where they do beyond chance, it lacks something.
    pub correlations: Vec<ErrorCorrelations>,
    /// Where the ship moves less or more than in any stretch that the model was fitted to; null where that is not known.
    #[serde(default)]
    pub validity: Option<Validity>,
}

/// A sample of the first model's simulation and of the measurement.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Traced {
    /// The run or recording.
    pub source: String,
    /// The window, from 0 in each recording.
    pub window: i32,
    /// Time in the window \[s\].
    pub t: f64,
    /// Measured u, v \[m/s\], r \[rad/s\].
    pub measured: [f64; 3],
    /// Simulated.
    pub simulated: [f64; 3],
    /// Half-width of the 95 % band, if known.
    pub half: [Option<f64>; 3],
}

/// Simulates all of `contestants` over `runs`; the first is the model under test, which also is returned over time.
///
/// # Errors
/// No run is as long as a window.
pub fn compare(
    contestants: &[Contestant],
    runs: &PooledRuns,
    options: &CompareOptions,
) -> Result<(Compared, Vec<Traced>), CrossError> {
    let mut sources: Vec<(String, Vec<Part>)> = runs.windows(options.window);
    sources.retain(|(_, windows)| !windows.is_empty());
    let windows = || sources.iter().flat_map(|(_, windows)| windows);
    let (Some(first), true) = (contestants.first(), windows().next().is_some()) else {
        return Err(CrossError::NoWindow);
    };
    let std = deviations(windows().map(|w| w.measured.as_slice()));
    let held = runs.are_inputs_held();
    let mut models: Vec<Simulated> = contestants.iter().map(|it| Simulated::of(it, &sources, held)).collect();
    models.push(Simulated::mean(&sources));
    let mut looked = Looked::new(first, options, held);
    looked.at(&sources, &models[0]);
    let compared: Vec<ComparedModel> = models.iter().map(|one| one.compared(&sources, std)).collect();
    let differences = differences(&compared, &models, std);
    let shares = looked.inside.shares().or_else(|| looked.spreads.as_ref()?.together.shares());
    let (bands, outside) = (shares.map(Bands::of), looked.counter.outside());
    let spread = looked.spreads.as_ref().and_then(Spreads::spread);
    let inside = (bands.as_ref(), spread.as_ref());
    let whole = runs.windows(None);
    let validity = options.magnitudes.and_then(|known| {
        let parts = || whole.iter().flat_map(|(_, parts)| parts);
        let rows: Vec<_> = parts().map(|part| first.widest().map(|ship| ship.exogenous(part))).collect();
        let views = parts().zip(&rows).map(|(part, rows)| {
            rows.as_ref().map_or(part.view(), |exogenous| RunView { exogenous, ..part.view() })
        });
        Validity::of(known, views, options.rate_hz)
    });
    let [std_u, std_v, std_r] = std;
    let tried = Compared {
        vessel: options.vessel.to_owned(),
        window_s: options.window.map(|samples| samples as f64 / options.rate_hz),
        windows: windows().count() as u64,
        samples: windows().map(|w| w.samples() as u64).sum(),
        std_u,
        std_v,
        std_r,
        statements: verdict(&compared, &differences, (validity.as_ref(), &outside), inside),
        models: compared,
        differences,
        bands,
        spread,
        correlations: error_correlations(first, &sources, &models[0], held),
        outside,
        validity,
    };
    Ok((tried, looked.trace))
}

/// The first model sample by sample.
struct Looked<'a> {
    /// Of the model, or of each of those that are averaged.
    banded: Vec<Banded<'a>>,
    inside: Inside,
    spreads: Option<Spreads>,
    widest: Option<Ship<'a>>,
    counter: Counter<'a>,
    rate_hz: f64,
    are_inputs_held: bool,
    trace: Vec<Traced>,
}

impl<'a> Looked<'a> {
    fn new(first: &Contestant<'a>, options: &CompareOptions<'a>, are_inputs_held: bool) -> Self {
        let (ships, known) = (&first.ships, options.known);
        let of_each = ships.len() == known.len();
        let banded = ships.iter().zip(known).map(|(ship, known)| Banded::new(*ship, *known));
        let rmse = known.first().filter(|_| !of_each).map(|known| known.rmse);
        Self {
            banded: banded.filter(|_| of_each).collect(),
            inside: Inside::default(),
            spreads: (ships.len() > 1).then(|| Spreads::new(ships.len(), rmse)),
            widest: first.widest().copied(),
            counter: Counter::new(options.covered),
            rate_hz: options.rate_hz,
            are_inputs_held,
            trace: Vec::new(),
        }
    }

    /// Half-widths of the bands over `window`, with its simulation; `None` if they are not known.
    fn halves(&mut self, window: &Part, Trajectory { states, spread }: &Trajectory) -> Option<Vec<[f64; 3]>> {
        let of_spread = self.spreads.as_mut().and_then(|spreads| spreads.add(window, states, spread));
        let each: Option<Vec<_>> =
            self.banded.iter().map(|banded| banded.halves(window, self.are_inputs_held)).collect();
        let each = each.filter(|each| !each.is_empty());
        let mean = each.map(|each| {
            let of = |k: usize, d: usize| each.iter().map(|band| band[k][d]).sum::<f64>() / each.len() as f64;
            (0..=window.samples()).map(|k| [0, 1, 2].map(|d| of(k, d))).collect::<Vec<[f64; 3]>>()
        });
        if let Some(halves) = &mean {
            self.inside.add(window, states, halves);
        }
        mean.or(of_spread)
    }

    fn at(&mut self, sources: &[(String, Vec<Part>)], simulated: &Simulated) {
        for ((source, windows), trajectories) in sources.iter().zip(&simulated.windows) {
            for (i, (window, trajectory)) in windows.iter().zip(trajectories).enumerate() {
                let Some(trajectory) = trajectory else { continue };
                let bands = self.halves(window, trajectory);
                let states = &trajectory.states;
                if let Some(ship) = &self.widest {
                    self.counter.add(&ship.exogenous(window), states);
                }
                let pairs = window.measured.as_chunks::<3>().0.iter().zip(states.as_chunks::<3>().0);
                self.trace.extend(pairs.enumerate().map(|(k, (measured, simulated))| Traced {
                    source: source.clone(),
                    window: i as i32,
                    t: k as f64 / self.rate_hz,
                    measured: *measured,
                    simulated: *simulated,
                    half: bands.as_ref().map_or([None; 3], |bands| bands[k].map(Some)),
                }));
            }
        }
    }
}

/// With fewer recordings than this, windows are compared: the interval of a median would have no two ends.
const FEW: usize = 6;

/// The first of `compared` against the others by their error norms: recording by recording, or window by window.
fn differences(compared: &[ComparedModel], models: &[Simulated], std: [f64; 3]) -> Vec<Difference> {
    let by_window = compared.first().is_none_or(|first| first.recordings.len() < FEW);
    let norms = |i: usize| match by_window {
        true => models[i].sums.iter().flatten().map(|sum| sum.errors(std, std).error_norm).collect(),
        false => compared[i].recordings.iter().map(|one| one.errors.error_norm).collect::<Vec<_>>(),
    };
    let first = norms(0);
    let difference = |i: usize| {
        let pairs = first.iter().zip(norms(i)).map(|(error, other)| [*error, other]);
        let [low, median, high] = paired_median(pairs)?;
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let (name, place, pairs) = (compared[i].name, compared[i].place, first.len() as u64);
        Some(Difference { name, place, pairs, median: finite(median), interval: [low, high].map(finite) })
    };
    (1..compared.len()).filter_map(difference).collect()
}

/// The verdict on the first of `compared`, then remarks.
fn verdict(
    compared: &[ComparedModel],
    differences: &[Difference],
    (validity, outside): (Option<&Validity>, &[Outside]),
    (bands, spread): (Option<&Bands>, Option<&Spread>),
) -> Vec<String> {
    let mut out: Vec<String> = compared.first().map(headline).into_iter().collect();
    out.extend(differences.iter().map(against));
    out.extend(validity.and_then(Validity::statement));
    out.extend(outside.iter().map(Outside::statement));
    out.extend(spread.map(Spread::statement));
    out.extend(bands.map(|b| {
        let [u, v, r] = [b.inside_u, b.inside_v, b.inside_r].map(|share| 100.0 * share);
        format!("inside the 95 % bands: u {u:.1} %, v {v:.1} %, r {r:.1} % of the samples")
    }));
    out
}

/// Useless if it diverges or is no better than the mean of the data.
fn headline(model: &ComparedModel) -> String {
    let errors = &model.errors;
    if errors.diverged > 0 {
        return format!("useless: {} of {} windows diverge", errors.diverged, errors.windows);
    }
    let degrees = || DegreeOfFreedom::ALL.into_iter().zip(errors.fits());
    let fits = degrees().map(fit).collect::<Vec<_>>().join(", ");
    let worse = degrees().filter(|(_, fit)| fit.is_some_and(|fit| fit <= 0.0));
    let worse: Vec<String> = worse.map(|(d, _)| d.name().to_owned()).collect();
    match worse.is_empty() {
        true => format!("fit {fits}"),
        false => format!("useless in {}: no better than the mean of the data (fit {fits})", listed(&worse)),
    }
}

fn fit((d, fit): (DegreeOfFreedom, Option<f64>)) -> String {
    fit.map_or_else(|| format!("{} does not vary", d.state()), |fit| format!("{} {fit:.1} %", d.state()))
}

fn against(difference: &Difference) -> String {
    let Difference { name, place, pairs, median, interval } = difference;
    let verdict = match interval {
        [Some(low), _] if *low > 0.0 => "better than",
        [_, Some(high)] if *high < 0.0 => "worse than",
        _ => "not told apart from",
    };
    let than = match name {
        Standing::LeastSquares => "least squares".to_owned(),
        Standing::Other => place.map_or("the other model".to_owned(), |place| format!("model {place}")),
        Standing::Averaged => format!("model {} of the average alone", place.unwrap_or_default()),
        Standing::Mean | Standing::Model | Standing::Average => "the mean of the data".to_owned(),
    };
    let lies = lies_above(*median, *interval, *pairs, "pairs");
    format!("{verdict} {than}: {lies}")
}
