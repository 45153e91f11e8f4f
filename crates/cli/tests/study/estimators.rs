//! Estimators by name, one by one and compared, through the real binaries.

use std::sync::LazyLock;

use estimation::EstimateStatus;
use tempfile::TempDir;

use crate::support::*;

const COMPARE: &str = "estimate --vessel vessel.toml --trajectories campaign.parquet \
     --estimator ls,iv,output-error,prediction-error --campaign campaign.toml --out estimates.parquet";
const NAMES: [&str; 4] = ["ls", "iv", "output-error", "prediction-error"];

/// The small study with all estimators compared.
static COMPARED: LazyLock<Study> = LazyLock::new(|| {
    let folder = with(&["campaign.parquet", "validation.parquet", "design.json"]);
    run(&folder, COMPARE).succeeds();
    run(&folder, VALIDATE).succeeds();
    Study::of(&folder)
});

fn compared() -> TempDir {
    COMPARED.with(&[
        "campaign.parquet",
        "validation.parquet",
        "estimates.parquet",
        "estimate.json",
        "scores.parquet",
        "validation.json",
        "design.json",
    ])
}

/// The text column `index` of a table, row by row.
fn texts(folder: &TempDir, file: &str, id: &'static str, index: usize) -> Vec<String> {
    let table = craft::read(&folder.path().join(file), id);
    let of = |block: &files::Table| {
        let column = &block.columns[index];
        (0..column.len()).map(|row| column.text_at(row).unwrap().to_owned()).collect::<Vec<_>>()
    };
    table.blocks.iter().flat_map(of).collect()
}

#[test]
fn compare_has_a_row_per_run_and_estimator_and_alone_each_gives_the_same() {
    let folder = compared();
    for (file, id) in [("estimates.parquet", "estimates"), ("scores.parquet", "scores")] {
        let estimators = texts(&folder, file, id, 2);
        assert_eq!(estimators.len(), 3 * RUNS as usize * NAMES.len(), "{file}");
        assert!(estimators.chunks(NAMES.len()).all(|own| own == NAMES), "{file}");
    }
    let whole = craft::read(&folder.path().join("estimates.parquet"), "estimates");
    let parameter = |table: &files::Table, row: usize| table.columns[4].value_at(row);
    let few: Vec<String> = (0..8).map(|run| format!("optimized/{run}")).collect();
    let few = format!("--runs {}", few.join(","));
    for (i, name) in NAMES.iter().enumerate() {
        let line = format!("{ESTIMATE} --estimator {name} --campaign campaign.toml {few}")
            .replace("estimates.parquet", "alone.parquet");
        run(&folder, &line).succeeds();
        let alone = craft::read(&folder.path().join("alone.parquet"), "estimates");
        for row in 0..8 {
            let (a, b) =
                (parameter(&alone.blocks[0], row), parameter(&whole.blocks[0], row * NAMES.len() + i));
            assert_eq!(a, b, "{name}, row {row}");
        }
    }
    run(&folder, &format!("{ESTIMATE} --estimator output-error,ls,ls {few}")).succeeds();
    assert_eq!(
        texts(&folder, "estimates.parquet", "estimates", 2)[..3],
        ["output-error", "ls", "output-error"]
    );
    assert_eq!(json(&folder, "estimate.json")["data"]["estimator"], "output-error");
}

