use std::collections::BTreeMap;

use design::{AccuracyOf, CriterionName, Method, Status};
use estimation::Estimator;
use files::{Document, Units};
use refusal::Invalid;
use regression::MeanRemoval;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use trial::arranging::{Foretold, Promised};
use trial::campaign::{Designed, check_shares};
use trial::moments::{HeldParameter, SampledFrom, UnreachedMotion};

use super::refined::RefinedDesign;
use crate::figure_goals::{FigureGoal, FigureGoals};

pub use design::AccuracyPoint;

/// `design.json`: how long to run each maneuver, and how good that is.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignDocument {
    /// `D`: log|det| of the information matrix; `covariance D`, `A`, `relative A`, `V`, or `figures`: a criterion of the
    /// estimate's covariance, see `covariance`.
    #[serde(with = "titles")]
    #[schemars(schema_with = "titles::schema")]
    pub criterion: CriterionName,
    /// How the instruments' mean is removed, where there are instruments.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub mean_removal: Option<MeanRemoval>,
    /// What is known of it.
    pub status: DesignStatus,
    /// The certificate in words.
    pub statement: String,
    /// Parameters that no maneuver excites apart from the others: they were held at their values, and the trial tells nothing of
    /// them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub held: Vec<HeldParameter>,
    /// Where its maneuvers leave what the logs of the model cover, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub beyond: Vec<String>,
    /// Where the parameters that it was designed with are a guess or an estimate: which of its maneuvers, executed by inputs, many
    /// ships with other parameters miss.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub unreached: Option<Unreached>,
    /// Share of the experiment time per maneuver, in the dictionary's order; sums to 1.
    pub shares: BTreeMap<String, f64>,
    /// Maneuver names in the dictionary's order.
    pub order: Vec<String>,
    /// How many maneuvers there were to choose from, where those without a share are not listed.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub candidates: Option<u64>,
    /// The criterion's derivative by every share, for `D` g_q = Σ_d tr(M_d(w)⁻¹ M_d,q): above `dimension` a maneuver is
    /// worth more time (above what the maneuvers between their bounds have, where `available` binds). Absent where inputs
    /// were refined instead of shares.
    #[serde(default, skip_serializing_if = "BTreeMap::is_empty")]
    pub sensitivities: BTreeMap<String, f64>,
    /// p = Σ_q w_q g_q: the total dimension for `D`, the number of parameters for `covariance D`, 1 for A and V; with the
    /// sensitivities.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub dimension: Option<u64>,
    /// Kiefer–Wolfowitz gap max_q g_q − p; where `available` binds, max Σ g_q v_q − p over the shares v that it allows.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// The gap divided by p.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub relative_gap: Option<f64>,
    /// log|det| of the information matrix at the shares, whatever the criterion.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub log_det: Option<f64>,
    /// Efficiency of other shares of the same maneuvers against these.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub efficiency: Option<Efficiency>,
    /// Whole segments, where `--segments` asked for them.
    pub counts: Option<BTreeMap<String, u64>>,
    /// About the counts.
    pub counted: Option<Counts>,
    /// Largest share that every maneuver can have, where `--available` limits them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    #[schemars(extend("additionalProperties" = {"type": "number", "minimum": 0, "maximum": 1.000000001}))]
    pub available: Option<BTreeMap<String, f64>>,
    /// About a criterion of the covariance.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub covariance: Option<CovarianceCriterion>,
    /// What error of the parameters it promises, where the parameters that this was predicted with are a guess: nominal ones
    /// without true ones.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promise: Option<DesignPromise>,
    /// `output-error` where the covariance is that of an output-error estimate.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub estimator: Option<Estimator>,
    /// What is known before contributes, by the priors of a ship's forces or the fit of her model.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prior: Option<DesignPrior>,
    /// About few or long maneuvers, where they were asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub restricted: Option<Restricted>,
    /// Standard errors of figures of merit, where `--figures` was given.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub figures: Option<DesignFigures>,
    /// How long the experiment has to be, where an accuracy was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<Accuracy>,
    /// Order and lengths of the maneuvers, where `--arrange` asked for them: the optimized experiment follows them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub sequence: Option<Sequence>,
    /// How its input signals were refined, where `--refine` asked for it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub refined: Option<RefinedDesign>,
}

