//! How often the test of forces that a ship lacks rejects a right ship under correlated noise.
//!
//! `cargo run --release -p fitting --example rejections -- 40 0.9 1` simulates eight zig-zags of KVLCC2 with 40 seeds, whose
//! noise is autoregressive of order 1 with this coefficient per second, and repeats the zig-zags so often.

#[path = "../tests/all/fitting/ship.rs"]
#[allow(dead_code)]
mod ship;

use estimation::fitting::{Channels, Problem, Settings};
use ship::{KVLCC2, Normals, Recorded, forces, parts, trial};

/// Standard deviations of the noise of u, v \[m/s\] and r \[rad/s\].
const NOISE: [f64; 3] = [0.005, 0.005, 0.0005];

fn main() {
    let given: Vec<f64> = std::env::args().skip(1).filter_map(|own| own.parse().ok()).collect();
    let at = |i: usize, usual: f64| given.get(i).copied().unwrap_or(usual);
    let (seeds, correlation, times) = (at(0, 40.0) as u64, at(1, 0.9), at(2, 1.0) as u64);
    let (mut rejected, mut by_terms) = (0, 0);
    for seed in 1..=seeds {
        let recorded: Vec<Recorded> = (0..times).flat_map(|i| noisy(1000 * seed + i, correlation)).collect();
        let (signs, p_value, units) = judged(&recorded);
        by_terms += u64::from(p_value.is_some_and(|own| own < estimation::fitting::LEVEL));
        rejected += u64::from(signs || p_value.is_some_and(|own| own < estimation::fitting::LEVEL));
        println!("seed {seed}: p {p_value:?}, {units}, wrong sign {signs}");
    }
    println!("correlation {correlation}: {rejected} of {seeds} rejected, {by_terms} by scores");
}

/// Zig-zags whose noise is correlated from second to second.
fn noisy(seed: u64, correlation: f64) -> Vec<Recorded> {
    let truth = forces(KVLCC2);
    let mut normals = Normals::new(seed);
    let mut all = trial(&truth, &truth.nominal(), 1.0, [0.0; 3], seed);
    for own in &mut all {
        let mut noise = [0, 1, 2].map(|d: usize| NOISE[d] * normals.next());
        for row in own.measured.chunks_exact_mut(3) {
            (0..3).for_each(|d| {
                row[d] += noise[d];
                let fresh = (1.0 - correlation * correlation).sqrt() * NOISE[d] * normals.next();
                noise[d] = correlation * noise[d] + fresh;
            });
        }
    }
    all
}

/// Whether a sign is wrong, the p-value of the scores, and how many independent units they have.
fn judged(recorded: &[Recorded]) -> (bool, Option<f64>, String) {
    let (ship, (_, channels)) = (forces(KVLCC2), parts(KVLCC2));
    let recordings = recorded.iter().map(Recorded::recording).collect();
    let problem = Problem::new(&ship, recordings, channels.len(), Settings::new(1.0)).expect("recordings");
    let fit = problem.fit().expect("a fit");
    let found = problem
        .criticise(&fit, Channels { all: &channels, inputs: channels.len(), listed: None })
        .expect("numbers that are determined");
    let units = format!("{} {}", found.units, if found.whole { "windows" } else { "pieces" });
    (found.has_wrong_sign(), found.p_value, units)
}
