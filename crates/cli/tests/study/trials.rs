//! Standard maneuvers and motions by feedback, through the binaries.

use files::TableReader;
use ship::model::Vessel;
use study::estimates;
use tempfile::TempDir;

use crate::support::*;

/// A folder with the coaster's files.
fn coaster() -> TempDir {
    let folder = TempDir::new().unwrap();
    for name in ["vessel.toml", "dictionary.toml", "campaign.toml"] {
        let text = std::fs::read_to_string(repository().join("pipelines/coaster").join(name)).unwrap();
        put(&folder, name, &text);
    }
    folder
}

const MERIT: &str = "validate merit --vessel vessel.toml --dictionary dictionary.toml";

/// A dictionary of one maneuver.
fn one(folder: &TempDir, keys: &str) {
    put(folder, "dictionary.toml", &format!("[[maneuver]]\nname = \"m\"\n{keys}\n"));
}

const ZIG_ZAG: &str = "kind = \"zig-zag-test\"\nspeed_m_s = 7.0\nheading_rad = 0.35\nduration_s = 100.0";

#[test]
fn law_figures_of_simulated_runs_are_those_of_the_simulation() {
    let folder = coaster();
    run(&folder, DICTIONARY).succeeds();
    run(&folder, &format!("{MERIT} --length-m 100 --trajectories dictionary.parquet --out merit.json"))
        .succeeds();
    put(&folder, "first.json", &String::from_utf8(bytes(&folder, "merit.json")).unwrap());
    let first = json(&folder, "merit.json");
    // The dictionary is simulated with the true parameters, and so is the ship without trajectories.
    let told = run(&folder, &format!("{MERIT} --length-m 100 --out merit.json")).succeeds();
    let second = json(&folder, "merit.json");
    let figures = second["data"]["maneuvers"]
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|own| own["figures"].as_array().unwrap());
    let judged: Vec<bool> = figures.clone().filter_map(|own| own["passes"].as_bool()).collect();
    let met = judged.iter().filter(|passes| **passes).count();
    let words = format!("{} figures of 11 maneuvers; {met} of {} criteria", figures.count(), judged.len());
    assert!(judged.len() > 8 && told.stdout.contains(&words), "{words}: {told}");
    let [first, second] = [&first, &second].map(|found| found["data"]["maneuvers"].as_array().unwrap());
    assert_eq!(first.len(), 11);
    for (one, other) in first.iter().zip(second) {
        for (a, b) in one["figures"].as_array().unwrap().iter().zip(other["figures"].as_array().unwrap()) {
            let [x, y] = [a, b].map(|figure| figure["value"].as_f64().unwrap());
            assert!((x - y).abs() < 1e-6 * y.abs().max(1.0), "{}: {a} {b}", one["name"]);
            assert_eq!(a["passes"], b["passes"]);
        }
    }
    let of = |name: &str| first.iter().find(|own| own["name"] == name).unwrap();
    let value = |name: &str, figure: &str| {
        let figures = of(name)["figures"].as_array().unwrap();
        figures.iter().find(|own| own["name"] == figure).unwrap()["value"].as_f64().unwrap()
    };
    // The ship is the same on both sides.
    for (starboard, port) in
        [("zig-zag-10-starboard", "zig-zag-10-port"), ("zig-zag-20-starboard", "zig-zag-20-port")]
    {
        for figure in ["initial_turning", "overshoot_1", "overshoot_2"] {
            assert!((value(starboard, figure) - value(port, figure)).abs() < 0.01, "{figure}");
        }
    }
    assert!((value("circle-starboard", "advance") - value("circle-port", "advance")).abs() < 1e-3);
    // Steps of a minute are too short for the turn to settle: a stable ship seems to have a loop, and has none.
    assert!(value("spiral", "loop_width") > 1.0 && value("reverse-spiral", "loop_width") < 0.1);
    assert_eq!(of("zig-zag-10-starboard")["figures"][1]["passes"], true);
    // The stop of this dictionary is full astern.
    let reach = &of("crash-stop")["figures"][0];
    assert_eq!(
        (&reach["name"], &reach["most"], &reach["passes"]),
        (&"track_reach".into(), &15.0.into(), &true.into())
    );
    let table = TableReader::open(folder.path().join("merit.parquet"), "merit-rows", 1).unwrap();
    let figures: usize = first.iter().map(|own| own["figures"].as_array().unwrap().len()).sum();
    assert_eq!(table.rows(), figures);
}

