//! Studies that are simulated.

use files::{Digest, Provenance, commit, stage_document};
use serde_json::{Value, json};
use study::documents::RunDocument;

use crate::support::*;

const PRESETS: [&str; 9] = [
    "model-ship",
    "coaster",
    "full-scale",
    "kvlcc2",
    "esso-osaka",
    "esso-osaka-3m",
    "mariner",
    "kvlcc2-l7",
    "otter",
];

/// What `run` with `flags` says of the stages that it ran.
fn stages(folder: &tempfile::TempDir, line: &str) -> Vec<String> {
    let ran = run(folder, &format!("{line} --json --quiet")).succeeds();
    let said: Value = serde_json::from_str(&ran.stdout).unwrap();
    said["run"].as_array().unwrap().iter().map(|name| name.as_str().unwrap().to_owned()).collect()
}

/// The page of a study of `preset`, of two trials as `flags` say.
fn come_to_its_page(preset: &str, flags: &str) {
    let folder = tempfile::tempdir().unwrap();
    run(&folder, &format!("new mine --vessel {preset}")).succeeds();
    let ran = run(&folder, &format!("run mine --quiet --set campaign.realizations=2{flags}")).succeeds();
    assert!(ran.stdout.starts_with("out/mine/report.html: "), "{ran}");
    let page = String::from_utf8(bytes(&folder, "out/mine/report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("mine"), "{preset}");
    run(&folder, "verify out/mine").succeeds();
}

/// Of shorter trials where the whole ones take long to be put in order.
#[test]
fn every_preset_comes_to_its_page_by_two_commands() {
    let shorter =
        [("coaster", 225), ("esso-osaka", 450), ("esso-osaka-3m", 225), ("mariner", 300), ("kvlcc2-l7", 150)];
    for preset in PRESETS {
        let short = shorter.iter().find(|(name, _)| *name == preset);
        let flags = short.map(|(_, seconds)| format!(" --set campaign.duration_s={seconds}"));
        come_to_its_page(preset, &flags.unwrap_or_default());
    }
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn every_preset_comes_to_its_page_by_two_commands_in_trials_of_its_own_length() {
    PRESETS.iter().for_each(|preset| come_to_its_page(preset, ""));
}

/// Of terms: medians of 30 trials lie near the medians that the design foretold.
#[test]
fn law_trials_have_the_errors_that_their_design_foretold() {
    have_the_errors_foretold("model-ship", 30, "report", [0.7, 1.4]);
}

/// Of forces, whose priors pull every estimate the same way.
#[test]
#[ignore = "long: `make nightly` runs it"]
fn law_trials_of_a_ship_with_forces_have_the_errors_that_their_design_foretold() {
    have_the_errors_foretold("mariner", 24, "validate", [0.6, 1.6]);
}

fn have_the_errors_foretold(preset: &str, trials: u32, end: &str, within: [f64; 2]) {
    let folder = tempfile::tempdir().unwrap();
    run(&folder, &format!("new mine --vessel {preset}")).succeeds();
    run(&folder, &format!("run mine --quiet --stage {end} --set campaign.realizations={trials}")).succeeds();
    let foretold = json(&folder, "out/mine/design.json")["data"]["sequence"]["foretold"].clone();
    let found = json(&folder, "out/mine/validation.json")["data"]["scored"]["designs"][0].clone();
    assert_eq!(found["design"], "optimized");
    for error in ["parameter_error", "simulation_error"] {
        let [foretold, found] = [&foretold[error], &found[error]["median"]].map(|own| own.as_f64().unwrap());
        let ratio = found / foretold;
        assert!(within[0] < ratio && ratio < within[1], "{preset}: {error} {found}, foretold {foretold}");
    }
    if end == "report" {
        let page = String::from_utf8(bytes(&folder, "out/mine/report.html")).unwrap();
        assert!(page.contains("Before the trial the design foretold"), "{preset}");
    }
}

#[test]
fn every_hand_written_file_of_a_preset_is_commented() {
    for preset in PRESETS {
        let folder = tempfile::tempdir().unwrap();
        run(&folder, &format!("new mine --vessel {preset}")).succeeds();
        for name in ["vessel.toml", "dictionary.toml", "campaign.toml", "study.toml"] {
            let text = String::from_utf8(bytes(&folder, &format!("mine/{name}"))).unwrap();
            let own = text.lines().find(|line| !line.starts_with("#:schema ")).unwrap_or_default();
            assert!(own.starts_with("# "), "{preset}/{name} begins with {own}");
        }
    }
}

/// The chart off Helsinki.
fn helsinki() -> String {
    repository().join("fixtures/charts/helsinki_land_gshhg.geojson").display().to_string()
}

#[test]
fn a_chart_and_a_place_come_to_a_plan_by_two_commands() {
    let folder = tempfile::tempdir().unwrap();
    let slot = "2026-06-01T06:00:00Z/2026-06-01T18:00:00Z";
    let line =
        format!("new mine --vessel full-scale --place 24.97,60.12 --slot {slot} --chart {}", helsinki());
    run(&folder, &line).succeeds();
    let text = String::from_utf8(bytes(&folder, "mine/plan.toml")).unwrap();
    assert!(
        text.starts_with("#:schema schemas/plan-toml.schema.json\n# ") && text.contains("name = \"mine\"")
    );
    assert!(text.contains("kind = \"land\"") && text.contains("guessed"), "{text}");
    let few = "--set campaign.realizations=2 --set plan.safety.runs=16";
    let ran = run(&folder, &format!("run mine --quiet {few}")).succeeds();
    assert!(ran.stdout.starts_with("out/mine/report.html: "), "{ran}");
    let plan: Value = serde_json::from_slice(&bytes(&folder, "out/mine/plan.json")).unwrap();
    assert_eq!(plan["data"]["status"], "optimal");
    assert_eq!(plan["data"]["voyage"]["passage"]["departure"], "2026-06-01T06:00:00Z");
    run(&folder, "verify out/mine").succeeds();
    // A ship of 3 m finds room where her maneuvers fit, too.
    let line = format!("new small --vessel esso-osaka --place 24.97,60.05 --chart {}", helsinki());
    run(&folder, &line).succeeds();
    run(&folder, &format!("run small --quiet --stage plan {few}")).succeeds();
}

#[test]
fn the_trial_on_a_chart_begins_where_there_is_most_room() {
    let folder = tempfile::tempdir().unwrap();
    // Land but for a square of 10 km about 20° east on the equator, and the same as depths.
    let ring = |edge: f64| {
        let corners = [(-edge, -edge), (edge, -edge), (edge, edge), (-edge, edge), (-edge, -edge)];
        corners.map(|(x, y)| [20.0 + x, y])
    };
    let land = json!({"type": "FeatureCollection", "features": [{"type": "Feature", "properties": {},
        "geometry": {"type": "Polygon", "coordinates": [ring(0.5), ring(0.045)]}}]});
    put(&folder, "bay.geojson", &land.to_string());
    let area = |own: &Value, edge: f64| {
        json!({"type": "Feature", "properties": own,
        "geometry": {"type": "Polygon", "coordinates": [ring(edge)]}})
    };
    let depths = json!({"type": "FeatureCollection", "features":
        [area(&json!({"DRVAL1": 20.0, "DRVAL2": 30.0}), 0.045)]});
    put(&folder, "depths.geojson", &depths.to_string());
    // An area of 7 km, of which the eastern part is closed.
    for (chart, kind) in [("bay", "land"), ("depths", "depth")] {
        run(&folder, &format!("new {chart} --vessel full-scale --place 20.02,0.0 --chart {chart}.geojson"))
            .succeeds();
        let text = String::from_utf8(bytes(&folder, &format!("{chart}/plan.toml"))).unwrap();
        assert!(text.contains(&format!("kind = \"{kind}\"")), "{text}");
        let number = |key: &str| -> f64 {
            let line =
                text.lines().find(|line| line.starts_with(key)).unwrap_or_else(|| panic!("{key} in {text}"));
            line.split(" = ").nth(1).unwrap().parse().unwrap()
        };
        // The middle between the area's western edge, 3.5 km west of the place, and the land 5 km east of 20°.
        let middle = 20.0 + (0.045 + 0.02 - 3500.0 / 111_320.0) / 2.0;
        assert!((number("longitude_deg") - middle).abs() < 0.001, "{text}");
        assert!(number("latitude_deg").abs() < 0.012, "{text}");
    }
}

/// What the stages do without flags.
const PAPERS: &str = "[moments]\nestimator = \"iv\"\n[design]\nfor = \"iv\"\ncriterion = \"d-hessian\"\n[estimate]\nestimator = \"iv\"\n";

#[test]
fn law_run_writes_the_bytes_that_the_stages_write() {
    let folder = written(4);
    put(&folder, "study.toml", PAPERS);
    for stage in STAGES {
        run(&folder, stage).succeeds();
    }
    run(&folder, "run . --out out --quiet").succeeds();
    // The page names its folder of results.
    for name in MADE.iter().filter(|name| **name != "report.html") {
        assert!(bytes(&folder, &format!("out/{name}")) == bytes(&folder, name), "{name} differs");
    }
}

#[test]
fn law_what_is_up_to_date_is_not_run_again() {
    let folder = written(4);
    put(&folder, "study.toml", PAPERS);
    let all = ["dictionary", "moments", "design", "validation", "campaign", "estimate", "validate", "report"];
    assert_eq!(stages(&folder, "run . --out out"), all);
    let before = listing(&folder.path().join("out"));
    assert_eq!(stages(&folder, "run . --out out"), [""; 0]);
    assert_eq!(listing(&folder.path().join("out")), before);
    // A comment changes the digest of a file and of all that is made of it.
    edit(&folder, "campaign.toml", "seed = 1", "# another\nseed = 1");
    let of_the_campaign = ["validation", "campaign", "estimate", "validate", "report"];
    assert_eq!(stages(&folder, "run . --out out"), of_the_campaign);
    // A changed flag, a changed value
    put(
        &folder,
        "study.toml",
        &PAPERS.replace("\n[estimate]", "\nsegments = 5\nsegment_samples = 200\n[estimate]"),
    );
    assert_eq!(stages(&folder, "run . --out out"), ["design", "campaign", "estimate", "validate", "report"]);
    assert_eq!(stages(&folder, "run . --out out --set campaign.realizations=3"), of_the_campaign);
}

#[test]
fn law_a_damaged_output_is_made_again_and_nothing_else() {
    let folder = written(4);
    stages(&folder, "run . --out out");
    let whole = bytes(&folder, "out/moments.json");
    put(&folder, "out/moments.json", "{}");
    assert_eq!(stages(&folder, "run . --out out"), ["moments"]);
    assert!(bytes(&folder, "out/moments.json") == whole);
    std::fs::remove_file(folder.path().join("out/scores.parquet")).unwrap();
    assert_eq!(stages(&folder, "run . --out out"), ["validate"]);
    let mut record: RunDocument = document(&folder, "out/run.json").data;
    record.stages.get_mut("design").unwrap().digest = Some(Digest::of_bytes(b"another program"));
    let file = stage_document(folder.path().join("out/run.json"), &Provenance::default(), &record).unwrap();
    commit(vec![file]).unwrap();
    assert_eq!(stages(&folder, "run . --out out"), ["design"], "another program ran it");
    put(&folder, "out/run.json", "{}");
    assert_eq!(stages(&folder, "run . --out out").len(), 8, "without a record nothing is known");
}

#[test]
fn law_a_file_that_a_dictionary_names_is_an_input() {
    let folder = tempfile::tempdir().unwrap();
    run(&folder, "new mine --vessel esso-osaka").succeeds();
    let line = "run mine --stage moments";
    assert_eq!(stages(&folder, line), ["dictionary", "moments"]);
    assert_eq!(stages(&folder, line), [""; 0]);
    edit(&folder, "mine/crash-stop.csv", "12,0", "11,0");
    assert_eq!(stages(&folder, line), ["dictionary", "moments"]);
}

#[test]
fn a_stage_brings_those_that_it_needs_and_no_more() {
    let folder = written(4);
    assert_eq!(stages(&folder, "run . --out out --stage validation"), ["validation"]);
    assert_eq!(stages(&folder, "run . --out out --stage design"), ["dictionary", "moments", "design"]);
    let document = json(&folder, "out/run.json");
    assert_eq!(document["schema"], "run/2");
    let command = &document["data"]["stages"]["design"]["command"];
    let words = "design --moments {out}/moments.json --for output-error --criterion d --arrange --vessel {study}/vessel.toml \
                 --dictionary {study}/dictionary.toml --out {out}/design.json";
    assert_eq!(*command, json!(words.split(' ').collect::<Vec<_>>()));
}

#[test]
fn results_of_another_study_are_not_written_over() {
    let folder = tempfile::tempdir().unwrap();
    ["one", "two"].iter().for_each(|name| drop(run(&folder, &format!("new {name} --vessel model-ship"))));
    assert_eq!(stages(&folder, "run one --out out --stage dictionary"), ["dictionary"]);
    let before = listing(&folder.path().join("out"));
    let pieces = ["out/run.json: `data.study`: found the results of another study", "with --out"];
    refused(&folder, 3, "run two --out out --stage dictionary", &pieces);
    assert_eq!(listing(&folder.path().join("out")), before);
    // Moved together they belong together.
    std::fs::create_dir(folder.path().join("below")).unwrap();
    for name in ["one", "out"] {
        std::fs::rename(folder.path().join(name), folder.path().join("below").join(name)).unwrap();
    }
    assert_eq!(stages(&folder, "run below/one --out below/out --stage dictionary"), [""; 0]);
}

#[test]
fn a_setting_on_the_command_line_replaces_that_of_the_study() {
    let folder = written(4);
    put(&folder, "study.toml", "[design]\nduration_s = 90\n");
    // The usual flags stay, as far as they go together.
    let usual = "--for output-error --criterion d";
    let ship = "--vessel {study}/vessel.toml --dictionary {study}/dictionary.toml";
    for (own, whole) in [
        ("duration_s=60", format!("{usual} --arrange --duration-s 60 {ship}")),
        ("most_maneuvers=3", format!("{usual} --duration-s 90 --most-maneuvers 3")),
        ("criterion=a", "--criterion a --duration-s 90".to_owned()),
        ("arrange=false", format!("{usual} --duration-s 90")),
    ] {
        run(&folder, &format!("run . --out out --stage design --set study.design.{own}")).succeeds();
        let document = json(&folder, "out/run.json");
        let command = &document["data"]["stages"]["design"]["command"];
        let words = format!("design --moments {{out}}/moments.json {whole} --out {{out}}/design.json");
        assert_eq!(*command, json!(words.split(' ').collect::<Vec<_>>()));
    }
}

#[test]
fn progress_names_every_stage() {
    let folder = written(4);
    let ran = run(&folder, "run . --out out --stage moments").succeeds();
    let called = "[2/2] moments: seatrial moments --vessel ./vessel.toml --trajectories out/dictionary.parquet --campaign \
                  ./campaign.toml --estimator output-error --out";
    assert!(
        ran.stderr.starts_with("[1/2] dictionary: seatrial simulate dictionary")
            && ran.stderr.contains(called),
        "{ran}"
    );
    let again = run(&folder, "run . --out out --stage moments").succeeds();
    assert_eq!(again.stderr, "[1/2] dictionary: up to date\n[2/2] moments: up to date\n", "{again}");
    assert_eq!(again.stdout, "out/moments.json: 0 of 2 stages run, 2 up to date\n", "{again}");
}

/// Wherever `new` is killed, there is no folder that the next one refuses.
#[test]
fn law_a_study_appears_whole_or_not_at_all() {
    let folder = tempfile::tempdir().unwrap();
    for count in (1..).step_by(9) {
        let mut command = std::process::Command::new(SEATRIAL);
        command.args(["new", "mine", "--vessel", "coaster"]).current_dir(&folder);
        if command.env("SEATRIAL_FAULT", format!("kill:{count}")).output().unwrap().status.success() {
            assert!(count > 20);
            break;
        }
        assert!(!folder.path().join("mine").exists(), "killed at {count}");
    }
    let left: Vec<_> = std::fs::read_dir(&folder).unwrap().map(|own| own.unwrap().file_name()).collect();
    assert_eq!(left, ["mine"]);
}
