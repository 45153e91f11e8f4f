//! Errors over sources left out against numbers computed independently: `fixtures/oracle/pooled.json`.

use std::ops::Range;

use estimation::pooled::Score;
use regression::MeanRemoval;
use regression::Sums;
use regression::pooled::{Options, Part, fit};

use crate::support::craft::{close, craft, oracle, parts, regression};

#[test]
fn oracle_cross_validation() {
    let oracle = oracle();
    let vessel = craft();
    let lifted = vessel.model.with_intercepts();
    let all = parts(&oracle);
    let window = oracle["window"].as_u64().unwrap() as usize;
    let options = Options { removal: MeanRemoval::Complete, prior: None, most: f64::INFINITY };
    let fitted = |parts: &[&Part], model: Option<&[f64]>| {
        let sums: Vec<Sums> = parts.iter().map(|p| regression(&vessel, p, model).sums()).collect();
        let found = fit(&sums.iter().collect::<Vec<_>>(), &options).map(|d| d.solution.unwrap());
        let theta: Vec<f64> = found.iter().flat_map(|s| s.theta.clone()).collect();
        lifted.layout().woven(&theta, [0, 1, 2].map(|d: usize| found[d].intercept))
    };
    for estimator in ["ls", "iv"] {
        let mut score = Score::default();
        for source in ["a", "b", "c"] {
            let train: Vec<&Part> = all.iter().filter(|p| p.source != source).collect();
            let mut model = fitted(&train, None);
            if estimator == "iv" {
                model = fitted(&train, Some(&model));
            }
            let cut = |p: &'_ Part| -> Vec<Range<usize>> {
                (0..p.samples() / window).map(|i| i * window..(i + 1) * window).collect()
            };
            let own = all.iter().filter(|p| p.source == source);
            let windows = own.flat_map(|p| cut(p).into_iter().map(|samples| p.view().part(samples)));
            score.merge(&Score::of(&lifted, &model, windows));
        }
        let expected = &oracle["cross"][estimator];
        assert_eq!(score.samples, expected["windows"].as_u64().unwrap() * window as u64);
        close(&score.rmse().unwrap(), &expected["rmse"], estimator);
    }
}
