use refusal::listed;
use regression::pooled::Whiteness;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::DegreeOfFreedom;

use super::noise::{LASTING, Noise, NoiseKind};

/// What becomes of a model that runs are asked about.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Verdict {
    /// Nothing is missing beyond chance, which is no proof of the model.
    #[default]
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
    fn from(noise: &Noise) -> Self {
        let (guess, best) = (&noise.guess, noise.kinds.first().map_or(0.0, |(_, likelihood)| *likelihood));
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
        let others = noise.kinds.iter().filter(|(other, _)| other.kind != guess.kind);
        Self {
            kind: guess.kind,
            drifts: forces.or(sensors).unwrap_or_default(),
            others: others
                .map(|(guess, likelihood)| OtherNoise { kind: guess.kind, below: best - likelihood })
                .collect(),
            turns: noise.turns as u64,
            at_rest: noise.at_rest,
        }
    }
}

/// What the runs say about the structure of a model: one of terms, whose errors are whitened, or one of forces.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Criticism {
    /// Whether something is missing beyond chance.
    pub rejected: bool,
    /// What becomes of the model.
    pub verdict: Verdict,
    /// How probable it is under the model that anything looked for seems as likely to be missing; null where nothing could be
    /// looked for, and of forces where a sign is wrong.
    pub p_value: Option<f64>,
    /// Whether the noise was stated; else it was found by its likelihood.
    pub stated_noise: bool,
    /// Noise of the measured u; absent where errors were not whitened, as for forces.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_u: Option<f64>,
    /// Of v.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_v: Option<f64>,
    /// Of r.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise_r: Option<f64>,
    /// Standard deviation of each component of the current.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub current_std: Option<f64>,
    /// Over which the current changes, 100,000 where it stays; null for one that is new at every sample.
    pub current_time_s: Option<f64>,
    /// Of what kind the noise is; absent where it was stated.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub noise: Option<FoundNoise>,
    /// Errors over the noise: 1 where the noise explains them.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub error_ratio: Option<f64>,
    /// Windows or pieces of them that count as independent; absent where errors were whitened.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub units: Option<u64>,
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
    /// What was looked for: wrong signs, then the most likely first.
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

/// What a candidate is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "kebab-case")]
pub enum Suspect {
    /// A term: a product, or a logged channel by itself.
    #[default]
    Term,
    /// An input that acts later than the model has it.
    Late,
    /// A current.
    Current,
    /// A channel or a part of the ship with the opposite sign, or two that are exchanged.
    Sign,
}

/// Something that the model lacks or has wrong.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Absent {
    /// What it is; a term where this is absent.
    #[serde(default)]
    pub kind: Suspect,
    /// A term, `lag of the inputs`, `delay of the inputs`, an input that acts late, `current`, or a sign in words.
    pub name: String,
    /// `surge`, `sway` or `yaw`; null for what acts in all.
    pub degree: Option<String>,
    /// Unit of the values.
    pub unit: String,
    /// What it would be if it were added: one value, north and east of a current, seconds; of a sign how many times as the nominal
    /// values say the channel acts, and nothing where the ship was fitted again.
    pub value: Vec<f64>,
    /// Standard error of each.
    pub standard_error: Vec<f64>,
    /// The value in the prime system, where it has one.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub prime_value: Option<f64>,
    /// By which share the cost of a fit of forces would fall; below 0 where it rises.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// The least that these runs would nearly always have shown; null of a sign.
    pub visible_from: Option<f64>,
    /// How probable it is under the model that anything that was looked for seems as likely.
    pub p_value: f64,
    /// −2 log of the probability of it alone.
    pub evidence: f64,
    /// Whether it may be what is missing: no other is likelier by far. Whether a sign is wrong.
    pub candidate: bool,
    /// What to do if it is so.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub remedy: Option<String>,
}

impl Criticism {
    /// The signs that are wrong.
    pub fn wrong_signs(&self) -> impl Iterator<Item = &Absent> {
        self.absent.iter().filter(|absent| absent.kind == Suspect::Sign && absent.candidate)
    }

