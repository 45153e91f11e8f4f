//! Channels computed from others.

use ship::model::Formula;

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
    for text in ["", "2", "|n", "tan(n)", "cos(n", "n^0", "n^x", "n /2", "-n", "cos()", "1..2 n"] {
        assert!(Formula::parse(text).is_err(), "{text}");
    }
}

#[test]
fn sums_and_differences_are_read_as_written() {
    assert_eq!(at("port + starboard", &[3.0, 4.0]), 7.0);
    assert_eq!(at("port |port| - starboard |starboard|", &[3.0, -4.0]), 25.0);
    assert_eq!(at("2 a - 0.5 b^2 + -1 a b", &[3.0, 4.0]), 6.0 - 8.0 - 12.0);
    assert_eq!(at("a - a", &[0.3]), 0.0);
    assert_eq!(Formula::parse("b - a + |b|").unwrap().channels, ["b", "a"]);
    // A sign belongs to a number unless there are blanks around it.
    assert_eq!(at("n -2 m", &[3.0, 4.0]), -24.0);
    assert_eq!(at("n - 2 m", &[3.0, 4.0]), -5.0);
    for text in ["n +", "n + 2", "2 + n", "+ n", "- n", "n * - m", "n + + m", "n +m", "n-m"] {
        assert!(Formula::parse(text).is_err(), "{text}");
    }
    let many = ["n"; 33].join(" + ");
    assert!(Formula::parse(&many).is_err());
}

#[test]
fn law_slopes_of_sums_are_those_of_differences_of_values() {
    let formula = Formula::parse("a |a| - b |b| + 3 a^2 sin(b)").unwrap();
    let row = [1.3, -0.7];
    for by in 0..2 {
        let moved = |step: f64| {
            let mut row = row;
            row[by] += step;
            formula.evaluate(&row)
        };
        let expected = (moved(1e-6) - moved(-1e-6)) / 2e-6;
        approx::assert_relative_eq!(formula.slope(by, |i| row[i]), expected, max_relative = 1e-7);
    }
}

/// Channels, values and slopes that numpy found by functions written beside the formulas: `scripts/independent/derived.py`.
#[test]
fn oracle_derived_channels_and_their_slopes() {
    let oracle: serde_json::Value =
        serde_json::from_str(include_str!("../../../../../fixtures/oracle/derived.json")).unwrap();
    let numbers = |value: &serde_json::Value| -> Vec<f64> {
        value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap()).collect()
    };
    let cases = oracle["cases"].as_array().unwrap();
    assert!(cases.len() >= 10);
    for case in cases {
        let text = case["formula"].as_str().unwrap();
        let formula = Formula::parse(text).unwrap();
        let channels: Vec<&str> =
            case["channels"].as_array().unwrap().iter().filter_map(|c| c.as_str()).collect();
        assert_eq!(formula.channels, channels, "{text}");
        let values = numbers(&case["values"]);
        let rows = case["rows"].as_array().unwrap().iter().zip(case["slopes"].as_array().unwrap());
        for ((row, slopes), value) in rows.zip(values) {
            let (row, slopes) = (numbers(row), numbers(slopes));
            approx::assert_relative_eq!(formula.evaluate(&row), value, max_relative = 1e-12, epsilon = 1e-15);
            for (by, slope) in slopes.into_iter().enumerate() {
                let found = formula.slope(by, |channel| row[channel]);
                approx::assert_relative_eq!(found, slope, max_relative = 1e-6, epsilon = 1e-7);
            }
        }
    }
}
