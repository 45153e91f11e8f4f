//! The stand-in vessel of the Helsinki study, written out by hand.

use std::f64::consts::TAU;

/// States or increments of surge, sway and yaw.
pub type Three = [f64; 3];

/// The vessel's motion with one set of parameters.
pub struct Ship {
    /// Parameters per degree of freedom, in the order of [`regressors`].
    theta: [Vec<f64>; 3],
}

const TERMS: [&[&str]; 3] = [&["u", "u |u|", "v r", "tau1"], &["v", "u r", "tau2"], &["r", "u v", "tau3"]];

/// Regressors of surge, sway and yaw.
pub fn regressors([u, v, r]: Three, [tau1, tau2, tau3]: Three) -> [Vec<f64>; 3] {
    [vec![u, u * u.abs(), v * r, tau1], vec![v, u * r, tau2], vec![r, u * v, tau3]]
}

impl Ship {
    /// `nominal` or `value` of the vessel.toml in `text`.
    pub fn new(text: &str, which: &str) -> Self {
        let file: toml::Value = toml::from_str(text).unwrap();
        assert_eq!(file["sample_rate_hz"].as_float(), Some(1.0));
        let degrees = ["surge", "sway", "yaw"];
        let theta = [0, 1, 2].map(|d| {
            let terms = file[degrees[d]].as_array().unwrap();
            let names: Vec<&str> = terms.iter().map(|t| t["term"].as_str().unwrap()).collect();
            assert_eq!(names, TERMS[d], "the tests know another vessel");
            terms.iter().map(|t| t[which].as_float().unwrap()).collect()
        });
        Self { theta }
    }

    /// The state after one sample; `current` in the vessel's axes.
    pub fn step(&self, state: Three, inputs: Three, current: [f64; 2]) -> Three {
        let relative = [state[0] - current[0], state[1] - current[1], state[2]];
        let phi = regressors(relative, inputs);
        [0, 1, 2].map(|d| state[d] + phi[d].iter().zip(&self.theta[d]).map(|(a, b)| a * b).sum::<f64>())
    }

    /// N + 1 states in still water.
    pub fn simulate(&self, initial: Three, inputs: &[Three]) -> Vec<Three> {
        let mut states = vec![initial];
        for row in inputs {
            states.push(self.step(states[states.len() - 1], *row, [0.0; 2]));
        }
        states
    }
}

/// Pose (north, east, heading) after a second at `state`.
pub fn advanced([x, y, psi]: Three, [u, v, r]: Three) -> Three {
    [x + u * psi.cos() - v * psi.sin(), y + u * psi.sin() + v * psi.cos(), psi + r]
}

/// Difference of two headings, in (−π, π].
pub fn turned(a: f64, b: f64) -> f64 {
    let d = (a - b).rem_euclid(TAU);
    if d > TAU / 2.0 { d - TAU } else { d }
}

/// Σ φ̃ ζ̃ᵀ of surge, sway and yaw: lifted regressors of measured states against those of the instruments.
pub struct Sums([Vec<Vec<f64>>; 3]);

impl Sums {
    pub fn new() -> Self {
        Self([5, 4, 4].map(|n| vec![vec![0.0; n]; n]))
    }

    /// Adds a segment, `times` times: instruments are `ship` under the same inputs from the same state.
    pub fn add(&mut self, ship: &Ship, states: &[Three], inputs: &[Three], times: f64) {
        let instruments = ship.simulate(states[0], inputs);
        for ((state, instrument), row) in states.iter().zip(&instruments).zip(inputs) {
            let (phi, zeta) = (regressors(*state, *row), regressors(*instrument, *row));
            for d in 0..3 {
                let lift = |v: &[f64]| v.iter().copied().chain([1.0]).collect::<Vec<_>>();
                let (phi, zeta) = (lift(&phi[d]), lift(&zeta[d]));
                for (row, a) in self.0[d].iter_mut().zip(&phi) {
                    row.iter_mut().zip(&zeta).for_each(|(sum, b)| *sum += times * a * b);
                }
            }
        }
    }

    /// log|det| of all three.
    pub fn log_det(&self) -> f64 {
        self.0.iter().map(|m| log_det(m.clone())).sum()
    }

    pub fn dimension(&self) -> usize {
        self.0.iter().map(Vec::len).sum()
    }
}

/// By Gaussian elimination, rows and columns brought to size one first.
fn log_det(mut m: Vec<Vec<f64>>) -> f64 {
    let n = m.len();
    let size: Vec<f64> = (0..n).map(|i| m[i][i].abs().sqrt()).collect();
    (0..n).for_each(|i| (0..n).for_each(|j| m[i][j] /= size[i] * size[j]));
    let mut sum: f64 = size.iter().map(|s| 2.0 * s.ln()).sum();
    for k in 0..n {
        let best = (k..n).max_by(|a, b| m[*a][k].abs().total_cmp(&m[*b][k].abs())).unwrap();
        m.swap(k, best);
        sum += m[k][k].abs().ln();
        for i in k + 1..n {
            let factor = m[i][k] / m[k][k];
            (k..n).for_each(|j| m[i][j] -= factor * m[k][j]);
        }
    }
    sum
}
