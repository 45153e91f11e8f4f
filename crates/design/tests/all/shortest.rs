//! The shortest experiment for an accuracy.

use design::{
    AccuracyOf, Candidates, Criterion, Degree, Dictionary, Errors, MOST, NoDesign, Norm, Options, Question,
    Stock, Wanted, holds_from,
};

/// Straight lines with intercept through −1 and 1, white noise of unit variance.
fn line() -> Dictionary {
    let mut information = Candidates::new(vec![2]);
    information.push(&[1.0, -1.0, -1.0, 1.0]).unwrap();
    information.push(&[1.0, 1.0, 1.0, 1.0]).unwrap();
    let degree =
        Degree { name: "surge".into(), regressors: vec!["x".into()], parameters: vec!["slope".into()] };
    let maneuvers = vec!["left".into(), "right".into()];
    Dictionary { degrees: vec![degree], maneuvers, sample_rate_hz: 2.0, intercepts: true, information }
}

#[test]
fn law_the_time_for_an_accuracy_falls_as_its_square_and_what_exists_limits_it() {
    let dictionary = line();
    let meat = &dictionary.information;
    let criterion = Criterion::of_covariance(&dictionary, meat, vec![1.0], Norm::Trace).unwrap();
    let Criterion::Covariance(own) = &criterion else { panic!() };
    let asked = |accuracy: f64, longest_s: f64, stock: Option<&Stock>| {
        let wanted = Wanted { accuracy, of: AccuracyOf::Overall, longest_s };
        let errors = Errors::new(&dictionary, own, &[1.0]);
        let question = Question {
            dictionary: &dictionary,
            lengths: &[20.0, 20.0],
            criterion: &criterion,
            errors,
            wanted,
            stock,
        };
        question.shortest(&Options::default())
    };
    // The slope of half the samples at either end has the variance 1/N.
    assert!((asked(0.1, 1e3, None).unwrap().samples - 100.0).abs() <= 1.0);
    assert!((asked(0.05, 1e3, None).unwrap().samples - 400.0).abs() <= 1.0);
    let Err(NoDesign::OutOfReach(found)) = asked(0.1, 25.0, None) else { panic!() };
    assert!((found.best - 50f64.recip().sqrt()).abs() < 1e-9);
    // 20 s, 40 samples, on the left: of N samples 40 there, var = 1/(4 w (1 − w) N).
    let stock = Stock { seconds: [("left".to_owned(), 20.0)].into(), ..Stock::default() };
    let limited = asked(0.1, 1e3, Some(&stock)).unwrap();
    let share = 40.0 / limited.samples;
    assert!((4.0 * share * (1.0 - share) * limited.samples - 100.0).abs() < 1.0, "{limited:?}");
    assert!(limited.samples > 100.0 && limited.design.shares[0] <= share + 1e-9);
}

/// At the answer, whole maneuvers take `MOST` of the time or more; a sample earlier they take less.
#[test]
fn law_a_prediction_holds_from_where_whole_maneuvers_take_most_of_the_time() {
    let cases: [(&[f64], &[f64]); 4] = [
        (&[0.5, 0.5], &[40.0, 60.0]),
        (&[0.27, 0.231, 0.198, 0.195, 0.063, 0.038, 0.005], &[300.0; 7]),
        (&[0.1, 0.9, 0.0], &[10.0, 400.0, 1e6]),
        (&[0.79, 0.01, 0.2], &[100.0, 100.0, 100.0]),
    ];
    for (shares, lengths) in cases {
        let whole = |samples: f64| -> f64 {
            let pairs = shares.iter().zip(lengths);
            pairs.filter(|(w, n)| **w * samples >= **n * (1.0 - 1e-12)).map(|(w, _)| w).sum()
        };
        let from = holds_from(shares, lengths);
        assert!(whole(from) >= MOST && whole(from - 1.0) < MOST, "{shares:?}: {from}");
    }
}
