//! Which estimator is recommended.

use estimation::{Contender, Estimator, Recommendation};

fn contender(estimator: Estimator, errors: impl Fn(usize) -> Option<f64>) -> Contender {
    let errors: Vec<Option<f64>> = (0..96).map(errors).collect();
    let without_estimate = errors.iter().filter(|e| e.is_none()).count();
    Contender { estimator, errors, without_estimate }
}

/// Errors that vary far more from run to run than between estimators.
fn varied(i: usize) -> f64 {
    1.0 + (i * 37 % 96) as f64 / 10.0
}

#[test]
fn law_a_small_difference_in_every_run_is_told_and_a_chance_one_is_not() {
    let iv = contender(Estimator::Iv, |i| Some(varied(i)));
    let worse = contender(Estimator::Ls, |i| Some(varied(i) + 0.01));
    let found = Recommendation::new(&[worse.clone(), iv.clone()]).unwrap();
    assert_eq!((found.estimator(), found.candidates()), (Some(Estimator::Iv), vec![Estimator::Iv]));
    let chance =
        contender(Estimator::OutputError, |i| Some(varied(i) + if i % 2 == 0 { 0.3 } else { -0.29 }));
    let found = Recommendation::new(&[worse, iv, chance]).unwrap();
    assert_eq!((found.estimator(), found.candidates().len()), (None, 2));
}

#[test]
fn an_estimator_that_leaves_runs_without_an_estimate_is_not_considered() {
    let better = contender(Estimator::OutputError, |i| (i > 0).then(|| 0.5 * varied(i)));
    let iv = contender(Estimator::Iv, |i| Some(varied(i)));
    let found = Recommendation::new(&[better.clone(), iv]).unwrap();
    assert_eq!((found.least, found.others), (Estimator::Iv, vec![]));
    assert_eq!(Recommendation::new(&[better]), None);
}

#[test]
fn five_runs_tell_no_difference() {
    let few = |estimator, shift: f64| Contender {
        estimator,
        errors: (0..5).map(|i| Some(varied(i) + shift)).collect(),
        without_estimate: 0,
    };
    let found = Recommendation::new(&[few(Estimator::Iv, 0.0), few(Estimator::Ls, 1.0)]).unwrap();
    assert_eq!((found.least, found.estimator()), (Estimator::Iv, None));
}
