//! Channels computed from others.

use vessel::Formula;

fn at(text: &str, values: &[f64]) -> f64 {
    Formula::parse(text).map_or(f64::NAN, |f| f.evaluate(values))
}

#[test]
fn products_parts_and_powers_are_read_as_written() {
    assert_eq!(at("negative(n)", &[-3.0]), -3.0);
    assert_eq!(at("negative(n)", &[3.0]), 0.0);
    assert_eq!(at("positive(n)^2 * 0.5", &[4.0]), 8.0);
    assert_eq!(at("n |n|", &[-3.0]), -9.0);
    assert_eq!(at("2e-1 a b^2", &[5.0, 3.0]), 9.0);
    approx::assert_relative_eq!(at("-1 w^2 cos(gamma)", &[2.0, 0.3]), -4.0 * 0.3_f64.cos());
    approx::assert_relative_eq!(at("w w sin( gamma )", &[2.0, 0.3]), 4.0 * 0.3_f64.sin());
    assert_eq!(Formula::parse("b a |b|").unwrap().channels, ["b", "a"]);
}

#[test]
fn a_missing_value_stays_missing() {
    for text in ["n", "|n|", "positive(n)", "negative(n)", "cos(n)"] {
        assert!(at(text, &[f64::NAN]).is_nan(), "{text}");
    }
}

#[test]
fn what_is_no_product_is_refused() {
    for text in ["", "2", "n + m", "|n", "tan(n)", "cos(n", "n^0", "n^x", "n /2", "-n", "cos()", "1..2 n"] {
        assert!(Formula::parse(text).is_err(), "{text}");
    }
}