    /// Whether all reported numbers are finite: squared errors of a model that nearly diverges may overflow.
    pub(super) fn is_finite(&self) -> bool {
        let noise = [self.noise_u, self.noise_v, self.noise_r, self.current_std, self.error_ratio];
        let absent = |a: &Absent| {
            let [values, errors] = [&a.value, &a.standard_error].map(|all| all.iter().all(|x| x.is_finite()));
            let numbers = [a.p_value, a.evidence].into_iter().chain(a.visible_from);
            values && errors && numbers.into_iter().all(f64::is_finite)
        };
        let white = self.whiteness.iter().flat_map(|w| [w.statistic, w.p_value, w.first_autocorrelation]);
        let optional = noise.into_iter().chain([self.p_value, self.current_time_s]).flatten();
        let noises = self.noise.iter().flat_map(|noise| {
            let drifts = noise.drifts.iter().flat_map(|drift| [drift.std, drift.time_s]);
            drifts.chain(noise.others.iter().map(|other| other.below))
        });
        optional.chain(noises).chain(white).all(f64::is_finite)
            && self.absent.iter().all(absent)
            && self.apart.iter().all(|apart| apart.p_value.is_finite())
    }
}

/// Size in standard errors at which a trial nearly always detects an absent term.
const SEEN: f64 = 3.9;

impl Absent {
    /// A candidate with these values, their standard errors, and the logarithm of the probability of it alone.
    pub(crate) fn scored(values: Vec<f64>, errors: Vec<f64>, log_p: f64, p_value: f64) -> Self {
        Self {
            visible_from: Some(SEEN * errors.iter().copied().fold(0.0, f64::max)),
            value: values,
            standard_error: errors,
            evidence: -2.0 * log_p,
            p_value,
            ..Self::default()
        }
    }

    /// `r |r|` in yaw.
    pub fn label(&self) -> String {
        match (self.kind, self.share) {
            (Suspect::Late, Some(_)) => format!("a late `{}`", self.name),
            _ => called(&self.name, self.degree.as_deref()),
        }
    }

    /// What is wrong, by how much, and the remedy.
    pub(crate) fn sentence(&self) -> String {
        let cost = self.share.map_or(String::new(), |share| format!(" (cost {})", change(share)));
        let what = match (self.kind, self.share) {
            (Suspect::Sign, Some(_)) => format!("{}{cost}", self.name),
            (Suspect::Sign, None) => format!("{}: {}", self.name, values(self)),
            (Suspect::Late, Some(_)) => {
                let seconds = self.value.first().copied().unwrap_or_default();
                let than =
                    if seconds < 0.0 { "earlier than it is logged" } else { "later than the model has it" };
                format!("`{}` acts {} s {than}{cost}", self.name, number(seconds.abs()))
            }
            _ => {
                let per_value = self.value.first().zip(self.prime_value).map(|(value, prime)| prime / value);
                let prime = per_value.filter(|_| self.value[0] != 0.0).map_or(String::new(), |one| {
                    let [value, error] =
                        [self.value[0], self.standard_error[0]].map(|x| number(x * one.abs()));
                    format!(", {value} ± {error} in the prime system")
                });
                format!("most likely missing: {}, {} if added{prime}{cost}", self.label(), values(self))
            }
        };
        self.remedy.as_ref().map_or(what.clone(), |remedy| format!("{what}; remedy: {remedy}"))
    }
}

/// A share of the cost as its change: −7.9 %.
pub(crate) fn change(share: f64) -> String {
    format!("−{:.1} %", 100.0 * share.min(1.0))
}

fn probability(p: f64) -> String {
    if p < 1e-4 { "p < 0.0001".to_owned() } else { format!("p {p:.4}") }
}

pub(super) fn called(name: &str, degree: Option<&str>) -> String {
    degree.map_or(name.to_owned(), |degree| format!("`{name}` in {degree}"))
}

