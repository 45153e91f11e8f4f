//! A ship of which nothing is known but her logs: what steers and drives her, and the usual terms.

use std::fmt::Write;

use logs::guess::{Needed, Placed};

use super::looking::{LogGuess, Looked};
use super::presets::Preset;

/// What may steer and drive a ship: channel, unit and role.
type Inputs = &'static [(&'static str, &'static str, &'static str)];

/// Rudder and propeller, or its thrust; propellers on both sides, which a model may exchange; a rudder beside a propeller that is not
/// logged.
const KNOWN: [Inputs; 5] = [
    &[("delta", "rad", "rudder"), ("n", "1/s", "propeller")],
    &[("delta", "rad", "rudder"), ("thrust", "N", "thrust")],
    &[("n_port", "1/s", "port"), ("n_starboard", "1/s", "starboard")],
    &[("n1", "1/s", "port"), ("n2", "1/s", "starboard")],
    &[("delta", "rad", "rudder")],
];

/// Samples of a usual recording.
const SAMPLES: f64 = 300.0;

/// Channels that logs of a ship may have, the likeliest first.
pub(super) fn needed() -> Vec<Vec<Needed>> {
    let need = |&(channel, unit, _): &(&str, &str, &str)| Needed {
        channel: channel.to_owned(),
        unit: unit.to_owned(),
    };
    KNOWN.iter().map(|inputs| inputs.iter().map(need).collect()).collect()
}

/// The ship of the logs that were `looked` at.
pub(super) fn ship(looked: &Looked) -> Preset {
    let has = |channel: &str| {
        looked.placed().any(|placed| placed.channel == channel)
            || looked.missing().iter().any(|need| need.channel == channel)
    };
    let inputs = KNOWN.iter().find(|inputs| inputs.iter().all(|(channel, ..)| has(channel)));
    let inputs = inputs.copied().unwrap_or(KNOWN[0]);
    let rate_hz = rate_hz(looked);
    let mut text = format!(
        "# A ship of which nothing is known but her logs. `estimate` begins with the terms below, and with six recordings or more adds\n\
         # those that the recordings support. What is known of her makes better models: her main dimensions, or a ship like her:\n\
         # `seatrial new <folder> --logs <folder> --guess …` or `--vessel …`.\n\
         #\n\
         # Every term adds  parameter × term  to the state at the next sample, so a parameter holds for this `sample_rate_hz` [Hz] only:\n\
         # a usual recording has {SAMPLES} samples or so. States are u surge, v sway [m/s] and r yaw rate [rad/s].\n\
         name = \"Ship of these logs\"\nsample_rate_hz = {rate_hz:?}\n"
    );
    for (channel, unit, role) in inputs {
        let _ = write!(text, "\n[[input]]\nname = \"{channel}\"\nunit = \"{unit}\"\nrole = \"{role}\"\n");
    }
    let reverses = |placed: &Placed| placed.channel == "n" && placed.has_negative;
    if looked.placed().any(reverses) {
        text += "\n# She goes astern, where a propeller pulls less.\n";
        for (name, formula) in [("n_ahead", "positive(n)"), ("n_astern", "negative(n)")] {
            let _ = write!(text, "[[derived]]\nname = \"{name}\"\nformula = \"{formula}\"\nunit = \"1/s\"\n");
        }
    }
    let of_inputs = inputs.iter().flat_map(|&(channel, unit, _)| match (channel, unit) {
        ("delta", _) => vec![("yaw", "N_delta".to_owned(), "u^2 delta".to_owned())],
        ("thrust", _) => vec![("surge", "X_thrust".to_owned(), "thrust".to_owned())],
        ("n", _) => vec![("surge", "X_nn".to_owned(), "n |n|".to_owned())],
        (n, _) => [("surge", "X"), ("yaw", "N")]
            .map(|(degree, force)| (degree, format!("{force}_{n}"), format!("{n} |{n}|")))
            .into(),
    });
    let hull = [
        ("surge", "X_u", "u"),
        ("surge", "X_uu", "u |u|"),
        ("sway", "Y_v", "v"),
        ("sway", "Y_ur", "u r"),
        ("yaw", "N_r", "r"),
    ];
    let hull = hull.map(|(degree, name, term)| (degree, name.to_owned(), term.to_owned()));
    let terms: Vec<(&str, String, String)> = hull.into_iter().chain(of_inputs).collect();
    for degree in ["surge", "sway", "yaw"] {
        for (_, name, term) in terms.iter().filter(|(of, ..)| *of == degree) {
            let _ =
                write!(text, "\n[[{degree}]]\nparameter = \"{name}\"\nterm = \"{term}\"\nnominal = 0.0\n");
        }
    }
    Preset::of_vessel(text)
}

/// The highest usual rate \[Hz\] at which logs have values, and a usual recording no more samples than enough.
fn rate_hz(looked: &Looked) -> f64 {
    let step_s = match &looked.found {
        LogGuess::Table(_, guess) => guess.clock.as_ref().map_or(1.0, |clock| clock.step_s),
        LogGuess::Bag(bag) => bag.topics().iter().fold(0.0, |most, topic| topic.step_s.max(most)),
        LogGuess::Sentences(guess) => guess.steps_s[1],
    };
    let most = (SAMPLES / looked.usual_s).min(1.0 / step_s);
    let usual = [0.01, 0.1, 1.0, 10.0].into_iter().flat_map(|decade| [decade, 2.0 * decade, 5.0 * decade]);
    usual.take_while(|rate| *rate <= most).last().unwrap_or(0.01)
}
