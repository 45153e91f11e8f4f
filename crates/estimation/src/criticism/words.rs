use refusal::listed;

use super::found::{Absent, Apart, Criticism, FoundNoise, Verdict};
use super::noise::LASTING;
use super::tested::LEVEL;

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
/// Maximum number of recordings that are named.
const NAMED: usize = 4;

/// The verdict, what is most likely missing, what it cannot be distinguished from, what the runs would have shown.
/// `under_white`: whether the model is rejected under white noise, which is not the likeliest.
pub(super) fn statements(found: &Criticism, under_white: bool) -> Vec<String> {
    let mut out = Vec::new();
    let Some(p) = found.p_value else {
        return vec!["structure: the runs tell of nothing that the model lacks".to_owned()];
    };
    out.extend(contradictions(&found.apart));
    match (found.verdict, found.absent.first()) {
        (Verdict::Rejected, Some(first)) if p < LEVEL => {
            let p = if p < 1e-4 { "p < 0.0001".to_owned() } else { format!("p {p:.4}") };
            let values = values(first);
            let under = if under_white { ", under white noise" } else { "" };
            out.push(format!(
                "model rejected ({p}{under}): most likely missing: {}, {values} if added",
                first.label()
            ));
            let others: Vec<String> =
                found.absent[1..].iter().filter(|a| a.candidate).map(Absent::label).collect();
            if !others.is_empty() {
                out.push(format!("cannot be told from: {}", listed(&others)));
            }
        }
        (Verdict::None, _) if found.waves_s.is_some() => out.push(format!(
            "no verdict on the model: its errors oscillate with a period of about {:.1} s, as where waves move the ship, so that \
             tests and standard errors do not hold",
            found.waves_s.unwrap_or_default()
        )),
        (Verdict::None, _) => out.push(
            "no verdict on the model: these errors follow no noise known here, so that tests and standard errors do not hold"
                .to_owned(),
        ),
        (Verdict::Rejected, _) => {}
        _ => out.push(format!("model not rejected (p {p:.2}), which is no proof of it")),
    }
    let detectable = |(name, degree): &(&str, Option<&str>)| {
        let is = |a: &&Absent| a.name == *name && a.degree.as_deref() == *degree;
        let absent = found.absent.iter().find(is)?;
        Some(format!("{} from {} {}", absent.label(), number(absent.visible_from), absent.unit))
    };
    let visible: Vec<String> = REPORTED.iter().filter_map(detectable).collect();
    if !visible.is_empty() {
        out.push(format!("these runs would have shown {}", listed(&visible)));
    }
    out.extend(found.noise.as_ref().map(|noise| noise_found(found, noise)));
    if let Some(f) = &found.feedback {
        out.push(format!(
            "`{}` answers the measured {} within the sample (correlation {:.2}), as under an autopilot that steers by the sensor \
             that is logged: `ls` and `iv` are then biased; use `output-error`, or steer by another sensor",
            f.input, f.state, f.correlation
        ));
    }
    if found.stated_noise && (found.error_ratio - 1.0).abs() > OFF {
        out.push(format!("errors are {:.2} times the stated noise", found.error_ratio));
    }
    out
}

/// Names the recordings that contradict the others.
fn contradictions(apart: &[Apart]) -> Option<String> {
    let first = apart.first()?;
    let p = if first.p_value < 1e-4 { "p < 0.0001".to_owned() } else { format!("p {:.4}", first.p_value) };
    let named: Vec<String> = apart.iter().take(NAMED).map(|own| format!("`{}`", own.recording)).collect();
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
fn noise_found(found: &Criticism, noise: &FoundNoise) -> String {
    let [u, v, r] = [found.noise_u, found.noise_v, found.noise_r].map(number);
    let mut own = vec![format!("white noise of u {u}, v {v} m/s, r {r} rad/s")];
    for (of, name) in [("force", "forces, in a sample"), ("sensor", "sensors that drift by")] {
        let each = noise.drifts.iter().filter(|own| own.of == of);
        let each: Vec<String> = each
            .map(|each| {
                format!("{} {} {} over {} s", each.state, number(each.std), each.unit, number(each.time_s))
            })
            .collect();
        if !each.is_empty() {
            own.push(format!("{name} {}", each.join(", ")));
        }
    }
    if found.current_std > 0.0 {
        let drifting = |time| format!("drifting over {} s", number(time));
        let time = found.current_time_s.map_or("new at every sample".to_owned(), drifting);
        own.push(format!("a current of {} m/s, {time}", number(found.current_std)));
    }
    let turns = if noise.turns == 1 { "turn" } else { "turns" };
    let rest = if noise.at_rest { "" } else { ", without coming to rest" };
    let next = noise.others.first().map_or(String::new(), |next| {
        format!("; next likely: {}, {:.1} below in twice the log-likelihood", next.kind.words(), next.below)
    });
    format!("noise found in {} {turns}{rest}: {}: {}{next}", noise.turns, noise.kind.words(), own.join("; "))
}

impl Criticism {
    /// The warning that a current persists, for estimates that do not allow for one: parameters take it for the vessel's own
    /// motion.
    pub fn persistent_current(&self) -> Option<String> {
        let time = self.current_time_s.filter(|time| *time >= SLOW)?;
        let lasts = if time >= LASTING { "stays".to_owned() } else { format!("changes within {time:.0} s") };
        (self.current_std >= FELT * self.noise_u.min(self.noise_v)).then(|| {
            format!(
                "standard errors do not hold: a current of {} m/s {lasts}, and parameters take it for the vessel's own motion; \
                 `estimate pool --estimator prediction-error` allows for it",
                number(self.current_std)
            )
        })
    }
}

fn values(absent: &Absent) -> String {
    let pairs = absent.value.iter().zip(&absent.standard_error);
    let values: Vec<String> = pairs.map(|(v, e)| format!("{} ± {}", number(*v), number(*e))).collect();
    format!("{} {}", values.join(", "), absent.unit)
}

/// Three significant digits.
fn number(x: f64) -> String {
    if x == 0.0 || !x.is_finite() {
        return x.to_string();
    }
    let exponent = libm::floor(libm::log10(x.abs())) as i32;
    match exponent {
        -4..=5 => format!("{x:.*}", (2 - exponent).max(0) as usize),
        _ => format!("{x:.2e}"),
    }
}
