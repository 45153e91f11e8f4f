//! Moments of several runs of a maneuver.

use trial::moments::{DegreeMoments, ManeuverMoments, OutputErrorMoments, Pool};

fn moments(samples: u64, entry: f64) -> ManeuverMoments {
    let degree = DegreeMoments {
        name: "surge".into(),
        shape: [1, 1],
        m: vec![entry],
        nonstationarity: entry,
        b: Some(vec![2.0 * entry]),
    };
    let output_error = OutputErrorMoments { f: vec![entry], e: None, p: Some(vec![-entry]) };
    ManeuverMoments { name: "turn".into(), samples, degrees: vec![degree], output_error: Some(output_error) }
}

#[test]
fn law_pooled_moments_are_means_over_all_samples() {
    let mut found = moments(10, 1.0);
    found.pool(&moments(30, 5.0));
    assert_eq!((found.samples, found.degrees[0].m[0], found.degrees[0].nonstationarity), (40, 4.0, 5.0));
    assert_eq!(found.degrees[0].b, Some(vec![8.0]));
    let expected = OutputErrorMoments { f: vec![4.0], e: None, p: Some(vec![-4.0]) };
    assert_eq!(found.output_error, Some(expected));
}

#[test]
fn a_maneuver_that_stands_for_one_run_is_not_pooled() {
    let mut pool = Pool::default();
    pool.add(false, moments(10, 1.0)).unwrap();
    assert!(pool.add(false, moments(1, 0.0)).unwrap_err().to_string().contains("two runs"));
}
