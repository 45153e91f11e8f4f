use estimation::pooled::{Covariance, Covered, Delivered, Pool, Pooled, RecordingConstant, Surroundings};
use estimation::{Estimator, RunEstimate};
use files::{Document, Units};
use numerics::statistics::Z;
use refusal::{Invalid, check_numbers};
use regression::MeanRemoval;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::{
    Constrained, Constraint, DegreeOfFreedom, DerivedChannel, DerivedSpec, InputSpec, MeasuredSpec, TermSpec,
    Variable, Vessel, VesselFile, Written,
};
use trial::moments::PriorInformation;
use validation::comparison::Magnitudes;

use super::forces::{FittedForces, own_lag};

/// `model.json`: a model as it was estimated, with all that it takes to simulate it. Every stage that takes a `vessel.toml`
/// takes it instead.
///
/// The state x = (u, v, r) goes from sample to sample by x(k+1) = x(k) + Σ value · term + constant, the terms at sample k.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelDocument {
    /// Name of the vessel.
    pub vessel: String,
    /// The sampling rate that the values hold for.
    pub sample_rate_hz: f64,
    /// Inputs, in order.
    pub inputs: Vec<InputSpec>,
    /// Measured disturbances, in order.
    pub measured: Vec<MeasuredSpec>,
    /// Channels that are computed from inputs, measured disturbances and each other.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub derived: Vec<DerivedSpec>,
    /// Surge, sway, yaw; without terms where the model is made of forces.
    pub degrees: Vec<ModelDegree>,
    /// Forces that the model is made of, in place of terms per sample.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub forces: Option<FittedForces>,
    /// Covariance of the values that were estimated by themselves, 0 at bounds; null where some have no standard error, for the
    /// estimate of a single run, and where the structure was searched for: a ridge or a choice of terms leaves none that hold.
    pub covariance: Option<Covariance>,
    /// The estimator.
    pub estimator: Estimator,
    /// How the instruments' mean is removed.
    pub mean_removal: MeanRemoval,
    /// Regression pairs.
    pub samples: u64,
    /// What each run or recording gains beside the terms.
    pub recordings: Vec<RecordingConstant>,
    /// The current that was found with it, where one was unknown.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub surroundings: Vec<Surroundings>,
    /// What the data covered: the model is known to hold within.
    pub covered: Vec<Covered>,
    /// How large the motions were that it was fitted to; null where no run was long enough, and from
    /// sums of runs.
    #[serde(default)]
    pub magnitudes: Option<Magnitudes>,
    /// Where the structure was searched for: RMSE of u, v \[m/s\], r \[rad/s\] of free simulations over recordings that were left out
    /// of the whole search, which bands of predictions come from; null where some diverged.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub left_out_rmse: Option<[f64; 3]>,
    /// Whether the data reject the structure; null where that could not be tried. Of a searched model: whether recordings
    /// that were left out of the whole search speak against it.
    pub rejected: Option<bool>,
    /// What to know before using the model, in words.
    pub statements: Vec<String>,
    /// Models whose trajectories are averaged for predictions, where an average was made; the others are this model alone.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub members: Vec<AverageMember>,
    /// RMSE of u, v \[m/s\], r \[rad/s\] of that average over the recordings that were fitted; null where a model diverges.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average_rmse: Option<[f64; 3]>,
}

/// Share of its width by which a channel may leave its range in the data: a model must be able to repeat its logs
/// with slightly different inputs.
const SPARE: f64 = 0.02;

/// The equation of one degree of freedom; its numbers are per sample, in the unit of its state.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelDegree {
    /// `surge`, `sway` or `yaw`.
    pub name: String,
    /// The state that gains: `u`, `v` or `r`.
    pub state: String,
    /// Its unit.
    pub unit: String,
    /// Its terms.
    pub parameters: Vec<ModelParameter>,
    /// What the state gains in a sample whatever the vessel does.
    pub constant: f64,
    /// The same by least squares, with `least_squares` of the parameters.
    pub constant_least_squares: Option<f64>,
    /// Standard deviation of what terms and constant leave of the measured increments.
    pub increment_std: f64,
    /// RMSE of free simulations over the recordings that were fitted; null where one diverges.
    pub output_rmse: Option<f64>,
}

