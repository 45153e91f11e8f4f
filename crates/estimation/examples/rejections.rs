//! How often the criticism of a ship with forces rejects a right ship, and names what is wrong, under several kinds of noise.
//!
//! `cargo run --release --example rejections -- <what> <trials> <seed> [<sea> …]` simulates eight zig-zags of KVLCC2 for each trial,
//! with `size`: the right ship; `yaw`: `r |r|` is missing in yaw; `sway`: `v U` is missing in sway; `rudder`: the rudder is
//! logged with the other sign.

#[path = "../tests/all/fitting/ship.rs"]
#[allow(dead_code)]
mod ship;

use estimation::fitting::{Channels, Problem, Settings};
use numerics::statistics::wilson;
use ship::{KVLCC2, Normals, Recorded, forces, parts, trial};

/// Standard deviations of the noise of u, v \[m/s\] and r \[rad/s\].
const NOISE: [f64; 3] = [0.005, 0.005, 0.0005];
/// Of the accelerations by gusts \[m/s², rad/s²\], which change over [`GUST_S`].
const GUSTS: [f64; 3] = [0.002, 0.002, 0.0002];
const GUST_S: f64 = 8.0;
/// Of a current in earth axes \[m/s\], which changes over [`CURRENT_S`].
const CURRENT: f64 = 0.02;
const CURRENT_S: f64 = 30.0;
/// The drift of sensors takes so long; it is as large as their noise.
const SENSORS_S: f64 = 60.0;
const SEAS: [&str; 4] = ["white", "gusts", "current", "sensors"];

fn main() {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let at = |i: usize| given.get(i).map(String::as_str);
    let what = at(0).unwrap_or("size");
    let number = |i: usize, usual: u64| at(i).and_then(|own| own.parse().ok()).unwrap_or(usual);
    let (trials, seed) = (number(1, 40), number(2, 1));
    for sea in SEAS.into_iter().filter(|sea| given.len() < 4 || given[3..].iter().any(|own| own == sea)) {
        let (mut rejected, mut signs, mut named) = (0, 0, 0);
        for i in 0..trials {
            let [rejects, sign, first] = judged(what, &recorded(what, sea, 1_000_000 * seed + i));
            rejected += u64::from(rejects);
            signs += u64::from(sign);
            named += u64::from(first);
        }
        let [rejected, signs, named] = [rejected, signs, named].map(|count| share(count, trials));
        println!("{what}, {sea}: rejected {rejected}, a sign wrong {signs}, named first {named}");
    }
}

/// The ship with what the fitted one lacks.
fn truth(what: &str) -> String {
    let more = |equation: &str, term: &str, prime: f64| {
        let begin = format!("{equation} = [");
        let spec =
            format!("\n  {{ parameter = \"more\", term = \"{term}\", prime = {prime}, fixed = true }},");
        KVLCC2.replace(&begin, &(begin.clone() + &spec))
    };
    match what {
        "yaw" => more("yaw", "r |r|", -0.03),
        _ => KVLCC2.to_owned(),
    }
}

/// A process that changes over `time` samples, with standard deviation 1.
fn drift(time: f64, count: usize, normals: &mut Normals) -> Vec<f64> {
    let keep = (-1.0 / time).exp();
    let mut value = normals.next();
    let mut next = || {
        let now = value;
        value = keep * value + (1.0 - keep * keep).sqrt() * normals.next();
        now
    };
    (0..count).map(|_| next()).collect()
}

fn recorded(what: &str, sea: &str, seed: u64) -> Vec<Recorded> {
    let ship = forces(&truth(what));
    let body = ship.body::<f64>(&ship.nominal());
    let mut normals = Normals::new(seed);
    let mut all = trial(&ship, &ship.nominal(), 1.0, [0.0; 3], seed);
    for own in &mut all {
        let count = own.measured.len() / 3;
        let mut drifts = |time: f64| [0, 1, 2].map(|_| drift(time, count, &mut normals));
        match sea {
            "gusts" => {
                let (gusts, mut state) = (drifts(GUST_S), [own.measured[0], 0.0, 0.0]);
                let rows: Vec<&[f64]> = own.inputs.chunks_exact(2).collect();
                for k in 1..count {
                    state = body.step(state, rows[k - 1], rows[k.min(rows.len() - 1)], 1.0);
                    (0..3).for_each(|d| state[d] += GUSTS[d] * gusts[d][k]);
                    own.measured[3 * k..3 * k + 3].copy_from_slice(&state);
                }
            }
            "current" => {
                let ([north, east, _], mut heading) = (drifts(CURRENT_S), 0.0_f64);
                for (k, row) in own.measured.chunks_exact_mut(3).enumerate() {
                    let (sin, cos) = heading.sin_cos();
                    heading += row[2];
                    row[0] += CURRENT * (cos * north[k] + sin * east[k]);
                    row[1] += CURRENT * (cos * east[k] - sin * north[k]);
                }
            }
            "sensors" => {
                let drifts = drifts(SENSORS_S);
                let rows = own.measured.chunks_exact_mut(3).enumerate();
                rows.for_each(|(k, row)| (0..3).for_each(|d| row[d] += NOISE[d] * drifts[d][k]));
            }
            _ => {}
        }
        let rows = own.measured.chunks_exact_mut(3);
        rows.for_each(|row| (0..3).for_each(|d| row[d] += NOISE[d] * normals.next()));
        if what == "rudder" {
            own.inputs.iter_mut().step_by(2).for_each(|angle| *angle = -*angle);
        }
    }
    all
}

/// Whether the ship is rejected, a sign is wrong, and what is wrong is named first.
fn judged(what: &str, recorded: &[Recorded]) -> [bool; 3] {
    let lacking = KVLCC2.lines().filter(|line| what != "sway" || !line.contains("\"Y_v\""));
    let (ship, (_, channels)) = (forces(&lacking.collect::<Vec<_>>().join("\n")), parts(KVLCC2));
    let recordings = recorded.iter().map(Recorded::recording).collect();
    let problem = Problem::new(&ship, recordings, channels.len(), Settings::new(1.0)).expect("recordings");
    let asked = Channels { all: &channels, inputs: channels.len() };
    let fit = match problem.fit() {
        Ok(fit) => fit,
        Err(error) => {
            let said = problem.explained(error, &ship.nominal(), asked).to_string();
            return [true, said.contains("`delta` acts"), said.contains("`delta` acts")];
        }
    };
    let found = problem.criticise(&fit, asked).expect("numbers that are determined");
    let first = found.absent.first().filter(|first| first.candidate).map(|first| first.label());
    let wanted = match what {
        "yaw" => "`r |r|` in yaw",
        "sway" => "`v U` in sway",
        _ => "`delta` acts with the opposite sign, the angle of `rudder`",
    };
    [found.rejected, found.wrong_signs().next().is_some(), first.is_some_and(|first| first == wanted)]
}

/// With its 95 % interval (Wilson's).
fn share(count: u64, total: u64) -> String {
    let [low, high] = wilson(count, total).unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
    format!("{:.1} % ({low:.1} to {high:.1}) of {total}", 100.0 * count as f64 / total.max(1) as f64)
}