impl DesignDocument {
    /// The experiment of the design.
    pub fn designed(&self) -> Designed {
        let part = |part: &SequencePart| (part.maneuver.clone(), part.samples as usize);
        let order = self.sequence.as_ref().map(|sequence| sequence.parts.iter().map(part).collect());
        Designed { shares: self.shares.clone(), order }
    }

    /// How many maneuvers have a share.
    pub fn used(&self) -> usize {
        self.shares.values().filter(|share| **share > 0.0).count()
    }

    /// The parameters that are held, in words; `None` where none are.
    pub fn held_in_words(&self) -> Option<String> {
        (!self.held.is_empty()).then(|| HeldParameter::words(&self.held))
    }

    /// What to print of it, with its promise and its warnings.
    pub fn summary(&self) -> String {
        if self.refined.is_some() {
            let promise =
                self.promise.as_ref().map_or(String::new(), |promise| format!(" {}", promise.statement));
            return format!("{}{promise}", self.statement);
        }
        let used = self.used();
        let within = self.relative_gap.map_or(String::new(), |gap| format!(", relative gap {gap:.1e}"));
        let prior = self.prior.as_ref().map(|prior| format!("; {}", prior.statement));
        let too_short = self.accuracy.as_ref().and_then(|accuracy| {
            let from = accuracy.holds_from_s.filter(|from| accuracy.duration_s < *from)?;
            Some(format!(
                "; {:.1} s are too short for the predicted error, which holds from {from:.1} s on",
                accuracy.duration_s
            ))
        });
        let promise = self.promise.as_ref().map(|promise| format!("; {}", promise.statement));
        let unreached = self.unreached.as_ref().map(|unreached| format!("; {}", unreached.statement));
        let held = self.held_in_words().map_or_else(String::new, |words| format!("; {words}"));
        format!(
            "{used} of {} maneuvers, {}{within}{held}{}{}{}{}",
            self.shares.len(),
            self.status,
            prior.unwrap_or_default(),
            too_short.unwrap_or_default(),
            promise.unwrap_or_default(),
            unreached.unwrap_or_default(),
        )
    }
}

/// The parameter error that a design promises, with a range: an error is relative to a parameter, and the nominal one may be
/// off.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignPromise {
    /// Root of Σ (standard error/nominal parameter)², as predicted.
    pub parameter_error: f64,
    /// The range that was measured where each nominal parameter was off by a factor e^(0.4 z), z standard normal: 90 % of trials
    /// in one experiment, 31 of 40 in another (docs/design.md).
    pub range: [f64; 2],
    /// Both in words.
    pub statement: String,
}

/// What priors contribute to the estimates that a design is for.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignPrior {
    /// By parameter how much of its estimate is the prior's after the trial: 0 none, 1 all.
    pub shares: BTreeMap<String, f64>,
    /// Which are mostly the prior's, in words.
    pub statement: String,
}

/// Maneuvers by inputs that many ships miss.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Unreached {
    /// What the ships' parameters were drawn from.
    pub from: SampledFrom,
    /// How many ships were simulated.
    pub ships: u32,
    /// The maneuvers.
    pub motions: Vec<UnreachedMotion>,
    /// The warning in words, with a remedy.
    pub statement: String,
}

/// Maneuvers one after the other.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Sequence {
    /// In order; a maneuver may occur more than once.
    pub parts: Vec<SequencePart>,
    /// Samples of all.
    pub samples: u64,
    /// Value of the criterion with the state carried over, as `starts` have it.
    pub value: f64,
    /// How it was found, in words.
    pub statement: String,
    /// The errors that its estimate is to have, where that is by output error.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub foretold: Option<Foretold>,
    /// What each trial that it was compared with promises, by its own sequence: the one that was taken first.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub promised: Vec<Promised>,
}