/// Terms whose detection limit is reported if nothing is missing.
const REPORTED: [(&str, Option<&str>); 5] = [
    ("v |v|", Some("sway")),
    ("r |r|", Some("yaw")),
    ("lag of the inputs", None),
    ("delay of the inputs", None),
    ("current", None),
];
/// Currents that change this slowly \[s\] and are this large relative to the noise of u and v bias estimates.
const SLOW: f64 = 2.0;
const FELT: f64 = 0.5;
/// Errors that differ from the stated noise by more than this share are reported.
const OFF: f64 = 0.05;
const NAMED: usize = 4;

/// The verdict, what is wrong, what it cannot be distinguished from, what the runs would have shown.
/// `under_white`: whether the model is rejected under white noise, which is not the likeliest.
pub(crate) fn statements(criticism: &Criticism, under_white: bool) -> Vec<String> {
    let mut out: Vec<String> = contradictions(&criticism.apart).into_iter().collect();
    let rejected = criticism.verdict == Verdict::Rejected;
    let said = |p: f64, under: &str, absent: &Absent| match rejected {
        true => format!("model rejected ({}{under}): {}", probability(p), absent.sentence()),
        false => absent.sentence(),
    };
    out.extend(criticism.wrong_signs().map(|sign| said(sign.p_value, "", sign)));
    let Some(p) = criticism.p_value else {
        if out.is_empty() {
            out.push("structure: the runs tell of nothing that the model lacks".to_owned());
        }
        return out;
    };
    let mut others = criticism.absent.iter().filter(|absent| absent.kind != Suspect::Sign);
    match (criticism.verdict, others.next()) {
        (Verdict::Rejected, Some(first)) if p < LEVEL => {
            out.push(said(p, if under_white { ", under white noise" } else { "" }, first));
            let (alike, further): (Vec<&Absent>, Vec<&Absent>) = others.partition(|a| a.candidate);
            if !alike.is_empty() {
                let alike: Vec<String> = alike.into_iter().map(Absent::label).collect();
                out.push(format!("cannot be told from: {}", listed(&alike)));
            }
            let late = |a: &&Absent| a.kind == Suspect::Late && a.share.is_some() && a.p_value < LEVEL;
            out.extend(further.into_iter().filter(late).map(Absent::sentence));
        }
        (Verdict::None, _) => out.push(match criticism.waves_s {
            Some(period) => format!(
                "no verdict on the model: its errors oscillate with a period of about {period:.1} s, as where waves move the ship, \
                 so that tests and standard errors do not hold"
            ),
            None => "no verdict on the model: these errors follow no noise known here, so that tests and standard errors do not hold"
                .to_owned(),
        }),
        (Verdict::Rejected, _) => {}
        _ => out.push(format!("model not rejected (p {p:.2}), which is no proof of it")),
    }
    let detectable = |(name, degree): &(&str, Option<&str>)| {
        let is = |a: &&Absent| a.name == *name && a.degree.as_deref() == *degree;
        let absent = criticism.absent.iter().find(is)?;
        Some(format!("{} from {} {}", absent.label(), number(absent.visible_from?), absent.unit))
    };
    let visible: Vec<String> = REPORTED.iter().filter_map(detectable).collect();
    if !visible.is_empty() {
        out.push(format!("these runs would have shown {}", listed(&visible)));
    }
    out.extend(criticism.noise.as_ref().map(|noise| noise_found(criticism, noise)));
    if let Some(f) = &criticism.feedback {
        out.push(format!(
            "`{}` answers the measured {} within the sample (correlation {:.2}), as under an autopilot that steers by the sensor \
             that is logged: `ls` and `iv` are then biased; use `output-error`, or steer by another sensor",
            f.input, f.state, f.correlation
        ));
    }
    if let Some(ratio) =
        criticism.error_ratio.filter(|ratio| criticism.stated_noise && (ratio - 1.0).abs() > OFF)
    {
        out.push(format!("errors are {ratio:.2} times the stated noise"));
    }
    out
}

