//! What becomes of a design: refined inputs, and its promise after a trial.

use std::collections::BTreeMap;

use design::{AccuracyOf, CriterionName};
use estimation::Estimator;
use estimation::refine::Forward;
use files::{Document, Units};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{Source, Vessel};
use trial::moments::Promise;
use trial::refining::Refinement;

use super::design::{
    CovarianceCriterion, DesignDocument, DesignPromise, DesignStatus, Sequence, SequencePart, titles,
};
use super::statements;

/// `refined.json`: an experiment whose input signals were refined, against the one that it began as.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedDocument {
    /// `covariance relative A`: Σ variance/θ² of an output-error estimate.
    #[serde(with = "titles")]
    #[schemars(schema_with = "titles::schema")]
    pub criterion: CriterionName,
    /// The parameters that the experiment was simulated with.
    pub simulated_with: Source,
    /// The parameters that errors are relative to.
    pub relative_to: Source,
    /// Samples of the experiment.
    pub samples: u64,
    /// Its duration \[s\].
    pub duration_s: f64,
    /// The design's experiment.
    pub before: RefinedExperiment,
    /// The refined one.
    pub after: RefinedExperiment,
    /// Value before over value after: how many times the time the start would need for the same errors.
    pub worth: f64,
    /// Inputs that changed faster in the design's experiment than their rates allow: `before` is of one in which they follow it
    /// as fast as they may.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub slowed: Vec<String>,
    /// What error of the parameters the refined experiment promises, where nominal parameters are a guess.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub promise: Option<DesignPromise>,
    /// Every limit with what was reached.
    pub limits: Vec<RefinedLimit>,
    /// Time between the knots of a correction \[s\].
    pub knot_s: f64,
    /// Iterations of the search.
    pub iterations: u64,
    /// Simulations of the search.
    pub simulations: u64,
    /// Whether the search ended by itself, before its iterations did.
    pub settled: bool,
    /// What was found, in words.
    pub statement: String,
}

/// What is predicted of an experiment.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedExperiment {
    /// The criterion, with measurement errors and current.
    pub value: f64,
    /// Its part by measurement errors alone.
    pub measurement_value: f64,
    /// Root of the value: the root-mean-square parameter error that is predicted.
    pub parameter_error: f64,
    /// Predicted standard error of every parameter, in the parameter's unit.
    pub standard_errors: BTreeMap<String, f64>,
}

/// A limit of motion, of an input or of an input's rate.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RefinedLimit {
    /// As in `limits.toml`: `u_m_s`, `inputs.tau1`, `rates.tau1`.
    pub limit: String,
    /// The largest modulus allowed, in the unit of the state, the input or the input per second; none where there is no limit.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub allowed: Option<f64>,
    /// The largest modulus at the start.
    pub before: f64,
    /// The largest modulus of the refined experiment.
    pub after: f64,
}

impl RefinedDocument {
    /// What to print of it, with its promise.
    pub fn summary(&self) -> String {
        let promise = self.promise.as_ref().map_or(String::new(), |p| format!(" {}", p.statement));
        format!("{}{promise}", self.statement)
    }
}

impl Document for RefinedDocument {
    const ID: &'static str = "refined";
    const VERSION: u32 = 1;
    const UNITS: Units = &[
        ("1", "samples value measurement_value parameter_error worth iterations simulations"),
        ("1", "range"),
        ("s", "duration_s knot_s"),
        ("as the parameter", "standard_errors"),
        ("as `limit`", "allowed before after"),
    ];
}

// From refined inputs to `refined.json`, and to the files that a campaign needs.

/// The maneuver's name.
const NAME: &str = "refined";

/// A refined experiment of a vessel, for files.
pub struct RefinedFiles<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The experiment.
    pub found: &'a Refinement,
    /// Whether its parameters are a guess: nominal ones without true ones, and no estimates.
    pub is_guess: bool,
}

