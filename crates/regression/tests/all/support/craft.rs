//! A small craft: parts of its motion, random or computed independently (`fixtures/oracle/pooled.json`), and their
//! regressions.

use regression::pooled::{Centring, Options, Part, Regression, fit, sandwich};
use regression::{MeanRemoval, Sums};
use serde_json::Value;
use ship::engine::{Run, RunView, Segment, simulate_one};
use ship::model::{Vessel, VesselFile};

use super::noise::Normals;

pub const TRUTH: [f64; 8] = [-0.06, 0.7, 0.01, -0.25, -0.3, -0.2, -0.08, 0.1];

pub fn craft() -> Vessel {
    Vessel::from_file(craft_file()).unwrap()
}

pub fn craft_file() -> VesselFile {
    oracle()["vessel"].as_str().unwrap().parse().unwrap()
}

/// Parts as runs of one segment each.
pub fn runs(parts: &[Part]) -> Vec<Run> {
    let run = |(i, part): (usize, &Part)| Run {
        design: "simulated".to_owned(),
        run: i as i32,
        segments: vec![Segment { maneuver: "zigzag".to_owned(), start: 0 }],
        initial: [0, 1, 2].map(|d| part.measured[d]),
        instrument_exogenous: Vec::new(),
        exogenous: part.exogenous.clone(),
        measured: part.measured.clone(),
    };
    parts.iter().enumerate().map(run).collect()
}

/// A part of `samples` samples with forces that are correlated in time and no measurement noise, or none at all.
pub fn part(vessel: &Vessel, samples: usize, number: usize, normals: &mut Normals, disturbed: bool) -> Part {
    let lifted = vessel.model.with_intercepts();
    let phase = number as f64;
    let (mut exogenous, mut measured) = (Vec::new(), vec![1.2, 0.0, 0.0]);
    let mut force = [0.0; 3];
    for k in 0..samples {
        let k = k as f64;
        let swing = (0.32 * k + phase).sin();
        let row = [3.0 + 0.9 * (0.17 * k + 2.0 * phase).sin(), 0.3 * swing.signum()];
        exogenous.extend(row);
        for (f, size) in force.iter_mut().zip([0.004, 0.002, 0.001]) {
            *f = 0.5 * *f + if disturbed { size * normals.next() } else { 0.0 };
        }
        let state = [0, 1, 2].map(|d| measured[measured.len() - 3 + d]);
        let next = simulate_one(&lifted, &lifted.layout().woven(&TRUTH, force), state, &row);
        measured.extend(&next[3..]);
    }
    Part::new("zigzag", "a", RunView::measured(&measured, &exogenous))
}

pub fn many(vessel: &Vessel, count: usize, samples: usize, seed: u64) -> Vec<Part> {
    let mut normals = Normals::new(seed);
    (0..count).map(|i| part(vessel, samples, i, &mut normals, true)).collect()
}
pub const COMPLETE: Options = Options { removal: MeanRemoval::Complete, prior: None, most: f64::INFINITY };

/// The nominal simulation over every part.
pub fn simulated(vessel: &Vessel, parts: &[Part]) -> Vec<Vec<f64>> {
    let lifted = vessel.model.with_intercepts();
    let nominal = lifted.layout().woven(&vessel.nominal, [0.0; 3]);
    parts.iter().map(|part| part.whole().simulated(&lifted, &nominal).unwrap()).collect()
}

pub fn regressions(vessel: &Vessel, parts: &[Part]) -> Vec<Regression> {
    with_instruments(vessel, parts, &simulated(vessel, parts))
}

pub fn with_instruments(vessel: &Vessel, parts: &[Part], states: &[Vec<f64>]) -> Vec<Regression> {
    let pairs = parts.iter().zip(states);
    pairs.map(|(part, states)| Regression::with(&vessel.model, &part.whole(), states)).collect()
}

pub fn errors(data: &[Regression], sums: &[&Sums], bandwidth: usize) -> (Vec<f64>, Vec<f64>) {
    let found = fit(sums, &COMPLETE);
    let (data, centring): (Vec<&Regression>, _) =
        (data.iter().collect(), Centring::new(sums, MeanRemoval::Complete));
    let (mut theta, mut errors) = (Vec::new(), Vec::new());
    for (d, degree) in found.iter().enumerate() {
        let solution = degree.solution.as_ref().unwrap();
        let p = solution.theta.len();
        let covariance = sandwich(&data, &centring, solution, d, bandwidth);
        theta.extend(&solution.theta);
        errors.extend((0..p).map(|i| covariance[i * p + i].sqrt()));
    }
    (theta, errors)
}

pub fn oracle() -> Value {
    serde_json::from_str(include_str!("../../../../../fixtures/oracle/pooled.json")).unwrap()
}

pub fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
}

pub fn parts(oracle: &Value) -> Vec<Part> {
    let part = |p: &Value| {
        let (inputs, measured) = (numbers(&p["inputs"]), numbers(&p["measured"]));
        Part::new("zigzag", p["source"].as_str().unwrap(), RunView::measured(&measured, &inputs))
    };
    oracle["parts"].as_array().unwrap().iter().map(part).collect()
}

pub fn close(found: &[f64], expected: &Value, what: &str) {
    let expected = numbers(expected);
    assert_eq!(found.len(), expected.len(), "{what}");
    let scale = expected.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    for (found, expected) in found.iter().zip(&expected) {
        assert!(
            (found - expected).abs() < 1e-9 * expected.abs().max(1e-3 * scale),
            "{what}: {found} {expected}"
        );
    }
}

/// The data of `part` with instruments simulated with parameters `model`, or its regressors as instruments.
pub fn regression(vessel: &Vessel, part: &Part, model: Option<&[f64]>) -> Regression {
    match model {
        None => Regression::of(&vessel.model, &part.whole()),
        Some(model) => {
            let states = part.whole().simulated(&vessel.model.with_intercepts(), model).unwrap();
            Regression::with(&vessel.model, &part.whole(), &states)
        }
    }
}
