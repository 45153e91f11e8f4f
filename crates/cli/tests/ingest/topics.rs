//! The made-up logs in `fixtures/logs`: one file per topic, several clocks, formats and conventions at once.

use study::documents::State;
use study::files::read_vessel;
use study::trajectories::{Layout, TrajectoryReader};

use crate::runner::*;

/// Surge, sway, yaw rate at time `t`, as scripts/independent/ingest.py has them.
fn motion(t: f64) -> [f64; 3] {
    [1.0 + 0.2 * (0.15 * t).sin(), 0.1 * (0.2 * t).sin(), 0.12 * (0.1 * t).cos()]
}

fn forces(t: f64) -> [f64; 3] {
    let n = 10.0 + (0.3 * t).sin();
    let (sin, cos) = (20.0 * (0.2 * t).sin()).to_radians().sin_cos();
    let force = 0.05 * n * n;
    [force * cos, force * sin, -2.0 * force * sin]
}

#[test]
fn law_the_motion_that_the_logs_were_made_of_comes_back() {
    let made = ingest(&repository("fixtures/logs"), &["--config", "ingest.toml"]);
    assert_eq!(made.summary.recordings.iter().map(|r| r.name.as_str()).collect::<Vec<_>>(), ["a", "b"]);
    assert!(made.columns["design"].text_at(0) == Some("made-up"));
    for (run, seconds) in [(0, 60), (1, 45)] {
        let rows = made.rows_of(run);
        // The gyro's last value happened 0.2 s before the end.
        assert_eq!(rows.len(), 2 * seconds, "run {run}");
        for (k, &row) in rows.iter().enumerate() {
            let t = 0.5 * k as f64;
            assert_eq!(made.f64("t")[row], t);
            for (name, expected, tolerance) in
                [("y_u", motion(t)[0], 0.004), ("y_v", motion(t)[1], 0.004), ("y_r", motion(t)[2], 1e-5)]
            {
                let found = made.f64(name)[row];
                assert!((found - expected).abs() < tolerance, "{name} at {t} s: {found}, not {expected}");
            }
            if k + 1 < rows.len() {
                for (name, expected) in ["tau1", "tau2", "tau3"].into_iter().zip(forces(t)) {
                    let found = made.f64(name)[row];
                    assert!((found - expected).abs() < 0.02, "{name} at {t} s: {found}, not {expected}");
                }
            } else {
                assert!(made.columns["tau1"].is_null(row), "the last row has no inputs");
            }
        }
    }
}

#[test]
fn labels_become_maneuvers() {
    let made = ingest(&repository("fixtures/logs"), &["--config", "ingest.toml"]);
    let names = made.maneuvers();
    let rows = made.rows_of(0);
    assert!(rows[..40].iter().all(|row| names[*row] == "turn" && made.i32("segment")[*row] == 0));
    assert!(rows[40..].iter().all(|row| names[*row] == "straight" && made.i32("segment")[*row] == 1));
    assert_eq!(made.summary.maneuvers.len(), 2);
    assert_eq!(made.summary.maneuvers[0].samples, 80);
}

#[test]
fn trajectories_are_read_by_the_next_stage_in_the_vessels_units() {
    let logs = repository("fixtures/logs");
    let out = tempfile::tempdir().unwrap();
    let target = out.path().join("trajectories.parquet");
    let more =
        ["--config", "ingest.toml", "--vessel", "vessel.toml", "--json", "--out", target.to_str().unwrap()];
    let ran = run(&logs, &more);
    assert_eq!(ran.code, Some(0), "{}", ran.stderr);
    assert!(ran.stdout.contains("\"runs\":2"), "{}", ran.stdout);
    let vessel = read_vessel(&logs.join("vessel.toml"), &mut Default::default()).unwrap();
    let reader = TrajectoryReader::open(&target, &Layout::new(&vessel.model), 2.0).unwrap();
    let runs = reader.runs(0).unwrap();
    assert_eq!(runs.len(), 2);
    assert_eq!((runs[0].samples(), runs[0].segments.len()), (119, 2));
    let [x, _, n] = forces(10.0).map(|force| force / 1000.0);
    let row = &runs[0].exogenous[3 * 20..3 * 21];
    assert!((row[0] - x).abs() < 2e-5 && (row[2] - n).abs() < 2e-5, "{row:?} for {x}, {n}");
    assert_eq!(runs[0].initial[..], runs[0].measured[..3]);
}

#[test]
fn the_same_logs_give_the_same_bytes_for_any_number_of_threads() {
    let out = tempfile::tempdir().unwrap();
    let bytes = ["1", "2", "7"].map(|threads| {
        let target = out.path().join(format!("{threads}/"));
        std::fs::create_dir(&target).unwrap();
        let target = target.to_str().unwrap();
        let ran = run(
            &repository("fixtures/logs"),
            &["--config", "ingest.toml", "--threads", threads, "--out", target],
        );
        assert_eq!(ran.code, Some(0), "{}", ran.stderr);
        ["trajectories.parquet", "ingest.json"]
            .map(|name| std::fs::read(std::path::Path::new(target).join(name)).unwrap())
    });
    assert!(bytes[0] == bytes[1] && bytes[1] == bytes[2]);
}

#[test]
fn the_summary_tells_rates_noise_and_lags() {
    let made = ingest(&repository("fixtures/logs"), &["--config", "ingest.toml"]);
    let a = &made.summary.recordings[0];
    let channel = |name: &str| a.channels.iter().find(|c| c.name == name).unwrap();
    assert!((channel("psi").rate_hz.unwrap() - 10.0).abs() < 1e-3, "{:?}", channel("psi"));
    assert!((channel("x").rate_hz.unwrap() - 5.0).abs() < 1e-3);
    assert!((channel("speed").max.unwrap() - 11.0).abs() < 0.01 && channel("speed").unit == "1/s");
    assert!((channel("psi").min.unwrap() - 4.7).abs() < 0.1, "unwrapped: {:?}", channel("psi"));
    let yaw = &a.motion[0];
    assert_eq!(yaw.state, State::R);
    assert!(yaw.rms < 2e-3 && yaw.lag_s.unwrap().abs() < 0.02, "{yaw:?}");
}

#[test]
fn a_delay_that_is_not_corrected_is_found() {
    let logs = repository("fixtures/logs");
    let text = std::fs::read_to_string(logs.join("ingest.toml")).unwrap();
    let folder = folder(&[("ingest.toml", &text.replace("delay_s = 0.2\n", ""))]);
    let made = ingest(folder.path(), &["--config", "ingest.toml", "--logs", logs.to_str().unwrap()]);
    let lag = made.summary.recordings[0].motion[0].lag_s.unwrap();
    assert!((lag - 0.2).abs() < 0.02, "{lag}");
}
