//! Moments of several runs of a maneuver.

use estimation::pooled::Covariance;
use trial::moments::{DegreeMoments, ManeuverMoments, OutputErrorMoments, Pool, PriorInformation};

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

/// Of parameters of very different size, beside one at a bound and one that the fit does not know.
#[test]
fn law_what_a_fit_knows_is_the_inverse_of_its_covariance() {
    let names = ["a", "bound", "b", "constant"];
    let covariance = Covariance {
        joint: true,
        names: names.map(str::to_owned).to_vec(),
        entries: vec![
            4e-12, 0.0, 1e-3, 3e-6, //
            0.0, 0.0, 0.0, 0.0, //
            1e-3, 0.0, 1e6, 2.0, //
            3e-6, 0.0, 2.0, 9.0,
        ],
        parts: None,
    };
    let sigma = |name: &str| ["bound", "c"].contains(&name).then_some(0.5);
    let known = PriorInformation::new(["a", "b", "bound", "c", "d"].into_iter(), Some(&covariance), sigma);
    let PriorInformation { parameters, information } = known.unwrap();
    assert_eq!(parameters, ["a", "b", "bound", "c"]);
    // The constant is not asked for: the rest is what it leaves of the others.
    let part = [[4e-12, 1e-3, 0.0, 0.0], [1e-3, 1e6, 0.0, 0.0], [0.0, 0.0, 0.25, 0.0], [0.0, 0.0, 0.0, 0.25]];
    for (i, row) in part.iter().enumerate() {
        for j in 0..4 {
            let product: f64 = (0..4).map(|k| row[k] * information[4 * k + j]).sum();
            let unit = row[i].sqrt() / part[j][j].sqrt();
            assert!(
                (product - f64::from(u8::from(i == j))).abs() < 1e-12 * unit.max(1.0),
                "{i}, {j}: {product}"
            );
        }
    }
    assert!(PriorInformation::new(["d"].into_iter(), Some(&covariance), sigma).is_none());
}
