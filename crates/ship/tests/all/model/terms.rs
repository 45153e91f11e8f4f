//! Terms as they are written.

use numerics::Lane;
use ship::model::Term;

const VARIABLES: [&str; 5] = ["u", "v", "r", "n", "delta"];

fn at(text: &str, values: [f64; 5]) -> f64 {
    let mut out = [f64::NAN];
    Term::parse(text, &VARIABLES).unwrap().values(&values.map(|value| [value]), &mut out);
    out[0]
}

#[test]
fn products_powers_and_moduli_are_read_as_written() {
    let x = [-2.0, 3.0, 0.5, -4.0, 0.1];
    assert_eq!(at("u", x), -2.0);
    assert_eq!(at("u|u|", x), -4.0);
    assert_eq!(at("u |u| delta", x), -0.4);
    assert_eq!(at("v * r", x), 1.5);
    assert_eq!(at("n |n|", x), -16.0);
    assert_eq!(at("u^3 |r|^2", x), -2.0);
}

#[test]
fn a_misspelt_variable_is_refused_with_the_nearest_name() {
    let error = Term::parse("u |u| dleta", &VARIABLES).unwrap_err();
    assert!(error.to_string().contains("`dleta`") && error.remedy.contains("`delta`"), "{error}");
    for text in ["", "|u", "u^0", "u^x", "u +"] {
        assert!(Term::parse(text, &VARIABLES).is_err(), "{text}");
    }
}

#[test]
fn law_many_samples_and_lanes_have_the_values_of_one() {
    let x = [-0.7, 0.3, 0.2, 5.0, -0.4];
    for text in ["u |u|", "v r", "u^2 |v| delta", "|n| n"] {
        let term = Term::parse(text, &VARIABLES).unwrap();
        let mut many = [Lane::ZERO; 2];
        term.values(&x.map(|x| [Lane::ZERO, Lane::splat(x)]), &mut many);
        assert_eq!((many[0][3], many[1][3]), (0.0, at(text, x)), "{text}");
    }
}

#[test]
fn the_constant_is_one_wherever_it_is_evaluated() {
    assert_eq!((at("1", [0.0; 5]), at(" 1 ", [3.0; 5])), (1.0, 1.0));
    assert!(Term::parse("1 u", &VARIABLES).is_err() && Term::parse("2", &VARIABLES).is_err());
}
