//! Designs of the next round.

use design::apportion;
use estimation::Simulated;
use maneuver::{DictionaryFile, Generator};
use regression::Noise;
use ship::model::{Source, Vessel};
use trial::campaign::{Parts, Plan};
use trial::rounds::{GrowingRun, Planner, SoFar};

const NOISE: Noise = Noise { measurement: [0.1, 0.1, 0.1], current: 0.1 };

#[test]
fn law_a_design_beats_equal_shares_and_makes_good_what_was_missed() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let dictionary: DictionaryFile =
        include_str!("../../../../pipelines/scenarios/dictionary.toml").parse().unwrap();
    let generator = Generator::without_tables(&vessel, &dictionary).unwrap();
    let planner = Planner::new(&vessel, &generator, NOISE).unwrap();
    let theta = vessel.parameters(Source::Value).unwrap();
    let sizes: Vec<f64> = theta.iter().map(|t| t.abs()).collect();
    let extend = |run: &GrowingRun, shares: &[f64]| {
        let counts = apportion(shares, 500).into_iter().enumerate().filter(|(_, n)| *n > 0);
        let mut longer = run.clone();
        let plan: Plan = counts.map(|(q, n)| (q, n as usize)).collect();
        longer.extend(&vessel, &generator, &mut Parts::default(), &plan).unwrap();
        longer
    };
    let information = |run: &GrowingRun| {
        let own = Simulated { theta: &theta, initial: run.initial, exogenous: &run.exogenous };
        planner.informations(&[own]).pop().flatten().unwrap()
    };
    let error = |run: &GrowingRun| {
        let own = information(run);
        let errors = planner.standard_errors(&own, &sizes, run.samples(&vessel)).unwrap();
        errors.iter().zip(&sizes).map(|(e, s)| (e / s).powi(2)).sum::<f64>().sqrt()
    };
    let once = planner.shares(&theta, &sizes, None, 500).unwrap();
    let (new, equal) = (GrowingRun::default(), vec![1.0 / 11.0; 11]);
    assert!(error(&extend(&new, &once)) < error(&extend(&new, &equal)));
    // The same maneuver for a while: then the best rest differs from the best whole.
    let lopsided = extend(&new, &[1.0].iter().chain(&[0.0; 10]).copied().collect::<Vec<_>>());
    let so_far = SoFar { samples: 500, information: &information(&lopsided), shares: &once };
    let rest = planner.shares(&theta, &sizes, Some(so_far), 500).unwrap();
    assert!(rest[0] < once[0], "{rest:?} {once:?}");
    assert!(error(&extend(&lopsided, &rest)) < error(&extend(&lopsided, &equal)));
}
