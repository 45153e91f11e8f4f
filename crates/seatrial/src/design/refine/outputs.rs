//! What `design refine` writes.

use std::collections::BTreeMap;
use std::fmt::Write;
use std::path::{Path, PathBuf};

use artifact::{Provenance, Staged, stage_document};
use identification::refine::{Forward, Refined};
use vessel::Vessel;

use super::limits::Limits;
use super::start::Start;
use crate::cli::name_of;
use crate::failure::Failure;
use study::documents::{
    CovarianceCriterion, DesignDocument, Efficiency, RefinedDocument, RefinedExperiment, RefinedLimit,
    Sequence, SequencePart,
};

/// Everything that is known of a refined experiment.
pub struct Outputs<'a> {
    pub vessel: &'a Vessel,
    pub start: &'a Start,
    pub limits: &'a Limits,
    pub refined: &'a Refined,
    /// Samples between knots.
    pub knot: usize,
}

/// The maneuver's name.
const NAME: &str = "refined";

impl Outputs<'_> {
    /// `refined.json`.
    pub fn document(&self) -> RefinedDocument {
        let Refined { before, after, .. } = self.refined;
        let rate_hz = self.vessel.sample_rate_hz;
        let moduli = |forward: &Forward, inputs: &[f64]| self.limits.moduli(&forward.states, inputs, rate_hz);
        let (first, last) = (moduli(before, &self.start.inputs), moduli(after, &self.refined.inputs));
        let limit = |i: usize| RefinedLimit {
            limit: self.limits.names[i].clone(),
            allowed: Some(self.limits.allowed[i]).filter(|limit| limit.is_finite()),
            before: first[i],
            after: last[i],
        };
        let worth = before.value / after.value;
        RefinedDocument {
            criterion: "covariance relative A".into(),
            simulated_with: name_of(self.start.with),
            relative_to: name_of(self.start.relative_to),
            samples: self.samples() as u64,
            duration_s: self.samples() as f64 / rate_hz,
            before: self.experiment(before),
            after: self.experiment(after),
            worth,
            limits: (0..self.limits.names.len()).map(limit).collect(),
            knot_s: self.knot as f64 / rate_hz,
            iterations: self.refined.iterations as u64,
            simulations: self.refined.evaluations as u64,
            settled: self.refined.settled,
            statement: self.statement(worth),
        }
    }

    fn statement(&self, worth: f64) -> String {
        if self.refined.inputs == self.start.inputs {
            return "Nothing better was found within the limits: the inputs are the start's.".into();
        }
        let ended = if self.refined.settled { "settled" } else { "stopped at its limit of iterations" };
        format!(
            "Predicted parameter error {:.3} instead of {:.3}, worth {:.0} % more time; a local search that {ended} after {} \
             iterations, not proved best; the simulation with {} parameters and without disturbances keeps every limit.",
            self.refined.after.value.sqrt(),
            self.refined.before.value.sqrt(),
            100.0 * (worth - 1.0),
            self.refined.iterations,
            match name_of(self.start.with).as_str() {
                "value" => "true",
                _ => "nominal",
            }
        )
    }

    fn samples(&self) -> usize {
        self.refined.inputs.len() / self.vessel.model.inputs.max(1)
    }

    fn by_parameter(&self, values: impl Iterator<Item = f64>) -> BTreeMap<String, f64> {
        self.vessel.model.parameter_names().map(str::to_owned).zip(values).collect()
    }

    fn experiment(&self, forward: &Forward) -> RefinedExperiment {
        RefinedExperiment {
            value: forward.value,
            measurement_value: forward.measurement_value,
            parameter_error: forward.value.sqrt(),
            standard_errors: self.by_parameter(forward.variances.iter().map(|v| v.max(0.0).sqrt())),
        }
    }

    /// All files: `refined.json` at `out`, then `inputs.csv`, the dictionary and the design at `others`.
    pub fn staged(
        &self,
        out: &Path,
        [inputs, dictionary, design]: &[PathBuf; 3],
        provenance: &Provenance,
        document: &RefinedDocument,
    ) -> Result<Vec<Staged>, Failure> {
        Ok(vec![
            stage_document(out, provenance, document)?,
            Staged::bytes(inputs, self.csv().as_bytes())?,
            Staged::bytes(dictionary, self.dictionary().as_bytes())?,
            stage_document(design, provenance, &self.design(document))?,
        ])
    }

    /// A column per input, digits that give the same numbers again.
    fn csv(&self) -> String {
        let model = &self.vessel.model;
        let names: Vec<&str> = model.variables[3..3 + model.inputs].iter().map(|v| v.name.as_str()).collect();
        let mut text = names.join(",");
        for row in self.refined.inputs.chunks_exact(model.inputs.max(1)) {
            let cells: Vec<String> = row.iter().map(f64::to_string).collect();
            text.push('\n');
            text.push_str(&cells.join(","));
        }
        text.push('\n');
        text
    }

    fn dictionary(&self) -> String {
        let mut text = String::from("# Written by design refine: the refined experiment as one maneuver.\n");
        let duration = self.samples() as f64 / self.vessel.sample_rate_hz;
        // Writing into a string cannot fail.
        let _ = write!(
            text,
            "[[maneuver]]\nname = \"{NAME}\"\nkind = \"inputs\"\nfile = \"inputs.csv\"\nspeed_m_s = {:?}\nduration_s = {duration:?}\n",
            self.start.initial[0]
        );
        text
    }

    /// The design that has nothing but the refined maneuver.
    fn design(&self, document: &RefinedDocument) -> DesignDocument {
        let forward = &self.refined.after;
        let samples = self.samples() as u64;
        let n = forward.information.len().isqrt();
        let mut mean: Vec<f64> = forward.information.iter().map(|f| f / samples as f64).collect();
        let one = || BTreeMap::from([(NAME.to_owned(), 1.0)]);
        DesignDocument {
            criterion: document.criterion.clone(),
            mean_removal: "complete".into(),
            status: "refined".into(),
            statement: document.statement.clone(),
            shares: one(),
            order: vec![NAME.into()],
            sensitivities: one(),
            dimension: 1,
            gap: 0.0,
            relative_gap: 0.0,
            log_det: numerics::log_det(n, &mut mean).map_or(f64::MIN, |found| found.log_abs),
            proved_global: false,
            starts: Vec::new(),
            efficiency: Efficiency { equal_shares: 1.0, single: one() },
            counts: None,
            counted: None,
            available: None,
            covariance: Some(CovarianceCriterion {
                name: "a-relative".into(),
                value: forward.value,
                weights: self.by_parameter(self.start.weights.iter().copied()),
                samples,
                standard_errors: document.after.standard_errors.clone(),
            }),
            estimator: Some("output-error".into()),
            robust: None,
            restricted: None,
            accuracy: None,
            sequence: Some(Sequence {
                parts: vec![SequencePart { maneuver: NAME.into(), samples }],
                samples,
                value: -(forward.value * samples as f64).ln(),
                statement: document.statement.clone(),
            }),
        }
    }
}