#[test]
fn documents_and_page_tell_of_every_estimator_and_the_study_stays_that_of_instrumental_variables() {
    let folder = compared();
    let (estimate, validation) = (json(&folder, "estimate.json"), json(&folder, "validation.json"));
    for data in [&estimate["data"], &validation["data"]["scored"]] {
        let all = data["compared"].as_array().unwrap();
        let names: Vec<&str> = all.iter().map(|e| e["estimator"].as_str().unwrap()).collect();
        assert_eq!(names, NAMES);
        assert_eq!(all[1]["designs"], data["designs"], "the study is that of iv");
        for searched in &all[3..] {
            assert!(searched["designs"][0]["not_converged"].is_u64());
        }
    }
    let plain = with(&["validation.json"]);
    assert_eq!(
        json(&plain, "validation.json")["data"]["scored"]["designs"],
        validation["data"]["scored"]["designs"]
    );
    for recommendation in validation["data"]["scored"]["recommendations"].as_array().unwrap() {
        let (found, candidates) =
            (&recommendation["estimator"], recommendation["candidates"].as_array().unwrap());
        assert_eq!(found.is_string(), candidates.len() == 1, "{recommendation}");
        for other in recommendation["others"].as_array().unwrap() {
            let told_apart = other["interval"][0].as_f64().is_some_and(|low| low > 0.0);
            assert_eq!(told_apart, !candidates.contains(&other["estimator"]), "{other}");
        }
    }
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for name in NAMES {
        assert!(page.contains(&format!("<th scope=\"row\">{name}</th>")), "{name}");
    }
    // Statuses of estimates that the counts do not tell apart are explained.
    let status = EstimateStatus::OwnInstruments.name();
    assert!(page.to_lowercase().contains(&format!("{status}: the nominal model diverges over the run")));
    let said = validation["data"]["scored"]["recommendations"][0]["statement"].as_str().unwrap();
    assert!(page.contains(said), "{said}");
    // The parameters are those of the recommended estimator.
    let words = match validation["data"]["scored"]["recommendations"][0]["estimator"].as_str() {
        Some(best) => format!("Estimates by {best}, which the validation recommends."),
        None => "No estimator is recommended; these are the estimates by iv.".to_owned(),
    };
    assert!(page.contains(&words), "{words}");
}

#[test]
fn law_searches_are_better_than_the_papers_instruments_on_the_papers_disturbances() {
    let validation = json(&compared(), "validation.json");
    let median = |i: usize| {
        validation["data"]["scored"]["compared"][i]["designs"][0]["parameter_error"]["median"]
            .as_f64()
            .unwrap()
    };
    let [ls, iv, free, predicted] = [0, 1, 2, 3].map(median);
    assert!(iv < 0.3 * ls && free < 0.8 * iv && predicted < 0.8 * iv, "{ls} {iv} {free} {predicted}");
}

#[test]
fn law_compared_estimates_have_the_same_bytes_for_all_threads_and_shards() {
    let folder = compared();
    let whole = bytes(&folder, "estimates.parquet");
    for threads in [1, 2] {
        run(&folder, &format!("{COMPARE} --threads {threads}")).succeeds();
        assert!(bytes(&folder, "estimates.parquet") == whole, "{threads} threads");
    }
    let document = bytes(&folder, "estimate.json");
    let (line, _) = COMPARE.split_once(" --out ").unwrap();
    for k in [2, 1] {
        run(&folder, &format!("{line} --shard {k}/2 --out part-{k}.parquet")).succeeds();
    }
    run(
        &folder,
        "estimate --vessel vessel.toml --gather part-2.parquet part-1.parquet --out estimates.parquet",
    )
    .succeeds();
    assert!(bytes(&folder, "estimates.parquet") == whole && bytes(&folder, "estimate.json") == document);
}

/// Without stated disturbances, they are found from the runs.
#[test]
fn prediction_error_finds_what_disturbs_the_runs() {
    let folder = with(&["design.json"]);
    edit(&folder, "campaign.toml", &format!("realizations = {RUNS}"), "realizations = 6");
    run(&folder, CAMPAIGN).succeeds();
    let line = format!("{ESTIMATE} --estimator prediction-error");
    run(&folder, &line).succeeds();
    let found = json(&folder, "estimate.json");
    let designs = found["data"]["designs"].as_array().unwrap();
    assert!(designs.iter().any(|own| own["identified"].as_u64().is_some_and(|runs| runs > 0)), "{found}");
    assert!(
        found["settings"]["estimator"] == "prediction-error" && found["inputs"].get("campaign").is_none()
    );
}

