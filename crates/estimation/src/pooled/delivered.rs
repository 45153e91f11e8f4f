use std::collections::HashMap;
use std::f64::consts::TAU;

use numerics::statistics::Z;
use numerics::statistics::student_half_width;
use numerics::symmetric;
use regression::pooled::{AnyParts, Part, PartView, Regression, Unread};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{RunView, Streams};
use ship::model::{DegreeOfFreedom, Model, Variable, Vessel};

use super::{DegreeTrust, Estimated, ParameterTrust, Pool, Score, Searched, SourceErrors};

/// The model that an estimate delivers, whole: with it others simulate what was validated.
#[derive(Clone, Debug, PartialEq)]
pub struct Delivered {
    /// θ̂: surge, sway, yaw.
    pub theta: Vec<f64>,
    /// What u, v \[m/s\], r \[rad/s\] gain in any sample: the intercepts, and the constant that was known before.
    pub constant: [f64; 3],
    /// Covariance of the estimates; none where a degree of freedom has no standard errors.
    pub covariance: Option<Covariance>,
    /// θ̂ and constant by least squares of the same data, to be compared with.
    pub least_squares: Option<(Vec<f64>, [f64; 3])>,
    /// Standard deviation of what the terms leave of the increments: u, v \[m/s\], r \[rad/s\] per sample.
    pub increment_std: [f64; 3],
    /// RMSE of free simulations over the recordings that were fitted; none where one diverges.
    pub output_rmse: Option<[f64; 3]>,
    /// One entry per run or recording.
    pub recordings: Vec<RecordingConstant>,
    /// The current that was found with it, part by part; empty where none is unknown.
    pub surroundings: Vec<Surroundings>,
    /// What the data covered: states, inputs, measured disturbances.
    pub covered: Vec<Covered>,
}

/// Covariance of estimates.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Covariance {
    /// Whether those of different degrees of freedom were estimated together; else the entries between them are 0.
    pub joint: bool,
    /// Names of the parameters; `surge constant` and the like where the constants are among them.
    pub names: Vec<String>,
    /// As many rows as names, row-major.
    pub entries: Vec<f64>,
    /// Sub-experiments or pieces of recordings whose differences the errors come from; absent where they do not.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub parts: Option<u64>,
}

impl Covariance {
    /// That of what the priors of a model's parameters know, each by itself; `None` without any.
    pub fn of_priors(model: &Model) -> Option<Self> {
        let known = model.parameter_names().zip(model.prior_deviations());
        let known: Vec<(&str, f64)> = known.filter_map(|(name, prior)| Some((name, prior?))).collect();
        let n = known.len();
        let mut entries = vec![0.0; n * n];
        known.iter().enumerate().for_each(|(i, (_, deviation))| entries[i * (n + 1)] = deviation * deviation);
        let names = known.iter().map(|(name, _)| (*name).to_owned()).collect();
        (n > 0).then_some(Self { joint: true, names, entries, parts: None })
    }
}

/// What the increments of one recording gain on the terms: a steady force, current or sensor error of that day.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct RecordingConstant {
    /// Its name.
    pub source: String,
    /// Regression pairs.
    pub samples: u64,
    /// Mean of Δu − φᵀθ̂ per sample.
    pub constant_u: f64,
    /// Of sway speed.
    pub constant_v: f64,
    /// Of yaw rate.
    pub constant_r: f64,
}

/// The range of a channel in the data.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Covered {
    /// Its name.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// Least value.
    pub low: f64,
    /// Largest value.
    pub high: f64,
}

impl Covered {
    /// Whether `value` lies in the range; that of an angle is an arc.
    pub fn contains(&self, value: f64) -> bool {
        let turned = match self.unit == "rad" && value.is_finite() {
            true => self.low + (value - self.low).rem_euclid(TAU),
            false => value,
        };
        // Rounding may turn the lower end once around.
        (self.low..=self.high).contains(&value) || (self.low..=self.high).contains(&turned)
    }
}