#[test]
fn law_noise_and_currents_widen_figures_and_hardly_move_them() {
    let folder = coaster();
    run(&folder, DICTIONARY).succeeds();
    run(&folder, &format!("{MERIT} --length-m 100 --trajectories dictionary.parquet --out merit.json"))
        .succeeds();
    let still = json(&folder, "merit.json");
    run(&folder, MOMENTS).succeeds();
    run(&folder, DESIGN).succeeds();
    edit(&folder, "campaign.toml", "realizations = 100", "realizations = 32");
    run(&folder, CAMPAIGN).succeeds();
    run(&folder, &format!("{MERIT} --length-m 100 --trajectories campaign.parquet --out merit.json"))
        .succeeds();
    let moved = json(&folder, "merit.json");
    let overshoot = |found: &serde_json::Value| {
        let maneuvers = found["data"]["maneuvers"].as_array().unwrap();
        maneuvers.iter().find(|own| own["name"] == "zig-zag-20-starboard").unwrap().clone()
    };
    let (still, moved) = (overshoot(&still), overshoot(&moved));
    assert!(moved["runs"].as_u64().unwrap() > 20, "{moved}");
    let (one, many) = (&still["figures"][1], &moved["figures"][1]);
    assert!(
        one["std"].is_null() && one["low"].is_null() && many["std"].as_f64().unwrap() > 0.01,
        "{one} {many}"
    );
    // Trials come to it from other maneuvers, and so at other speeds.
    assert!((one["value"].as_f64().unwrap() - many["value"].as_f64().unwrap()).abs() < 1.5, "{one} {many}");
}

#[test]
fn motions_that_are_not_reached_are_refused_or_said() {
    let folder = coaster();
    one(&folder, &format!("{ZIG_ZAG}\nhelm = {{ delta = 0.01 }}"));
    let pieces =
        ["maneuver `m`, heading to starboard", "found", "in 100 s", "expected 20.1°", "--allow=unreached"];
    refused(&folder, 4, DICTIONARY, &pieces);
    run(&folder, &format!("{DICTIONARY} --allow=unreached")).succeeds();
    let table = TableReader::open(folder.path().join("dictionary.parquet"), "trajectories", 1).unwrap();
    let words = table.provenance().settings["reached"]["m"].as_str().unwrap().to_owned();
    assert!(words.contains("heading to starboard") && words.contains("(wanted 20.1°)"), "{words}");
    let pieces = ["dictionary.toml: maneuver `m`, heading", "at the most", "expected 20.1°"];
    refused(&folder, 4, &format!("{MERIT} --length-m 100 --out merit.json"), &pieces);
    one(&folder, "kind = \"turning-circle\"\nspeed_m_s = 7.0\nduration_s = 60.0\nhelm = { delta = 0.35 }");
    refused(&folder, 4, DICTIONARY, &["maneuver `m`, turn to starboard", "expected 540.0°"]);
    // Thrust for 7 m/s of the nominal ship, which has other parameters than the true one.
    let keys = "kind = \"accelerate\"\nfrom_m_s = 3.0\nto_m_s = 7.0\nduration_s = 600.0";
    put(
        &folder,
        "dictionary.toml",
        &format!(
            "tolerance = {{ speed = 0.001 }}\ninputs_from = \"nominal\"\n[[maneuver]]\nname = \"m\"\n{keys}\n"
        ),
    );
    edit(&folder, "vessel.toml", "value = 0.02573\n", "value = 0.0514\n");
    refused(&folder, 4, DICTIONARY, &["maneuver `m`, mean speed of the second half", "m/s in 600 s"]);
    edit(&folder, "dictionary.toml", "600.0", "600.0\nexecuted = \"feedback\"");
    run(&folder, DICTIONARY).succeeds();
}