#[test]
fn names_and_silent_sensors_are_refused() {
    let folder = with(&["campaign.parquet"]);
    refused(&folder, 2, &format!("{ESTIMATE} --estimator output-eror"), &["output-eror", "output-error"]);
    refused(&folder, 2, &format!("{ESTIMATE} --estimator auto"), &["--estimator auto", "--fit together"]);
    edit(&folder, "campaign.toml", "std_v_m_s = 0.15811388300841897", "std_v_m_s = 0.0");
    refused(&folder, 3, COMPARE, &["campaign.toml", "`measurement.std_v_m_s`", "found 0"]);
    edit(&folder, "campaign.toml", "kind = \"white\"", "kind = \"gauss-markov\"\ntime_constant_s = 0.0");
    refused(&folder, 3, CAMPAIGN, &["campaign.toml"]);
}

/// Straight ahead there is no sensitivity to sway and yaw; runs of too few samples are refused as for every
/// estimator.
#[test]
fn unexcited_runs_are_counted_and_runs_that_are_too_short_refused() {
    let folder = with(&["dictionary.parquet"]);
    let line = ESTIMATE.replace("campaign.parquet", "dictionary.parquet");
    let ran = run(&folder, &format!("{line} --estimator output-error --json")).succeeds();
    let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let statuses = texts(&folder, "estimates.parquet", "estimates", 3);
    assert_eq!(statuses[..2], ["not identifiable", "not identifiable"], "{ran}");
    let count = |status: &str| statuses.iter().filter(|own| own.starts_with(status)).count();
    assert_eq!(statuses.len(), 11);
    assert_eq!(said["identified"], count("identified"), "{ran}");
    let summary = json(&folder, "estimate.json");
    assert_eq!(summary["data"]["designs"][0]["identified"], count("identified"));
    assert_eq!(summary["data"]["designs"][0]["not_converged"], count("not converged"));
}

/// A model that is unstable for any signs of its parameters diverges from every start.
#[test]
fn searches_that_end_nowhere_are_counted_and_reported() {
    let folder = with(&["campaign.parquet", "validation.parquet"]);
    let table = craft::read(&folder.path().join("campaign.parquet"), "trajectories");
    assert!(!table.blocks.is_empty());
    // Few, noisy samples per run: many searches find no minimum.
    edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 6.0");
    let made = with(&["design.json"]);
    std::fs::copy(made.path().join("design.json"), folder.path().join("design.json")).unwrap();
    run(&folder, CAMPAIGN).succeeds();
    let ran = run(&folder, &format!("{ESTIMATE} --estimator output-error --json")).succeeds();
    let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let lost = said["not_converged"].as_u64().unwrap();
    assert!(lost > 0, "{ran}");
    let statuses = texts(&folder, "estimates.parquet", "estimates", 3);
    assert_eq!(statuses.iter().filter(|s| *s == "not converged").count() as u64, lost);
    run(&folder, &format!("{VALIDATE} --allow=mixed")).succeeds();
    let designs = json(&folder, "validation.json")["data"]["scored"]["designs"].clone();
    let told: u64 = designs.as_array().unwrap().iter().map(|d| d["not_converged"].as_u64().unwrap()).sum();
    assert_eq!(told, lost);
}

#[test]
fn lasting_currents_and_wind_disturb_and_leave_other_channels_as_they_are() {
    let folder = with(&["design.json"]);
    let measured = |folder: &TempDir| {
        run(folder, CAMPAIGN).succeeds();
        craft::read(&folder.path().join("campaign.parquet"), "trajectories")
    };
    let white = measured(&folder);
    edit(&folder, "campaign.toml", "kind = \"white\"", "kind = \"gauss-markov\"\ntime_constant_s = 20.0");
    let text = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
    let wind = "[wind]\nstd_surge_m_s2 = 0.01\nstd_sway_m_s2 = 0.01\nstd_yaw_rad_s2 = 0.01\n\n[measurement]";
    put(&folder, "campaign.toml", &text.replacen("[measurement]", wind, 1));
    let lasting = measured(&folder);
    let place = |name: &str| white.schema.columns.iter().position(|c| c.name == name).unwrap();
    let noise = |table: &craft::Whole, row: usize| {
        let value = |name: &str| table.blocks[0].columns[place(name)].as_f64().unwrap()[row];
        value("y_u") - value("u")
    };
    for row in [0, 17, 900] {
        assert!((noise(&white, row) - noise(&lasting, row)).abs() < 1e-12);
    }
    let u = |table: &craft::Whole| table.blocks[0].columns[place("u")].as_f64().unwrap()[900];
    assert!((u(&white) - u(&lasting)).abs() > 1e-4);
}