/// A term with its value.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ModelParameter {
    /// Its name.
    pub name: String,
    /// What it multiplies.
    pub term: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Its standard error; null at a bound, and where the structure was searched for.
    pub standard_error: Option<f64>,
    /// Of a searched structure of few terms: 2.5 % of the searches over recordings that were drawn again found less.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub low: Option<f64>,
    /// 2.5 % found more.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub high: Option<f64>,
    /// Whether the value was known and not estimated.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub fixed: bool,
    /// Another parameter that it equals …
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub tied_to: Option<String>,
    /// … times this factor.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub factor: Option<f64>,
    /// Between which estimates stay; null at an open end.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub bounds: Option<[Option<f64>; 2]>,
    /// Whether it lies at a bound.
    #[serde(default, skip_serializing_if = "std::ops::Not::not")]
    pub at_bound: bool,
    /// The estimate by least squares of the same data, to be compared with.
    pub least_squares: Option<f64>,
    /// The true value, where the logs were simulated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub truth: Option<f64>,
}

impl ModelDocument {
    /// The model that `estimator` found in `pool`; `None` unless all degrees of freedom have an estimate.
    pub fn new(pool: &Pool, estimator: Estimator, found: &Pooled) -> Option<Self> {
        let delivered = found.delivered.as_ref()?;
        let errors: Vec<Option<f64>> =
            found.degrees.iter().flat_map(|d| &d.parameters).map(|p| p.standard_error).collect();
        Some(Self {
            samples: found.samples,
            rejected: found.criticism.as_ref().map(|criticism| criticism.rejected),
            statements: found.statements.clone(),
            members: Vec::new(),
            average_rmse: None,
            ..Self::of(pool.vessel, (estimator, pool.removal), delivered, &errors)
        })
    }

    /// The model in `delivered`, from the estimate `found` of one run.
    pub fn of_run(vessel: &Vessel, removal: MeanRemoval, found: &RunEstimate, delivered: &Delivered) -> Self {
        let errors = found.estimate.as_ref().map_or(&[][..], |(_, errors)| errors);
        let errors: Vec<Option<f64>> = errors.iter().map(|e| Some(*e).filter(|e| !e.is_nan())).collect();
        let model = Self::of(vessel, (found.estimator, removal), delivered, &errors);
        let sources: Vec<&str> = model.recordings.iter().map(|recording| recording.source.as_str()).collect();
        let sources = sources.join(", ");
        let statement = format!("estimated from run {sources} alone; what its structure lacks was not tried");
        Self { statements: vec![statement], ..model }
    }

    fn of(
        vessel: &Vessel,
        made: (Estimator, MeanRemoval),
        delivered: &Delivered,
        errors: &[Option<f64>],
    ) -> Self {
        Self::with_degrees(vessel, made, delivered, |d| ModelDegree::new(vessel, delivered, errors, d))
    }

    /// The delivered model, with equations by `degree`.
    pub(super) fn with_degrees(
        vessel: &Vessel,
        (estimator, mean_removal): (Estimator, MeanRemoval),
        delivered: &Delivered,
        degree: impl FnMut(DegreeOfFreedom) -> ModelDegree,
    ) -> Self {
        Self {
            vessel: vessel.name.clone(),
            sample_rate_hz: vessel.sample_rate_hz,
            inputs: Vec::new(),
            measured: Vec::new(),
            derived: Vec::new(),
            degrees: DegreeOfFreedom::ALL.into_iter().map(degree).collect(),
            forces: None,
            covariance: delivered.covariance.clone(),
            estimator,
            mean_removal,
            samples: delivered.recordings.iter().map(|recording| recording.samples).sum(),
            recordings: delivered.recordings.clone(),
            surroundings: delivered.surroundings.clone(),
            covered: delivered.covered.clone(),
            magnitudes: None,
            left_out_rmse: None,
            rejected: None,
            statements: Vec::new(),
            members: Vec::new(),
            average_rmse: None,
        }
        .with_channels(vessel)
    }

