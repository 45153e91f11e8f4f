//! Coverage of the intervals that a search for few terms prints: recordings of a known ship are simulated repeatedly,
//! in gusts and with noise, and searched, and the intervals of the base structure's parameters that contain the truth
//! are counted.
//!
//! ```text
//! cargo run --release -p seatrial-estimation --example compact_intervals -- [realizations] [resamples] [white|gusts] [seed]
//! ```

use std::collections::BTreeMap;

use estimation::search::{BootstrapOptions, Cut, SearchOptions, search};
use regression::pooled::PooledRuns;
use ship::engine::{Run, Segment, Streams, simulate_one};
use ship::model::terms::listed;
use ship::model::{Vessel, VesselFile};

/// A ship of 3 m; its nominal values are the truth.
const SHIP: &str = r#"
name = "known ship"
sample_rate_hz = 1.0
input = [{ name = "n", unit = "1/s" }, { name = "delta", unit = "rad" }]
surge = [
    { parameter = "X_uu", term = "u |u|", nominal = -0.06 },
    { parameter = "X_vr", term = "v r", nominal = 0.9 },
    { parameter = "X_nn", term = "n |n|", nominal = 0.0012 },
]
sway = [
    { parameter = "Y_v", term = "v", nominal = -0.06 },
    { parameter = "Y_ur", term = "u r", nominal = -0.35 },
    { parameter = "Y_vv", term = "v |v|", nominal = -0.6 },
    { parameter = "Y_delta", term = "u |u| delta", nominal = -0.02 },
]
yaw = [
    { parameter = "N_r", term = "r", nominal = -0.12 },
    { parameter = "N_uv", term = "u v", nominal = 0.03 },
    { parameter = "N_rr", term = "r |r|", nominal = -0.8 },
    { parameter = "N_delta", term = "u |u| delta", nominal = 0.05 },
]
"#;
/// Terms that the ship does not have: 28, to third order.
const OTHERS: [&str; 3] = [
    "u; u^3; v^2; r^2; u v^2; u r^2; u |u| delta^2; |v| |r|",
    "r; u v; v |r|; |v| r; v^3; r^3; v r^2; v^2 r; u^2 v; u^2 r",
    "v; u r; v |r|; |v| r; v^3; r^3; v r^2; v^2 r; u^2 v; u^2 r",
];
const RECORDINGS: u32 = 12;
const SAMPLES: usize = 60;
/// Standard deviations of the noise of u, v \[m/s\] and r \[rad/s\], and of the increments that gusts add per sample.
const NOISE: [f64; 3] = [0.004, 0.004, 0.002];
const GUSTS: [f64; 3] = [0.002, 0.002, 0.001];
/// Share of a gust that remains after a sample: a time constant of 8 s.
const LASTING: f64 = 0.88;

/// The disturbances of the ship's recordings.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Disturbed {
    /// By white noise of the sensors.
    White,
    /// By gusts too.
    ForceNoise,
}

/// The known ship.
pub fn ship() -> Vessel {
    let file: VesselFile = SHIP.parse().unwrap_or_default();
    Vessel::from_file(file).unwrap_or_else(|e| panic!("the ship of the example: {e}"))
}

