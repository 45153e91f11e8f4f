//! The gradient by one adjoint against that by all sensitivities.

use estimation::predictor::{Recordings, Sensitivities, slopes};
use numerics::{LANES, Lane};
use ship::model::{Source, Vessel};

#[test]
fn law_slopes_are_those_of_all_sensitivities() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let model = vessel.model.with_intercepts();
    let wave = |k: usize, by: f64| Lane::splat((by * k as f64).sin());
    let inputs = |k: usize| [500.0, 90.0, 40.0].map(|size| Lane::splat(size) * wave(k, 0.05 + 0.001 * size));
    let exogenous: Vec<Lane> = (0..203).flat_map(inputs).collect();
    let measured: Vec<Lane> = (0..3 * 204).map(|k| Lane::splat(0.3) * wave(k, 1.7)).collect();
    let mut samples = [203; LANES];
    let theta = model.layout().woven(&vessel.parameters(Source::Value).unwrap(), [1e-3, -2e-3, 1e-3]);
    let unknowns: Vec<Lane> =
        [theta, vec![0.02, -0.01, 0.03]].concat().into_iter().map(Lane::splat).collect();
    let free: Vec<usize> = (0..unknowns.len()).collect();
    for (shorter, from_start) in [(203, true), (203, false), (90, true)] {
        samples[3] = shorter;
        let recordings = Recordings {
            model: &model,
            measured: &measured,
            exogenous: &exogenous,
            initial: [Lane::ZERO; 3],
            samples,
        };
        let all = Sensitivities::of(&recordings, &unknowns, &free, from_start);
        let rows = all.errors.as_chunks::<3>().0;
        let weights = |lane: usize, squares: [f64; 3]| squares.map(|square| (lane + 1) as f64 / square);
        let found = slopes(&recordings, &unknowns, &free, from_start, weights, &mut Vec::new());
        for (lane, found) in found.iter().enumerate() {
            let squares = [0, 1, 2].map(|d: usize| rows.iter().map(|e| e[d][lane].powi(2)).sum::<f64>());
            let weights = weights(lane, squares);
            let entry = |i: usize| -> f64 {
                let row = |(k, e): (usize, &[Lane; 3])| {
                    let slopes = all.by(k, i);
                    (0..3).map(|d| weights[d] * slopes[d][lane] * e[d][lane]).sum::<f64>()
                };
                rows.iter().enumerate().map(row).sum()
            };
            let gradient: Vec<f64> = free.iter().map(|i| entry(*i)).collect();
            let size = gradient.iter().fold(0.0_f64, |most, own| most.max(own.abs()));
            let near = |a: f64, b: f64, size: f64| assert!((a - b).abs() <= 1e-11 * size, "{lane}: {a} {b}");
            (0..3).for_each(|d| near(found.squares[d], squares[d], squares[d]));
            found.gradient.iter().zip(&gradient).for_each(|(a, b)| near(*a, *b, size));
        }
    }
}