    /// The same with the channels of `vessel`.
    fn with_channels(self, vessel: &Vessel) -> Self {
        let model = &vessel.model;
        let role = |place: usize| model.roles.get(&place).copied();
        let input = |(i, variable): (usize, &Variable)| {
            let coupling = vessel.couplings[i];
            let inputs = model.input_variables();
            InputSpec {
                name: variable.name.clone(),
                unit: variable.unit.clone(),
                follows: coupling.map(|(leader, _)| inputs[leader].name.clone()),
                factor: coupling.map(|(_, factor)| factor),
                range: vessel.actuators[i].range,
                lag_s: own_lag(vessel, i),
                rate_per_s: vessel.actuators[i].rate_per_s,
                dead_band: Some(vessel.actuators[i].dead_band).filter(|band| *band > 0.0),
                hold_s: Some(vessel.actuators[i].hold_s).filter(|hold| *hold > 0.0),
                role: role(3 + i),
            }
        };
        let measured = |(place, variable): (usize, &Variable)| MeasuredSpec {
            name: variable.name.clone(),
            unit: variable.unit.clone(),
            simulated: model.simulated.get(&place).copied(),
            role: role(place),
        };
        let derived = |channel: &DerivedChannel| DerivedSpec {
            name: model.variables[channel.variable].name.clone(),
            unit: model.variables[channel.variable].unit.clone(),
            formula: channel.text.clone(),
            role: role(channel.variable),
        };
        // In the order of the file, not of computation.
        let mut written: Vec<&DerivedChannel> = model.derived.iter().collect();
        written.sort_by_key(|channel| channel.variable);
        Self {
            inputs: model.input_variables().iter().enumerate().map(input).collect(),
            measured: (3 + model.inputs..).zip(model.measured()).map(measured).collect(),
            derived: written.into_iter().map(derived).collect(),
            ..self
        }
    }

    /// What its fit knows of the parameters before another trial; `None` where it has no covariance.
    pub fn known(&self) -> Option<PriorInformation> {
        match &self.forces {
            Some(forces) => {
                let of = |name: &str| forces.parameters.iter().find(|p| p.name == name)?.prior_deviation;
                let names = forces.parameters.iter().map(|p| p.name.as_str());
                PriorInformation::new(names, Some(&forces.covariance), of)
            }
            None => {
                let parameters = self.degrees.iter().flat_map(|degree| &degree.parameters);
                let names = parameters.map(|p| p.name.as_str());
                PriorInformation::new(names, Some(self.covariance.as_ref()?), |_| None)
            }
        }
    }

    /// The vessel of the model, with the estimates as its nominal values.
    ///
    /// # Errors
    /// See [`Vessel::from_file`].
    pub fn vessel(&self) -> Result<Vessel, Invalid> {
        self.with(|p| Some(p.value), |d| Some(d.constant)).unwrap_or_else(|| Err(self.incomplete()))
    }

    /// `vessel`, which the model is of, limited to about the ranges of the data: inputs within their range there and
    /// within that of their actuators, motion within that of u, v, r.
    #[must_use]
    pub fn kept_to_data(&self, mut vessel: Vessel) -> Vessel {
        let range = |name: &str| {
            let covered = self.covered.iter().find(|covered| covered.name == name)?;
            let spare = SPARE * (covered.high - covered.low);
            Some([covered.low - spare, covered.high + spare])
        };
        for (variable, actuator) in vessel.model.input_variables().iter().zip(&mut vessel.actuators) {
            let stated = actuator.range.unwrap_or([f64::NEG_INFINITY, f64::INFINITY]);
            if let Some([low, high]) = range(&variable.name) {
                actuator.range =
                    Some([stated[0].max(low).min(stated[1]), stated[1].min(high).max(stated[0])]);
            }
        }
        let states = DegreeOfFreedom::ALL.map(|degree| range(degree.state()));
        vessel.motion = if let [Some(u), Some(v), Some(r)] = states { Some([u, v, r]) } else { None };
        vessel
    }

