//! Intervals of shares, quantiles and paired differences.

use serde_json::Value;

use numerics::statistics::{mean_interval, paired_median, quantile_interval, sorted, wilson};

const ORACLE: &str = include_str!("../../../../fixtures/oracle/intervals.json");

fn cases(name: &str) -> Vec<Value> {
    serde_json::from_str::<Value>(ORACLE).unwrap()[name].as_array().unwrap().clone()
}

/// Draws of an even distribution over (0, 1): a multiplicative generator modulo a Mersenne prime.
fn draws(mut state: u64) -> impl FnMut() -> f64 {
    move || {
        state = state * 48_271 % 2_147_483_647;
        state as f64 / 2_147_483_647.0
    }
}

#[test]
fn oracle_wilsons_limits_are_the_shares_that_a_score_test_just_keeps() {
    for case in cases("shares") {
        let [low, high] = wilson(case["count"].as_u64().unwrap(), case["total"].as_u64().unwrap()).unwrap();
        let expected = [0, 1].map(|end| case["interval"][end].as_f64().unwrap());
        assert!(
            (low - expected[0]).abs() < 1e-9 && (high - expected[1]).abs() < 1e-9,
            "{case}: {low} {high}"
        );
    }
    assert_eq!(wilson(0, 0), None);
}

#[test]
fn oracle_ranks_of_quantiles_are_those_of_exact_rational_sums() {
    for case in cases("quantiles") {
        let expected = [0, 1].map(|end| case["ranks"][end].as_u64().map(|rank| rank as usize));
        // The values are their own ranks.
        let ranks: Vec<f64> = (1..=case["values"].as_u64().unwrap()).map(|rank| rank as f64).collect();
        let interval = quantile_interval(&ranks, case["quantile"].as_f64().unwrap());
        assert_eq!(interval.map(|rank| rank.map(|rank| rank as usize)), expected, "{case}");
    }
}

#[test]
fn law_nineteen_of_twenty_intervals_hold_the_median_they_were_drawn_from() {
    let mut draw = draws(1);
    let held = (0..2000).filter(|_| {
        let values = sorted((0..96).map(|_| Some(draw())));
        let [low, high] = quantile_interval(&values, 0.5).map(Option::unwrap);
        low <= 0.5 && 0.5 <= high
    });
    let share = held.count() as f64 / 2000.0;
    assert!((0.945..0.985).contains(&share), "{share}");
}

#[test]
fn an_end_among_absent_values_is_absent() {
    let values = sorted((0..20).map(|i| (i < 12).then_some(f64::from(i))));
    assert_eq!(quantile_interval(&values, 0.5), [Some(5.0), None]);
    assert_eq!(quantile_interval(&values[..5], 0.5), [None, None]);
}

#[test]
fn pairs_differ_by_their_median() {
    let close = (0..20).map(|i| [Some(f64::from(i)), Some(f64::from(i) + 1.0)]);
    assert_eq!(paired_median(close), Some([1.0, 1.0, 1.0]));
    let lost = (0..20).map(|i| [Some(1.0), (i < 4).then_some(0.0)]);
    assert_eq!(paired_median(lost), Some([f64::INFINITY; 3]));
    let few = [[Some(1.0), Some(2.0)], [None, None]].into_iter();
    assert_eq!(paired_median(few), Some([f64::NEG_INFINITY, 0.5, f64::INFINITY]));
}

#[test]
fn law_nineteen_of_twenty_intervals_hold_the_mean_they_were_drawn_from() {
    let mut draw = draws(7);
    let held = (0..2000).filter(|_| {
        let values: Vec<f64> = (0..96).map(|_| draw()).collect();
        let [low, high] = mean_interval(&values).unwrap();
        low <= 0.5 && 0.5 <= high
    });
    let share = held.count() as f64 / 2000.0;
    assert!((0.93..0.97).contains(&share), "{share}");
    assert_eq!(mean_interval(&[1.0]), None);
}
