//! Intervals of shares, quantiles and paired differences.

use serde_json::Value;

use numerics::statistics::{
    LEAST_FOR_MEDIAN, clustered_share, mean_interval, median_interval_in_words, paired_median,
    quantile_interval, sorted, wilson,
};

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

/// Probability of every count of `n` trials that succeed with probability `p`.
fn binomial(n: u64, p: f64) -> Vec<f64> {
    let mut logarithm = n as f64 * (1.0 - p).ln();
    let mut out = vec![logarithm.exp()];
    for k in 1..=n {
        logarithm += ((n - k + 1) as f64 / k as f64).ln() + (p / (1.0 - p)).ln();
        out.push(logarithm.exp());
    }
    out
}

/// What the pages say about intervals: about 95 of 100 studies' intervals contain the true share; another
/// study's share falls into them some 83 times of 100, since 2 Φ(1.96/√2) − 1 = 0.834 for normal errors.
/// Summed over all outcomes, without random draws.
#[test]
fn law_intervals_hold_the_share_in_95_of_100_studies_and_another_studys_in_83() {
    for (n, p) in [(500, 0.5), (500, 0.58), (300, 0.3), (2000, 0.9)] {
        let of_count = binomial(n, p);
        let intervals: Vec<[f64; 2]> = (0..=n).map(|k| wilson(k, n).unwrap()).collect();
        let within = |[low, high]: [f64; 2], share: f64| share >= low && share <= high;
        let held: f64 =
            intervals.iter().zip(&of_count).filter(|(i, _)| within(**i, p)).map(|(_, of)| of).sum();
        let falls = |interval: [f64; 2]| -> f64 {
            let own = of_count.iter().enumerate().filter(|(k, _)| within(interval, *k as f64 / n as f64));
            own.map(|(_, of)| of).sum()
        };
        let fell: f64 = intervals.iter().zip(&of_count).map(|(interval, of)| of * falls(*interval)).sum();
        assert!((held - 0.95).abs() < 0.012, "{n} {p}: {held}");
        assert!((fell - 0.834).abs() < 0.015, "{n} {p}: {fell}");
    }
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
    // A few values too, where 1.96 standard errors hold it in 86 % of four.
    for count in [4, 96] {
        let held = (0..2000).filter(|_| {
            let normal = |_| (0..12).map(|_| draw()).sum::<f64>() - 6.0;
            let values: Vec<f64> = (0..count).map(normal).collect();
            let [low, high] = mean_interval(&values).unwrap();
            low <= 0.0 && 0.0 <= high
        });
        let share = held.count() as f64 / 2000.0;
        assert!((0.93..0.97).contains(&share), "{count}: {share}");
    }
    assert_eq!(mean_interval(&[1.0]), None);
}

#[test]
fn law_an_interval_of_a_median_is_stated_as_soon_as_there_is_one_and_never_as_a_nan() {
    let number = |x: f64| format!("{x:.1}");
    for count in 0..40_u64 {
        let values: Vec<f64> = (0..count).map(|i| i as f64).collect();
        let ends = quantile_interval(&values, 0.5);
        let words = median_interval_in_words(ends, count, number);
        assert_eq!(words.is_ok(), count >= LEAST_FOR_MEDIAN, "{count}: {words:?}");
        // What has no value is infinite: more and more of the pairs.
        for absent in 0..=count as usize {
            let mut some = values.clone();
            some[count as usize - absent..].fill(f64::INFINITY);
            let said = match median_interval_in_words(quantile_interval(&some, 0.5), count, number) {
                Ok(said) | Err(said) => said,
            };
            assert!(!said.contains("NaN") && !said.contains("inf"), "{said}");
        }
    }
    let few = median_interval_in_words([None; 2], 3, number).unwrap_err();
    assert_eq!(few, "too few pairs for a 95 % interval: 3, at least 6");
    assert_eq!(median_interval_in_words([Some(1.0), None], 9, number).unwrap(), "from 1.0 up");
}

/// Ten intervals of an estimate hold the truth in 7 or in all of ten: they are not ten independent ones.
#[test]
fn law_nineteen_of_twenty_intervals_of_clusters_hold_the_share() {
    let (mut draw, mut independent, mut held) = (draws(11), 0, 0);
    for _ in 0..2000 {
        let counts: Vec<u64> = (0..40)
            .map(|_| {
                let own = if draw() < 0.5 { 0.7 } else { 1.0 };
                (0..10).filter(|_| draw() < own).count() as u64
            })
            .collect();
        let shares: Vec<f64> = counts.iter().map(|count| *count as f64 / 10.0).collect();
        let holds = |[low, high]: [f64; 2]| u32::from(low <= 0.85 && 0.85 <= high);
        held += holds(clustered_share(&shares).unwrap());
        independent += holds(wilson(counts.iter().sum(), 400).unwrap());
    }
    assert!((1860..=1940).contains(&held) && independent < 1840, "{held} {independent}");
    assert_eq!(clustered_share(&[0.5]), None);
}