    /// The same with the least-squares values, if there are any.
    ///
    /// # Errors
    /// See [`Vessel::from_file`].
    pub fn by_least_squares(&self) -> Result<Option<Vessel>, Invalid> {
        self.with(|p| p.least_squares, |d| d.constant_least_squares).transpose()
    }

    /// RMSE of u, v, r over the fitted recordings; `None` if a simulation diverges.
    pub fn output_rmse(&self) -> Option<[f64; 3]> {
        let all: Option<Vec<f64>> = self.degrees.iter().map(|degree| degree.output_rmse).collect();
        all.and_then(|all| all.try_into().ok())
    }

    /// Covariance of its parameters: of the terms, or of all numbers of forces; `None` where no such errors hold.
    pub fn errors_of_parameters(&self) -> Option<&Covariance> {
        self.forces.as_ref().map(|forces| &forces.covariance).or(self.covariance.as_ref())
    }

    /// Half the width of a 95 % interval of a parameter, in standard errors.
    pub fn half_width(&self) -> f64 {
        self.errors_of_parameters().map_or(Z, Covariance::half_width)
    }

    fn incomplete(&self) -> Invalid {
        let given = format!("{} degrees of freedom", self.degrees.len());
        Invalid::new("data.degrees", given, "surge, sway and yaw", "estimate the model again")
    }

    fn with(
        &self,
        value: impl Fn(&ModelParameter) -> Option<f64>,
        constant: impl Fn(&ModelDegree) -> Option<f64>,
    ) -> Option<Result<Vessel, Invalid>> {
        let [surge, sway, yaw] = self.degrees.as_slice() else { return None };
        if let Some(forces) = &self.forces {
            // They have no other values.
            constant(surge)?;
            return Some(forces.file().and_then(|file| Vessel::from_file(self.channels_of(file))));
        }
        let term = |p: &ModelParameter| {
            Some(TermSpec {
                parameter: p.name.clone(),
                term: p.term.clone(),
                value: None,
                // A tied parameter follows from the other one.
                nominal: Some(value(p)?).filter(|_| p.tied_to.is_none()),
                fixed: p.fixed,
                tied_to: p.tied_to.clone(),
                factor: p.factor,
                bounds: p
                    .bounds
                    .map(|[low, high]| [low.unwrap_or(f64::NEG_INFINITY), high.unwrap_or(f64::INFINITY)]),
                ..TermSpec::default()
            })
        };
        let terms = |degree: &ModelDegree| degree.parameters.iter().map(term).collect::<Option<Vec<_>>>();
        Some(Vessel::from_file(self.channels_of(VesselFile {
            surge: terms(surge)?,
            sway: terms(sway)?,
            yaw: terms(yaw)?,
            constant: [constant(surge)?, constant(sway)?, constant(yaw)?],
            ..VesselFile::default()
        })))
    }

    /// The ship of a fit of forces as a file, with the estimates as her nominal values.
    ///
    /// # Errors
    /// A model without forces; a text that is no ship.
    pub fn forces_file(&self) -> Result<VesselFile, Invalid> {
        let Some(forces) = &self.forces else {
            let remedy = "estimate a vessel with `model = \"forces\"`";
            return Err(Invalid::new("data.forces", "none: terms per sample", "a fit of forces", remedy));
        };
        Ok(self.channels_of(forces.file()?))
    }

    /// `file` with the name, rate and channels of the model.
    fn channels_of(&self, file: VesselFile) -> VesselFile {
        VesselFile {
            name: Some(self.vessel.clone()),
            sample_rate_hz: Some(self.sample_rate_hz),
            input: self.inputs.clone(),
            measured: self.measured.clone(),
            derived: self.derived.clone(),
            fitted: true,
            ..file
        }
    }

    /// The model that was fitted to recordings: forces, and what is told of them degree by degree.
    pub fn fitted(vessel: &Vessel, delivered: &Delivered, forces: FittedForces) -> Self {
        let degree = |degree: DegreeOfFreedom| {
            let d = degree as usize;
            ModelDegree {
                name: degree.name().to_owned(),
                state: degree.state().to_owned(),
                unit: degree.unit().to_owned(),
                parameters: Vec::new(),
                constant: 0.0,
                constant_least_squares: None,
                increment_std: delivered.increment_std[d],
                output_rmse: delivered.output_rmse.map(|rmse| rmse[d]),
            }
        };
        let made = (Estimator::OutputError, MeanRemoval::None);
        Self { forces: Some(forces), ..Self::with_degrees(vessel, made, delivered, degree) }
    }
}