/// One maneuver of a sequence.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SequencePart {
    /// Name in the dictionary.
    pub maneuver: String,
    /// Its samples.
    pub samples: u64,
}

/// Shares of few maneuvers.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Restricted {
    /// At most so many maneuvers.
    pub most_maneuvers: u64,
    /// `exhaustive`: every choice of maneuvers was tried; `exchange`: no exchange of one maneuver improves the criterion.
    pub method: Method,
    /// The fraction of the experiment time that the restriction costs at most; see `statement`.
    pub gap: f64,
    /// What is known of it, in words.
    pub statement: String,
}

/// The shortest experiment of a wanted accuracy.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Accuracy {
    /// The wanted standard error, relative to the parameters; 1 where it is that of figures, relative to those wanted.
    pub wanted: f64,
    /// Which relative standard error.
    pub of: AccuracyOf,
    /// Duration of the experiment \[s\].
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub duration_s: f64,
    /// Its samples.
    pub samples: u64,
    /// The accuracy that it is predicted to have.
    pub reached: f64,
    /// The range to expect it in, as in `promise`: of `overall`, where the nominal parameters are a guess.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub range: Option<[f64; 2]>,
    /// From which duration on that prediction holds \[s\]: maneuvers that take four fifths of the time are then as long as in the
    /// dictionary, whose matrices the prediction adds up. Trials that are shorter consist of their beginnings, and err more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub holds_from_s: Option<f64>,
    /// Predicted accuracy against time.
    pub curve: Vec<AccuracyPoint>,
    /// The answer in words.
    pub statement: String,
}

/// A criterion of the covariance of the instrumental-variable estimate, as `moments --campaign` predicts it.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct CovarianceCriterion {
    /// Its name on the command line.
    pub name: CriterionName,
    /// What is smallest at the shares, for an experiment of `samples`: Σ_d log det cov θ̂_d (d), Σ weight × variance
    /// (a, a-relative), the mean square of a free run's error (v), or Σ weight × variance/value² of figures of merit and
    /// 10⁻⁵ of that of parameters (figures).
    pub value: f64,
    /// Weight of every parameter's variance; with d whether it counts.
    pub weights: BTreeMap<String, f64>,
    /// Number of samples of the experiment that `value` and `standard_errors` are for; 1 where none was asked for.
    pub samples: u64,
    /// Predicted standard error of every parameter, in the parameter's unit; in proportion to 1/√samples.
    pub standard_errors: BTreeMap<String, f64>,
}

/// Efficiencies, for D |det Γ(w)/det Γ(w*)|^(1/n_θ): the fraction of the experiment time that the optimal shares would
/// need for the same value of the criterion.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Efficiency {
    /// Of equal shares.
    pub equal_shares: f64,
    /// Of every maneuver on its own (0: some direction is not excited at all).
    pub single: BTreeMap<String, f64>,
}

/// Whole segments that approximate the shares.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Counts {
    /// Number of segments.
    pub segments: u64,
    /// Samples per segment.
    pub segment_samples: u64,
    /// Efficiency of the counts against the shares.
    pub efficiency: f64,
    /// `exhaustive`: no other counts have a better criterion; `exchange`: no exchange of a segment improves it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub method: Option<Method>,
    /// The fraction of the experiment time that the counts waste at most against the best shares; see `statement`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub gap: Option<f64>,
    /// What is known of the counts, in words.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub statement: Option<String>,
}

impl Document for DesignDocument {
    const ID: &'static str = "design";
    const VERSION: u32 = 2;
    const UNITS: Units = &[
        ("1", "shares sensitivities dimension gap relative_gap log_det iterations equal_shares single"),
        ("1", "candidates counts segments segment_samples efficiency samples wanted reached"),
        ("1", "range parameter_error missed share interval ships"),
        ("1", "value measurement_value worth simulations"),
        ("s", "duration_s knot_s"),
        ("the unit beside it", "standard_error d_optimal"),
        ("as the parameter", "standard_errors"),
        ("as `limit`", "allowed before after"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        check_shares(&self.shares)
    }
}

/// What the experiment leaves uncertain of figures of merit, where `--figures` was given.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignFigures {
    /// Number of samples of the experiment that standard errors are for; 1 where none was asked for. They are in proportion
    /// to 1/√samples.
    pub samples: u64,
    /// All figures with slopes, those without a weight too.
    pub figures: Vec<DesignFigure>,
    /// Which figures are left out or have no weight, and why.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub left_out: Vec<String>,
}