#[test]
fn maneuvers_that_no_ship_carries_out_are_refused_by_key() {
    let folder = coaster();
    let refuse = |keys: &str, pieces: &[&str]| {
        one(&folder, keys);
        refused(&folder, 3, DICTIONARY, pieces);
    };
    refuse(ZIG_ZAG, &["maneuver `m`", "helm"]);
    refuse(
        &format!("{ZIG_ZAG}\nhelm = {{ rudder = 0.3 }}"),
        &["`helm.rudder`", "found no input", "`n`, `delta`"],
    );
    refuse(&format!("{ZIG_ZAG}\nhelm = {{ delta = 1.0 }}"), &["`helm`", "delta = 1", "from -0.611 to 0.611"]);
    refuse(&format!("{ZIG_ZAG}\nhelm = {{ delta = 0.0 }}"), &["`helm`", "found none"]);
    refuse(
        &format!("{ZIG_ZAG}\nhelm = {{ delta = 0.3 }}\nexecuted = \"feedback\""),
        &["maneuver `m`, `executed`", "reacts"],
    );
    refuse(&format!("{ZIG_ZAG}\nhelm = {{ delta = 0.3 }}\nevery_s = 0.0"), &["`every_s`", "more than 0 s"]);
    refuse(&format!("{ZIG_ZAG}\nhelm = {{ delta = 0.3 }}\ndelay = 1.0"), &["found key `delay`", "`delay_s`"]);
    let motion = "kind = \"accelerate\"\nfrom_m_s = 3.0\nto_m_s = 7.0\nduration_s = 60.0";
    refuse(
        &format!("{motion}\nfeedback = {{ strength = 1.0 }}"),
        &["maneuver `m`, `feedback`", "found a controller", "executed = \"feedback\""],
    );
    let fed = format!("{motion}\nexecuted = \"feedback\"");
    refuse(&format!("{fed}\nfeedback = {{ strength = -1.0 }}"), &["`feedback.strength`", "more than 0"]);
    let spiral = "kind = \"spiral-test\"\nspeed_m_s = 7.0\nhelm = { delta = 0.3 }\ndwell_s = 60.0";
    refuse(&format!("{spiral}\nduration_s = 100.0"), &["`duration_s`", "found 100 s", "at least 1020 s"]);
}

#[test]
fn figures_that_cannot_be_told_are_refused() {
    let folder = coaster();
    let merit = |length: &str| format!("{MERIT} --length-m {length} --out merit.json");
    refused(&folder, 4, &merit("2"), &["samples", "found 2 Hz", "at least"]);
    refused(&folder, 2, &merit("0"), &["--length-m", "found 0"]);
    refused(
        &folder,
        3,
        &format!("{} --draws 10", merit("100")),
        &["vessel.toml: `covariance`", "found none", "--draws"],
    );
    one(&folder, "kind = \"accelerate\"\nfrom_m_s = 3.0\nto_m_s = 7.0\nduration_s = 60.0");
    refused(&folder, 3, &merit("100"), &["[[maneuver]]", "no standard maneuver", "`zig-zag-test`"]);
    run(&folder, DICTIONARY).succeeds();
    one(&folder, &format!("{ZIG_ZAG}\nhelm = {{ delta = 0.35 }}").replace("m\"", "other\""));
    put(
        &folder,
        "dictionary.toml",
        &format!("[[maneuver]]\nname = \"other\"\n{ZIG_ZAG}\nhelm = {{ delta = 0.35 }}\n"),
    );
    let line = format!("{} --trajectories dictionary.parquet --allow=mixed", merit("100"));
    refused(&folder, 4, &line, &["no run of a standard maneuver", "`other`"]);
}

/// The coaster's files, with two runs of which `kind` is steered by the logged sensors.
fn steered_by_the_log(kind: &str, edits: [&str; 2]) -> TempDir {
    let folder = coaster();
    let all = std::fs::read_to_string(folder.path().join("dictionary.toml")).unwrap();
    assert!(all.contains(kind));
    edit(&folder, "dictionary.toml", edits[0], edits[1]);
    edit(&folder, "campaign.toml", "realizations = 100", "realizations = 2");
    for line in [DICTIONARY, MOMENTS, DESIGN, CAMPAIGN] {
        run(&folder, line).succeeds();
    }
    folder
}

