//! `validation.json`: models against the truth, and against runs that they were not fitted to.

use estimation::{Estimator, PairedDifference, Quantiles, Share};
use files::{Document, Units};
use numerics::statistics::median_interval_in_words;
use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::Source;
use trial::rounds::{ArmSummary, RoundGain, Stopping};
use validation::comparison::Compared;
use validation::selection::Selection;
use validation::tally::{Counted, PairCounts, QUANTILE_ERROR, Tally};

use super::Bounds;
use crate::tables::estimates::distinct;

/// `validation.json`: how good models are, by what was asked for.
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ValidationDocument {
    /// Of `validate --estimates` and `monte-carlo --keep scores`: the errors of estimates of simulated runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scored: Option<ScoredEstimates>,
    /// Of `monte-carlo`: the errors of realizations in memory.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub counted: Option<CountedRuns>,
    /// Of `validate --model`: models on recordings that they were not fitted to.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recordings: Option<Compared>,
    /// Of `validate --design`: models from picked sub-experiments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub picks: Option<Selection>,
    /// Of `monte-carlo` without a design: trials in rounds beside trials that are designed once.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub rounds: Option<TrialsInRounds>,
}

impl Document for ValidationDocument {
    const ID: &'static str = "validation";
    const VERSION: u32 = 2;
    const UNITS: Units = &[
        ("1", "bounds.parameter_error samples validation_samples realizations runs seed quantile_error"),
        ("1", "not_identifiable not_converged diverged undesigned without_estimate most_without_estimate"),
        ("1", "parameter_error_share parameter_error_share_interval simulation_error_share"),
        ("1", "simulation_error_share_interval without_estimate_share parameter_error share interval"),
        ("1", "median_ratio median_ratio_interval only_one_below only_other_below ratio"),
        ("1", "parameter_errors_below simulation_errors_below not_in_sum count beyond"),
        ("m/s, m/s and rad/s as numbers", "bounds.simulation_error simulation_error rmse_norm"),
        ("the compared error's unit", "others others.median others.interval"),
        ("m/s", "rmse_u rmse_v std_u std_v bias_u bias_v spread_u spread_v"),
        ("rad/s", "rmse_r std_r bias_r spread_r"),
        ("that of the errors around it", "from ends"),
        ("1", "windows error_norm pairs differences.median differences.interval stretches below above"),
        ("1", "inside_u inside_v inside_r bound own crossed spread.models place"),
        ("s", "window_s stretch_s"),
        ("%", "fit_u fit_v fit_r instrument_fit"),
        ("the channel's unit", "outside.low outside.high"),
        ("1", "picks counts available parts degenerate_from ratio_q90 degenerate_share"),
        ("1", "degenerate_share_interval"),
        (
            "1",
            "rounds.rounds nominal_spread accuracy maneuvers points.median points.median_interval points.q90",
        ),
        ("1", "points.q90_interval predicted within within_interval gains.low gains.high stopped"),
        ("1", "median_error median_error_interval within_stopped within_stopped_interval"),
        ("1", "rms_over_accuracy rms_over_accuracy_interval"),
        ("s", "duration_s time_s mean_time_s mean_time_interval_s"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        let Self { scored, counted, recordings, picks, rounds } = self;
        let has = scored.is_some() || counted.is_some() || recordings.is_some() || picks.is_some();
        if has || rounds.is_some() {
            return Ok(());
        }
        Err(Invalid::new("data", "nothing", "what was validated", "run its stage again"))
    }
}

/// The errors of estimates of simulated runs.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ScoredEstimates {
    /// The bounds that the shares below are counted against.
    pub bounds: Bounds,
    /// Samples of the validation trajectory.
    pub samples: u64,
    /// Seed of the campaign that the runs come from; absent for runs that were not simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub seed: Option<u64>,
    /// One entry per design.
    pub designs: Vec<DesignScores>,
    /// Which estimator to use for each design, where several were compared.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub recommendations: Option<Vec<EstimatorRecommendation>>,
    /// Every estimator on the same runs, where they were compared; `designs` then is that of `iv`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub compared: Option<Vec<EstimatorScores>>,
}

/// The errors of one estimator.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorScores {
    /// The estimator.
    pub estimator: Estimator,
    /// One entry per design.
    pub designs: Vec<DesignScores>,
}

