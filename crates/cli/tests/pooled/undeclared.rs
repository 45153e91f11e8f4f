//! Logs without stated noise, some of them useless: statements about the model.

use crate::support::{edit, json, put, run, written};
use tempfile::TempDir;

const RATE_HZ: f64 = 8.0;
const SAMPLES: usize = 900;

/// The conditions of a log of the paper's ship.
#[derive(Clone, Copy)]
struct Log {
    /// Standard deviation of the sensors.
    noise: f64,
    /// Increments of every state per sample by waves of 3 s.
    waves: f64,
    /// Whether the thrusters run.
    driven: bool,
    /// Her drag relative to the paper's ship.
    drag: f64,
    seed: u64,
}

const HEALTHY: Log = Log { noise: 0.0158, waves: 0.0, driven: true, drag: 1.0, seed: 1 };

/// Numbers of mean 0 and standard deviation 1.
struct Normals(u64);

impl Normals {
    fn next(&mut self) -> f64 {
        let mut one = || {
            self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
            (self.0 >> 11) as f64 / (1_u64 << 53) as f64
        };
        (0..12).map(|_| one()).sum::<f64>() - 6.0
    }
}

/// The log as text: t, u, v, r, then three forces.
fn recorded(log: Log) -> String {
    let mut normals = Normals(log.seed);
    let mut text = "t,u,v,r,tau1,tau2,tau3\n".to_owned();
    let mut state = [if log.driven { 1.0 } else { 0.0 }, 0.0, 0.0];
    for k in 0..=SAMPLES {
        let t = k as f64 / RATE_HZ;
        let block = |period: f64, levels: &[f64]| levels[(t / period) as usize % levels.len()];
        let driven = f64::from(u8::from(log.driven));
        let tau1 = driven * block(17.0, &[5200.0, 1500.0, 9000.0, 3200.0, 7000.0]);
        let tau3 = driven * block(6.5, &[180.0, -220.0, 60.0, -120.0, 240.0, 0.0, -60.0]);
        let tau2 = -2.5 * tau3 + driven * block(11.0, &[900.0, -700.0, 0.0, 1500.0]);
        let [y_u, y_v, y_r] = state.map(|x| x + log.noise * normals.next());
        text += &format!("{t:.3},{y_u:.6},{y_v:.6},{y_r:.6},{tau1:.3},{tau2:.3},{tau3:.3}\n");
        let [u, v, r] = state;
        let wave = |d: f64| log.waves * (std::f64::consts::TAU * t / 3.0 + log.seed as f64 + 2.0 * d).sin();
        state = [
            u - log.drag * (0.06 * u + 0.01 * u * u.abs()) + 1.4e-5 * tau1 + 0.08 * v * r + wave(0.0),
            v - log.drag * 0.1 * v + 1.4e-5 * tau2 - 0.006 * u * r + wave(1.0),
            r - 0.35 * r + 3.0e-4 * tau3 - 0.03 * u * v + wave(2.0),
        ];
    }
    text
}

/// A study with the runs of these logs, as `ingest` reads them.
fn ingested(logs: &[Log]) -> TempDir {
    let folder = written(1);
    let channels = [
        ("u", "y_u", "m/s"),
        ("v", "y_v", "m/s"),
        ("r", "y_r", "rad/s"),
        ("tau1", "tau1", "N"),
        ("tau2", "tau2", "N"),
        ("tau3", "tau3", "N m"),
    ];
    let mut config =
        "design = \"sea\"\nsample_rate_hz = 8.0\nmax_gap_s = 1.0\n\n[[file]]\npattern = [\"*.csv\"]\n\
                      time = { column = \"t\", unit = \"s\" }\n"
            .to_owned();
    for (column, channel, unit) in channels {
        config += &format!(
            "\n[[file.channel]]\ncolumn = \"{column}\"\nchannel = \"{channel}\"\nunit = \"{unit}\"\n"
        );
    }
    put(&folder, "ingest.toml", &config);
    for (i, log) in logs.iter().enumerate() {
        put(&folder, &format!("log{i}.csv"), &recorded(*log));
    }
    run(&folder, "ingest --config ingest.toml --vessel vessel.toml --out logs.parquet").succeeds();
    folder
}

