//! What an output-error estimate learns from a maneuver, predicted.

use std::path::{Path, PathBuf};

use artifact::Provenance;
use clap::ValueEnum;
use identification::{Noise, output_information, prediction_weights};
use serde_json::json;
use vessel::{DegreeOfFreedom, Model, Source, Streams, Vessel};

use crate::cli::name_of;
use crate::failure::Failure;
use crate::simulate::exogenous;
use study::documents::{OutputErrorModel, OutputErrorMoments};
use study::files::{generator, read_campaign};
use vessel::Run;

/// The estimators that moments are for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Predicted {
    /// Instrumental variables
    Iv,
    /// Least errors of free simulation
    OutputError,
}

/// Parameters of free simulations.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum SimulateWith {
    /// The true ones
    Value,
    /// The nominal ones
    Nominal,
}

/// Parameters drawn around others.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ParameterDraw {
    /// Which draw.
    pub number: u32,
    /// Relative standard deviation.
    pub spread: f64,
    /// Seed of all draws.
    pub seed: u64,
}

/// The noise that output errors are expected to have, and the model that is simulated.
pub struct OutputErrorNoise {
    model: Model,
    vessel_file: PathBuf,
    noise: Noise,
    parameters: Vec<f64>,
    about: OutputErrorModel,
}

impl OutputErrorNoise {
    /// `files`: vessel, campaign, and trajectories, for messages.
    ///
    /// # Errors
    /// A vessel without the parameters that are asked for; a spread that is none; validation maneuvers that the model cannot
    /// hold or that diverge.
    pub fn new(
        files: [&Path; 3],
        vessel: &Vessel,
        noise: Noise,
        with: Option<SimulateWith>,
        draw: Option<ParameterDraw>,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let known = vessel.value.iter().all(Option::is_some);
        let with = with.unwrap_or(if known { SimulateWith::Value } else { SimulateWith::Nominal });
        let source = if with == SimulateWith::Value { Source::Value } else { Source::Nominal };
        let mut parameters = vessel.parameters(source).map_err(|e| Failure::invalid(files[0], &e))?;
        let mut simulated_with = name_of(with);
        if let Some(draw) = draw {
            draw.apply(&mut parameters)?;
            simulated_with = format!("{simulated_with}, draw {}", draw.number);
            provenance.settings.insert("draw".into(), json!(draw.number));
            provenance.settings.insert("spread".into(), json!(draw.spread));
            provenance.settings.insert("seed".into(), json!(draw.seed));
        }
        let g = validation_weights(files, vessel, &parameters, provenance)?;
        let names = vessel.model.parameter_names().map(str::to_owned);
        let about = OutputErrorModel {
            simulated_with,
            parameters: names.zip(parameters.iter().copied()).collect(),
            rows: rows(&vessel.model),
            g,
        };
        let (model, vessel_file) = (vessel.model.clone(), files[0].to_owned());
        Ok(Self { model, vessel_file, noise, parameters, about })
    }

    /// Of one run.
    ///
    /// # Errors
    /// A simulation that diverges.
    pub fn moments(&self, run: &Run) -> Result<OutputErrorMoments, Failure> {
        let found =
            output_information(&self.model, &self.parameters, run.initial, &run.exogenous, &self.noise)
                .ok_or_else(|| {
                    diverges(&self.vessel_file, &format!("maneuver `{}`", run.segments[0].maneuver))
                })?;
        let weighted = self.noise.measurement.iter().all(|std| *std > 0.0);
        Ok(OutputErrorMoments {
            f: found.information,
            e: (!weighted).then_some(found.measurement),
            p: (self.noise.current > 0.0).then_some(found.process),
        })
    }

    /// As it stands in `moments.json`.
    pub fn document(self) -> OutputErrorModel {
        self.about
    }
}

impl ParameterDraw {
    fn apply(&self, parameters: &mut [f64]) -> Result<(), Failure> {
        if !(self.spread.is_finite() && self.spread > 0.0 && self.spread < 1.0) {
            return Err(Failure::Usage(format!(
                "--spread: found {}, expected a share above 0 and below 1; correct it",
                self.spread
            )));
        }
        let mut normals = vec![0.0; parameters.len()];
        Streams::new(self.seed, "nominal models").normals(self.number, 0, &mut normals);
        for (parameter, normal) in parameters.iter_mut().zip(normals) {
            // No draw turns a sign: damping stays damping.
            *parameter *= (1.0 + self.spread * normal).clamp(0.1, 1.9);
        }
        Ok(())
    }
}

/// Names of the lifted parameters.
pub(super) fn rows(model: &Model) -> Vec<String> {
    let of = |(d, degree): (DegreeOfFreedom, &vessel::Degree)| {
        degree.parameters.iter().cloned().chain([format!("intercept ({})", d.name())]).collect::<Vec<_>>()
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).flat_map(of).collect()
}

/// G, the mean over the campaign's validation maneuvers; none where the true model is needed to make them and not known.
fn validation_weights(
    [vessel_file, campaign, _]: [&Path; 3],
    vessel: &Vessel,
    parameters: &[f64],
    provenance: &mut Provenance,
) -> Result<Option<Vec<f64>>, Failure> {
    let config = read_campaign(campaign, provenance)?;
    let generator = generator(campaign, vessel, &config.validation_dictionary(), provenance)?;
    let invalid = |e| Failure::invalid(campaign, &e);
    let n = vessel.model.layout().with_intercepts().parameters();
    let (mut sum, mut total) = (vec![0.0; n * n], 0.0);
    for index in 0..generator.maneuvers().len() {
        let samples = generator.samples(index).map_err(invalid)?;
        let run = generator.realize(index, samples).map_err(invalid)?;
        let exogenous = exogenous(&vessel.model, &run.inputs);
        let name = &generator.maneuvers()[index].name;
        let own = prediction_weights(&vessel.model, parameters, run.initial, &exogenous)
            .ok_or_else(|| diverges(vessel_file, &format!("validation maneuver `{name}`")))?;
        sum.iter_mut().zip(&own).for_each(|(s, o)| *s += samples as f64 * o);
        total += samples as f64;
    }
    Ok((total > 0.0).then(|| sum.iter().map(|s| s / total).collect()))
}

fn diverges(vessel_file: &Path, what: &str) -> Failure {
    Failure::refuse(
        vessel_file,
        &format!("free simulation of {what}"),
        "one that diverges",
        "bounded motion",
        "take other parameters (--simulate-with), or a smaller --spread",
    )
}
