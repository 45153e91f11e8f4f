//! Random numbers depend on their keys alone.

use numerics::{GROUPS, LANES, Lane, Wide};
use ship::engine::{
    Axes, Current, Disturbances, Driven, Measurement, Recording, Streams, Weather, Wind, simulate,
    simulate_disturbed,
};
use ship::model::Vessel;

fn draws(seed: u64, purpose: &str, run: u32, channel: u32, count: usize) -> Vec<f64> {
    let mut out = vec![0.0; count];
    Streams::new(seed, purpose).normals(run, channel, &mut out);
    out
}

#[test]
fn law_normals_have_the_moments_of_the_normal_distribution() {
    let x = draws(1, "a", 0, 0, 200_000);
    let mean = |power: i32| x.iter().map(|v| v.powi(power)).sum::<f64>() / x.len() as f64;
    // Four Monte Carlo standard errors each.
    for (power, expected, variance) in [(1, 0.0, 1.0), (2, 1.0, 2.0), (3, 0.0, 15.0), (4, 3.0, 96.0)] {
        let tolerance = 4.0 * f64::sqrt(variance / x.len() as f64);
        assert!((mean(power) - expected).abs() < tolerance, "moment {power}: {}", mean(power));
    }
    let neighbours: f64 = x.windows(2).map(|p| p[0] * p[1]).sum::<f64>() / x.len() as f64;
    assert!(neighbours.abs() < 4.0 / (x.len() as f64).sqrt());
}

/// The normal distribution function: a series near zero, a continued fraction in the tails.
fn normal_cdf(x: f64) -> f64 {
    let density = (-0.5 * x * x).exp() / std::f64::consts::TAU.sqrt();
    if x.abs() < 4.0 {
        let (mut term, mut sum) = (x, x);
        for k in 1..100 {
            term *= x * x / f64::from(2 * k + 1);
            sum += term;
        }
        return 0.5 + density * sum;
    }
    let fraction = (1..200).rev().fold(x.abs(), |below, k| x.abs() + f64::from(k) / below);
    if x < 0.0 { density / fraction } else { 1.0 - density / fraction }
}

#[test]
fn law_normals_follow_the_normal_distribution_into_its_tails() {
    let mut x = draws(5, "a", 1, 0, 2_000_000);
    x.sort_by(f64::total_cmp);
    let n = x.len() as f64;
    let distance = x
        .iter()
        .enumerate()
        .map(|(i, x)| (normal_cdf(*x) - i as f64 / n).abs().max((normal_cdf(*x) - (i + 1) as f64 / n).abs()))
        .fold(0.0, f64::max);
    // Kolmogorov's distribution: beyond 2.2/sqrt(n) once in 8000.
    assert!(distance < 2.2 / n.sqrt(), "{distance}");
    for bound in [2.0, 3.0, 4.0, 4.5] {
        let expected = n * normal_cdf(-bound);
        for count in [
            x.iter().filter(|x| **x < -bound).count() as f64,
            x.iter().filter(|x| **x > bound).count() as f64,
        ] {
            assert!((count - expected).abs() < 4.0 * expected.sqrt(), "{bound}: {count} of {expected}");
        }
    }
}

/// The two numbers of a pair, and consecutive ones: not even their squares are correlated.
#[test]
fn law_neighbouring_normals_and_channels_are_independent() {
    let (x, y) = (draws(6, "a", 1, 0, 400_000), draws(6, "a", 1, 1, 400_000));
    let n = x.len() as f64;
    let related = |pairs: &mut dyn Iterator<Item = (f64, f64)>| {
        let (mut plain, mut squares) = (0.0, 0.0);
        for (a, b) in pairs {
            plain += a * b;
            squares += (a * a - 1.0) * (b * b - 1.0);
        }
        (plain / n.sqrt(), squares / (2.0 * n.sqrt()))
    };
    for lag in 1..=4 {
        let (plain, squares) = related(&mut x.iter().copied().zip(x[lag..].iter().copied()));
        assert!(plain.abs() < 4.0 && squares.abs() < 4.0, "lag {lag}: {plain}, {squares}");
    }
    let (plain, squares) = related(&mut x.iter().copied().zip(y.iter().copied()));
    assert!(plain.abs() < 4.0 && squares.abs() < 4.0, "channels: {plain}, {squares}");
}

#[test]
fn law_streams_differ_by_seed_purpose_run_and_channel_and_by_nothing_else() {
    let reference = draws(1, "a", 2, 3, 1000);
    assert_eq!(reference, draws(1, "a", 2, 3, 1000));
    assert_eq!(reference[..10], draws(1, "a", 2, 3, 10)[..]);
    for other in [
        draws(2, "a", 2, 3, 1000),
        draws(1, "b", 2, 3, 1000),
        draws(1, "a", 3, 3, 1000),
        draws(1, "a", 2, 2, 1000),
    ] {
        let correlation: f64 = reference.iter().zip(&other).map(|(a, b)| a * b).sum::<f64>() / 1000.0;
        assert!(correlation.abs() < 4.0 / 1000.0_f64.sqrt(), "{correlation}");
    }
}