/// The small study's model is right: few of its runs reject it, by chance. Without damping in sway it is wrong, and most do.
#[test]
fn runs_are_asked_what_the_model_lacks_where_disturbances_are_stated() {
    let folder = with(&["campaign.parquet"]);
    let preset = include_str!("../../../ship/presets/ljungberg-model-ship.toml");
    let poorer: Vec<&str> = preset.split("\n\n").filter(|block| !block.contains("\"Y_v\"")).collect();
    std::fs::write(folder.path().join("poorer.toml"), poorer.join("\n\n")).unwrap();
    let rejected = |line: &str| {
        let ran = run(&folder, &format!("{line} --json")).succeeds();
        let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
        let statuses = texts(&folder, "estimates.parquet", "estimates", 3);
        let count = statuses.iter().filter(|own| *own == "identified, model rejected").count();
        let summary = json(&folder, "estimate.json");
        let designs = summary["data"]["designs"].as_array().unwrap();
        let counted: Vec<Option<u64>> = designs.iter().map(|d| d["rejected"].as_u64()).collect();
        assert_eq!(said["rejected"].as_u64(), counted.iter().copied().sum(), "{ran}");
        (said["rejected"].as_u64(), count as u64)
    };
    let right = rejected(&format!("{ESTIMATE} --campaign campaign.toml"));
    assert!(right.0 == Some(right.1) && right.1 <= RUNS, "{right:?}");
    let wrong = ESTIMATE.replace("vessel.toml", "poorer.toml");
    let wrong = rejected(&format!("{wrong} --campaign campaign.toml --allow=mixed"));
    assert!(wrong.0 == Some(wrong.1) && wrong.1 > RUNS, "{wrong:?}");
    assert_eq!(rejected(ESTIMATE), (None, 0));
    let ran = run(&folder, ESTIMATE).succeeds();
    assert!(ran.stdout.contains(", model not criticised"), "{ran}");
    let ran = run(&folder, &format!("{ESTIMATE} --campaign campaign.toml")).succeeds();
    assert!(ran.stdout.contains(" reject the model"), "{ran}");
}

/// Estimates with an unknown current are among the results, each with its unknowns.
#[test]
fn results_name_what_was_unknown() {
    let folder = with(&["campaign.parquet", "validation.parquet"]);
    let way = "out/scenarios/white/unknown/current";
    std::fs::create_dir_all(folder.path().join(way)).unwrap();
    let flags = "--unknown-current earth --intercepts none";
    let there = |line: &str| {
        let line = line.replace("estimates.parquet", &format!("{way}/estimates.parquet"));
        line.replace("scores.parquet", &format!("{way}/scores.parquet"))
    };
    run(&folder, &there(&format!("{ESTIMATE} --estimator output-error {flags}"))).succeeds();
    run(&folder, &there(VALIDATE)).succeeds();
    let missing = way.replace("current", "undeclared");
    let unknown = [way, &missing].map(|way| folder.path().join(way)).to_vec();
    let text = report::results::tables(&report::results::Folders { unknown, ..Default::default() }).unwrap();
    let row = format!("scenarios white | {RUNS} | 1 | `output-error {flags}` |");
    for piece in [row.as_str(), "scenarios white unknown undeclared"] {
        assert!(text.contains(piece), "{piece}: {text}");
    }
}

#[test]
fn an_estimator_that_is_gone_is_refused_with_what_does_its_work() {
    let folder = compared();
    for line in [
        "estimate --vessel vessel.toml --trajectories campaign.parquet --estimator refined-iv --out e.parquet",
        "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --estimator refined-iv --out e.parquet",
        "monte-carlo --vessel vessel.toml --estimator iv,refined-iv --out validation.json",
    ] {
        refused(
            &folder,
            2,
            line,
            &["'refined-iv' for '--estimator", "output-error", "it is gone: take `output-error`"],
        );
    }
}
