//! Models of many sizes, for which no structure is compiled, against explicit sums.

use std::collections::BTreeMap;

use regression::{Batch, MeanRemoval, Outcome};
use ship::model::{Degree, Factor, Model, Product, Term, Variable};

use crate::support::explicit::{Regression, solve};
use crate::support::noise::Normals;
use crate::support::{Recording, SideBySide, estimate};

const NAMES: [&str; 5] = ["u", "v", "r", "n", "delta"];

/// Terms of surge, sway and yaw. States before and after terms of inputs alone; more terms than are multiplied at
/// once; inputs only.
const MODELS: [[&[&str]; 3]; 3] = [
    [
        &["u", "u |u|", "v r", "r^2", "v |v|", "n", "delta"],
        &["v", "delta"],
        &["r", "u v", "u", "u r", "|r| r", "n v"],
    ],
    [&["n", "u"], &["v", "u r", "n |n|", "delta", "n delta"], &["delta", "n"]],
    [&["u", "u^2 |v| delta", "r |r|", "v r", "|n| n u"], &["v", "u r", "v |v|", "u v", "delta"], &["r"]],
];

pub fn model(terms: [&[&str]; 3]) -> Model {
    let degrees = terms.map(|texts| {
        Degree::new(
            texts.iter().map(|text| (*text).to_owned()).collect(),
            texts.iter().map(|text| Term::parse(text, &NAMES).unwrap()).collect(),
        )
    });
    let variable = |name: &&str| Variable { name: (*name).to_owned(), unit: String::new() };
    let variables = NAMES.iter().map(variable).collect();
    Model {
        variables,
        inputs: 2,
        simulated: BTreeMap::new(),
        roles: BTreeMap::new(),
        derived: Vec::new(),
        degrees,
        constant: [0.0; 3],
        forces: None,
        pace: ship::model::RateChange::Own,
    }
}

/// Random numbers; instruments that are close to the measured states.
fn recordings(samples: usize, runs: usize, shared: bool) -> Vec<Recording> {
    let mut normals = Normals::new(7);
    let mut some = |count: usize| (0..count).map(|_| normals.next()).collect::<Vec<f64>>();
    let (states, inputs) = (some(3 * (samples + 1)), some(2 * samples));
    (0..runs)
        .map(|_| {
            let own = if shared { states.clone() } else { some(states.len()) };
            let measured = own.iter().zip(some(own.len())).map(|(own, noise)| own + 0.2 * noise).collect();
            let exogenous = if shared { inputs.clone() } else { some(inputs.len()) };
            Recording { measured, instrument_states: own, exogenous, segments: vec![0, 20] }
        })
        .collect()
}

/// A product of factors at a state and inputs.
fn product(factors: &[Factor], row: &[f64]) -> f64 {
    let own = |f: &Factor| if f.modulus { row[f.variable].abs() } else { row[f.variable] };
    factors.iter().map(own).product()
}

/// Δy of a degree of freedom less its known part, on its terms.
fn regression(model: &Model, run: &Recording, d: usize) -> Regression {
    let degree = &model.degrees[d];
    let at =
        |states: &[f64], k: usize| [&states[3 * k..3 * k + 3], &run.exogenous[2 * k..2 * k + 2]].concat();
    let terms = |row: Vec<f64>| degree.terms.iter().map(|term| product(&term.factors, &row)).collect();
    let known = |row: Vec<f64>| -> f64 {
        let own = degree.known.iter().map(|known| known.coefficient * product(&known.factors, &row));
        model.constant[d] + own.sum::<f64>()
    };
    let change = |k: usize| run.measured[3 * (k + 1) + d] - run.measured[3 * k + d];
    let samples = 0..run.samples();
    Regression {
        phi: samples.clone().map(|k| terms(at(&run.measured, k))).collect(),
        zeta: samples.clone().map(|k| terms(at(&run.instrument_states, k))).collect(),
        target: samples.map(|k| change(k) - known(at(&run.measured, k))).collect(),
    }
}

/// −2 log likelihood of a moving average of order one with σ² at its most likely value, which comes second, by
/// Cholesky's decomposition of its covariance, tridiagonal with 1 + θ² and θ.
fn likelihood(sequence: &[f64], theta: f64) -> (f64, f64) {
    let (mut pivot, mut white) = (f64::INFINITY, 0.0);
    let (mut log_det, mut squares) = (0.0, 0.0);
    for own in sequence {
        white = own - theta / pivot * white;
        pivot = 1.0 + theta * theta - theta * theta / pivot;
        log_det += pivot.ln();
        squares += white * white / pivot;
    }
    let variance = squares / sequence.len() as f64;
    (sequence.len() as f64 * variance.ln() + log_det, variance)
}

/// Its autocovariances: the best of 2000 θ, and of 2000 about it.
fn likeliest_moving_average(sequence: &[f64]) -> [f64; 2] {
    let best = |middle: f64, half: f64| {
        let all = (-1000..=1000).map(|i| (middle + half * f64::from(i) / 1000.0).clamp(-1.0, 1.0));
        all.min_by(|a, b| likelihood(sequence, *a).0.total_cmp(&likelihood(sequence, *b).0)).unwrap()
    };
    let theta = best(best(0.0, 1.0), 2e-3);
    let variance = likelihood(sequence, theta).1;
    [variance * (1.0 + theta * theta), variance * theta]
}