/// The recordings of a realization: zig-zags with different rudder angles, periods and speeds.
pub fn recorded(vessel: &Vessel, disturbed: Disturbed, streams: &Streams, realization: u32) -> Vec<Run> {
    let run = |number: u32| {
        let mut normals = vec![0.0; 6 * (SAMPLES + 1)];
        streams.normals(RECORDINGS * realization + number, 0, &mut normals);
        let phase = f64::from(number);
        let (mut measured, mut exogenous) = (Vec::new(), Vec::new());
        let (mut state, mut gust) = ([0.9 + 0.05 * phase.sin(), 0.0, 0.0], [0.0; 3]);
        for k in 0..=SAMPLES {
            let noise = &normals[6 * k..6 * k + 6];
            (0..3).for_each(|d| measured.push(state[d] + NOISE[d] * noise[d]));
            if k == SAMPLES {
                break;
            }
            let time = k as f64;
            let angle = (0.15 + 0.03 * phase) * ((0.1 + 0.02 * phase) * time + phase).sin();
            let row = [6.0 + 2.0 * (0.05 * time + 2.0 * phase).sin(), angle];
            exogenous.extend(row);
            let next = simulate_one(&vessel.model, &vessel.nominal, state, &row);
            for d in 0..3 {
                let size = if disturbed == Disturbed::ForceNoise { GUSTS[d] } else { 0.0 };
                gust[d] = LASTING * gust[d] + (1.0 - LASTING * LASTING).sqrt() * size * noise[3 + d];
                state[d] = next[3 + d] + gust[d];
            }
        }
        Run {
            design: "known".to_owned(),
            run: number as i32,
            segments: vec![Segment { maneuver: "zigzag".to_owned(), start: 0 }],
            initial: [0, 1, 2].map(|d| measured[d]),
            instrument_exogenous: Vec::new(),
            exogenous,
            measured,
        }
    };
    (0..RECORDINGS).map(run).collect()
}

/// Per parameter of the base structure, the number of realizations whose interval contains the truth.
pub fn covered(realizations: u32, resamples: u32, disturbed: Disturbed, seed: u64) -> Vec<(String, u32)> {
    let vessel = ship();
    let lists = OTHERS.map(|terms| terms.split(';').map(|term| term.trim().to_owned()).collect::<Vec<_>>());
    let all = listed(&vessel.model, lists.each_ref().map(Vec::as_slice));
    let all = all.unwrap_or_else(|e| panic!("the terms of the example: {e}"));
    let names: Vec<String> = vessel.model.parameter_names().map(str::to_owned).collect();
    let mut held = vec![0; names.len()];
    let streams = Streams::new(seed, "recordings of a known ship");
    for realization in 0..realizations {
        let runs = recorded(&vessel, disturbed, &streams, realization);
        let runs = PooledRuns::new(runs, &BTreeMap::new());
        let options = SearchOptions {
            cut: Cut { window: SAMPLES, every: SAMPLES / 2, scored: None },
            folds: 6,
            ridges: SearchOptions::half_decades(),
            compact: true,
            bootstrap: Some(BootstrapOptions { resamples, seed: seed + u64::from(realization) }),
            average: None,
            rate_hz: vessel.sample_rate_hz,
        };
        let Ok(found) = search(&vessel.model, &all, &runs, &options, &|_| ()) else { continue };
        let Some(resampled) = found.resampled else { continue };
        for ((name, truth), held) in names.iter().zip(&vessel.nominal).zip(&mut held) {
            let own = resampled.parameters.get(name);
            *held += u32::from(own.is_some_and(|own| (own.low..=own.high).contains(truth)));
        }
        println!("{} of {realizations}: {held:?}", realization + 1);
    }
    names.into_iter().zip(held).collect()
}

fn main() {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let number = |i: usize, usual: u32| arguments.get(i).and_then(|own| own.parse().ok()).unwrap_or(usual);
    let (realizations, resamples, seed) = (number(0, 40), number(1, 50), u64::from(number(3, 1)));
    let gusts = arguments.get(2).is_none_or(|own| own != "white");
    let disturbed = if gusts { Disturbed::ForceNoise } else { Disturbed::White };
    let found = covered(realizations, resamples, disturbed, seed);
    let all = found.len() as u32 * realizations;
    for (name, held) in &found {
        println!("{name}: {:.1} % of {realizations}", 100.0 * f64::from(*held) / f64::from(realizations));
    }
    let held: u32 = found.iter().map(|(_, held)| held).sum();
    println!(
        "all: {:.1} % of {all} intervals hold the truth ({disturbed:?})",
        100.0 * f64::from(held) / f64::from(all)
    );
}
