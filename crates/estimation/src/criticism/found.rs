use regression::pooled::Whiteness;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::DegreeOfFreedom;

use super::feedback::Feedback;
use super::noise::{Noise, NoiseKind};

/// What becomes of a model that runs are asked about.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing is missing beyond chance, which is no proof of the model.
    NotRejected,
    /// Something is missing beyond chance.
    Rejected,
    /// The errors follow no noise known here, so that nothing can be said.
    None,
}

/// Noise that was found by its likelihood.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundNoise {
    /// What there is besides white noise of the sensors.
    pub kind: NoiseKind,
    /// Forces or errors of sensors that drift.
    pub drifts: Vec<FoundDrift>,
    /// The other kinds, the likeliest first.
    pub others: Vec<OtherNoise>,
    /// How often noise and parameters were found in turns.
    pub turns: u64,
    /// Whether the parameters came to rest.
    pub at_rest: bool,
}

/// A force or an error of a sensor that drifts, as a Gauss–Markov process.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FoundDrift {
    /// `force` for what is added to the state in a sample, `sensor` for what is added to its measurement.
    pub of: String,
    /// The state: `u`, `v` or `r`.
    pub state: String,
    /// Its standard deviation.
    pub std: f64,
    /// The unit of that.
    pub unit: String,
    /// Over which time it drifts, 100,000 where it stays.
    pub time_s: f64,
}

/// A kind of noise that is less likely.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct OtherNoise {
    /// The kind.
    pub kind: NoiseKind,
    /// By how much its twice restricted log-likelihood, less 2 for every level, is below that of the kind that was taken.
    pub below: f64,
}

impl From<&Noise> for FoundNoise {
    fn from(found: &Noise) -> Self {
        let (guess, best) = (&found.guess, found.kinds.first().map_or(0.0, |(_, likelihood)| *likelihood));
        let of = |of: &str, std: [f64; 3], times: [f64; 3]| {
            let each = DegreeOfFreedom::ALL.map(|d| FoundDrift {
                of: of.to_owned(),
                state: d.state().to_owned(),
                std: std[d as usize],
                unit: d.unit().to_owned(),
                time_s: times[d as usize],
            });
            each.to_vec()
        };
        let forces = guess.forces().map(|(std, times)| of("force", std, times));
        let sensors = guess.sensors().map(|(std, time)| of("sensor", std, [time; 3]));
        let others = found.kinds.iter().filter(|(own, _)| own.kind != guess.kind);
        Self {
            kind: guess.kind,
            drifts: forces.or(sensors).unwrap_or_default(),
            others: others
                .map(|(own, likelihood)| OtherNoise { kind: own.kind, below: best - likelihood })
                .collect(),
            turns: found.turns as u64,
            at_rest: found.at_rest,
        }
    }
}

/// What the runs say about the structure of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Criticism {
    /// Whether something is missing beyond chance.
    pub rejected: bool,
    /// What becomes of the model.
    pub verdict: Verdict,
    /// How probable it is under the model that anything looked for seems as likely to be missing; null where nothing could be
    /// looked for.
    pub p_value: Option<f64>,
    /// Whether the noise was stated; else it was found by its likelihood.
    pub stated_noise: bool,
    /// Noise of the measured u.
    pub noise_u: f64,
    /// Of v.
    pub noise_v: f64,
    /// Of r.
    pub noise_r: f64,
    /// Standard deviation of each component of the current.
    pub current_std: f64,
    /// Over which the current changes, 100,000 where it stays; null for one that is new at every sample.
    pub current_time_s: Option<f64>,
    /// Of what kind the noise is; absent where it was stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<FoundNoise>,
    /// Errors over the noise: 1 where the noise explains them.
    pub error_ratio: f64,
    /// Whether the whitened errors of u, v, r are white.
    pub whiteness: Vec<Whiteness>,
    /// Recordings that contradict the others, the farthest first, up to half of them.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub apart: Vec<Apart>,
    /// An input that answers what was measured at the same sample; absent where none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<Feedback>,
    /// The period of waves that move the ship \[s\], where errors follow no noise known here and oscillate.
    #[serde(skip)]
    pub waves_s: Option<f64>,
    /// What was looked for, the most likely first.
    pub absent: Vec<Absent>,
    /// What could not be told from the terms that there are.
    pub hidden: Vec<String>,
    /// The verdict and what follows, in words.
    pub statements: Vec<String>,
}

/// A recording whose own parameters are not those of the others.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Apart {
    /// Its name.
    pub recording: String,
    /// How probable it is, if all are of one ship, that any of them differs as much.
    pub p_value: f64,
}

/// Something that the model lacks.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Absent {
    /// A term, `lag of the inputs`, `delay of the inputs` or `current`.
    pub name: String,
    /// `surge`, `sway` or `yaw`; null for what acts in all.
    pub degree: Option<String>,
    /// Unit of the values.
    pub unit: String,
    /// What it would be if it were added: one value, north and east of a current.
    pub value: Vec<f64>,
    /// Standard error of each.
    pub standard_error: Vec<f64>,
    /// The least that these runs would nearly always have shown.
    pub visible_from: f64,
    /// How probable it is under the model that anything that was looked for seems as likely.
    pub p_value: f64,
    /// −2 log of the probability of it alone, by which candidates are ranked.
    pub evidence: f64,
    /// Whether it may be what is missing: no other is likelier by far.
    pub candidate: bool,
}

impl Criticism {
    /// Whether all reported numbers are finite: squared errors of a model that nearly diverges may overflow.
    pub(super) fn is_finite(&self) -> bool {
        let noise = [self.noise_u, self.noise_v, self.noise_r, self.current_std, self.error_ratio];
        let absent = |a: &Absent| {
            let [values, errors] = [&a.value, &a.standard_error].map(|all| all.iter().all(|x| x.is_finite()));
            values && errors && [a.visible_from, a.p_value, a.evidence].iter().all(|x| x.is_finite())
        };
        let white = self.whiteness.iter().flat_map(|w| [w.statistic, w.p_value, w.first_autocorrelation]);
        let optional = [self.p_value, self.current_time_s].into_iter().flatten();
        let found = self.noise.iter().flat_map(|noise| {
            let drifts = noise.drifts.iter().flat_map(|drift| [drift.std, drift.time_s]);
            drifts.chain(noise.others.iter().map(|own| own.below))
        });
        noise.into_iter().chain(found).chain(white).chain(optional).all(f64::is_finite)
            && self.absent.iter().all(absent)
            && self.apart.iter().all(|own| own.p_value.is_finite())
    }
}

impl Absent {
    /// `r |r|` in yaw.
    pub fn label(&self) -> String {
        called(&self.name, self.degree.as_deref())
    }
}

/// The name of an effect in one degree of freedom, or in all.
pub(super) fn called(name: &str, degree: Option<&str>) -> String {
    degree.map_or(name.to_owned(), |degree| format!("`{name}` in {degree}"))
}
