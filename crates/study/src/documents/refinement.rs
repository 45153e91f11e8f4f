//! From refined inputs to `refined.json`, and to the files that a campaign needs.

use std::collections::BTreeMap;

use design::CriterionName;
use estimation::Estimator;
use estimation::refine::Forward;
use ship::model::Vessel;
use trial::moments::Promise;
use trial::refining::Refinement;

use super::design::{CovarianceCriterion, DesignDocument, DesignPromise, Sequence, SequencePart};
use super::design_status::DesignStatus;
use super::refined::{RefinedDocument, RefinedExperiment, RefinedLimit};
use super::statements;

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