impl ModelDegree {
    /// With standard errors of all parameters: surge, sway, yaw.
    fn new(vessel: &Vessel, delivered: &Delivered, errors: &[Option<f64>], degree: DegreeOfFreedom) -> Self {
        let d = degree as usize;
        let first = vessel.model.layout().terms(d).start;
        let (equation, units) = (&vessel.model.degrees[d], vessel.model.parameter_units());
        let least_squares = delivered.least_squares.as_ref();
        let estimated = |place: usize| {
            let i = place - first;
            let value = delivered.theta[place];
            let at_bound = equation.at_bound(i, value);
            ModelParameter {
                name: equation.parameters[i].clone(),
                term: equation.terms[i].text.clone(),
                unit: units[place].clone(),
                value,
                standard_error: errors.get(place).copied().flatten().filter(|_| !at_bound),
                bounds: bounds(vessel, d, i),
                at_bound,
                least_squares: least_squares.map(|(theta, _)| theta[place]),
                truth: vessel.value[place],
                ..ModelParameter::default()
            }
        };
        let parameter = |written: Written| match written {
            Written::Estimated(place) => estimated(place),
            Written::Constrained(constrained) => ModelParameter {
                least_squares: least_squares.map(|(theta, _)| constrained.value(theta)),
                ..ModelParameter::constrained(vessel, constrained, &delivered.theta, |i| {
                    errors.get(i).copied().flatten()
                })
            },
        };
        Self {
            name: degree.name().to_owned(),
            state: degree.state().to_owned(),
            unit: degree.unit().to_owned(),
            parameters: vessel.written(degree).into_iter().map(parameter).collect(),
            constant: delivered.constant[d],
            constant_least_squares: least_squares.map(|(_, constant)| constant[d]),
            increment_std: delivered.increment_std[d],
            output_rmse: delivered.output_rmse.map(|rmse| rmse[d]),
        }
    }
}

/// The bounds of parameter `i` of degree of freedom `d`.
pub(super) fn bounds(vessel: &Vessel, d: usize, i: usize) -> Option<[Option<f64>; 2]> {
    let bounds = vessel.model.degrees[d].bounds.get(&i)?;
    Some(bounds.map(|end| Some(end).filter(|end| end.is_finite())))
}

impl ModelParameter {
    /// A parameter of `vessel` that was not estimated separately, given estimates `theta` of the others with their
    /// standard `errors`.
    pub(super) fn constrained(
        vessel: &Vessel,
        constrained: &Constrained,
        theta: &[f64],
        errors: impl Fn(usize) -> Option<f64>,
    ) -> Self {
        let truths: Option<Vec<f64>> = vessel.value.iter().copied().collect();
        let (fixed, tie) = match constrained.constraint {
            Constraint::Fixed(_) => (true, None),
            Constraint::Tied { to, factor } => (false, Some((to, factor))),
        };
        let name = |(to, _)| vessel.model.parameter_names().nth(to).map(str::to_owned);
        Self {
            name: constrained.name.clone(),
            term: constrained.term.text.clone(),
            unit: vessel.model.unit(constrained.degree, &constrained.term),
            value: constrained.value(theta),
            standard_error: tie.and_then(|(to, factor)| Some(factor.abs() * errors(to)?)),
            fixed,
            tied_to: tie.and_then(name),
            factor: tie.map(|(_, factor)| factor),
            truth: truths.map(|truths| constrained.value(&truths)),
            ..Self::default()
        }
    }
}