/// Parameters of a degree of freedom and their standard errors, by definition: see [`regression::Instruments`].
fn by_definition(model: &Model, run: &Recording, d: usize, groups: &[usize]) -> (Vec<f64>, Vec<f64>) {
    let mut lifted = regression(model, run, d);
    lifted.lift(groups);
    let (found, p) = (lifted.solve(), model.degrees[d].terms.len());
    let residual = |(phi, target): (&Vec<f64>, &f64)| {
        target - phi.iter().zip(&found).map(|(phi, theta)| phi * theta).sum::<f64>()
    };
    let residuals: Vec<f64> = lifted.phi.iter().zip(&lifted.target).map(residual).collect();
    let freedom = (residuals.len() - found.len()) as f64;
    let [gamma0, gamma1] =
        likeliest_moving_average(&residuals).map(|gamma| gamma * residuals.len() as f64 / freedom);
    let mut centred = regression(model, run, d);
    centred.subtract_instrument_means(groups);
    let matrix = |entry: &dyn Fn(usize, usize) -> f64| -> Vec<Vec<f64>> {
        (0..p).map(|i| (0..p).map(|j| entry(i, j)).collect()).collect()
    };
    let zeta = &centred.zeta;
    let a = matrix(&|i, j| zeta.iter().zip(&centred.phi).map(|(zeta, phi)| zeta[i] * phi[j]).sum());
    let meat = matrix(&|i, j| {
        let own = zeta.iter().map(|z| z[i] * z[j]).sum::<f64>();
        let neighbours = zeta.windows(2).map(|z| z[0][i] * z[1][j] + z[1][i] * z[0][j]).sum::<f64>();
        gamma0 * own + gamma1 * neighbours
    });
    let columns: Vec<Vec<f64>> =
        (0..p).map(|j| solve(a.clone(), (0..p).map(|i| if i == j { 1.0 } else { 0.0 }).collect())).collect();
    let variance = |i: usize| -> f64 {
        let pairs = (0..p).flat_map(|k| (0..p).map(move |l| (k, l)));
        pairs.map(|(k, l)| columns[k][i] * meat[k][l] * columns[l][i]).sum()
    };
    (found[..p].to_vec(), (0..p).map(|i| variance(i).sqrt()).collect())
}

fn check(model: &Model, runs: &[Recording], removal: MeanRemoval, outcomes: &[Outcome]) {
    let groups: &[usize] = match removal {
        MeanRemoval::None => &[],
        MeanRemoval::Batch => &[0, 20],
        MeanRemoval::Complete => &[0],
    };
    for (run, outcome) in runs.iter().zip(outcomes) {
        let Outcome::Identified(found) = outcome else { panic!("{outcome:?}") };
        let mut first = 0;
        for d in 0..3 {
            let (theta, errors) = by_definition(model, run, d, groups);
            for (i, (theta, error)) in theta.into_iter().zip(errors).enumerate() {
                let tolerance = 1e-8 * error;
                let (own, own_error) = (found.parameters[first + i], found.standard_errors[first + i]);
                assert!((own - theta).abs() < tolerance, "{removal:?} {d} {i}: {own}, expected {theta}");
                assert!(
                    (own_error - error).abs() < 1e-5 * error,
                    "{removal:?} {d} {i}: {own_error}, expected {error}"
                );
            }
            first += model.degrees[d].terms.len();
        }
    }
}

/// Estimates runs in lanes, with own or shared instruments, and compares each with its definition.
fn check_model(model: &Model, removals: &[MeanRemoval]) {
    for (samples, removal) in [64, 75, 130].into_iter().flat_map(|n| removals.iter().map(move |r| (n, *r))) {
        let runs = recordings(samples, 3, false);
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        check(model, &runs, removal, &estimate(&side_by_side.batch(model), removal));
        let runs = recordings(samples, 3, true);
        let side_by_side = SideBySide::new(&runs.iter().collect::<Vec<_>>());
        let own = side_by_side.batch(model);
        let (instrument_states, exogenous) = (&runs[0].instrument_states, &runs[0].exogenous);
        let shared = Batch {
            model,
            measured: own.measured,
            instrument_states,
            instrument_exogenous: exogenous,
            exogenous,
            segments: own.segments,
        };
        let found = estimate(&shared, removal);
        check(model, &runs, removal, &found);
        assert_eq!(format!("{found:?}"), format!("{:?}", estimate(&own, removal)));
    }
}

#[test]
fn law_estimates_by_any_model_are_those_of_their_definition() {
    for terms in MODELS {
        check_model(&model(terms), &[MeanRemoval::Complete, MeanRemoval::Batch, MeanRemoval::None]);
    }
}

#[test]
fn law_what_is_known_of_any_model_is_subtracted_first() {
    let mut model = model([&["u", "v r", "n"], &["v", "1"], &["r", "delta"]]);
    model.constant[0] = 0.3;
    let u_v = Term::parse("u |v|", &NAMES).unwrap().factors;
    model.degrees[2].known.push(Product { coefficient: 0.7, factors: u_v });
    check_model(&model, &[MeanRemoval::None]);
}