const TALLIED: &str = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --design design.json \
                       --keep estimates --out tallied/validation.json";
const ESTIMATED: &str =
    "estimate --vessel vessel.toml --trajectories campaign.parquet --out estimates.parquet";

fn estimates_of(folder: &TempDir, name: &str) -> Vec<estimates::Row> {
    let text = std::fs::read_to_string(folder.path().join("vessel.toml")).unwrap();
    let vessel = Vessel::from_file(toml::from_str(&text).unwrap()).unwrap();
    let file = folder.path().join(name);
    let table = TableReader::open(&file, estimates::ID, estimates::VERSION).unwrap();
    (0..table.blocks()).flat_map(|i| estimates::rows(&table, &vessel, &file, i).unwrap()).collect()
}

#[test]
fn law_instruments_of_tracked_motions_are_the_same_in_memory_and_in_files() {
    let feedback = "executed = \"feedback\"";
    let logged = "executed = \"feedback\"\nfeedback = { sensors = \"logged\" }";
    let folder = steered_by_the_log("accelerate", [feedback, logged]);
    let table = TableReader::open(folder.path().join("campaign.parquet"), "trajectories", 1).unwrap();
    let names: Vec<&str> = table.columns().iter().map(|column| column.name.as_str()).collect();
    assert!(names.ends_with(&["psi", "instrument_n", "instrument_delta"]), "{names:?}");
    run(&folder, ESTIMATED).succeeds();
    std::fs::create_dir(folder.path().join("tallied")).unwrap();
    run(&folder, TALLIED).succeeds();
    let own = estimates_of(&folder, "estimates.parquet");
    assert_eq!(own, estimates_of(&folder, "tallied/estimates.parquet"));
    // Recorded inputs would be other instruments.
    let text = std::fs::read_to_string(folder.path().join("dictionary.toml")).unwrap();
    put(&folder, "dictionary.toml", &text.replace(logged, ""));
    for line in [DICTIONARY, MOMENTS, DESIGN, CAMPAIGN, ESTIMATED] {
        run(&folder, line).succeeds();
    }
    assert_ne!(own, estimates_of(&folder, "estimates.parquet"));
}

#[test]
fn instruments_over_inputs_that_follow_the_noise_of_the_log_are_refused() {
    let keys = "yaw_rate_rad_s = 0.0105\n";
    let folder =
        steered_by_the_log("reverse-spiral", [keys, "yaw_rate_rad_s = 0.0105\nsensors = \"logged\"\n"]);
    let pieces =
        ["maneuver `reverse-spiral`", "the noise of the logged sensors", "--estimator iv", "output-error"];
    refused(&folder, 3, ESTIMATED, &pieces);
    run(&folder, &format!("{ESTIMATED} --estimator output-error --campaign campaign.toml")).succeeds();
    std::fs::create_dir(folder.path().join("tallied")).unwrap();
    refused(&folder, 3, TALLIED, &["dictionary.toml: maneuver `reverse-spiral`", "--estimator iv"]);
}

#[test]
fn law_uncertain_parameters_make_uncertain_figures() {
    let folder = coaster();
    edit(&folder, "campaign.toml", "realizations = 100", "realizations = 1");
    edit(&folder, "campaign.toml", "duration_s = 5400.0", "duration_s = 3600.0");
    for line in [DICTIONARY, MOMENTS, DESIGN, CAMPAIGN] {
        run(&folder, line).succeeds();
    }
    let pool = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --runs optimized/0 --estimator iv \
                --out estimates.parquet";
    run(&folder, pool).succeeds();
    let merit = |of: &str, flags: &str| {
        let line = format!(
            "validate merit --vessel {of} --dictionary dictionary.toml --length-m 100 {flags} --out merit.json"
        );
        run(&folder, &line).succeeds();
        json(&folder, "merit.json")["data"].clone()
    };
    let (truth, drawn) = (merit("vessel.toml", ""), merit("model.json", "--draws 60 --seed 2"));
    assert_eq!((&truth["intervals"], &drawn["intervals"]), (&"runs".into(), &"parameters".into()));
    let (mut inside, mut all) = (0, 0);
    for (one, other) in
        drawn["maneuvers"].as_array().unwrap().iter().zip(truth["maneuvers"].as_array().unwrap())
    {
        for (figure, known) in
            one["figures"].as_array().unwrap().iter().zip(other["figures"].as_array().unwrap())
        {
            let [low, high] = ["low", "high"].map(|key| figure[key].as_f64().unwrap());
            assert!(low <= high, "{figure}");
            all += 1;
            inside += i32::from((low..=high).contains(&known["value"].as_f64().unwrap()));
        }
    }
    assert!(all > 30 && 2 * inside > all, "{inside} of {all} intervals hold the truth");
    assert_eq!(merit("model.json", "--draws 60 --seed 2"), drawn);
    assert_ne!(merit("model.json", "--draws 60 --seed 3"), drawn);
}