impl RefinedFiles<'_> {
    /// `refined.json`.
    pub fn document(&self) -> RefinedDocument {
        let (start, limits, refined) = (&self.found.start, &self.found.limits, &self.found.refined);
        let rate_hz = self.vessel.sample_rate_hz;
        let moduli = |forward: &Forward, inputs: &[f64]| limits.moduli(&forward.states, inputs, rate_hz);
        let (first, last) = (moduli(&refined.before, &start.inputs), moduli(&refined.after, &refined.inputs));
        let limit = |i: usize| RefinedLimit {
            limit: limits.names[i].clone(),
            allowed: Some(limits.allowed[i]).filter(|limit| limit.is_finite()),
            before: first[i],
            after: last[i],
        };
        RefinedDocument {
            criterion: CriterionName::ARelative,
            simulated_with: start.source,
            relative_to: start.source,
            samples: self.samples() as u64,
            duration_s: self.samples() as f64 / rate_hz,
            before: self.experiment(&refined.before),
            after: self.experiment(&refined.after),
            worth: self.found.efficiency(),
            slowed: start.slowed.clone(),
            promise: self.is_guess.then(|| self.promise()),
            limits: (0..limits.names.len()).map(limit).collect(),
            knot_s: self.found.knot as f64 / rate_hz,
            iterations: refined.iterations as u64,
            simulations: refined.evaluations as u64,
            settled: refined.settled,
            statement: statements::refinement(self.found),
        }
    }

    /// Refined inputs are played whatever the ship does.
    fn promise(&self) -> DesignPromise {
        statements::promise(Promise::of_guess(self.found.refined.after.parameter_error(), true))
    }

    fn samples(&self) -> usize {
        self.found.refined.inputs.len() / self.vessel.model.inputs.max(1)
    }

    fn by_parameter(&self, values: impl Iterator<Item = f64>) -> BTreeMap<String, f64> {
        self.vessel.model.parameter_names().map(str::to_owned).zip(values).collect()
    }

    fn experiment(&self, forward: &Forward) -> RefinedExperiment {
        RefinedExperiment {
            value: forward.value,
            measurement_value: forward.measurement_value,
            parameter_error: forward.parameter_error(),
            standard_errors: self.by_parameter(forward.standard_errors()),
        }
    }

    /// `inputs.csv`: a column per input, with digits that round-trip.
    pub fn inputs(&self) -> String {
        let model = &self.vessel.model;
        let mut text = model.input_names().join(",");
        for row in self.found.refined.inputs.chunks_exact(model.inputs.max(1)) {
            let cells: Vec<String> = row.iter().map(f64::to_string).collect();
            text.push('\n');
            text.push_str(&cells.join(","));
        }
        text.push('\n');
        text
    }

    /// `refined-dictionary.toml`: the experiment as one maneuver with inputs from `inputs.csv`.
    pub fn dictionary(&self) -> String {
        format!(
            "# Written by design refine: the refined experiment as one maneuver.\n[[maneuver]]\nname = \"{NAME}\"\nkind = \
             \"inputs\"\nfile = \"inputs.csv\"\nspeed_m_s = {:?}\nduration_s = {:?}\n",
            self.found.start.initial[0],
            self.samples() as f64 / self.vessel.sample_rate_hz
        )
    }

    /// The design with only the refined maneuver. Without a choice of shares there are no sensitivities, no gap and
    /// no efficiencies.
    pub fn design(&self, document: &RefinedDocument) -> DesignDocument {
        let forward = &self.found.refined.after;
        let samples = self.samples() as u64;
        DesignDocument {
            criterion: CriterionName::ARelative,
            mean_removal: None,
            status: DesignStatus::Refined,
            statement: document.statement.clone(),
            held: Vec::new(),
            beyond: Vec::new(),
            unreached: None,
            prior: None,
            promise: document.promise.clone(),
            shares: BTreeMap::from([(NAME.to_owned(), 1.0)]),
            order: vec![NAME.into()],
            candidates: None,
            sensitivities: BTreeMap::new(),
            dimension: None,
            gap: None,
            relative_gap: None,
            log_det: forward.log_det(samples),
            proved_global: false,
            starts: Vec::new(),
            efficiency: None,
            counts: None,
            counted: None,
            available: None,
            covariance: Some(CovarianceCriterion {
                name: CriterionName::ARelative,
                value: forward.value,
                weights: self.by_parameter(self.found.start.weights.iter().copied()),
                samples,
                standard_errors: document.after.standard_errors.clone(),
            }),
            estimator: Some(Estimator::OutputError),
            restricted: None,
            figures: None,
            accuracy: None,
            sequence: Some(Sequence {
                foretold: None,
                parts: vec![SequencePart { maneuver: NAME.into(), samples }],
                samples,
                value: forward.log_value(samples),
                statement: document.statement.clone(),
            }),
        }
    }
}

