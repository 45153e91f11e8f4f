//! A compiled model against its written terms.

use std::collections::BTreeMap;

use numerics::{LANES, Lane};
use ship::engine::{Ambient, Compiled};
use ship::model::{Degree, Factor, Model, Term, Variable};

const NAMES: [&str; 5] = ["u", "v", "r", "n", "delta"];
const AT: [f64; 5] = [-0.7, 0.3, 0.2, 5.0, -0.4];

fn model() -> Model {
    let degree = |texts: &[&str]| {
        Degree::new(
            texts.iter().map(|t| (*t).to_owned()).collect(),
            texts.iter().map(|t| Term::parse(t, &NAMES).unwrap()).collect(),
        )
    };
    let degrees = [
        degree(&["u", "u |u|", "u^2 |v| delta", "n |n|", "r", "|delta| |v| v^3"]),
        degree(&["v r", "delta", "|u| |r| r^2"]),
        degree(&["|r| r u", "|n| n u"]),
    ];
    let variable = |name: &&str| Variable { name: (*name).to_owned(), unit: String::new() };
    let (simulated, derived) = (BTreeMap::new(), Vec::new());
    let variables = NAMES.iter().map(variable).collect();
    Model {
        variables,
        inputs: 2,
        simulated,
        roles: BTreeMap::new(),
        derived,
        degrees,
        constant: [0.0; 3],
        forces: None,
        pace: ship::model::RateChange::Own,
    }
}

fn theta() -> Vec<f64> {
    (1..=11).map(f64::from).collect()
}

/// The terms in order, factor by factor.
fn terms(x: &[f64]) -> Vec<f64> {
    let scalar = |f: &Factor| if f.modulus { x[f.variable].abs() } else { x[f.variable] };
    let model = model();
    let all = model.degrees.iter().flat_map(|d| &d.terms);
    all.map(|term| term.factors.iter().map(scalar).product()).collect()
}

fn increments(x: &[f64]) -> [f64; 3] {
    let weighted: Vec<f64> = terms(x).iter().zip(theta()).map(|(t, p)| t * p).collect();
    [&weighted[..6], &weighted[6..9], &weighted[9..]].map(|own| own.iter().sum())
}

fn at<'m>(model: &'m Model, x: &[f64]) -> Compiled<'m, f64> {
    let mut compiled = Compiled::new(model, &theta());
    compiled.look([x[0], x[1], x[2]], &x[3..], None);
    compiled
}

/// Of `f` by variable `z`.
fn quotient(f: impl Fn(&[f64]) -> f64, z: usize) -> f64 {
    let (mut high, mut low) = (AT, AT);
    high[z] += 1e-5;
    low[z] -= 1e-5;
    (f(&high) - f(&low)) / 2e-5
}

#[test]
fn law_terms_and_increments_are_those_of_the_written_terms_for_one_run_and_for_many() {
    let (model, expected) = (model(), increments(&AT));
    let one = at(&model, &AT);
    let lanes: Vec<Lane> = theta().into_iter().map(Lane::splat).collect();
    let mut many = Compiled::new(&model, &lanes);
    for _ in 0..2 {
        many.look([AT[0], AT[1], AT[2]].map(Lane::splat), &AT[3..], None);
    }
    for d in 0..3 {
        approx::assert_relative_eq!(one.increments()[d], expected[d], max_relative = 1e-14);
        assert_eq!(many.increments()[d][LANES - 1], one.increments()[d]);
    }
    for (i, term) in terms(&AT).into_iter().enumerate() {
        approx::assert_relative_eq!(one.term(i), term, max_relative = 1e-14);
    }
}

#[test]
fn law_a_step_adds_increments_at_the_speed_through_water_and_the_force() {
    let model = model();
    let (current, force) = ([0.2, -0.1], [3.0, 2.0, 1.0]);
    let state = [AT[0] + current[0], AT[1] + current[1], AT[2]];
    let ambient = Ambient { current: Some(current), force: Some(force) };
    let next = Compiled::new(&model, &theta()).step(state, &AT[3..], ambient);
    for (d, expected) in increments(&AT).into_iter().enumerate() {
        approx::assert_relative_eq!(next[d], state[d] + expected + force[d], max_relative = 1e-13);
    }
}

#[test]
fn law_slopes_are_the_difference_quotients_of_increments() {
    let model = model();
    let mut compiled = at(&model, &AT);
    let (slopes, mut gradients) = (compiled.slopes(), [[0.0; 3]; 5]);
    compiled.gradients(&mut gradients);
    for z in 0..5 {
        for d in 0..3 {
            let expected = quotient(|x| increments(x)[d], z);
            approx::assert_relative_eq!(gradients[z][d], expected, max_relative = 1e-7, epsilon = 1e-8);
            assert!(z > 2 || gradients[z][d] == slopes[d][z]);
        }
    }
}

#[test]
fn law_transposed_products_are_the_difference_quotients_of_what_they_weigh() {
    let model = model();
    let weights: Vec<f64> = (0..11).map(|i| 0.3 - 0.1 * f64::from(i)).collect();
    let seconds = [[1.2, -0.8, 0.5], [0.1, 0.7, -0.4], [-0.9, 0.6, 0.2]];
    let weighed = |x: &[f64]| -> f64 {
        let slopes = at(&model, x).slopes();
        let first: f64 = terms(x).iter().zip(&weights).map(|(t, w)| t * w).sum();
        first + (0..9).map(|e| slopes[e / 3][e % 3] * seconds[e / 3][e % 3]).sum::<f64>()
    };
    let mut out = [0.0; 5];
    at(&model, &AT).pull_back(&weights, &seconds, &mut out);
    for (z, found) in out.into_iter().enumerate() {
        approx::assert_relative_eq!(found, quotient(weighed, z), max_relative = 1e-7, epsilon = 1e-7);
    }
}
