//! The likelihood of noise against the covariance of all samples.

use estimation::criticism::{NoiseKind, Subject, restricted_likelihood};
use numerics::{dot, log_det, solve};
use ship::engine::{Compiled, RunView};
use ship::model::{Model, Source, Vessel};

const RATE_HZ: f64 = 8.0;
const SAMPLES: usize = 14;
const INITIAL: [f64; 3] = [0.6, 0.05, 0.1];

/// A short run that the path of a free simulation does not follow exactly.
fn run(model: &Model, theta: &[f64]) -> (Vec<f64>, Vec<f64>) {
    let wave = |k: usize, by: f64| (by * k as f64).sin();
    let inputs = |k: usize| [2000.0, 900.0, 400.0].map(|size: f64| size * wave(k + 1, 0.2 + 1e-4 * size));
    let exogenous: Vec<f64> = (0..SAMPLES).flat_map(inputs).collect();
    let states = ship::engine::simulate_one(model, theta, INITIAL, &exogenous);
    let off = |(i, x): (usize, f64)| x + 0.05 * wave(i * i + 3, 1.7);
    (states.into_iter().enumerate().map(off).collect(), exogenous)
}

/// A random draw, in units of its standard deviation.
#[derive(Clone, Copy, PartialEq)]
enum Draw {
    Noise(usize, usize),
    Start(usize),
    /// Of the current, of forces or of sensors, before a sample.
    Water(usize, usize),
    Push(usize, usize),
    Sensor(usize, usize),
}

fn draws(kind: NoiseKind) -> Vec<Draw> {
    use NoiseKind::{Current, Forces, ForcesAndCurrent, ForcesEach, Sensors, White};
    let steps = |count: usize| (0..=SAMPLES).flat_map(move |k| (0..count).map(move |d| (k, d)));
    let mut all: Vec<Draw> = steps(3).map(|(k, d)| Draw::Noise(k, d)).collect();
    all.extend((0..3).map(Draw::Start));
    if matches!(kind, White | Current | ForcesAndCurrent) {
        all.extend(steps(2).map(|(k, d)| Draw::Water(k, d)));
    }
    if matches!(kind, Forces | ForcesEach | ForcesAndCurrent) {
        all.extend(steps(3).map(|(k, d)| Draw::Push(k, d)));
    }
    if kind == Sensors {
        all.extend(steps(3).map(|(k, d)| Draw::Sensor(k, d)));
    }
    all
}

/// The model linearised about a free simulation.
struct Line {
    states: Vec<[f64; 3]>,
    /// By sample the derivatives of the next state by the state, and the terms.
    slopes: Vec<[[f64; 3]; 3]>,
    terms: Vec<Vec<f64>>,
    /// The degree of freedom of every term.
    degrees: Vec<usize>,
}

impl Line {
    fn new(model: &Model, theta: &[f64], exogenous: &[f64]) -> Self {
        let states = ship::engine::simulate_one(model, theta, INITIAL, exogenous).as_chunks::<3>().0.to_vec();
        let mut compiled = Compiled::<f64>::new(model, theta);
        let (mut slopes, mut terms) = (Vec::new(), Vec::new());
        for (state, row) in states.iter().zip(exogenous.chunks_exact(3)) {
            compiled.look(*state, row, None);
            terms.push((0..theta.len()).map(|i| compiled.term(i)).collect());
            slopes.push(compiled.slopes());
        }
        Self { states, slopes, terms, degrees: model.layout().degrees().collect() }
    }
}

/// A kind of noise with its levels.
#[derive(Clone, Copy)]
struct NoiseModel {
    kind: NoiseKind,
    noise: [f64; 3],
    /// Standard deviations of forces or sensors, and their times.
    three: [f64; 3],
    times: [f64; 3],
    current: f64,
    /// Of a current that drifts.
    current_time: Option<f64>,
}

/// The response of all measurements to a draw, or to a unit of a parameter, by propagation through all samples.
#[allow(clippy::needless_range_loop)] // Several arrays at once.
fn response(line: &Line, levels: &NoiseModel, drawn: Option<Draw>, parameter: Option<usize>) -> Vec<f64> {
    use NoiseKind::{Forces, ForcesAndCurrent, ForcesEach, Sensors};
    let NoiseModel { kind, noise, three: std, times, current: flow, current_time: time } = *levels;
    let unit = |own: Draw| if drawn == Some(own) { 1.0 } else { 0.0 };
    let keep = |time: f64| (-1.0 / (RATE_HZ * time)).exp();
    let next = |before: f64, k: usize, std: f64, keep: f64, drawn: f64| {
        keep * before + std * if k == 0 { drawn } else { (1.0 - keep * keep).sqrt() * drawn }
    };
    let mut x: [f64; 3] = [0, 1, 2].map(|d| 1e3 * noise[d] * unit(Draw::Start(d)));
    let (mut water, mut push, mut sensor, mut heading) = ([0.0; 2], [0.0; 3], [0.0; 3], 0.0_f64);
    let mut out = Vec::new();
    for k in 0..=SAMPLES {
        for d in 0..3 {
            if matches!(kind, Forces | ForcesEach | ForcesAndCurrent) {
                push[d] = next(push[d], k, std[d], keep(times[d]), unit(Draw::Push(k, d)));
            }
            if kind == Sensors {
                sensor[d] = next(sensor[d], k, std[d], keep(times[d]), unit(Draw::Sensor(k, d)));
            }
            out.push(x[d] + sensor[d] + noise[d] * unit(Draw::Noise(k, d)));
        }
        if k == SAMPLES {
            break;
        }
        for d in 0..2 {
            water[d] = next(water[d], k, flow, time.map_or(0.0, keep), unit(Draw::Water(k, d)));
        }
        let (sin, cos) = if time.is_some() { heading.sin_cos() } else { (0.0, 1.0) };
        let body = [cos * water[0] + sin * water[1], cos * water[1] - sin * water[0]];
        let mut moved = x;
        for d in 0..3 {
            let j = line.slopes[k][d];
            moved[d] += j[0] * (x[0] - body[0]) + j[1] * (x[1] - body[1]) + j[2] * x[2] + push[d];
        }
        if let Some(i) = parameter {
            moved[line.degrees[i]] += line.terms[k][i];
        }
        heading += line.states[k][2] / RATE_HZ;
        x = moved;
    }
    out
}

