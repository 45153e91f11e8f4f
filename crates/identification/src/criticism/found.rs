use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::feedback::Feedback;
use crate::pooled::Whiteness;

/// What the runs say about the structure of a model.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Criticism {
    /// Whether something is missing beyond chance.
    pub rejected: bool,
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
    /// Errors over the noise: 1 where the noise explains them.
    pub error_ratio: f64,
    /// Whether the whitened errors of u, v, r are white.
    pub whiteness: Vec<Whiteness>,
    /// An input that answers what was measured at the same sample; absent where none does.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub feedback: Option<Feedback>,
    /// What was looked for, the most likely first.
    pub absent: Vec<Absent>,
    /// What could not be told from the terms that there are.
    pub hidden: Vec<String>,
    /// The verdict and what follows, in words.
    pub statements: Vec<String>,
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
    /// Whether all that is told are numbers: errors of a model that all but diverges have squares that are none.
    pub(super) fn is_finite(&self) -> bool {
        let noise = [self.noise_u, self.noise_v, self.noise_r, self.current_std, self.error_ratio];
        let absent = |a: &Absent| {
            let [values, errors] = [&a.value, &a.standard_error].map(|all| all.iter().all(|x| x.is_finite()));
            values && errors && [a.visible_from, a.p_value, a.evidence].iter().all(|x| x.is_finite())
        };
        let white = self.whiteness.iter().flat_map(|w| [w.statistic, w.p_value, w.first_autocorrelation]);
        let optional = [self.p_value, self.current_time_s].into_iter().flatten();
        noise.into_iter().chain(white).chain(optional).all(f64::is_finite) && self.absent.iter().all(absent)
    }
}

impl Absent {
    /// `r |r|` in yaw.
    pub fn told(&self) -> String {
        called(&self.name, self.degree.as_deref())
    }
}

/// What something is called that acts in one degree of freedom, or in all.
pub(super) fn called(name: &str, degree: Option<&str>) -> String {
    degree.map_or(name.to_owned(), |degree| format!("`{name}` in {degree}"))
}