#[test]
fn law_a_runs_noise_does_not_depend_on_its_neighbours() {
    let white = Disturbances {
        current: Current::White { std_m_s: 0.5 },
        measurement: Measurement { std_u_m_s: 0.1, std_v_m_s: 0.0, std_r_rad_s: 0.3 },
    };
    let streams = Streams::new(7, "x");
    let measured = |runs: [u32; LANES]| {
        let mut states = vec![Lane::ZERO; 3 * 101];
        white.measure(&streams, runs, &mut states);
        (white.current(&streams, runs, 100, 8.0), states)
    };
    let (one, other) = (measured([5; LANES]), measured([0, 1, 2, 3, 4, 5, 6, 7]));
    let alone = draws(7, "x", 5, 2, 101);
    assert!(
        one.1.chunks(3).zip(&alone).all(|(row, alone)| row[2][0] == 0.3 * alone),
        "with any instruction set"
    );
    assert!(one.0.iter().zip(&other.0).all(|(a, b)| a[0] == b[5]));
    assert!(one.1.iter().zip(&other.1).all(|(a, b)| a[0] == b[5]));
    assert!(
        one.1.iter().skip(1).step_by(3).all(|v| *v == Lane::ZERO),
        "no noise where its deviation is zero"
    );
}

#[test]
fn law_choices_are_equally_likely() {
    let draws = Streams::new(3, "x").choices(0, 0, 11, 110_000);
    for value in 0..11 {
        let count = draws.iter().filter(|d| **d == value).count() as f64;
        assert!((count - 10_000.0).abs() < 4.0 * 10_000.0_f64.sqrt(), "{value}: {count}");
    }
}

#[test]
fn law_runs_that_are_simulated_at_once_are_those_of_one_group_after_the_other() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let theta: Vec<Lane> = vessel.nominal.iter().copied().map(Lane::splat).collect();
    let (initial, inputs) = ([0.5, 0.0, 0.1], vec![120.0; 3 * 64]);
    let current = Current::GaussMarkov { std_m_s: 0.3, time_constant_s: 5.0, axes: Axes::Earth };
    let measurement = Measurement { std_u_m_s: 0.1, std_v_m_s: 0.0, std_r_rad_s: 0.2 };
    let disturbances = Disturbances { current, measurement };
    let gusts =
        Wind { std_surge_m_s2: 0.01, std_sway_m_s2: 0.02, std_yaw_rad_s2: 0.0, time_constant_s: Some(3.0) };
    let streams = Streams::new(3, "x");
    // Blocks that end inside, at and after the last sample, odd and even.
    for samples in [50, 31, 32, 33, 64, 1] {
        let numbers: [[u32; LANES]; GROUPS] =
            std::array::from_fn(|group| std::array::from_fn(|lane| (LANES * group + lane) as u32));
        let buffers =
            || [const { Vec::new() }; GROUPS].map(|_: Vec<Lane>| vec![Lane::ZERO; 3 * (samples + 1)]);
        let (mut truth, mut measured) = (buffers(), buffers());
        let mut recordings = Vec::new();
        for ((numbers, truth), measured) in numbers.iter().zip(&mut truth).zip(&mut measured) {
            let disturbing = disturbances.of_runs(Some(&gusts), &streams, *numbers, 8.0);
            recordings.push(Recording { disturbing, truth, measured });
        }
        let recordings = recordings.try_into().unwrap_or_else(|_| panic!("as many as groups"));
        let driven = Driven::SharedInputs(&inputs[..3 * samples]);
        simulate_disturbed::<GROUPS>(&vessel.model, &theta, initial.map(Wide::from), driven, recordings);
        for ((numbers, truth), measured) in numbers.iter().zip(&truth).zip(&measured) {
            let current = disturbances.current(&streams, *numbers, samples, 8.0);
            let force = gusts.force(&streams, *numbers, samples, 8.0);
            let weather = Weather { current: &current, turning: 0.125, force: &force };
            let mut alone = vec![Lane::ZERO; 3 * (samples + 1)];
            let inputs = &inputs[..3 * samples];
            simulate(&vessel.model, &theta, initial.map(Lane::splat), inputs, &weather, &mut alone);
            assert!(*truth == alone, "{samples}");
            disturbances.measure(&streams, *numbers, &mut alone);
            assert!(*measured == alone, "{samples}");
        }
        assert!(truth[0] != truth[1]);
    }
}
