//! Small cases whose numbers are known by hand.

use design::{
    AccuracyOf, Candidates, CountOptions, Criterion, Degree, Dictionary, Error, Errors, Length, NoDesign,
    Norm, Options, Question, Rivals, Segments, Start, Stock, Wanted, count_segments, counted, is_concave,
    promised_error, solve,
};

/// Candidates that are matrices with one block each.
fn candidates(n: usize, entries: &[&[f64]]) -> Candidates {
    let mut all = Candidates::new(vec![n]);
    entries.iter().for_each(|own| all.push(own).unwrap());
    all
}

fn degree(name: &str, parameter: &str) -> Degree {
    Degree { name: name.into(), regressors: vec![format!("{name}'s")], parameters: vec![parameter.into()] }
}

/// Straight lines with intercept through −1 and 1, at two samples a second.
fn line() -> Dictionary {
    Dictionary {
        degrees: vec![degree("surge", "slope")],
        maneuvers: vec!["left".into(), "right".into()],
        sample_rate_hz: 2.0,
        intercepts: true,
        information: candidates(2, &[&[1.0, -1.0, -1.0, 1.0], &[1.0, 1.0, 1.0, 1.0]]),
    }
}

#[test]
fn law_a_direction_in_a_common_block_is_explained_by_the_parameter_of_its_row() {
    let dictionary = Dictionary {
        degrees: vec![degree("surge", "X_u"), degree("sway", "Y_v"), degree("yaw", "N_r")],
        information: candidates(6, &[&[1.0; 36]]),
        ..line()
    };
    // Rows: X_u, intercept, Y_v, intercept, N_r, intercept.
    for (row, name, parameter) in
        [(0, "surge", "X_u"), (2, "sway", "Y_v"), (3, "sway", "Y_v"), (4, "yaw", "N_r")]
    {
        let mut direction = vec![0.1; 6];
        direction[row] = -0.9;
        let explained = dictionary.explain(Error::Unexcited { block: 0, direction });
        let NoDesign::Unexcited { degree, parameter: found, regressor } = explained else { panic!() };
        assert_eq!((degree.as_str(), found.as_str(), regressor), (name, parameter, format!("{name}'s")));
    }
    let two = Degree {
        regressors: vec!["v".into(), "r".into()],
        parameters: vec!["Y_v".into(), "Y_r".into()],
        ..degree("sway", "")
    };
    let degrees = vec![degree("surge", "X_u"), two];
    let dictionary = Dictionary { degrees, information: candidates(5, &[&[1.0; 25]]), ..line() };
    let error = Error::Unexcited { block: 0, direction: vec![0.3, 0.0, 0.2, 0.9, 0.0] };
    let NoDesign::Unexcited { parameter, .. } = dictionary.explain(error) else { panic!() };
    assert_eq!(parameter, "Y_r");
}

#[test]
fn law_rows_that_no_candidate_couples_do_not_spoil_a_proof() {
    // A row that is coupled with the first one only through the third, and one that is coupled with none.
    let a = [2.0, 0.0, 1.0, 0.0, 0.0, 2.0, 0.5, 0.0, 1.0, 0.5, 2.0, 0.0, 0.0, 0.0, 0.0, 1.0];
    assert!(is_concave(&candidates(4, &[&a])));
    // Rows scaled by 1, 2, 3 and 4 differ from that by a constant of the determinant.
    let scaled: Vec<f64> = a.iter().enumerate().map(|(k, own)| own * (1.0 + (k / 4) as f64)).collect();
    assert!(is_concave(&candidates(4, &[&scaled])));
    // Rows that nothing couples with the first one are judged as well: here no factors suit both candidates.
    let two = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 0.0, 2.0, 2.0];
    let three = [1.0, 0.0, 0.0, 0.0, 2.0, 1.0, 0.0, 3.0, 2.0];
    assert!(is_concave(&candidates(3, &[&two])) && !is_concave(&candidates(3, &[&two, &three])));
}

#[test]
fn law_starts_agree_by_their_values() {
    let information = &line().information;
    let design =
        solve(&candidates(2, &[&[4.0, 0.0, 0.0, 1.0], &[1.0, 0.0, 0.0, 9.0]]), &Options::default()).unwrap();
    assert!(design.log_det > 1.0);
    let start = |log_det: f64| Start { shares: vec![0.5; 2], log_det, relative_gap: 0.0, iterations: 1 };
    assert!(design.agrees(&start(design.log_det)));
    assert!(!design.agrees(&start(-design.log_det)));
    assert!(!design.agrees(&start(design.log_det * (1.0 - 1e-6))));
    assert!(!design.agrees(&start(design.log_det * (1.0 + 1e-6))));
    assert_eq!(information.len(), 2);
}

#[test]
fn law_what_exists_is_as_many_segments_as_fit_into_its_seconds() {
    let dictionary = line();
    let stock =
        Stock { seconds: [("left".to_owned(), 25.0)].into(), segments: [("right".to_owned(), 7)].into() };
    // 25 s are 50 samples: five segments of ten samples, and none of a fifth of one more.
    let within =
        |samples: f64, segments| stock.within(&dictionary, &Length { samples: Some(samples), segments });
    let found = within(100.0, Some((10, 10))).unwrap();
    assert_eq!((found.shares, found.counts), (vec![0.5, 0.7], Some(vec![5, 7])));
    let found = within(108.0, Some((9, 12))).unwrap();
    assert_eq!(found.counts, Some(vec![4, 7]));
    // Fewer than there are segments: no more than all.
    assert_eq!(within(20.0, Some((2, 10))).unwrap().counts, Some(vec![2, 2]));
}

