//! What is predicted of estimates: the moments of runs, and what output error makes of them.

use std::collections::BTreeMap;

use estimation::output_information;
use refusal::Invalid;
use regression::runs::RunInstruments;
use regression::{Batch, InstrumentKind, Noise, meat, moments};
use ship::engine::{Run, Segment};
use ship::model::{DegreeOfFreedom, Model, Vessel};

use super::matrices::diverges;
use super::{DegreeMoments, Expected, FreeRunModel, ManeuverMoments, OutputErrorMoments, Unpredictable};

/// Name of the design of a dictionary's runs.
const DICTIONARY: &str = "dictionary";

/// The moments of runs, and predictions about estimates from them.
#[derive(Clone, Debug)]
pub struct Prediction<'a> {
    vessel: &'a Vessel,
    instruments: InstrumentKind,
    /// The expected disturbances and the parameters that the residual is linearised with: for the matrices B.
    noise: Option<(Noise, Vec<f64>)>,
    /// The parameters of free simulations: for output error, with the same disturbances.
    free_runs: Option<Vec<f64>>,
}

/// A measured run as one run per segment, each from its first measured state; a run of a dictionary unchanged.
fn segments(run: &Run) -> Vec<Run> {
    if run.design == DICTIONARY || run.segments.len() < 2 {
        return vec![run.clone()];
    }
    let ends = run.segments.iter().skip(1).map(|s| s.start).chain([run.samples()]);
    let part = |(segment, end): (&Segment, usize)| {
        let part = run.view().part(segment.start..end);
        Run {
            design: run.design.clone(),
            run: run.run,
            segments: vec![Segment { maneuver: segment.maneuver.clone(), start: 0 }],
            exogenous: part.exogenous.to_vec(),
            instrument_exogenous: part.own_instrument_inputs(),
            measured: part.measured.to_vec(),
            initial: if segment.start == 0 { run.initial } else { part.initial },
        }
    };
    run.segments.iter().zip(ends).map(part).collect()
}

impl<'a> Prediction<'a> {
    /// With these `instruments`, with the matrices B if disturbances are `expected`, and output error's information if there is a
    /// model for it.
    pub fn new(
        vessel: &'a Vessel,
        instruments: InstrumentKind,
        expected: Option<&Expected>,
        output_error: Option<&FreeRunModel>,
    ) -> Self {
        let theta = |by_name: &BTreeMap<String, f64>| -> Vec<f64> {
            vessel.model.parameter_names().map(|name| by_name[name]).collect()
        };
        let noise = expected.map(|e| (e.noise(), theta(&e.parameters)));
        Self { vessel, instruments, noise, free_runs: output_error.map(|o| theta(&o.parameters)) }
    }

    /// Refuses what an output-error estimate cannot be predicted of where no regressors weigh its errors.
    ///
    /// # Errors
    /// A model without a free parameter; a state without noise.
    pub fn check(model: &Model, noise: &Noise) -> Result<(), Invalid> {
        if model.has_regressors() {
            return Ok(());
        }
        if model.parameters() == 0 {
            let remedy = "write some as tables with `nominal`";
            return Err(Invalid::new("the model", "no free number", "at least one to be estimated", remedy));
        }
        let Some(d) = noise.measurement.iter().position(|std| *std <= 0.0) else { return Ok(()) };
        let thing = format!("`measurement.{}`", ["std_u_m_s", "std_v_m_s", "std_r_rad_s"][d]);
        let expected = "noise in every state, which an output-error estimate weighs errors by";
        Err(Invalid::new(thing, "0", expected, "state what the sensor has, however little"))
    }

    /// The runs whose moments are computed: the segments of measured ones, each with instruments of its own.
    pub fn runs(recorded: &[Run]) -> Vec<Run> {
        recorded.iter().flat_map(segments).collect()
    }

    /// The moments of every run, each one maneuver, and whether they may be pooled with others of the same name: those of measured
    /// runs may, but not those of a dictionary, where each name has one run.
    ///
    /// # Errors
    /// A simulation that diverges; a measured run of a model without regressors.
    pub fn moments(&self, recorded: &[Run]) -> Result<Vec<(bool, ManeuverMoments)>, Unpredictable> {
        if !self.vessel.model.has_regressors() {
            return recorded.iter().map(|run| Ok((false, self.whole(run)?))).collect();
        }
        let (runs, instruments) = (Self::runs(recorded), RunInstruments::new(self.vessel, self.instruments));
        let mut all = Vec::with_capacity(runs.len());
        for batch in instruments.batches(&runs) {
            let (prepared, members) = batch.map_err(|e| Unpredictable::Vessel(e.invalid()))?;
            all.extend(self.of_batch(&prepared.batch(), members)?);
        }
        Ok(all)
    }

    fn of_batch(&self, batch: &Batch, runs: &[Run]) -> Result<Vec<(bool, ManeuverMoments)>, Unpredictable> {
        let mut middles = self.noise.as_ref().map(|(noise, theta)| meat(batch, theta, noise).into_iter());
        let of = |(run, sums): (&Run, regression::ManeuverMoments)| {
            let mut middle = middles.as_mut().and_then(Iterator::next).into_iter().flatten();
            let degree = |((d, m), nonstationarity): ((DegreeOfFreedom, Vec<f64>), f64)| DegreeMoments {
                name: d.name().to_owned(),
                shape: [m.len().isqrt() as u64; 2],
                m,
                nonstationarity,
                b: middle.next(),
            };
            let matrices = DegreeOfFreedom::ALL.into_iter().zip(sums.matrices);
            let maneuver = ManeuverMoments {
                name: run.segments[0].maneuver.clone(),
                samples: sums.samples,
                degrees: matrices.zip(sums.nonstationarity).map(degree).collect(),
                output_error: self.output_error(run)?,
            };
            Ok((run.design != DICTIONARY, maneuver))
        };
        runs.iter().zip(moments(batch)).map(of).collect()
    }

    /// What a simulated maneuver says of parameters that multiply no regressors.
    fn whole(&self, run: &Run) -> Result<ManeuverMoments, Unpredictable> {
        let name = run.segments.first().map_or(String::new(), |segment| segment.maneuver.clone());
        if run.design != DICTIONARY {
            let value = format!("a run of `{}`", run.design);
            let expected = "maneuvers that `simulate dictionary` simulates, of a ship with forces";
            let remedy = "simulate them, or fit the runs by `estimate --fit together`";
            let refused = Invalid::new(format!("maneuver `{name}`"), value, expected, remedy);
            return Err(Unpredictable::Maneuver(refused));
        }
        let (samples, output_error) = (run.samples() as u64, self.output_error(run)?);
        Ok(ManeuverMoments { name, samples, degrees: Vec::new(), output_error })
    }

    fn output_error(&self, run: &Run) -> Result<Option<OutputErrorMoments>, Unpredictable> {
        let Some(((noise, _), theta)) = self.noise.as_ref().zip(self.free_runs.as_ref()) else {
            return Ok(None);
        };
        let model = &self.vessel.model;
        let information = output_information(model, theta, run.initial, &run.exogenous, noise);
        let maneuver = run.segments.first().map_or("", |segment| &segment.maneuver);
        let information =
            information.ok_or_else(|| Unpredictable::Vessel(diverges(&format!("maneuver `{maneuver}`"))))?;
        let weighted = noise.measurement.iter().all(|std| *std > 0.0);
        Ok(Some(OutputErrorMoments {
            f: information.information,
            e: (!weighted).then_some(information.measurement),
            p: (noise.current > 0.0).then_some(information.process),
        }))
    }
}