/// Twice the restricted log-likelihood of all samples after the first, from their covariance.
#[allow(clippy::needless_range_loop)] // Cholesky's, of rows and columns.
fn dense(line: &Line, measured: &[f64], levels: &NoiseModel) -> f64 {
    let p = line.degrees.len();
    let n = 3 * (SAMPLES + 1);
    let columns: Vec<Vec<f64>> =
        draws(levels.kind).into_iter().map(|draw| response(line, levels, Some(draw), None)).collect();
    let mut lower = vec![0.0; n * n];
    for i in 0..n {
        for j in 0..=i {
            let covariance: f64 = columns.iter().map(|own| own[i] * own[j]).sum();
            let left = covariance - (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum::<f64>();
            lower[i * n + j] = if i == j { left.sqrt() } else { left / lower[j * n + j] };
        }
    }
    let white = |mut own: Vec<f64>| {
        for i in 0..n {
            let before: f64 = (0..i).map(|k| lower[i * n + k] * own[k]).sum();
            own[i] = (own[i] - before) / lower[i * n + i];
        }
        own.split_off(3)
    };
    let errors = white(measured.iter().zip(line.states.as_flattened()).map(|(y, x)| y - x).collect());
    let slopes: Vec<Vec<f64>> = (0..p).map(|i| white(response(line, levels, None, Some(i)))).collect();
    let mut normal: Vec<f64> = (0..p * p).map(|k| dot(&slopes[k / p], &slopes[k % p])).collect();
    let gradient: Vec<f64> = slopes.iter().map(|own| dot(own, &errors)).collect();
    let volume = log_det(p, &mut normal.clone()).unwrap().log_abs;
    let mut solved = gradient.clone();
    solve(p, &mut normal, &mut solved).unwrap();
    let logs: f64 = (3..n).map(|i| lower[i * n + i].ln()).sum();
    -2.0 * logs - (dot(&errors, &errors) - dot(&gradient, &solved)) - volume
}

#[test]
fn oracle_the_restricted_likelihood_is_that_of_the_whole_covariance() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let model = vessel.model.with_intercepts();
    let theta = model.layout().woven(&vessel.parameters(Source::Value).unwrap(), [1e-3, 0.0, -1e-3]);
    let (measured, exogenous) = run(&model, &theta);
    let view = RunView {
        measured: &measured,
        instrument_exogenous: &exogenous,
        exogenous: &exogenous,
        initial: INITIAL,
    };
    let subject = Subject {
        model: &model,
        runs: &[view],
        rate_hz: RATE_HZ,
        known_start: false,
        levels: None,
        names: &[],
        signs: &[],
    };
    let line = Line::new(&model, &theta, &exogenous);
    let noise = [0.03, 0.05, 0.04];
    let still = NoiseModel {
        kind: NoiseKind::White,
        noise,
        three: [0.0; 3],
        times: [0.0; 3],
        current: 0.0,
        current_time: None,
    };
    let forces = NoiseModel { three: [0.02, 0.01, 0.03], times: [0.4; 3], ..still };
    let flow = |of: NoiseModel| NoiseModel { current: 0.1, current_time: Some(0.7), ..of };
    for (own, more) in [
        (NoiseModel { current: 0.2, ..still }, &[0.2][..]),
        (NoiseModel { kind: NoiseKind::Current, ..flow(still) }, &[0.1, 0.7]),
        (NoiseModel { kind: NoiseKind::Forces, ..forces }, &[0.02, 0.01, 0.03, 0.4]),
        (
            NoiseModel { kind: NoiseKind::ForcesEach, times: [0.4, 2.0, 0.2], ..forces },
            &[0.02, 0.01, 0.03, 0.4, 2.0, 0.2],
        ),
        (
            NoiseModel { kind: NoiseKind::Sensors, three: [0.05, 0.02, 0.03], times: [0.6; 3], ..still },
            &[0.05, 0.02, 0.03, 0.6],
        ),
        (
            NoiseModel { kind: NoiseKind::ForcesAndCurrent, ..flow(forces) },
            &[0.02, 0.01, 0.03, 0.4, 0.1, 0.7],
        ),
    ] {
        let found = restricted_likelihood(&subject, &theta, own.kind, &[&noise, more].concat());
        let wanted = dense(&line, &measured, &own);
        assert!((found - wanted).abs() < 2e-5 * wanted.abs(), "{:?}: {found} {wanted}", own.kind);
    }
}
