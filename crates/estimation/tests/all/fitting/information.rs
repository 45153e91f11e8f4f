//! Laws of the information of simulated runs.

use estimation::fitting::{MeasuredRun, Prior, SimulatedRun};
use regression::Noise;
use ship::forces::Forces;

use crate::fitting::ship::{KVLCC2, Normals, forces};

const SAMPLE_S: f64 = 0.5;
const NOISE: [f64; 3] = [0.01, 0.008, 0.002];
/// Not straight ahead, where moduli have no slope.
const INITIAL: [f64; 3] = [1.1, -0.02, 0.01];

/// A zig-zag of the rudder with revolutions that change, of `samples`.
fn inputs(samples: usize) -> Vec<f64> {
    let row = |k: usize| {
        let side = if (k / 40).is_multiple_of(2) { 0.35 } else { -0.35 };
        [side, 11.85 * (1.0 + 0.1 * (0.07 * k as f64).sin())]
    };
    (0..samples).flat_map(row).collect()
}

/// The run of a ship that knows nothing of derivatives: steps one after the other, with a water that flows in each of them.
fn states(forces: &Forces, theta: &[f64], inputs: &[f64], currents: &[[f64; 2]]) -> Vec<[f64; 3]> {
    let body = forces.body::<f64>(theta);
    let mut all = vec![INITIAL];
    for (k, row) in inputs.as_chunks::<2>().0.iter().enumerate() {
        let [u, v, r] = all[k];
        let [along, across] = currents.get(k).copied().unwrap_or_default();
        let next = body.step_held([u - along, v - across, r], row, SAMPLE_S);
        let turn = 0.5 * SAMPLE_S * (r + next[2]);
        let flow = [along * turn.cos() + across * turn.sin(), across * turn.cos() - along * turn.sin()];
        all.push([next[0] + flow[0], next[1] + flow[1], next[2]]);
    }
    all
}

fn run(inputs: &[f64]) -> SimulatedRun<'_> {
    SimulatedRun { initial: INITIAL, inputs, width: 2, sample_s: SAMPLE_S }
}

/// ∂x/∂θ of every sample by central differences of fourth order.
fn differences(forces: &Forces, theta: &[f64], inputs: &[f64]) -> Vec<Vec<[f64; 3]>> {
    let by = |i: usize| {
        let step = 1e-5 * theta[i].abs().max(1e-2);
        let at = |share: f64| {
            let mut theta = theta.to_vec();
            theta[i] += share * step;
            states(forces, &theta, inputs, &[])
        };
        let all = [-2.0, -1.0, 1.0, 2.0].map(at);
        let of = |k: usize, d: usize| {
            (all[0][k][d] - 8.0 * all[1][k][d] + 8.0 * all[2][k][d] - all[3][k][d]) / (12.0 * step)
        };
        (0..all[0].len()).map(|k| [0, 1, 2].map(|d| of(k, d))).collect()
    };
    (0..theta.len()).map(by).collect()
}

#[test]
fn law_the_information_is_that_of_differences_of_simulations() {
    let forces = forces(KVLCC2);
    let (theta, inputs) = (forces.nominal(), inputs(200));
    let noise = Noise { measurement: NOISE, current: 0.0 };
    let found = run(&inputs).information(&forces, &theta, &noise).unwrap();
    let slopes = differences(&forces, &theta, &inputs);
    let n = theta.len();
    let product = |i: usize, j: usize| -> f64 {
        let own = slopes[i].iter().zip(&slopes[j]);
        own.map(|(a, b)| (0..3).map(|d| a[d] * b[d] / (NOISE[d] * NOISE[d])).sum::<f64>()).sum()
    };
    for i in 0..n {
        for j in 0..n {
            let (own, expected) = (found.measurement[i * n + j], product(i, j));
            let size = (product(i, i) * product(j, j)).sqrt();
            let (one, other) = (&forces.parameters()[i].name, &forces.parameters()[j].name);
            assert!((own - expected).abs() <= 1e-6 * size, "{one} {other}: {own} {expected} {size}");
        }
    }
    assert!(found.current.iter().all(|own| *own == 0.0));
}

