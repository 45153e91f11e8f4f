//! Runs that are stepped in lanes, and in place, against single runs.

use numerics::{LANES, Lane, Wide};
use ship::engine::{Ambient, Compiled, Stepping};
use ship::model::{Model, Term, Vessel};

/// The model ship with products of inputs and of more than two factors, a constant, and a known term.
fn model() -> Model {
    let file = "preset = \"ljungberg-model-ship\"".parse().unwrap();
    let mut model = Vessel::from_file(file).unwrap().model;
    let names: Vec<String> = model.variables.iter().map(|variable| variable.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let parsed = |texts: &[&str]| texts.iter().map(|text| Term::parse(text, &names).unwrap()).collect();
    let terms: [&[&str]; 3] = [
        &["u", "u |u|", "v r", "|tau1| tau1", "tau2", "tau1"],
        &["tau2", "v", "u r", "v |v|", "u |u| tau3"],
        &["r", "u v", "1", "u^2 |tau1| r", "tau3", "|v| r"],
    ];
    model.degrees.iter_mut().zip(terms).for_each(|(degree, texts)| degree.terms = parsed(texts));
    model.constant[1] = 0.25;
    let factors = model.degrees[0].terms[1].factors.clone();
    model.degrees[2].known.push(ship::model::Product { coefficient: -0.5, factors });
    model
}

/// Numbers between -1 and 1, some of them zero, always the same at a place.
fn number(i: usize) -> f64 {
    let mixed = (i as u64).wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
    let value = ((mixed ^ (mixed >> 29)) >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
    if value.abs() < 0.05 { 0.0 } else { value }
}

/// States of 200 samples as bits; `x` gives the number of a place.
fn steps<X: Stepping>(model: &Model, x: impl Fn(usize) -> X, bits: impl Fn(X) -> u64) -> Vec<[u64; 3]> {
    let parameters: Vec<X> = (0..17).map(&x).collect();
    let mut compiled = Compiled::new(model, &parameters);
    let mut state = [20, 21, 22].map(&x);
    let mut states = Vec::new();
    for k in 0..200 {
        let own = |i: usize| x(100 + 20 * k + i);
        let (exogenous, current, force) = ([0, 1, 2].map(own), [3, 4].map(own), [5, 6, 7].map(own));
        let ambient =
            Ambient { current: (k % 2 == 0).then_some(current), force: (k % 3 == 0).then_some(force) };
        let next = compiled.step(state, &exogenous, ambient);
        let row = [0.3, 0.1 * k as f64 - 7.0, 0.0];
        let drifting = compiled.step(state, &row, Ambient { current: Some(current), force: None });
        let mut advanced = state;
        compiled.advance(&mut advanced, row.as_slice(), |place| current.map(|own| own.at(place)));
        assert_eq!(advanced.map(&bits), drifting.map(&bits));
        states.push(next.map(&bits));
        state = if k % 5 == 0 { [8, 9, 10].map(own) } else { next };
    }
    states
}

#[test]
fn law_runs_side_by_side_step_like_one_bit_by_bit() {
    let model = model();
    for seed in 0..3 {
        let own = |lane: usize| move |i: usize| number(i + 100_000 * (seed * 40 + lane));
        let lanes = |first: usize| move |i: usize| Lane(std::array::from_fn(|lane| own(first + lane)(i)));
        for lane in [0, 3, LANES - 1] {
            let alone = steps(&model, own(lane), f64::to_bits);
            assert_eq!(steps(&model, lanes(0), |x: Lane| x[lane].to_bits()), alone);
            let second = |i: usize| Wide([lanes(LANES)(i), lanes(0)(i)]);
            assert_eq!(steps(&model, second, |x: Wide<2>| x.0[1][lane].to_bits()), alone);
        }
    }
}