/// Every run by itself.
const EACH: &str =
    "estimate --fit each --vessel vessel.toml --trajectories logs.parquet --out estimates.parquet";
/// All runs together.
const ALL: &str = "estimate --structure own --vessel vessel.toml --trajectories logs.parquet --estimator prediction-error --out estimates.parquet";

/// The statements about the pooled model.
fn statements(folder: &TempDir) -> String {
    run(folder, ALL).succeeds();
    json(folder, "estimate.json")["data"]["trust"]["statements"].to_string()
}

#[test]
fn the_noise_of_a_healthy_log_is_found_and_its_model_is_not_rejected() {
    let folder = ingested(&[HEALTHY]);
    let ran = run(&folder, EACH).succeeds();
    assert!(!ran.stdout.contains("approximate"), "{ran}");
    let summary = json(&folder, "estimate.json")["data"].clone();
    assert_eq!(
        summary["estimator"], "prediction-error",
        "of a measured log, of which nobody states the noise"
    );
    // Ten parameters within four of their standard errors.
    for own in summary["designs"][0]["parameters"].as_array().unwrap() {
        let [mean, truth, error] = ["mean", "truth", "predicted_se"].map(|key| own[key].as_f64().unwrap());
        assert!((mean - truth).abs() < 4.0 * error, "{own}");
    }
    let said = statements(&folder);
    assert!(said.contains("model not rejected") && said.contains("turns: white noise"), "{said}");
    // It is the default estimator for logs.
    let model = || json(&folder, "model.json")["data"].clone();
    let asked = model();
    run(&folder, &ALL.replace(" --estimator prediction-error", "")).succeeds();
    assert_eq!(asked, model());
}

#[test]
fn a_log_of_noise_alone_gives_no_model() {
    let folder = ingested(&[Log { driven: false, ..HEALTHY }]);
    run(&folder, EACH).refuses(4, &["logs.parquet", "`X_tau`", "no run that excites it"]);
    for estimator in ["ls", "iv"] {
        let line = format!("{} --estimator {estimator}", ALL.replace(" --estimator prediction-error", ""));
        let remedy =
            ["no degree of freedom that is identifiable", "or name a --prior for `ls`, `iv` or `auto`"];
        run(&folder, &line).refuses(4, &remedy);
        run(&folder, &format!("{line} --prior 0.03")).succeeds();
    }
    run(&folder, ALL).refuses(4, &["logs.parquet", "no degree of freedom that is identifiable"]);
}

#[test]
fn a_log_without_noise_gives_the_ship_itself() {
    let folder = ingested(&[Log { noise: 0.0, ..HEALTHY }]);
    run(&folder, EACH).succeeds();
    let summary = json(&folder, "estimate.json")["data"].clone();
    for own in summary["designs"][0]["parameters"].as_array().unwrap() {
        // Six digits are logged.
        assert!(own["relative_bias"].as_f64().unwrap().abs() < 1e-3, "{own}");
    }
    let said = statements(&folder);
    assert!(said.contains("model not rejected"), "{said}");
}

#[test]
fn waves_that_no_noise_known_here_describes_get_no_verdict_and_no_standard_errors() {
    let folder = ingested(&[Log { waves: 0.01, ..HEALTHY }]);
    let ran = run(&folder, EACH).succeeds();
    assert!(ran.stdout.contains("1 without standard errors: waves move the ship"), "{ran}");
    let said = statements(&folder);
    assert!(said.contains("no verdict on the model: its errors oscillate"), "{said}");
    assert!(said.contains("no standard errors are given; choose a calm day"), "{said}");
    let trust = &json(&folder, "estimate.json")["data"]["trust"];
    let own = trust["degrees"].as_array().unwrap().iter().flat_map(|d| d["parameters"].as_array().unwrap());
    assert!(
        own.clone().count() > 0
            && own.into_iter().all(|p| p.get("standard_error").is_none_or(|e| e.is_null())),
        "{trust}"
    );
}

