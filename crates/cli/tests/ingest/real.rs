//! Measured logs that are not part of the project: `../shared/data` next to it. Without them these tests say so and
//! pass.

use std::path::{Path, PathBuf};

use study::documents::{MotionSummary, RecordingSummary, State};

use crate::runner::*;

fn data(name: &str) -> Option<PathBuf> {
    let folder = repository("../shared/data").join(name);
    if !folder.is_dir() {
        eprintln!("skipped: there is no {}", folder.display());
        return None;
    }
    Some(folder)
}

fn ingest_study(study: &str, logs: &Path, vessel: bool) -> Made {
    let pipeline = repository("pipelines").join(study);
    let mut more = vec!["--config", "ingest.toml", "--logs", logs.to_str().unwrap()];
    if vessel {
        more.extend(["--vessel", "vessel.toml"]);
    }
    ingest(&pipeline, &more)
}

fn state(recording: &RecordingSummary, state: State) -> &MotionSummary {
    recording.motion.iter().find(|m| m.state == state).unwrap()
}

#[test]
fn all_logs_of_the_esso_osaka_model_are_taken() {
    let Some(logs) = data("esso_osaka") else { return };
    let made = ingest_study("esso-osaka", &logs, true);
    let recordings = &made.summary.recordings;
    assert_eq!(recordings.len(), 23);
    let sum = |f: &dyn Fn(&RecordingSummary) -> u64| recordings.iter().map(f).sum::<u64>();
    assert_eq!(sum(&|r| r.rows.empty), 327, "zigzag_31-Jul-2020_13_50_28 ends in empty rows");
    assert_eq!(sum(&|r| r.rows.repeated + r.rows.without_time + r.rows.cut + r.splits), 0);
    // Windows of a minute: the rest of each recording is shorter.
    assert_eq!(made.rows as u64, made.summary.samples + made.summary.runs);
    for r in recordings {
        let whole = (r.duration_s / 60.0 + 1e-6).floor() as u64;
        assert_eq!((r.segments, r.samples), (whole, 60 * whole), "{}", r.name);
    }
    let late = recordings.iter().find(|r| r.name == "random_06-Aug-2020_16_24_25_4").unwrap();
    assert_eq!(late.duration_s, 607.0, "a clock that starts at 1894 s");
    let n = late.channels.iter().find(|c| c.name == "n").unwrap();
    assert!(n.min.unwrap() < -9.9 && n.max.unwrap() > 0.0);
    // What vessel.toml derives follows the propeller's speed at every sample.
    for row in (0..made.rows).filter(|row| !made.columns["n"].is_null(*row)) {
        assert_eq!(made.f64("n_reverse")[row], made.f64("n")[row].min(0.0), "row {row}");
    }
    let kinds: Vec<&str> = made.maneuvers();
    for kind in ["zigzag/fast", "turning/medium", "random/slow", "berthing/slow"] {
        assert!(kinds.contains(&kind), "{kind}");
    }
}

#[test]
fn the_esso_osakas_measured_velocities_lag_the_derivative_of_its_position() {
    let Some(logs) = data("esso_osaka") else { return };
    let made = ingest_study("esso-osaka", &logs, false);
    for r in &made.summary.recordings {
        for name in [State::U, State::V] {
            let found = state(r, name);
            assert!(found.rms <= 0.04, "{}: {found:?}", r.name);
            let lag = found.lag_s.unwrap();
            assert!((0.2..1.5).contains(&lag), "{}: {found:?}", r.name);
        }
        assert!(state(r, State::R).rms < 0.015, "{}: {:?}", r.name, state(r, State::R));
    }
}

#[test]
fn all_zig_zags_of_the_kvlcc2_model_are_taken() {
    let Some(logs) = data("kvlcc2_hsva") else { return };
    let made = ingest_study("kvlcc2", &logs, true);
    assert_eq!(made.summary.recordings.len(), 13);
    assert_eq!((made.summary.runs, made.summary.samples, made.rows), (13, 2120, 2133));
    for r in &made.summary.recordings {
        assert!(
            r.channels.iter().all(|c| (c.rate_hz.unwrap() - 20.0).abs() < 1e-6 && c.gaps + c.missing == 0)
        );
        for found in &r.motion {
            assert!(found.rms < 1e-3 && found.lag_s.unwrap().abs() < 0.05, "{}: {found:?}", r.name);
        }
    }
    assert!(made.maneuvers().contains(&"Z_20_10_P"));
    assert!(made.columns.contains_key("roll") && made.units["thrust"] == "N");
}
