use std::collections::BTreeMap;

use estimation::output_information;
use refusal::Invalid;
use regression::{Batch, Noise, meat as middle, moments};
use ship::engine::{Run, Segment};
use ship::model::{DegreeOfFreedom, Model};

use super::free_runs::diverges;
use super::{DegreeMoments, Expected, FreeRunModel, ManeuverMoments, OutputErrorMoments};

/// Name of the design of a dictionary's runs.
pub(super) const DICTIONARY: &str = "dictionary";

/// The predictions about estimates, besides the moments themselves.
#[derive(Clone, Debug)]
pub struct Prediction<'a> {
    model: &'a Model,
    /// The expected disturbances and the parameters that the residual is linearised with: for the matrices B.
    noise: Option<(Noise, Vec<f64>)>,
    /// The parameters of free simulations: for output error, with the same disturbances.
    free_runs: Option<Vec<f64>>,
}

/// A measured run as one run per segment, each from its first measured state; a run of a dictionary
/// unchanged.
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
    /// With the matrices B if disturbances are `expected`, and output error's information if there is a model for it.
    pub fn new(model: &'a Model, expected: Option<&Expected>, output_error: Option<&FreeRunModel>) -> Self {
        let theta = |by_name: &BTreeMap<String, f64>| -> Vec<f64> {
            model.parameter_names().map(|name| by_name[name]).collect()
        };
        let noise = expected.map(|e| (e.noise(), theta(&e.parameters)));
        Self { model, noise, free_runs: output_error.map(|o| theta(&o.parameters)) }
    }

    /// The runs whose moments are computed: the segments of measured ones, each with instruments of its own.
    pub fn runs(&self, recorded: &[Run]) -> Vec<Run> {
        recorded.iter().flat_map(segments).collect()
    }

    /// The moments of every run of a batch, each one maneuver, and whether they may be pooled with others of
    /// the same name: those of measured runs may, but not those of a dictionary, where each name has one run.
    ///
    /// # Errors
    /// A free simulation that diverges.
    pub fn moments(&self, batch: &Batch, runs: &[Run]) -> Result<Vec<(bool, ManeuverMoments)>, Invalid> {
        let mut middles = self.noise.as_ref().map(|(noise, theta)| middle(batch, theta, noise).into_iter());
        let of = |(run, found): (&Run, regression::ManeuverMoments)| {
            let mut middle = middles.as_mut().and_then(Iterator::next).into_iter().flatten();
            let degree = |((d, m), nonstationarity): ((DegreeOfFreedom, Vec<f64>), f64)| DegreeMoments {
                name: d.name().to_owned(),
                shape: [m.len().isqrt() as u64; 2],
                m,
                nonstationarity,
                b: middle.next(),
            };
            let matrices = DegreeOfFreedom::ALL.into_iter().zip(found.matrices);
            let maneuver = ManeuverMoments {
                name: run.segments[0].maneuver.clone(),
                samples: found.samples,
                degrees: matrices.zip(found.nonstationarity).map(degree).collect(),
                output_error: self.output_error(run)?,
            };
            Ok((run.design != DICTIONARY, maneuver))
        };
        runs.iter().zip(moments(batch)).map(of).collect()
    }

    fn output_error(&self, run: &Run) -> Result<Option<OutputErrorMoments>, Invalid> {
        let Some(((noise, _), theta)) = self.noise.as_ref().zip(self.free_runs.as_ref()) else {
            return Ok(None);
        };
        let found = output_information(self.model, theta, run.initial, &run.exogenous, noise)
            .ok_or_else(|| diverges(&format!("maneuver `{}`", run.segments[0].maneuver)))?;
        let weighted = noise.measurement.iter().all(|std| *std > 0.0);
        Ok(Some(OutputErrorMoments {
            f: found.information,
            e: (!weighted).then_some(found.measurement),
            p: (noise.current > 0.0).then_some(found.process),
        }))
    }
}