impl Delivered {
    /// The model of `estimated`, which was fitted to `parts`; `None` unless all degrees of freedom have an estimate.
    pub(super) fn new(
        pool: &Pool,
        estimated: &Estimated,
        parts: &AnyParts,
        degrees: &[DegreeTrust],
        sources: &[SourceErrors],
    ) -> Result<Option<Self>, Unread> {
        let Some((theta, intercepts)) = estimated.theta() else { return Ok(None) };
        let mut account = Account::new(&pool.vessel.model, &theta, intercepts);
        parts.each(&mut |part| account.add(&part))?;
        let (searched, data) = (estimated.searched.as_ref(), pool.least_squares(estimated));
        let surroundings = searched.map(|(searched, _)| Surroundings::all(parts, searched)).transpose()?;
        let covariance = covariance(&pool.model, estimated, degrees, parts.count());
        let surroundings = surroundings.unwrap_or_default();
        let delivered = account.delivered(data, pooled_rmse(sources));
        Ok(Some(Self { covariance, surroundings, ..delivered }))
    }

    /// The model from an estimate of one run, θ̂ and intercepts; single runs only have standard errors.
    pub(crate) fn of_run(
        model: &Model,
        part: &PartView,
        (theta, intercepts): (Vec<f64>, [f64; 3]),
        least_squares: Option<(Vec<f64>, [f64; 3])>,
        surroundings: Option<Surroundings>,
    ) -> Self {
        let mut account = Account::new(model, &theta, intercepts);
        account.add(part);
        let lifted = model.with_intercepts();
        let parameters = lifted.layout().woven(&theta, intercepts);
        let rmse = Score::of(&lifted, &parameters, [part.run].into_iter()).rmse();
        let surroundings = surroundings.into_iter().collect();
        Self { surroundings, ..account.delivered(least_squares, rmse) }
    }
}

pub(super) fn beyond(model: &Model, intercepts: [f64; 3]) -> [f64; 3] {
    [0, 1, 2].map(|d| model.constant[d] + intercepts[d])
}

struct Account<'a> {
    model: &'a Model,
    theta: &'a [f64],
    intercepts: [f64; 3],
    /// Of Δy − φᵀθ̂ − c.
    squares: [f64; 3],
    samples: f64,
    ranges: Ranges<'a>,
    places: HashMap<String, usize>,
    /// Sums of Δy − φᵀθ̂ by recording.
    recordings: Vec<RecordingConstant>,
}

impl<'a> Account<'a> {
    fn new(model: &'a Model, theta: &'a [f64], intercepts: [f64; 3]) -> Self {
        Self {
            model,
            theta,
            intercepts,
            squares: [0.0; 3],
            samples: 0.0,
            ranges: Ranges::new(model),
            places: HashMap::new(),
            recordings: Vec::new(),
        }
    }

    fn add(&mut self, part: &PartView) {
        let (regression, layout) = (Regression::of(self.model, part), self.model.layout());
        let mut left = [0.0; 3];
        for (d, degree) in regression.degrees.iter().enumerate() {
            for error in degree.residuals(&self.theta[layout.terms(d)]) {
                left[d] += error;
                self.squares[d] += (error - self.intercepts[d]).powi(2);
            }
        }
        self.samples += regression.samples as f64;
        let place = self.places.get(part.source).copied().unwrap_or(self.recordings.len());
        if place == self.recordings.len() {
            self.places.insert(part.source.to_owned(), place);
            let source = part.source.to_owned();
            self.recordings.push(RecordingConstant { source, ..RecordingConstant::default() });
        }
        let recording = &mut self.recordings[place];
        recording.samples += regression.samples as u64;
        recording.constant_u += left[0];
        recording.constant_v += left[1];
        recording.constant_r += left[2];
        self.ranges.add(&part.run);
    }

    /// The model with what its data tell, and the estimate by least squares.
    fn delivered(self, simple: Option<(Vec<f64>, [f64; 3])>, rmse: Option<[f64; 3]>) -> Delivered {
        let model = self.model;
        Delivered {
            theta: self.theta.to_vec(),
            constant: beyond(model, self.intercepts),
            covariance: None,
            least_squares: simple.map(|(theta, intercepts)| (theta, beyond(model, intercepts))),
            increment_std: self.squares.map(|sum| (sum / f64::max(self.samples, 1.0)).sqrt()),
            output_rmse: rmse,
            surroundings: Vec::new(),
            covered: self.ranges.covered(),
            recordings: self.recordings(),
        }
    }

    fn recordings(mut self) -> Vec<RecordingConstant> {
        for recording in &mut self.recordings {
            let samples = recording.samples.max(1) as f64;
            let all = [&mut recording.constant_u, &mut recording.constant_v, &mut recording.constant_r];
            all.into_iter().zip(self.model.constant).for_each(|(sum, known)| *sum = *sum / samples + known);
        }
        self.recordings
    }
}

