//! Against numbers computed by numpy and scipy: `fixtures/oracle/chain.json`, written by `scripts/independent/chain.py`.

use logs::Law;
use logs::chain::{
    Actuator, Chain, Commanded, Compass, Drift, Gnss, Hull, Key, Logged, Recording, Weather, Wind,
};
use serde_json::Value;
use ship::engine::Helm;
use ship::model::{Source, Vessel, VesselFile};

const ORACLE: &str = include_str!("../../../../fixtures/oracle/chain.json");

fn actuator(position_m: [f64; 2]) -> Actuator {
    Actuator {
        position_m,
        coefficient: 1.44,
        law: Law::Quadratic,
        speed_limit_rps: Some(24.0),
        speed_rate_limit_rps_s: Some(12.0),
        angle_rate_limit_rad_s: Some(0.9),
        speed_std_rps: 0.0,
        speed_resolution_rps: 0.0,
        angle_std_rad: 0.0,
        angle_resolution_rad: 0.0,
        logged: Logged::Setting,
    }
}

/// The script's recording: the numbers stand there too.
fn recording() -> Recording {
    let file: VesselFile = toml::from_str("preset = \"ljungberg-model-ship\"").unwrap();
    let vessel = Vessel::from_file(file).unwrap();
    let parameters = vessel.parameters(Source::Value).unwrap();
    let chain = Chain {
        model: &vessel.model,
        parameters: &parameters,
        rate_hz: 2.0,
        units: [1.0; 3],
        actuators: &[actuator([-0.4, -0.15]), actuator([-0.4, 0.1]), actuator([0.5, 0.02])],
        gnss: Gnss {
            rate_hz: 2.0,
            white_std_m: 0.0,
            wander_std_m: 0.0,
            wander_time_s: None,
            resolution_m: 0.0,
        },
        compass: Compass {
            white_std_rad: 0.0,
            wander_std_rad: 0.0,
            wander_time_s: None,
            resolution_rad: 0.0,
        },
        hull: Some(Hull {
            frontal_area_m2: 30.0,
            lateral_area_m2: 80.0,
            length_m: 4.0,
            c_x: 0.6,
            c_y: 0.9,
            c_n: 0.15,
        }),
        scatter_std: 0.0,
        course_rad: Some(0.7),
    };
    let wanted = |k: usize| {
        let k = k as f64;
        let turn = 150.0 * (0.4 * k).sin();
        [3000.0 * (0.15 * k).cos(), -2.0 * turn + 300.0, turn + 40.0]
    };
    let forces: Vec<f64> = (0..40).flat_map(wanted).collect();
    let (helm, initial) = (Helm::table(&forces), [0.5, 0.1, 0.02]);
    let commanded = Commanded { helm, is_mirrored: false, initial, samples: 40 };
    let weather = Weather {
        current: Drift { north_m_s: 0.2, east_m_s: -0.1, std_m_s: 0.0, time_s: None },
        wind: Some(Wind { speed_m_s: 6.0, from_rad: 2.2, gust_std_m_s: 0.0, gust_time_s: None }),
    };
    let key = Key { seed: 1, maneuver: "any", repeat: 0 };
    chain.record(key, &commanded, &weather, 0).unwrap()
}

fn numbers(value: &Value) -> Vec<f64> {
    match value.as_array() {
        Some(all) => all.iter().flat_map(numbers).collect(),
        None => vec![value.as_f64().unwrap()],
    }
}

#[track_caller]
fn same(found: &[f64], expected: &Value, tolerance: f64) {
    let expected = numbers(expected);
    assert_eq!(found.len(), expected.len());
    for (i, (found, expected)) in found.iter().zip(expected).enumerate() {
        assert!((found - expected).abs() <= tolerance, "{i}: found {found}, expected {expected}");
    }
}

#[test]
fn oracle_thrusters_wind_current_and_motion() {
    let oracle: Value = serde_json::from_str(ORACLE).unwrap();
    let recording = recording();
    let truth = &recording.truth;
    let settings: Vec<f64> = truth.settings.iter().flatten().flat_map(|s| [s.n, s.alpha]).collect();
    same(&settings, &oracle["settings"], 1e-9);
    same(truth.forces.as_flattened(), &oracle["forces"], 1e-6);
    same(truth.states.as_flattened(), &oracle["states"], 1e-10);
    // Simpson's rule against an adaptive solver: it errs by h^5/2880 times the fourth derivative, below 1e-5 m in a step of
    // h = 0.5 s with speeds below 1 m/s and yaw accelerations below 0.6 rad/s^2; 40 steps. The trapezoidal rule would be off
    // by up to 5e-3 m in one.
    let poses: Vec<f64> = truth.poses.iter().flat_map(|p| [p.x, p.y, p.psi]).collect();
    same(&poses, &oracle["poses"], 4e-4);
    let hits: Vec<f64> =
        recording.hits.iter().flat_map(|h| [h.speed, h.speed_rate, h.angle_rate]).map(|n| n as f64).collect();
    same(&hits, &oracle["hits"], 0.0);
}
