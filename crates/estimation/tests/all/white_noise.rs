//! Tests under white noise beside those under a likelier kind.

use estimation::criticism::{Absent, clearer_under_white};

/// The test of one term.
fn absent(p_value: f64) -> Vec<Absent> {
    vec![Absent {
        name: "v |v|".to_owned(),
        degree: None,
        unit: String::new(),
        value: vec![1.0],
        standard_error: vec![1.0],
        visible_from: 1.0,
        p_value,
        evidence: 0.0,
        candidate: true,
    }]
}

#[test]
fn law_white_noise_rejects_at_half_the_level_and_where_it_is_the_clearer() {
    let clearer = |likeliest: f64, white: f64| {
        clearer_under_white(&absent(likeliest), absent(white)).map(|found| found[0].p_value)
    };
    assert_eq!(clearer(0.3, 0.02), Some(0.04));
    assert_eq!(clearer(0.3, 0.026), None);
    assert_eq!(clearer(0.01, 0.006), None);
    assert_eq!(clearer(0.01, 0.004), Some(0.008));
}