/// Logs of the paper's ship and of others, by their drag.
fn of_ships(drags: &[f64]) -> TempDir {
    let logs = drags.iter().zip(1..).map(|(drag, seed)| Log { drag: *drag, seed, ..HEALTHY });
    ingested(&logs.collect::<Vec<Log>>())
}

#[test]
fn a_recording_of_another_ship_is_named_and_two_ships_pooled_give_no_model_to_trust() {
    let alike = statements(&of_ships(&[1.0; 4]));
    assert!(alike.contains("model not rejected") && !alike.contains("contradict"), "{alike}");
    let folder = of_ships(&[1.0, 1.0, 1.3, 1.0]);
    let one = statements(&folder);
    assert!(
        one.contains("model rejected") && one.contains("recording `log2` contradicts the others"),
        "{one}"
    );
    let criticism = json(&folder, "estimate.json")["data"]["trust"]["criticism"].clone();
    let apart = criticism["apart"].as_array().unwrap();
    assert!(apart.len() == 1 && apart[0]["recording"] == "log2", "{criticism}");
    let two = statements(&of_ships(&[1.0, 1.3, 1.0, 1.3]));
    assert!(two.contains("model rejected") && two.contains("contradict the others"), "{two}");
}

#[test]
fn a_rudder_that_counts_to_the_other_side_is_named_with_its_remedy() {
    let case = crate::support::repository().join("../shared/cases-2/140-rudder-inverted-estimate");
    if !case.is_dir() {
        println!("skipped: there is no {}", case.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    for entry in std::fs::read_dir(case).unwrap() {
        let path = entry.unwrap().path();
        std::fs::write(folder.path().join(path.file_name().unwrap()), std::fs::read(&path).unwrap()).unwrap();
    }
    let made = "--vessel vessel.toml --trajectories t.parquet";
    let pooled = |sign: &str| {
        let config = std::fs::read_to_string(folder.path().join("ingest.toml")).unwrap();
        let own = "channel = \"delta\", unit = \"rad\"";
        put(&folder, "own.toml", &config.replace(own, &format!("{own}{sign}")));
        run(&folder, "ingest --config own.toml --vessel vessel.toml --out t.parquet").succeeds();
        let ran =
            run(&folder, &format!("estimate --structure own {made} --out estimates.parquet")).succeeds();
        (ran.stdout, json(&folder, "estimate.json")["data"]["trust"]["statements"].to_string())
    };
    let (line, said) = pooled("");
    let wrong = "`delta` acts with the opposite sign";
    for piece in [wrong, "`Y_uud`", "`N_uud`", "set `sign = -1`"] {
        assert!(said.contains(piece) && line.contains(piece), "{line}{said}");
    }
    assert!(said.contains(&format!("model rejected (p < 0.0001): {wrong}")), "{said}");
    let search = format!("estimate --structure library {made} --folds 3 --out estimate.json");
    let searched = run(&folder, &search).succeeds().stdout;
    assert!(searched.contains(wrong), "{searched}");
    let (line, said) = pooled(", sign = -1");
    assert!(!said.contains("opposite sign") && !line.contains("opposite sign"), "{line}{said}");
    let searched = run(&folder, &search).succeeds().stdout;
    assert!(!searched.contains(wrong), "{searched}");
    // No maneuver alone tells of a thrust that never changes.
    edit(&folder, "vessel.toml", "nominal = 0.02958", "fixed = true");
    run(&folder, "ingest --config ingest.toml --vessel vessel.toml --out t.parquet").succeeds();
    let single =
        run(&folder, &format!("estimate --fit each {made} --estimator ls --out single.parquet")).succeeds();
    assert!(single.stdout.contains(wrong), "{single}");
}
