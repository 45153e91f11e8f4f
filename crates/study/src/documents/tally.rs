use estimation::{Estimator, Share};
use files::{Document, Units};
use numerics::statistics::median_interval_in_words;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use validation::tally::{Bounds, Counted, PairCounts, QUANTILE_ERROR, Tally};

use super::{DesignScores, EstimatorScores};
use crate::estimates::distinct;

/// `tally.json`: what the realizations of a campaign say together, as counts that merge exactly.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TallyDocument {
    /// The bounds that the shares below are counted against.
    pub bounds: Bounds,
    /// Runs of every design that the campaign has.
    pub realizations: u64,
    /// Samples of a run.
    pub samples: u64,
    /// Samples of the validation runs together.
    pub validation_samples: u64,
    /// Seed of all random numbers.
    pub seed: u64,
    /// Relative error of the quantiles at most: they are read from histograms.
    pub quantile_error: f64,
    /// What became of the runs by each estimator.
    pub scores: Vec<EstimatorScores>,
    /// Estimators against each other on the same runs.
    pub paired: Vec<PairedRatio>,
    /// What it says, in words.
    pub statements: Vec<String>,
    /// The counts that all of this is made of.
    pub tally: Tally,
}

/// Two estimators on the same runs.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PairedRatio {
    /// The design.
    pub design: String,
    /// The one.
    pub one: Estimator,
    /// The other.
    pub other: Estimator,
    /// Median over the runs of the other's parameter error over the one's; null where it is infinite.
    pub median_ratio: Option<f64>,
    /// 95 % interval of that median. One that contains 1 tells no difference.
    pub median_ratio_interval: [Option<f64>; 2],
    /// Share of the runs in which the one alone lies below its bound.
    pub only_one_below: Share,
    /// Share of the runs in which the other alone does.
    pub only_other_below: Share,
}

impl TallyDocument {
    /// The document of `tally` of `realizations` runs per design, drawn with `seed`, with the numbers of samples of a
    /// run and of the validation runs.
    pub fn new(
        tally: Tally,
        bounds: Bounds,
        realizations: u64,
        [samples, validation_samples]: [u64; 2],
        seed: u64,
    ) -> Self {
        let estimators = distinct(tally.counted.iter().map(|counted| counted.estimator));
        let of = |estimator: &Estimator| {
            let own = tally.counted.iter().filter(|c| c.estimator == *estimator);
            EstimatorScores { estimator: *estimator, designs: own.map(scores).collect() }
        };
        let mut document = Self {
            bounds,
            realizations,
            samples,
            validation_samples,
            seed,
            quantile_error: QUANTILE_ERROR,
            scores: estimators.iter().map(of).collect(),
            paired: tally.pairs.iter().map(|pair| paired(pair, &tally)).collect(),
            statements: Vec::new(),
            tally,
        };
        let shares = document.tally.counted.iter().filter_map(|counted| share_in_words(counted, bounds));
        let pairs = document.paired.iter().zip(&document.tally.pairs);
        let pairs = pairs.filter_map(|(own, counts)| own.in_words(counts.ratio.count()));
        document.statements = shares.chain(pairs).collect();
        document
    }
}

fn scores(counted: &Counted) -> DesignScores {
    let runs = counted.runs as usize;
    let share = |count: u64| Share::of(count as usize, runs);
    let (parameter, simulation) =
        (share(counted.parameter_errors_below), share(counted.simulation_errors_below));
    let without = counted.not_identifiable + counted.not_converged;
    DesignScores {
        design: counted.design.clone(),
        runs: counted.runs,
        not_identifiable: counted.not_identifiable,
        not_converged: counted.estimator.searches().then_some(counted.not_converged),
        diverged: counted.diverged,
        parameter_error_share: parameter.share,
        parameter_error_share_interval: parameter.interval,
        simulation_error_share: simulation.share,
        simulation_error_share_interval: simulation.interval,
        without_estimate_share: Some(share(without).share),
        parameter_error: counted.parameter_error.histogram.quantiles(),
        simulation_error: counted.simulation_error.histogram.quantiles(),
        rmse_u: counted.rmse_u.histogram.quantiles(),
        rmse_v: counted.rmse_v.histogram.quantiles(),
        rmse_r: counted.rmse_r.histogram.quantiles(),
    }
}

fn paired(pair: &PairCounts, tally: &Tally) -> PairedRatio {
    let own = |c: &&Counted| c.design == pair.design && c.estimator == pair.one;
    let runs = tally.counted.iter().find(own).map_or(0, |counted| counted.runs as usize);
    PairedRatio {
        design: pair.design.clone(),
        one: pair.one,
        other: pair.other,
        median_ratio: pair.ratio.quantile(0.5),
        median_ratio_interval: pair.ratio.quantile_interval(0.5),
        only_one_below: Share::of(pair.only_one_below as usize, runs),
        only_other_below: Share::of(pair.only_other_below as usize, runs),
    }
}

/// The share of the runs whose parameter error lies below its bound.
fn share_in_words(counted: &Counted, bounds: Bounds) -> Option<String> {
    let Share { share, interval } = Share::of(counted.parameter_errors_below as usize, counted.runs as usize);
    let [low, high] = interval?;
    Some(format!(
        "{}, {}: parameter error below {} in {:.3} % of {} runs (95 % interval {:.3} to {:.3} %).",
        counted.design,
        counted.estimator,
        bounds.parameter_error,
        100.0 * share,
        counted.runs,
        100.0 * low,
        100.0 * high
    ))
}

impl PairedRatio {
    /// Whether the `runs` distinguish the two, and which is better.
    fn in_words(&self, runs: u64) -> Option<String> {
        let Self { design, one, other, median_ratio, median_ratio_interval: ends, .. } = self;
        let interval = match median_interval_in_words(*ends, runs, |end| format!("{end:.3}")) {
            Ok(interval) => format!("95 % interval {interval}"),
            Err(why) => why,
        };
        let found = format!("median ratio {:.3} ({interval}) over the same runs", (*median_ratio)?);
        Some(match *ends {
            [Some(low), _] if low > 1.0 => {
                format!("{design}: {one} has less parameter error than {other}: {found}.")
            }
            [_, Some(high)] if high < 1.0 => {
                format!("{design}: {other} has less parameter error than {one}: {found}.")
            }
            _ => format!("{design}: {one} and {other} cannot be told apart by parameter error: {found}."),
        })
    }
}

impl Document for TallyDocument {
    const ID: &'static str = "tally";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "bounds.parameter_error realizations samples validation_samples seed quantile_error runs"),
        ("1", "not_identifiable not_converged diverged parameter_error_share parameter_error_share_interval"),
        ("1", "simulation_error_share simulation_error_share_interval without_estimate_share"),
        ("1", "parameter_error median_ratio median_ratio_interval only_one_below only_other_below ratio"),
        ("1", "parameter_errors_below simulation_errors_below not_in_sum count beyond"),
        ("m/s, m/s and rad/s as numbers", "bounds.simulation_error simulation_error"),
        ("m/s", "rmse_u rmse_v"),
        ("rad/s", "rmse_r"),
        ("that of the errors around it", "from ends"),
    ];
}
