//! Currents and gusts.

use logs::chain::GaussMarkov;
use ship::engine::Streams;

#[test]
fn law_variance_and_correlation_are_those_requested() {
    let process = GaussMarkov { std: 0.4, time_s: 2.0 };
    let x = process.samples(&Streams::new(3, "here"), 1, 5, 400_000, 0.25);
    let mean = |f: &dyn Fn(usize) -> f64| (0..390_000).map(f).sum::<f64>() / 390_000.0;
    let variance = mean(&|k| x[k] * x[k]);
    // 390,000 samples hold some 24,000 independent ones: 1 % of the variance is a standard error.
    assert!((variance / 0.16 - 1.0).abs() < 0.04, "{variance}");
    let correlation = mean(&|k| x[k] * x[k + 8]) / variance;
    assert!((correlation - (-1.0_f64).exp()).abs() < 0.02, "{correlation}");
}

#[test]
fn without_time_it_is_white() {
    let streams = Streams::new(3, "here");
    let mut white = vec![0.0; 7];
    streams.normals(1, 5, &mut white);
    let found = GaussMarkov { std: 2.0, time_s: 0.0 }.samples(&streams, 1, 5, 7, 0.1);
    assert_eq!(found, white.iter().map(|w| 2.0 * w).collect::<Vec<_>>());
}