/// First and second overshoot of a log of 20 Hz in a towing tank, whose largest samples are exact enough \[°\], beyond the headings at
/// which its rudder moved.
fn raw_overshoots(log: &std::path::Path, heading: f64, side: f64) -> [f64; 2] {
    let text = std::fs::read_to_string(log).unwrap();
    let names: Vec<&str> = text.lines().next().unwrap().split(',').collect();
    let column = |name: &str| -> Vec<f64> {
        let place = names.iter().position(|own| *own == name).unwrap();
        text.lines().skip(1).map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
    };
    let (headings, rudder) = (column("psi_rad"), column("delta_rad"));
    let turned = |k: usize| side * (headings[k] - headings[0]).to_degrees();
    let first = (0..headings.len()).find(|k| turned(*k) >= heading).unwrap();
    let second = (first..headings.len()).find(|k| turned(*k) <= -heading).unwrap();
    let third = (second..headings.len()).find(|k| turned(*k) >= heading).unwrap_or(headings.len());
    let most = |range: std::ops::Range<usize>, sign: f64| range.map(|k| sign * turned(k)).fold(0.0, f64::max);
    // Where it is 0.1° off what it held, between two samples.
    let moved = |from: usize| {
        let off = |k: usize| (rudder[k] - rudder[from]).abs().to_degrees();
        let k = (from..rudder.len()).find(|k| off(*k) > 0.1).unwrap();
        turned(k) - (off(k) - 0.1) / (off(k) - off(k - 1)) * (turned(k) - turned(k - 1))
    };
    [most(first..second, 1.0) - moved(first), most(second..third, -1.0) + moved(second)]
}

#[test]
fn oracle_overshoots_of_the_kvlcc2_are_those_of_its_logs() {
    let logs = repository().join("../shared/data/kvlcc2_hsva");
    if !logs.is_dir() {
        eprintln!("skipped: there is no {}", logs.display());
        return;
    }
    let folder = TempDir::new().unwrap();
    let tests =
        [("Z_10_10_S", 10.0, 10.0, 1.0), ("Z_10_10_P", 10.0, 10.0, -1.0), ("Z_20_10_S", 20.0, 10.0, 1.0)];
    let maneuver = |(name, helm, heading, side): &(&str, f64, f64, f64)| {
        let (to, helm, heading) =
            (if *side > 0.0 { "starboard" } else { "port" }, helm.to_radians(), heading.to_radians());
        format!(
            "[[maneuver]]\nname = \"{name}\"\nkind = \"zig-zag-test\"\nspeed_m_s = 1.179\nhelm = {{ delta = {helm} }}\n\
             heading_rad = {heading}\nto = \"{to}\"\nduration_s = 70.0\n"
        )
    };
    put(&folder, "dictionary.toml", &tests.iter().map(maneuver).collect::<String>());
    let ingest =
        format!("ingest --config ingest.toml --vessel vessel.toml --logs {} --out t.parquet", logs.display());
    // By samples of a second it is not known when the rudder moved within them, and she turns by 2° in one.
    for (rate, average, most) in [("20.0", "", 0.05), ("1.0", "average_s = 0.5\n", 0.65)] {
        for name in ["vessel.toml", "ingest.toml"] {
            let text = std::fs::read_to_string(repository().join("pipelines/kvlcc2").join(name)).unwrap();
            let text = text.replace("sample_rate_hz = 1.0", &format!("sample_rate_hz = {rate}"));
            put(&folder, name, &text.replace("average_s = 0.5\n", average));
        }
        run(&folder, &ingest).succeeds();
        run(
            &folder,
            &format!("{MERIT} --length-m 7 --trajectories t.parquet --allow=mixed --out merit.json"),
        )
        .succeeds();
        let found = json(&folder, "merit.json");
        for ((name, _, heading, side), own) in
            tests.iter().zip(found["data"]["maneuvers"].as_array().unwrap())
        {
            let raw = raw_overshoots(&logs.join(format!("kvlcc2_hsva_{name}.csv")), *heading, *side);
            for (number, expected) in raw.iter().enumerate() {
                let figure = &own["figures"][number + 1];
                let off = figure["value"].as_f64().unwrap() - expected;
                assert!(off.abs() < most, "{rate} Hz, {name}: {figure}, {expected} in the log");
            }
        }
    }
}