#[test]
fn law_what_a_current_adds_is_that_of_ships_carried_by_each_draw() {
    let forces = forces(KVLCC2);
    let (theta, inputs) = (forces.nominal(), inputs(60));
    let noise = Noise { measurement: NOISE, current: 0.03 };
    let found = run(&inputs).information(&forces, &theta, &noise).unwrap();
    let slopes = run(&inputs).slopes(&forces, &theta).unwrap();
    let n = theta.len();
    let mut expected = vec![0.0; n * n];
    for draw in 0..120 {
        let (k, component) = (draw / 2, draw % 2);
        let at = |size: f64| {
            let mut currents = vec![[0.0; 2]; 60];
            currents[k][component] = size;
            states(&forces, &theta, &inputs, &currents)
        };
        let (ahead, back) = (at(1e-6), at(-1e-6));
        let score = |i: usize| -> f64 {
            let of = |(row, d): (usize, usize)| {
                let carried = (ahead[row][d] - back[row][d]) / 2e-6;
                slopes.by_theta[(3 * row + d) * n + i] * carried / (NOISE[d] * NOISE[d])
            };
            (0..=60).flat_map(|row| (0..3).map(move |d| (row, d))).map(of).sum::<f64>() * noise.current
        };
        let scores: Vec<f64> = (0..n).map(score).collect();
        for i in 0..n {
            (0..n).for_each(|j| expected[i * n + j] += scores[i] * scores[j]);
        }
    }
    for i in 0..n {
        for j in 0..n {
            let size = (expected[i * n + i] * expected[j * n + j]).sqrt();
            let (own, expected) = (found.current[i * n + j], expected[i * n + j]);
            assert!((own - expected).abs() <= 1e-5 * size, "{i} {j}: {own} {expected}");
        }
    }
}

/// A trial of KVLCC2 whose true numbers are as far from the priors' means as these allow, fitted many times: errors over
/// predicted standard errors have a mean square of 1.
#[test]
fn law_predicted_errors_are_those_of_many_fits() {
    let forces = forces(KVLCC2);
    let (truth, inputs) = (forces.nominal(), inputs(240));
    let noise = Noise { measurement: NOISE, current: 0.0 };
    let priors: Vec<f64> = forces.parameters().iter().map(|own| own.prior.unwrap()).collect();
    let known: Vec<f64> = priors.iter().map(|own| 1.0 / (own * own)).collect();
    let free = vec![true; truth.len()];
    let information = run(&inputs).information(&forces, &truth, &noise).unwrap();
    let predicted = information.errors(&known, &free).unwrap().covariance;
    let undisturbed = states(&forces, &truth, &inputs, &[]);
    let (mut normals, mut ratios) = (Normals::new(11), Vec::new());
    let mut squares = vec![0.0; truth.len()];
    let fits = 60;
    for _ in 0..fits {
        let measured: Vec<f64> = undisturbed
            .iter()
            .flat_map(|own| [0, 1, 2].map(|d| own[d] + NOISE[d] * normals.next()))
            .collect();
        let drawn = truth.iter().zip(&priors).map(|(own, deviation)| {
            Some(Prior { mean: own + deviation * normals.next(), deviation: *deviation })
        });
        let drawn: Vec<Option<Prior>> = drawn.collect();
        let own = MeasuredRun { run: run(&inputs), measured: &measured, noise: NOISE };
        let theta = own.most_probable(&forces, &drawn, &truth).unwrap();
        let n = truth.len();
        for i in 0..n {
            squares[i] += (theta[i] - truth[i]).powi(2) / predicted[i * n + i];
        }
    }
    for (own, parameter) in squares.iter().zip(forces.parameters()) {
        ratios.push(((own / f64::from(fits)).sqrt(), &parameter.name));
    }
    let mean = ratios.iter().map(|own| own.0 * own.0).sum::<f64>() / ratios.len() as f64;
    println!("{mean} {ratios:?}");
    // Of 60 fits a root mean square has a standard deviation of 9 %.
    assert!((mean.sqrt() - 1.0).abs() < 0.09, "{mean} {ratios:?}");
    assert!(ratios.iter().all(|own| (own.0 - 1.0).abs() < 0.36), "{ratios:?}");
}
