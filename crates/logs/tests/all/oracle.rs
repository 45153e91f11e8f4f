//! Against numbers computed by numpy and scipy: `fixtures/oracle/ingest.json`, written by `scripts/independent/ingest.py`.

use logs::{Law, Lever, Series, Thruster, euler, lag, noise_std};
use serde_json::Value;

use crate::parabolas;

const ORACLE: &str = include_str!("../../../../fixtures/oracle/ingest.json");

fn oracle(key: &str) -> Value {
    serde_json::from_str::<Value>(ORACLE).unwrap()[key].take()
}

/// Numbers; NaN for null.
fn numbers(value: &Value) -> Vec<f64> {
    value.as_array().unwrap().iter().map(|x| x.as_f64().unwrap_or(f64::NAN)).collect()
}

fn pair(value: &Value) -> [f64; 2] {
    numbers(value).try_into().unwrap()
}

fn number(value: &Value) -> f64 {
    value.as_f64().unwrap()
}

#[track_caller]
fn same(found: &[f64], expected: &[f64], tolerance: f64) {
    assert_eq!(found.len(), expected.len());
    for (k, (found, expected)) in found.iter().zip(expected).enumerate() {
        let both = found.is_nan() && expected.is_nan();
        assert!(both || (found - expected).abs() <= tolerance, "{k}: found {found}, expected {expected}");
    }
}

#[test]
fn oracle_euler_differences() {
    let case = oracle("euler");
    let [x, y, psi] = ["x", "y", "psi"].map(|name| numbers(&case[name]));
    let poses = (0..psi.len()).map(|k| [x[k], y[k], psi[k]]);
    let made: Vec<[f64; 3]> = euler(poses, number(&case["dt"])).collect();
    for (d, name) in ["u", "v", "r"].into_iter().enumerate() {
        let found: Vec<f64> = made.iter().map(|velocity| velocity[d]).collect();
        let (last, known) = found.split_last().unwrap();
        assert!(last.is_nan());
        same(known, &numbers(&case[name]), 1e-12);
    }
}

#[test]
fn oracle_smoother_is_the_filter_of_savitzky_and_golay_and_fits_uneven_clocks() {
    let case = oracle("smoother");
    let values = numbers(&case["values"]);
    for (clock, window, smooth, slope) in
        [("t", "window", "smooth", "slope"), ("uneven_t", "uneven_window", "uneven_smooth", "uneven_slope")]
    {
        let window = case[window].as_u64().unwrap() as usize;
        let (found, found_slope) = parabolas(&numbers(&case[clock]), &values, window);
        same(&found, &numbers(&case[smooth]), 1e-12);
        same(&found_slope, &numbers(&case[slope]), 1e-10);
    }
}

#[test]
fn oracle_noise() {
    let case = oracle("noise");
    let series = Series::new(&numbers(&case["t"]), &numbers(&case["values"]), 0.5);
    let found = noise_std(&series).unwrap();
    approx::assert_relative_eq!(found, number(&case["std"]), max_relative = 1e-9);
    assert!((found - 0.02).abs() < 0.002, "{found}");
}

#[test]
fn oracle_resampling() {
    let case = oracle("resampling");
    let series = Series::new(&numbers(&case["t"]), &numbers(&case["values"]), number(&case["max_gap_s"]));
    let at = |series: &Series| series.at(numbers(&case["grid"])).collect::<Vec<_>>();
    same(&at(&series), &numbers(&case["plain"]), 1e-12);
    same(&at(&series.averaged(number(&case["average_s"]))), &numbers(&case["averaged"]), 1e-12);
}

#[test]
fn oracle_lever_arm() {
    for case in oracle("lever").as_array().unwrap() {
        let lever = Lever(pair(&case["arm"]));
        let position = lever.position(pair(&case["position"]), number(&case["psi"]));
        same(&position, &pair(&case["reference_position"]), 1e-12);
        let velocity = lever.velocity(pair(&case["velocity"]), number(&case["r"]));
        same(&velocity, &pair(&case["reference_velocity"]), 1e-14);
    }
}

#[test]
fn oracle_azimuth_thrusters() {
    for case in oracle("azimuth").as_array().unwrap() {
        let thruster = Thruster {
            law: Law::Quadratic,
            coefficient: number(&case["coefficient"]),
            position_m: pair(&case["position_m"]),
        };
        let found = thruster.forces(number(&case["n"]), number(&case["alpha"]));
        same(&found, &numbers(&case["forces"]), 1e-14);
    }
}

#[test]
fn oracle_lag() {
    let case = oracle("lag");
    let [measured, reference] = ["measured", "reference"].map(|name| numbers(&case[name]).into());
    let found = lag(&measured, &reference, number(&case["rate_hz"]), 5.0).unwrap();
    approx::assert_abs_diff_eq!(found, number(&case["lag_s"]), epsilon = 1e-6);
    assert!((found - 0.73).abs() < 0.02, "{found}");
}