pub(super) struct Ranges<'a> {
    model: &'a Model,
    ends: Vec<[f64; 2]>,
}

impl<'a> Ranges<'a> {
    pub fn new(model: &'a Model) -> Self {
        Self { model, ends: vec![[f64::INFINITY, f64::NEG_INFINITY]; model.variables.len()] }
    }

    pub fn add(&mut self, run: &RunView) {
        let mut cover = |variable: usize, value: f64| {
            let [low, high] = &mut self.ends[variable];
            (*low, *high) = (low.min(value), high.max(value));
        };
        let rows = run.measured.as_chunks::<3>().0;
        rows.iter().for_each(|row| row.iter().enumerate().for_each(|(d, value)| cover(d, *value)));
        for row in run.exogenous.chunks_exact(self.model.exogenous().max(1)) {
            row.iter().enumerate().for_each(|(i, value)| cover(3 + i, *value));
        }
    }

    pub fn covered(&self) -> Vec<Covered> {
        let range = |(variable, [low, high]): (&Variable, &[f64; 2])| Covered {
            name: variable.name.clone(),
            unit: variable.unit.clone(),
            low: *low,
            high: *high,
        };
        self.model.variables.iter().zip(&self.ends).map(range).collect()
    }
}

impl Covariance {
    /// Half the width of a 95 % interval, in standard errors: by Student's t where few parts are compared.
    pub fn half_width(&self) -> f64 {
        self.parts.map_or(Z, |parts| student_half_width(parts as f64 - 1.0))
    }

    /// The standard error of the parameter `name`; `None` if it is not among them.
    pub fn standard_error(&self, name: &str) -> Option<f64> {
        let place = self.names.iter().position(|other| other == name)?;
        Some(self.entries[place * (self.names.len() + 1)].max(0.0).sqrt())
    }

    /// The joint covariance of all unknowns of `model`, which has intercepts.
    pub(crate) fn joint(model: &Model, entries: Vec<f64>, parts: usize) -> Self {
        let name = |(d, name): (usize, &str)| match name {
            "intercept" => format!("{} constant", DegreeOfFreedom::ALL[d].name()),
            name => name.to_owned(),
        };
        let names = model.layout().degrees().zip(model.parameter_names()).map(name).collect();
        Self { joint: true, names, entries, parts: Some(parts as u64) }
    }
}

/// A search has a joint covariance of all unknowns; else each degree of freedom has its own.
fn covariance(model: &Model, of: &Estimated, degrees: &[DegreeTrust], parts: usize) -> Option<Covariance> {
    let searched = of.searched.as_ref().filter(|_| of.used.iter().all(|used| used.searches()));
    if let Some((whole, _)) = searched {
        return (parts > 1).then(|| Covariance::joint(model, whole.covariance.clone(), parts));
    }
    covariance_of(degrees)
}

pub(super) fn covariance_of(degrees: &[DegreeTrust]) -> Option<Covariance> {
    let of = |degree: &DegreeTrust| -> Option<Vec<f64>> {
        degree.parameters.iter().map(ParameterTrust::spread).collect()
    };
    let errors: Vec<Vec<f64>> = degrees.iter().map(of).collect::<Option<_>>()?;
    let (all, mut first) = (errors.iter().map(Vec::len).sum::<usize>(), 0);
    let mut entries = vec![0.0; all * all];
    for (degree, errors) in degrees.iter().zip(&errors) {
        let (correlation, p) = (degree.correlation.as_ref()?, errors.len());
        for (k, entry) in correlation.iter().enumerate() {
            entries[(first + k / p) * all + first + k % p] = entry * errors[k / p] * errors[k % p];
        }
        first += p;
    }
    let names = degrees.iter().flat_map(|d| &d.parameters).map(|p| p.name.clone()).collect();
    Some(Covariance { joint: false, names, entries, parts: None })
}

fn pooled_rmse(sources: &[SourceErrors]) -> Option<[f64; 3]> {
    let (mut squares, mut samples) = ([0.0; 3], 0.0);
    for source in sources.iter().filter(|source| source.samples > 0) {
        let (errors, n) = (source.errors?, source.samples as f64);
        let rmse = [errors.rmse_u, errors.rmse_v, errors.rmse_r];
        squares.iter_mut().zip(rmse).for_each(|(sum, rmse)| *sum += n * rmse * rmse);
        samples += n;
    }
    (samples > 0.0).then(|| squares.map(|sum| (sum / samples).sqrt()))
}