/// The coaster's files with `keys` of her rudder.
fn with_rudder(keys: &str) -> TempDir {
    let folder = coaster();
    let range = "range = [-0.611, 0.611]";
    edit(&folder, "vessel.toml", range, &format!("{range}\n{keys}"));
    folder
}

/// Names of the columns of a table of trajectories that say what was commanded.
fn of_commands(folder: &TempDir, name: &str) -> Vec<String> {
    let table = TableReader::open(folder.path().join(name), "trajectories", 1).unwrap();
    let names = table.columns().iter().map(|column| column.name.clone());
    names.filter(|name| name.starts_with("command_")).collect()
}

#[test]
fn what_is_commanded_has_a_column_where_an_actuator_follows_it() {
    let folder = with_rudder("dead_band = 0.02\nhold_s = 2.0\nrate_per_s = 0.05");
    edit(&folder, "campaign.toml", "realizations = 100", "realizations = 2");
    for line in [DICTIONARY, MOMENTS, DESIGN, CAMPAIGN] {
        run(&folder, line).succeeds();
    }
    std::fs::create_dir(folder.path().join("tallied")).unwrap();
    let tallied = TALLIED.replace("--keep estimates", "--keep trajectories");
    run(&folder, &tallied).succeeds();
    for name in ["dictionary.parquet", "campaign.parquet", "tallied/campaign.parquet"] {
        assert_eq!(of_commands(&folder, name), ["command_delta"], "{name}");
    }
    let commands = |name: &str| {
        let table = TableReader::open(folder.path().join(name), "trajectories", 1).unwrap();
        let of = |block| {
            table.read_block(block, &["command_delta"]).unwrap().columns[0].as_f64().unwrap().to_vec()
        };
        // The last row of a run has no inputs.
        (0..table.blocks()).flat_map(of).filter(|own| !own.is_nan()).collect::<Vec<f64>>()
    };
    let (campaign, tallied) = (commands("campaign.parquet"), commands("tallied/campaign.parquet"));
    assert!(campaign == tallied, "{} and {} rows", campaign.len(), tallied.len());
    let table = TableReader::open(folder.path().join("dictionary.parquet"), "trajectories", 1).unwrap();
    let block = table.read_block(0, &["maneuver", "delta", "command_delta"]).unwrap();
    let [set, commanded] = [1, 2].map(|i: usize| block.columns[i].as_f64().unwrap());
    let is_zig_zag = |k: usize| block.columns[0].text_at(k) == Some("zig-zag-20-starboard");
    let rows: Vec<usize> = (0..set.len() - 1).filter(|k| is_zig_zag(*k) && is_zig_zag(k + 1)).collect();
    // A sample is half a second.
    assert!(rows.windows(2).all(|k| (set[k[1]] - set[k[0]]).abs() <= 0.025 + 1e-12));
    assert!(rows.windows(2).any(|k| (commanded[k[1]] - commanded[k[0]]).abs() > 0.3));
    run(&folder, "report --study . --results . --out report.html").succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    assert!(page.contains("Thin lines are what was commanded"));
    // Of every maneuver, in tenths of a pixel.
    assert_eq!(page.matches("stroke-width=\"6\"").count(), 12);
    // Immediate actuators, and a study in which nothing reacts, have no such columns.
    let folder = coaster();
    run(&folder, DICTIONARY).succeeds();
    assert!(of_commands(&folder, "dictionary.parquet").is_empty());
    let folder = with_rudder("lag_s = 3.0");
    one(&folder, "kind = \"steady-turn\"\nspeed_m_s = 7.0\nyaw_rate_rad_s = 0.005\nduration_s = 300.0");
    run(&folder, &format!("{DICTIONARY} --allow=unreached")).succeeds();
    assert!(of_commands(&folder, "dictionary.parquet").is_empty());
}

