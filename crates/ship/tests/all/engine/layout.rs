//! Parameters and intercepts in one order.

use std::collections::BTreeMap;

use ship::engine::{Ambient, Compiled};
use ship::model::{Degree, Model, Term, Variable};

fn model() -> Model {
    let variable = |name: &str| Variable { name: name.to_owned(), unit: String::new() };
    let degree = |texts: &[&str]| {
        Degree::new(
            texts.iter().map(|text| (*text).to_owned()).collect(),
            texts.iter().map(|text| Term::parse(text, &["u", "v", "r"]).unwrap()).collect(),
        )
    };
    Model {
        variables: ["u", "v", "r"].map(variable).to_vec(),
        inputs: 0,
        simulated: BTreeMap::new(),
        roles: BTreeMap::new(),
        derived: Vec::new(),
        degrees: [degree(&["u", "u |u|"]), degree(&["v"]), degree(&["r", "u r", "v"])],
        constant: [0.0; 3],
        forces: None,
        pace: ship::model::RateChange::Own,
    }
}

#[test]
fn parameters_and_intercepts_come_apart_as_they_were_woven() {
    let layout = model().with_intercepts().layout();
    assert_eq!(layout, model().layout().with_intercepts());
    let (theta, intercepts) = ([1.0, 2.0, 3.0, 4.0, 5.0, 6.0], [0.1, 0.2, 0.3]);
    let woven = layout.woven(&theta, intercepts);
    assert_eq!(woven, [1.0, 2.0, 0.1, 3.0, 0.2, 4.0, 5.0, 6.0, 0.3]);
    assert_eq!(layout.parameters(), woven.len());
    assert_eq!((layout.theta(&woven), layout.intercepts(&woven)), (theta.to_vec(), intercepts));
    assert_eq!(layout.degrees().collect::<Vec<_>>(), [0, 0, 0, 1, 1, 2, 2, 2, 2]);
    assert_eq!((layout.terms(2), layout.degree(1)), (5..8, 3..5));
    let plain = model().layout();
    assert!(!plain.has_intercepts() && plain.woven(&theta, intercepts) == theta);
    assert_eq!((plain.theta(&theta), plain.intercepts(&theta)), (theta.to_vec(), [0.0; 3]));
}

#[test]
fn law_an_intercept_does_what_a_constant_force_does() {
    let (plain, lifted) = (model(), model().with_intercepts());
    let (theta, force, state) = ([-0.1, -0.2, -0.3, -0.4, 0.5, 0.6], [0.1, 0.2, 0.3], [1.0, -0.5, 0.2]);
    let ambient = Ambient { current: None, force: Some(force) };
    let expected = Compiled::new(&plain, &theta).step::<f64>(state, &[], ambient);
    let parameters = lifted.layout().woven(&theta, force);
    let found = Compiled::new(&lifted, &parameters).step::<f64>(state, &[], Ambient::default());
    for (found, expected) in found.into_iter().zip(expected) {
        approx::assert_relative_eq!(found, expected, max_relative = 1e-15);
    }
}