/// The ranges of the variables of `model` in `parts`, in their order and units.
pub fn covered(model: &Model, parts: &[Part]) -> Vec<Covered> {
    let mut ranges = Ranges::new(model);
    parts.iter().for_each(|part| ranges.add(&part.view()));
    ranges.covered()
}

/// A current over ground that was found with a model in one run, or in a part of one.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Surroundings {
    /// The run or recording.
    pub source: String,
    /// Which of the parts that simulations start anew with, from 0.
    pub part: u64,
    /// What was found, along and across the vessel as she heads where the part starts.
    pub found: Vec<FoundUnknown>,
}

/// An unknown beside the parameters.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundUnknown {
    /// What it is: `current along` and the like.
    pub name: String,
    /// Its unit.
    pub unit: String,
    /// The estimate.
    pub value: f64,
    /// Its standard error; null where it has none, as where it makes no difference.
    pub standard_error: Option<f64>,
}

impl Surroundings {
    /// The current in part `part` of `source`: values and standard errors.
    pub(crate) fn of((source, part): (&str, usize), [values, errors]: [[f64; 2]; 2]) -> Self {
        let unknown = |(i, name): (usize, &str)| FoundUnknown {
            name: name.to_owned(),
            unit: "m/s".to_owned(),
            value: values[i],
            standard_error: Some(errors[i]).filter(|error| *error > 0.0),
        };
        let unknowns = ["current along", "current across"].into_iter().enumerate().map(unknown).collect();
        Self { source: source.to_owned(), part: part as u64, found: unknowns }
    }

    pub(super) fn all(parts: &AnyParts, searched: &Searched) -> Result<Vec<Self>, Unread> {
        let mut all = Vec::new();
        if !searched.currents.is_empty() {
            parts.each(&mut |part| {
                all.push(Self::of((part.source, all.len()), searched.currents[all.len()]))
            })?;
        }
        Ok(all)
    }
}

/// Parameters and what an estimate leaves uncertain of them.
pub struct Uncertain {
    parameters: Vec<f64>,
    /// Place of each uncertain parameter.
    places: Vec<usize>,
    /// A root of their covariance, n × n, row-major.
    root: Vec<f64>,
    /// Ends of what each may be.
    ends: Vec<[f64; 2]>,
}

impl Uncertain {
    /// Of `vessel` with `parameters`; what the covariance says of constants is left out. `None` where it is no covariance.
    pub fn new(vessel: &Vessel, parameters: Vec<f64>, covariance: &Covariance) -> Option<Self> {
        let names: Vec<&str> = vessel.model.parameter_names().collect();
        let place = |name: &String| names.iter().position(|other| other == name);
        let known: Vec<(usize, usize)> =
            covariance.names.iter().enumerate().filter_map(|(row, name)| Some((row, place(name)?))).collect();
        let (n, width) = (known.len(), covariance.names.len());
        let entry = |k: usize| covariance.entries[known[k / n].0 * width + known[k % n].0];
        let part: Vec<f64> = (0..n * n).map(entry).collect();
        let (values, vectors) = symmetric(n, &part)?;
        let root = (0..n * n).map(|k| vectors[k] * values[k % n].max(0.0).sqrt()).collect();
        let places: Vec<usize> = known.into_iter().map(|(_, place)| place).collect();
        let ends = places.iter().map(|place| ends(vessel, *place)).collect();
        Some(Self { parameters, places, root, ends })
    }

    /// Parameters of draw `draw`; numbers of forces stay within their bounds, as estimates do.
    pub fn drawn(&self, streams: &Streams, draw: u32) -> Vec<f64> {
        let n = self.places.len();
        let mut normals = vec![0.0; n];
        streams.normals(draw, 0, &mut normals);
        let mut parameters = self.parameters.clone();
        for ((row, place), [low, high]) in self.root.chunks_exact(n.max(1)).zip(&self.places).zip(&self.ends)
        {
            let off = row.iter().zip(&normals).map(|(a, z)| a * z).sum::<f64>();
            parameters[*place] = (parameters[*place] + off).clamp(*low, *high);
        }
        parameters
    }
}

fn ends(vessel: &Vessel, place: usize) -> [f64; 2] {
    let open = [f64::NEG_INFINITY, f64::INFINITY];
    vessel.model.forces.as_ref().map_or(open, |force_model| force_model.forces.parameters()[place].bounds)
}