/// What a design promised, and what an estimate of its trial leaves uncertain.
#[derive(Clone, Debug, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct PromiseUpdate {
    /// The update in words.
    pub statement: String,
    /// The estimator of the estimate.
    pub estimator: Estimator,
    /// Samples of the trial.
    pub samples: u64,
    /// Its duration \[s\]. All promises are for this length.
    #[schemars(extend("exclusiveMinimum" = 0.0))]
    pub duration_s: f64,
    /// Every parameter, in order.
    pub parameters: Vec<UpdatedParameter>,
    /// Root of Σ (standard error/scale)², with the fixed scales of `parameters`; absent where one is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parameter_error: Option<UpdatedError>,
    /// The criterion of the design, where parameters alone tell it.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub criterion: Option<UpdatedCriterion>,
    /// Figures of merit, where they were given.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub figures: Vec<UpdatedFigure>,
    /// Root of Σ (standard error/scale)² after one more trial of the same design and length.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub after_another: Option<f64>,
    /// How much longer trials of the same design have to be, where an accuracy was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub accuracy: Option<UpdatedAccuracy>,
    /// What to know before using it, in words.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub statements: Vec<String>,
}

/// An error as it was promised, and as it is now.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedError {
    /// Before the trial, for its length.
    pub promised: f64,
    /// From the covariance at the estimate.
    pub now: f64,
    /// The first over the second; absent where the second is zero.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub ratio: Option<f64>,
}

/// A parameter, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedParameter {
    /// Its name.
    pub name: String,
    /// The estimate.
    pub estimate: f64,
    /// What its error is relative to, before and after the trial: the modulus of the value that the design had.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub scale: Option<f64>,
    /// Its standard error.
    pub standard_error: UpdatedError,
}

/// The criterion of a design as an error.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedCriterion {
    /// Its name on the command line.
    pub name: CriterionName,
    /// a, a-relative: root of Σ weight × variance, with the weights of the design; d: |covariance|^(1/(2 × parameters)), by degree
    /// of freedom where each is estimated by itself.
    pub error: UpdatedError,
}

/// A figure of merit, in its unit.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedFigure {
    /// The maneuver.
    pub maneuver: String,
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Its standard error.
    pub standard_error: UpdatedError,
}

/// The time that an accuracy takes, from the covariance after the trial.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct UpdatedAccuracy {
    /// The standard error that the design was asked for.
    pub wanted: f64,
    /// Which one.
    pub of: AccuracyOf,
    /// What the trial reached.
    pub reached: f64,
    /// Time of this design in all \[s\].
    pub needed_s: f64,
    /// What is left of it; 0 where the accuracy is reached \[s\].
    pub remaining_s: f64,
}

impl PromiseUpdate {
    /// What to print of it.
    pub fn summary(&self) -> String {
        std::iter::once(&self.statement).chain(&self.statements).cloned().collect::<Vec<_>>().join(" ")
    }
}

impl UpdatedError {
    /// Of both errors.
    pub fn of(promised: f64, now: f64) -> Self {
        Self { promised, now, ratio: (now > 0.0).then(|| promised / now) }
    }
}
