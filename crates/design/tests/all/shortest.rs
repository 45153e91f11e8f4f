//! The shortest experiment for an accuracy.

use design::{
    AccuracyOf, Candidates, Criterion, Degree, Dictionary, Errors, NoDesign, Norm, Options, Question, Stock,
    Wanted,
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
    let middle = &dictionary.information;
    let criterion = Criterion::of_covariance(&dictionary, middle, vec![1.0], Norm::Trace).unwrap();
    let Criterion::Covariance(own) = &criterion else { panic!() };
    let asked = |accuracy: f64, longest_s: f64, stock: Option<&Stock>| {
        let wanted = Wanted { accuracy, of: AccuracyOf::Overall, longest_s };
        let errors = Errors::new(&dictionary, middle, own, &[1.0], wanted.of);
        let question = Question {
            dictionary: &dictionary,
            criterion: &criterion,
            errors,
            wanted,
            least_largest: false,
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