impl Document for ModelDocument {
    const ID: &'static str = "model";
    const VERSION: u32 = 2;
    const UNITS: Units = &[
        ("Hz", "sample_rate_hz"),
        (
            "1",
            "samples stretches factor part condition windows pieces prior_weight cost steps prior_share inflation weight",
        ),
        ("1", "p_value evidence share units prime_value"),
        ("the unit beside it", "visible_from"),
        ("s", "stretch_s lag_s hold_s window_s"),
        ("the channel's unit a second", "rate_per_s"),
        ("the parameter's unit", "value standard_error least_squares truth bounds prior prior_deviation"),
        ("m/s, m/s, rad/s", "left_out_rmse average_rmse"),
        ("the unit of the row's name times that of the column's", "entries"),
        ("the state's unit", "constant constant_least_squares increment_std output_rmse"),
        ("the channel's unit", "simulated range dead_band"),
        ("the unit of what it belongs to", "low high"),
        ("m/s", "constant_u constant_v"),
        ("rad/s", "constant_r"),
    ];

    fn check(&self) -> Result<(), Invalid> {
        let covered = self.covered.iter().map(|c| (format!("covered of {}", c.name), c.high - c.low));
        check_numbers(covered, "low below high", |width| width >= 0.0)?;
        let channels = self.magnitudes.iter().flat_map(|m| &m.channels);
        let widths = channels.map(|c| (format!("magnitude of {}", c.name), c.high - c.low));
        check_numbers(widths, "low below high", |width| width >= 0.0)?;
        let names = self.covariance.as_ref().map_or(0, |c| c.names.len());
        let entries = self.covariance.as_ref().map_or(0, |c| c.entries.len());
        if entries != names * names {
            let (found, expected) = (format!("{entries} entries"), format!("{names} rows and columns"));
            return Err(Invalid::new("data.covariance", found, expected, "estimate the model again"));
        }
        AverageMember::check(&self.members)?;
        self.vessel().map(|_| ())
    }
}

/// One of the models of an average.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct AverageMember {
    /// Its weight in the mean trajectory; those of all add up to 1.
    pub weight: f64,
    /// The recordings that its structure was found on.
    pub found_on: Vec<String>,
    /// The model of that structure, fitted to all recordings. It has no standard errors: the spread of the models takes their
    /// place.
    pub model: ModelDocument,
}

impl AverageMember {
    /// The members of the average of `models`, with equal weights.
    pub fn of(models: Vec<ModelDocument>) -> Vec<Self> {
        let weight = 1.0 / models.len() as f64;
        let found_on = |model: &ModelDocument| model.recordings.iter().map(|r| r.source.clone()).collect();
        models.into_iter().map(|model| Self { weight, found_on: found_on(&model), model }).collect()
    }

    /// Refuses members that do not belong together.
    ///
    /// # Errors
    /// Names the member.
    fn check(members: &[Self]) -> Result<(), Invalid> {
        let Some(first) = members.first() else { return Ok(()) };
        let expected = shared(&first.model);
        for (i, Self { model, weight, .. }) in members.iter().enumerate() {
            if (weight * members.len() as f64 - 1.0).abs() > 1e-9 {
                let thing = format!("`data.members[{i}].weight`");
                return Err(Invalid::new(thing, weight.to_string(), "equal weights", "estimate again"));
            }
            model.check().map_err(|e| Invalid { thing: format!("data.members[{i}]: {}", e.thing), ..e })?;
            let pairs = expected.iter().zip(shared(model));
            if let Some(((what, expected), (_, found))) = pairs.into_iter().find(|((_, a), (_, b))| a != b) {
                return Err(Invalid::new(
                    format!("data.members[{i}]: {what}"),
                    found,
                    format!("{expected}, as in the first model"),
                    "average models of one search",
                ));
            }
        }
        Ok(())
    }
}

/// The common properties of the models of an average.
fn shared(model: &ModelDocument) -> [(&'static str, String); 4] {
    let names = |all: Vec<&str>| all.join(", ");
    let inputs = model.inputs.iter().map(|input| input.name.as_str());
    let channels = inputs.chain(model.measured.iter().map(|channel| channel.name.as_str())).collect();
    let recordings = model.recordings.iter().map(|recording| recording.source.as_str()).collect();
    [
        ("vessel", model.vessel.clone()),
        ("sampling rate", format!("{} Hz", model.sample_rate_hz)),
        ("channels", names(channels)),
        ("recordings", names(recordings)),
    ]
}