/// A figure of merit and its standard errors.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct DesignFigure {
    /// The maneuver.
    pub maneuver: String,
    /// Its name.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Unit of its value and errors.
    pub unit: String,
    /// Its value for the model.
    pub value: f64,
    /// Its weight in the criterion `figures`.
    pub weight: f64,
    /// The standard error that was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub wanted: Option<f64>,
    /// Its standard error after this experiment.
    pub standard_error: f64,
    /// That after the D-optimal experiment of the same maneuvers and time: the one of `design` without `--criterion`.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub d_optimal: Option<f64>,
    /// The first over the second.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
}

/// Figures and their standard errors for an experiment.
pub struct SolvedFigures<'a> {
    /// The figures.
    pub goals: &'a FigureGoals,
    /// The standard error of each after the experiment.
    pub errors: Vec<f64>,
    /// After the D-optimal one, if there is one.
    pub d_optimal: Option<Vec<f64>>,
}

impl SolvedFigures<'_> {
    /// For the document. `samples`: of the experiment.
    pub(super) fn document(&self, samples: u64) -> DesignFigures {
        let one = |(index, goal): (usize, &FigureGoal)| {
            let (error, other) = (self.errors[index], self.d_optimal.as_ref().map(|errors| errors[index]));
            DesignFigure {
                maneuver: goal.maneuver.clone(),
                name: goal.name.clone(),
                what: goal.what.clone(),
                unit: goal.unit.clone(),
                value: goal.figure.value,
                weight: goal.figure.weight,
                wanted: goal.wanted,
                standard_error: error,
                d_optimal: other,
                ratio: other.filter(|other| *other > 0.0).map(|other| error / other),
            }
        };
        DesignFigures {
            samples,
            figures: self.goals.goals.iter().enumerate().map(one).collect(),
            left_out: self.goals.left_out.clone(),
        }
    }
}

refusal::choices! {
    /// What is known of a design.
    pub enum DesignStatus {
        /// Proved global.
        Optimal = "optimal",
        /// First-order optimal, not proved global.
        Stationary = "stationary",
        /// The gap was not reached.
        Stalled = "stalled",
        /// Few maneuvers, see `restricted`.
        Restricted = "restricted",
        /// One maneuver of refined inputs.
        Refined = "refined",
    }
}

impl From<Status> for DesignStatus {
    fn from(status: Status) -> Self {
        match status {
            Status::Optimal => Self::Optimal,
            Status::Stationary => Self::Stationary,
            Status::Stalled => Self::Stalled,
        }
    }
}

/// Criteria by the names that pages give them.
pub(super) mod titles {
    use design::CriterionName;
    use schemars::{Schema, SchemaGenerator, json_schema};
    use serde::de::Error;
    use serde::{Deserialize, Deserializer, Serializer};

    /// As a title.
    pub fn serialize<S: Serializer>(name: &CriterionName, to: S) -> Result<S::Ok, S::Error> {
        to.serialize_str(name.title())
    }

    /// From a title.
    pub fn deserialize<'de, D: Deserializer<'de>>(from: D) -> Result<CriterionName, D::Error> {
        let title = String::deserialize(from)?;
        let titles = CriterionName::ALL.map(CriterionName::title).join("`, `");
        let known = CriterionName::ALL.into_iter().find(|name| name.title() == title);
        known
            .ok_or_else(|| D::Error::custom(format!("unknown variant `{title}`, expected one of `{titles}`")))
    }

    /// All titles.
    pub fn schema(_: &mut SchemaGenerator) -> Schema {
        json_schema!({"type": "string", "enum": CriterionName::ALL.map(CriterionName::title)})
    }
}