/// The errors of one design. A run without an estimate, or whose free simulation diverged, counts as above every bound
/// and as infinite in the quantiles (written null).
#[derive(Clone, Debug, Default, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignScores {
    /// Name of the design.
    pub design: String,
    /// Number of runs.
    pub runs: u64,
    /// Runs without an estimate.
    pub not_identifiable: u64,
    /// Runs whose search for an estimate ended nowhere; absent for estimators that search for none.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub not_converged: Option<u64>,
    /// Runs whose free simulation diverged.
    pub diverged: u64,
    /// Share of all runs below the bound on the parameter error.
    pub parameter_error_share: f64,
    /// 95 % interval of that share (Wilson's); absent without runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter_error_share_interval: Option<[f64; 2]>,
    /// Share of all runs below the bound on the simulation error.
    pub simulation_error_share: f64,
    /// 95 % interval of that share (Wilson's); absent without runs.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub simulation_error_share_interval: Option<[f64; 2]>,
    /// Share of all runs that have no estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub without_estimate_share: Option<f64>,
    /// Of the parameter error.
    pub parameter_error: Quantiles,
    /// Of the simulation error.
    pub simulation_error: Quantiles,
    /// Of the RMSE in surge.
    pub rmse_u: Quantiles,
    /// Of the RMSE in sway.
    pub rmse_v: Quantiles,
    /// Of the RMSE in yaw rate.
    pub rmse_r: Quantiles,
}

/// Which estimator to use for one design.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct EstimatorRecommendation {
    /// Name of the design.
    pub design: String,
    /// The error that is compared, run by run.
    pub error: ComparedError,
    /// Number of runs.
    pub runs: u64,
    /// Estimators that leave a larger share of the runs without an estimate are not considered.
    pub most_without_estimate: f64,
    /// The estimator of least median error; null where the runs cannot tell it from another, or all are not considered.
    pub estimator: Option<Estimator>,
    /// The estimator of least median error, and those that the runs cannot tell from it.
    pub candidates: Vec<Estimator>,
    /// The other estimators that are considered, against that of least median error.
    pub others: Vec<PairedDifference>,
    /// That in words.
    pub statement: String,
}

/// What estimators are compared by.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ComparedError {
    /// The parameter error.
    ParameterError,
    /// The simulation error, where the truth is not known.
    SimulationError,
}

/// What the realizations of a campaign say together, as counts that merge exactly.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CountedRuns {
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

impl CountedRuns {
    /// The section of `tally` of `realizations` runs per design, drawn with `seed`, with the numbers of samples of a
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
            let counted = tally.counted.iter().filter(|c| c.estimator == *estimator);
            EstimatorScores { estimator: *estimator, designs: counted.map(scores).collect() }
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
        let pairs = pairs.filter_map(|(ratio, counts)| ratio.in_words(counts.ratio.count()));
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
    let is_of_pair = |c: &&Counted| c.design == pair.design && c.estimator == pair.one;
    let runs = tally.counted.iter().find(is_of_pair).map_or(0, |counted| counted.runs as usize);
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
        let ratio = format!("median ratio {:.3} ({interval}) over the same runs", (*median_ratio)?);
        Some(match *ends {
            [Some(low), _] if low > 1.0 => {
                format!("{design}: {one} has less parameter error than {other}: {ratio}.")
            }
            [_, Some(high)] if high < 1.0 => {
                format!("{design}: {other} has less parameter error than {one}: {ratio}.")
            }
            _ => format!("{design}: {one} and {other} cannot be told apart by parameter error: {ratio}."),
        })
    }
}

/// Trials designed in rounds against trials designed once.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct TrialsInRounds {
    /// Realizations per arm.
    pub realizations: u64,
    /// Rounds.
    pub rounds: u64,
    /// Sea time in all.
    pub duration_s: f64,
    /// What crude models are drawn about.
    pub crude_about: Source,
    /// Standard deviation of the logarithm of crude over these parameters.
    pub nominal_spread: f64,
    /// Predicted error at which a trial may stop.
    pub accuracy: f64,
    /// Maneuvers to design with.
    pub maneuvers: u64,
    /// The result in words.
    pub statements: Vec<String>,
    /// In the order `sequential`, `one-shot`, `informed`, `random`.
    pub arms: Vec<ArmSummary>,
    /// The trial in rounds over the one-shot trial, at the end of every round.
    pub gains: Vec<RoundGain>,
    /// `sequential`, `one-shot`.
    pub stopping: Vec<Stopping>,
}