#[test]
fn oracle_promised_errors_of_one_sample_and_of_many() {
    // A variance of e^1.8 of one sample, for two parameters together.
    let found = promised_error(Norm::LogDet, 1.8, 2, 1.0, 1.0);
    assert!((found - 0.45_f64.exp()).abs() < 1e-12, "{found}");
    let found = promised_error(Norm::LogDet, 1.8, 2, 25.0, 400.0);
    assert!((found - 0.25 * 0.45_f64.exp()).abs() < 1e-12, "{found}");
    assert!((promised_error(Norm::Trace, 6.25, 2, 25.0, 400.0) - 0.625).abs() < 1e-12);
}

#[test]
fn oracle_the_curve_of_an_accuracy_goes_from_a_sixteenth_of_the_time_to_sixteen_times_as_long() {
    let dictionary = line();
    let criterion =
        Criterion::of_covariance(&dictionary, &dictionary.information, vec![1.0], Norm::Trace).unwrap();
    let Criterion::Covariance(own) = &criterion else { panic!() };
    let wanted = Wanted { accuracy: 0.05, of: AccuracyOf::Overall, longest_s: 1e4 };
    let question = Question {
        dictionary: &dictionary,
        lengths: &[20.0, 20.0],
        criterion: &criterion,
        errors: Errors::new(&dictionary, own, &[1.0]),
        wanted,
        stock: None,
    };
    let shortest = question.shortest(&Options::default()).unwrap();
    // The slope's variance of shares w and 1 − w is 1/(4 w (1 − w)) of a sample.
    let variance = |w: f64| 0.25 / (w * (1.0 - w));
    let random = [0.5, 0.2, 0.4].map(|w| vec![w, 1.0 - w]).to_vec();
    let rivals = Rivals { paper: Some(vec![0.3, 0.7]), random, random_segments: 5 };
    let found = question.compare(&shortest, &rivals);
    let needs = |w: f64| variance(w) / 0.0025 / 2.0;
    assert!((found.samples as f64 - 400.0).abs() <= 1.0 && (found.reached - 0.05).abs() < 1e-4);
    assert!(
        (found.paper_s.unwrap() - needs(0.3)).abs() < 1e-6
            && (found.equal_s.unwrap() - needs(0.5)).abs() < 1e-6
    );
    assert!((found.random_s.unwrap() - needs(0.4)).abs() < 1e-6);
    let (first, last) = (found.curve[0], found.curve[found.curve.len() - 1]);
    let samples = shortest.samples;
    assert!(
        (first.duration_s - samples / 32.0).abs() < 1e-9 && (last.duration_s - 8.0 * samples).abs() < 1e-6
    );
    for point in &found.curve {
        let error = |w: f64| (variance(w) / (2.0 * point.duration_s)).sqrt();
        assert!((point.design - error(0.5)).abs() < 1e-6 && (point.equal.unwrap() - error(0.5)).abs() < 1e-9);
        assert!((point.paper.unwrap() - error(0.3)).abs() < 1e-9);
        assert!((point.random.unwrap() - error(0.4)).abs() < 1e-9);
    }
}

#[test]
fn oracle_segments_beyond_a_limit_go_to_the_candidates_that_lack_most() {
    let diagonal = |a: f64, b: f64, c: f64| vec![a, 0.0, 0.0, 0.0, b, 0.0, 0.0, 0.0, c];
    let each = [diagonal(1.0, 0.1, 0.1), diagonal(0.1, 2.0, 0.1), diagonal(0.1, 0.1, 3.0)];
    let all = candidates(3, &each.iter().map(Vec::as_slice).collect::<Vec<_>>());
    let options = CountOptions { exhaustive: 0, ..CountOptions::default() };
    // 6, 3 and 1 of ten; three of the first are left. The second has 4/0.3 per share, then 5/0.3, the third 2/0.1.
    let found = count_segments(&all, &[0.6, 0.3, 0.1], 10, Some(&[3, 10, 10]), &options).unwrap();
    let log_det = |counts: [f64; 3]| {
        let sum = |k: usize| (0..3).map(|q| counts[q] / 10.0 * each[q][4 * k]).sum::<f64>();
        (0..3).map(|k| sum(k).ln()).sum::<f64>()
    };
    assert!((found.apportioned - log_det([3.0, 6.0, 1.0])).abs() < 1e-12, "{found:?}");
}

#[test]
fn oracle_whole_segments_need_less_time_than_apportioned_ones_for_the_same_information() {
    // Half of each is best; three segments are two and one, and five with two of the first at most are two and three.
    let all = candidates(2, &[&[4.0, 0.0, 0.0, 0.0], &[0.0, 0.0, 0.0, 1.0]]);
    let design = solve(&all, &Options::default()).unwrap();
    let criterion = Criterion::Information(all);
    let of = |total, limits: Option<Vec<u64>>, shares: [f64; 2]| {
        let design = design::Design { shares: shares.to_vec(), ..design.clone() };
        let segments = Segments { total, samples: 10, limits };
        counted(&criterion, &design, &segments, &CountOptions::default(), 2).unwrap()
    };
    let found = of(5, Some(vec![2, 5]), [0.5, 0.5]);
    assert_eq!(found.counts, [2, 3]);
    // |M|^(1/2) of 2/5 and 3/5 against 1/2 and 1/2.
    assert!((found.efficiency - (0.24_f64 / 0.25).sqrt()).abs() < 1e-9, "{found:?}");
    // Shares that are not the best: apportioned they are four and one.
    let found = of(5, None, [0.8, 0.2]);
    assert_eq!(found.counts.iter().sum::<u64>(), 5);
    assert!((found.apportioned - (0.16_f64 / 0.24).sqrt()).abs() < 1e-9, "{found:?}");
}
