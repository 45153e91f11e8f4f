//! The paper's example: y(k) = θ₀u(k) + e(k) with an input offset that changes sign halfway.
//!
//! With u(k) = ũ(k) ± ū and ũ repeated in both halves, Σu = 0. Complete subtraction leaves ζ = u, batchwise leaves
//! ζ = ũ. θ̂ − θ₀ = Σζe / Σζu, so its variance is σ² Σζ² / (Σζu)²: σ² / (Σũ² + N ū²) and σ² / Σũ².

use numerics::LANES;
use regression::{MeanRemoval, Outcome};
use serde_json::Value;
use ship::model::Vessel;

use crate::support::noise::Normals;
use crate::support::{Recording, SideBySide, estimate};

const ORACLE: &str = include_str!("../../../../fixtures/oracle/oracle.json");
const BATCHES: usize = 1000;

/// A vessel whose increments are its inputs times a parameter: in surge the example, in sway and yaw anything.
const SCALAR: &str = r#"
name = "scalar example"
sample_rate_hz = 1.0
input = [{ name = "a", unit = "1" }, { name = "b", unit = "1" }, { name = "c", unit = "1" }]
surge = [{ parameter = "theta", term = "a", nominal = 1.0 }]
sway = [{ parameter = "sway", term = "b", nominal = 1.0 }]
yaw = [{ parameter = "yaw", term = "c", nominal = 1.0 }]
"#;

struct Example {
    theta: f64,
    noise: f64,
    offset: f64,
    u: Vec<f64>,
    y: Vec<f64>,
    oracle: Value,
}

fn example() -> Example {
    let oracle = serde_json::from_str::<Value>(ORACLE).unwrap()["scalar_example"].take();
    let number = |key: &str| oracle[key].as_f64().unwrap();
    let numbers = |key: &str| oracle[key].as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect();
    Example {
        theta: number("theta"),
        noise: number("noise_std"),
        offset: number("offset"),
        u: numbers("u"),
        y: numbers("y"),
        oracle,
    }
}

impl Example {
    /// States whose increments are `y` in surge and the inputs in sway and yaw.
    fn run(&self, y: &[f64]) -> Recording {
        let n = self.u.len();
        let (mut measured, mut exogenous) = (vec![0.0; 3], Vec::new());
        for (k, (u, y)) in self.u.iter().zip(y).enumerate() {
            let others = [(k as f64).sin(), (k as f64).cos()];
            exogenous.extend([*u, others[0], others[1]]);
            let last: Vec<f64> = measured[3 * k..].to_vec();
            measured.extend([last[0] + y, last[1] + others[0], last[2] + others[1]]);
        }
        Recording { instrument_states: measured.clone(), measured, exogenous, segments: vec![0, n / 2] }
    }

    /// Estimates of θ from increments `y`, one per lane.
    fn estimates(&self, ys: &[Vec<f64>], removal: MeanRemoval) -> Vec<f64> {
        let vessel = Vessel::from_file(SCALAR.parse().unwrap()).unwrap();
        let runs: Vec<Recording> = ys.iter().map(|y| self.run(y)).collect();
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        let theta = |outcome: &Outcome| match outcome {
            Outcome::Identified(estimate) => estimate.parameters[0],
            other => panic!("{other:?}"),
        };
        estimate(&side_by_side.batch(&vessel.model), removal)[..ys.len()].iter().map(theta).collect()
    }

    /// The variances by formula: complete, batchwise.
    fn variances(&self) -> [f64; 2] {
        let n = self.u.len();
        let varying = |k: usize| self.u[k] - if k < n / 2 { self.offset } else { -self.offset };
        let power: f64 = (0..n).map(|k| varying(k) * varying(k)).sum();
        let variance = self.noise * self.noise;
        [variance / (power + n as f64 * self.offset * self.offset), variance / power]
    }
}

const MODES: [(&str, MeanRemoval); 2] = [("complete", MeanRemoval::Complete), ("batch", MeanRemoval::Batch)];

#[test]
fn oracle_estimates_and_variances_of_the_scalar_example() {
    let example = example();
    for ((name, removal), variance) in MODES.into_iter().zip(example.variances()) {
        let expected = example.oracle["estimate"][name].as_f64().unwrap();
        let found = example.estimates(std::slice::from_ref(&example.y), removal)[0];
        assert!((found - expected).abs() < 1e-12, "{name}: found {found}, expected {expected}");
        let expected = example.oracle["variance"][name].as_f64().unwrap();
        assert!((variance / expected - 1.0).abs() < 1e-12, "{name}: found {variance}, expected {expected}");
    }
}

#[test]
fn law_complete_subtraction_beats_batchwise_when_the_offset_changes_sign() {
    let (example, mut normals) = (example(), Normals::new(17));
    let mut found = [Vec::new(), Vec::new()];
    for _ in 0..BATCHES {
        let mut draw =
            || example.u.iter().map(|u| example.theta * u + example.noise * normals.next()).collect();
        let ys: Vec<Vec<f64>> = (0..LANES).map(|_| draw()).collect();
        for (all, (_, removal)) in found.iter_mut().zip(MODES) {
            all.extend(example.estimates(&ys, removal));
        }
    }
    let mut spreads = Vec::new();
    for ((estimates, expected), (name, _)) in found.iter().zip(example.variances()).zip(MODES) {
        let n = estimates.len() as f64;
        let mean = estimates.iter().sum::<f64>() / n;
        let variance = estimates.iter().map(|t| (t - mean) * (t - mean)).sum::<f64>() / (n - 1.0);
        // Monte Carlo standard errors: of a mean σ/√n, of a normal sample's variance σ²√(2/(n−1)).
        assert!((mean - example.theta).abs() < 4.0 * (expected / n).sqrt(), "{name}: mean {mean}");
        let error = expected * (2.0 / (n - 1.0)).sqrt();
        assert!((variance - expected).abs() < 4.0 * error, "{name}: found {variance}, expected {expected}");
        spreads.push(variance);
    }
    assert!(spreads[0] < spreads[1]);
}