#[test]
fn actuators_that_cannot_be_are_refused_by_key() {
    for (keys, pieces) in [
        ("dead_band = -0.01", ["vessel.toml", "`dead_band` of input `delta`", "found -0.01", "0 or more"]),
        (
            "dead_band = 1.3",
            [
                "vessel.toml",
                "`dead_band` of input `delta`",
                "found 1.3",
                "the width of its `range` [-0.611, 0.611]",
            ],
        ),
        ("dead_band = \"2 deg\"", ["vessel.toml", "dead_band", "2 deg", "number"]),
        (
            "hold_s = 0.0",
            ["vessel.toml", "`hold_s` of input `delta`", "found 0", "above 0 s, at most 10000 s"],
        ),
        (
            "hold_s = nan",
            ["vessel.toml", "`hold_s` of input `delta`", "found NaN", "above 0 s, at most 10000 s"],
        ),
        (
            "hold_s = 200.0",
            [
                "dictionary.toml",
                "maneuver `zig-zag-10-starboard` of 200 s",
                "`hold_s` = 200 s of input `delta`",
                "`duration_s`",
            ],
        ),
        ("deadband = 0.01", ["vessel.toml", "found key `deadband`", "`dead_band`", "delta"]),
    ] {
        let folder = with_rudder(keys);
        let pieces =
            if keys.starts_with("deadband") || keys.contains("deg") { &pieces[..3] } else { &pieces[..] };
        refused(&folder, 3, DICTIONARY, pieces);
        assert!(!folder.path().join("dictionary.parquet").exists());
    }
    let folder = coaster();
    edit(
        &folder,
        "vessel.toml",
        "[[surge]]",
        "[[measured]]\nname = \"command_delta\"\nunit = \"1\"\nsimulated = 0.0\n\n[[surge]]",
    );
    refused(&folder, 3, DICTIONARY, &["`command_delta`", "taken", "rename it"]);
}

#[test]
fn inputs_of_one_side_are_kept_to_in_every_maneuver_or_refused() {
    let folder = coaster();
    edit(&folder, "vessel.toml", "range = [-1.0, 1.2]", "range = [0.0, 1.2]");
    refused(&folder, 3, DICTIONARY, &["maneuver `crash-stop`", "`inputs`", "n = -", "from 0 to 1.2"]);
    let keys = "kind = \"stop\"\nspeed_m_s = 7.0\nduration_s = 1500.0";
    one(&folder, keys);
    run(&folder, &format!("{DICTIONARY} --allow=unreached")).succeeds();
    // Propulsion that cannot be stopped.
    edit(&folder, "vessel.toml", "range = [0.0, 1.2]", "range = [0.1, 1.2]");
    refused(&folder, 3, DICTIONARY, &["maneuver `m`", "`inputs`", "n = 0", "from 0.1 to 1.2"]);
    for executed in ["inputs", "feedback"] {
        one(
            &folder,
            &format!(
                "kind = \"zig-zag\"\nspeed_m_s = 5.0\nyaw_rate_amplitude_rad_s = 0.004\nperiod_s = 120.0\nduration_s = 240.0\nexecuted = \"{executed}\""
            ),
        );
        run(&folder, &format!("{DICTIONARY} --allow=unreached")).succeeds();
        let table = TableReader::open(folder.path().join("dictionary.parquet"), "trajectories", 1).unwrap();
        let n = table.read_block(0, &["n"]).unwrap().columns[0].as_f64().unwrap().to_vec();
        assert!(n[..n.len() - 1].iter().all(|n| (0.1..=1.2).contains(n)), "{executed}");
    }
}