fn contradictions(apart: &[Apart]) -> Option<String> {
    let first = apart.first()?;
    let p = probability(first.p_value);
    let named: Vec<String> = apart.iter().take(NAMED).map(|one| format!("`{}`", one.recording)).collect();
    let more = match apart.len() - named.len() {
        0 => String::new(),
        more => format!(" and {more} more"),
    };
    let (s, contradict) = if apart.len() == 1 { ("", "contradicts") } else { ("s", "contradict") };
    Some(format!(
        "model rejected ({p}): recording{s} {}{more} {contradict} the others: another ship, loading or sensor; estimate them apart",
        listed(&named)
    ))
}

/// The noise that was found, its size, and the distance of the next kind.
fn noise_found(criticism: &Criticism, noise: &FoundNoise) -> String {
    let levels = [criticism.noise_u, criticism.noise_v, criticism.noise_r];
    let [u, v, r] = levels.map(|std| number(std.unwrap_or(f64::NAN)));
    let mut all = vec![format!("white noise of u {u}, v {v} m/s, r {r} rad/s")];
    for (of, name) in [("force", "forces, in a sample"), ("sensor", "sensors that drift by")] {
        let each = noise.drifts.iter().filter(|drift| drift.of == of);
        let each: Vec<String> = each
            .map(|each| {
                format!("{} {} {} over {} s", each.state, number(each.std), each.unit, number(each.time_s))
            })
            .collect();
        if !each.is_empty() {
            all.push(format!("{name} {}", each.join(", ")));
        }
    }
    if let Some(std) = criticism.current_std.filter(|std| *std > 0.0) {
        let drifting = |time| format!("drifting over {} s", number(time));
        let time = criticism.current_time_s.map_or("new at every sample".to_owned(), drifting);
        all.push(format!("a current of {} m/s, {time}", number(std)));
    }
    let turns = if noise.turns == 1 { "turn" } else { "turns" };
    let rest = if noise.at_rest { "" } else { ", without coming to rest" };
    let next = noise.others.first().map_or(String::new(), |next| {
        format!("; next likely: {}, {:.1} below in twice the log-likelihood", next.kind.words(), next.below)
    });
    format!("noise found in {} {turns}{rest}: {}: {}{next}", noise.turns, noise.kind.words(), all.join("; "))
}

impl Criticism {
    /// The warning that a current persists, for estimates that do not allow for one: parameters take it for motion.
    pub fn persistent_current(&self) -> Option<String> {
        let time = self.current_time_s.filter(|time| *time >= SLOW)?;
        let lasts = if time >= LASTING { "stays".to_owned() } else { format!("changes within {time:.0} s") };
        let std = self.current_std?;
        (std >= FELT * self.noise_u?.min(self.noise_v?)).then(|| {
            format!(
                "standard errors do not hold: a current of {} m/s {lasts}, and parameters take it for the vessel's own motion; \
                 `estimate --fit together --estimator prediction-error` allows for it",
                number(std)
            )
        })
    }
}

fn values(absent: &Absent) -> String {
    let pairs = absent.value.iter().zip(&absent.standard_error);
    let values: Vec<String> = pairs.map(|(v, e)| format!("{} ± {}", number(*v), number(*e))).collect();
    format!("{} {}", values.join(", "), absent.unit)
}

/// What to do about a channel that counts to the other side.
pub(crate) fn sign_remedy(channel: &str) -> String {
    format!("compare `{channel}` with the motion, and set `sign = -1` of that channel in ingest.toml if so")
}

/// `x` with three significant digits.
pub fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let exponent = libm::floor(libm::log10(x.abs())) as i32;
    match exponent {
        -4..=5 => format!("{x:.*}", (2 - exponent).max(0) as usize),
        _ => format!("{x:.2e}"),
    }
}

/// A model is rejected if the likeliest candidate has a smaller probability than this under the model.
pub const LEVEL: f64 = 0.05;

/// An input that answers what was measured at the same sample.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Feedback {
    /// The input.
    pub input: String,
    /// The measured state, whose error by prediction it goes with: `u`, `v` or `r`.
    pub state: String,
    /// Correlation of the input's news with that error.
    pub correlation: f64,
    /// Probability of a larger one, of any input and state, where inputs know nothing of the errors.
    pub p_value: f64,
}
