//! Generated dictionaries and designs for output-error estimates, through the binaries.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const GENERATE: &str = "duration_s = 37.5\n[generate]\ncandidates = 120\nseed = 3\n[generate.limits]\nu_m_s = 1.2\nv_m_s = 0.25\n\
     r_rad_s = 0.6\ninputs = { tau2 = 1430.0 }\n";
const OUTPUT_ERROR: &str = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator \
     output-error --out moments.json";
const FOR: &str = "design --moments moments.json --for output-error --criterion a-relative --relative-to value --out design.json";

/// A folder with a generated dictionary and its moments.
fn generated() -> TempDir {
    static MADE: OnceLock<Study> = OnceLock::new();
    let make = || {
        let folder = written(2);
        put(&folder, "dictionary.toml", GENERATE);
        [DICTIONARY, OUTPUT_ERROR].iter().for_each(|line| drop(run(&folder, line).succeeds()));
        Study::of(&folder)
    };
    MADE.get_or_init(make).with(&["dictionary.parquet", "moments.json"])
}

/// A folder with the paper's dictionary and its moments.
fn papers() -> TempDir {
    static MADE: OnceLock<Study> = OnceLock::new();
    MADE.get_or_init(|| Study::make(2, &[DICTIONARY, OUTPUT_ERROR]))
        .with(&["dictionary.parquet", "moments.json"])
}

fn data(folder: &TempDir) -> Value {
    json(folder, "design.json")["data"].clone()
}

fn names(folder: &TempDir) -> Vec<String> {
    let moments = json(folder, "moments.json");
    let maneuvers = moments["data"]["maneuvers"].as_array().unwrap();
    maneuvers.iter().map(|m| m["name"].as_str().unwrap().to_owned()).collect()
}

fn used(design: &Value) -> Vec<f64> {
    design["shares"].as_object().unwrap().values().map(|w| w.as_f64().unwrap()).filter(|w| *w > 0.0).collect()
}

#[test]
fn law_candidates_start_at_the_speeds_that_are_stated() {
    let folder = written(2);
    let starting = |starts: &str| {
        let table = format!("[generate]\nspeed_m_s = [0.0, 1.2]\nstart_m_s = {starts}");
        put(&folder, "dictionary.toml", &GENERATE.replace("[generate]", &table).replace("= 120", "= 90"));
    };
    starting("[0.25, 0.75]");
    run(&folder, DICTIONARY).succeeds();
    let table = craft::read(&folder.path().join("dictionary.parquet"), "trajectories");
    let named = |name: &str| table.schema.columns.iter().position(|column| column.name == name).unwrap();
    let [t, u] = ["t", "u"].map(named);
    let of = |block: &files::Table| {
        let begins = (0..block.columns[t].len()).filter(|row| block.columns[t].value_at(*row) == Some(0.0));
        begins.map(|row| block.columns[u].value_at(row).unwrap()).collect::<Vec<_>>()
    };
    let first: Vec<f64> = table.blocks.iter().flat_map(of).collect();
    assert!(first.iter().all(|u| [0.25, 0.75].contains(u)), "{first:?}");
    assert!([0.25, 0.75].iter().all(|start| first.iter().filter(|u| *u == start).count() > 10), "{first:?}");
    for (starts, said) in [
        ("[0.5, 1.3]", ["`generate.start_m_s`", "1.3 m/s", "speeds from 0 to 1.2 m/s"]),
        ("[1.0]", ["`generate.start_m_s`", "[1.0] m/s", "for `accelerate`"]),
    ] {
        starting(starts);
        refused(&folder, 3, DICTIONARY, &said);
    }
}

#[test]
fn law_shards_of_candidates_gather_to_the_bytes_of_the_whole() {
    let folder = generated();
    for k in 1..=2 {
        let line = DICTIONARY.replace("dictionary.parquet", &format!("part-{k}.parquet"));
        run(&folder, &format!("{line} --shard {k}/2")).succeeds();
    }
    run(&folder, "simulate dictionary --gather part-2.parquet part-1.parquet --out again.parquet").succeeds();
    assert_eq!(bytes(&folder, "again.parquet"), bytes(&folder, "dictionary.parquet"));
    let parts: Vec<String> = (1..=3).map(|k| format!("part-{k}.json")).collect();
    for (k, part) in parts.iter().enumerate() {
        let line = OUTPUT_ERROR.replace("moments.json", part);
        run(&folder, &format!("{line} --shard {}/3", k + 1)).succeeds();
    }
    let gather =
        |parts: &str| format!("{} --gather {parts}", OUTPUT_ERROR.replace("moments.json", "again.json"));
    run(&folder, &gather(&parts.join(" "))).succeeds();
    assert_eq!(bytes(&folder, "again.json"), bytes(&folder, "moments.json"));
    run(&folder, &gather("part-1.json part-3.json")).refuses(3, &["no shard 2/3"]);
    let line = FOR.replace("moments.json", "part-2.json");
    run(&folder, &line).refuses(3, &["part-2.json", "shard 2/3", "--gather"]);
    edit(&folder, "campaign.toml", "std_m_s = 0.158", "std_m_s = 0.159");
    run(&folder, &gather(&parts.join(" "))).refuses(3, &["campaign.toml", "another campaign", "part-1.json"]);
}

#[test]
fn law_a_design_over_a_table_is_the_one_over_the_document() {
    let folder = generated();
    run(&folder, MOMENTS).succeeds();
    run(&folder, DESIGN).succeeds();
    let whole = data(&folder);
    let table = |line: &str| line.replace("moments.json", "moments-2.json");
    run(&folder, &format!("{} --keep table", table(MOMENTS))).succeeds();
    assert!(folder.path().join("moments-2.parquet").is_file());
    run(&folder, &table(DESIGN)).succeeds();
    let streamed = data(&folder);
    let number = |design: &Value, key: &str| design[key].as_f64().unwrap();
    assert!((number(&whole, "log_det") - number(&streamed, "log_det")).abs() < 1e-8);
    assert!(number(&streamed, "relative_gap") <= 1e-10);
    assert_eq!(streamed["candidates"].as_u64(), Some(whole["shares"].as_object().unwrap().len() as u64));
    assert_eq!((&whole["status"], &whole["candidates"]), (&streamed["status"], &Value::Null));
    for (name, share) in streamed["shares"].as_object().unwrap() {
        let (own, other) = (share.as_f64().unwrap(), whole["shares"][name].as_f64().unwrap());
        assert!((own - other).abs() < 1e-4, "{name}: {own} and {other}");
    }
    let equal = |design: &Value| design["efficiency"]["equal_shares"].as_f64().unwrap();
    assert!((equal(&whole) - equal(&streamed)).abs() < 1e-8);
    run(&folder, CAMPAIGN).succeeds();
    let refused = |more: &str, code, pieces: &[&str]| {
        run(&folder, &format!("{} {more}", table(DESIGN))).refuses(code, pieces)
    };
    refused("--most-maneuvers 3", 2, &["--most-maneuvers", "without --keep table"]);
    refused("--criterion a-relative", 3, &["moments-2.json", "no expected disturbances"]);
    run(&folder, &format!("{MOMENTS} --keep table --shard 1/2")).refuses(2, &["--keep", "--shard"]);
    std::fs::remove_file(folder.path().join("moments-2.parquet")).unwrap();
    run(&folder, &table(DESIGN)).refuses(3, &["moments-2"]);
}

#[test]
fn candidates_keep_their_limits_and_are_counted_by_reason() {
    let folder = generated();
    let ran = run(&folder, &format!("{DICTIONARY} --json")).succeeds();
    let told: Value = serde_json::from_str(&ran.stdout).unwrap();
    let left_out: u64 = told["left_out"].as_object().unwrap().values().map(|n| n.as_u64().unwrap()).sum();
    assert_eq!(told["generated"].as_u64().unwrap() + left_out, 120);
    assert!(told["left_out"]["inputs.tau2"].as_u64().unwrap() > 0, "{told}");
    assert_eq!(names(&folder).len() as u64, told["generated"].as_u64().unwrap());
    let kinds =
        ["combined", "zig-zag", "pseudo-random-binary", "multisine", "spiral", "accelerate", "decelerate"];
    for kind in kinds {
        assert!(names(&folder).iter().any(|name| name.starts_with(kind)), "no {kind}");
    }
}

#[test]
fn law_names_and_inputs_of_candidates_do_not_depend_on_their_number_or_the_limits() {
    let folder = generated();
    let before = names(&folder);
    edit(&folder, "dictionary.toml", "candidates = 120", "candidates = 60");
    edit(&folder, "dictionary.toml", "tau2 = 1430.0", "tau2 = 1000.0");
    run(&folder, DICTIONARY).succeeds();
    let known = json(&folder, "moments.json");
    run(&folder, OUTPUT_ERROR).succeeds();
    let after = json(&folder, "moments.json");
    let fewer = names(&folder);
    assert!(!fewer.is_empty() && fewer.len() < before.len());
    let of = |document: &Value, name: &str| {
        let all = document["data"]["maneuvers"].as_array().unwrap();
        all.iter().find(|m| m["name"] == name).cloned()
    };
    for name in &fewer {
        assert_eq!(of(&known, name), of(&after, name), "{name}");
    }
}

#[test]
fn a_campaign_runs_the_generated_maneuvers_in_the_designs_order() {
    let folder = generated();
    let line = format!("{FOR} --duration-s 125");
    let arrange = "--arrange --vessel vessel.toml --dictionary dictionary.toml";
    run(&folder, &line).succeeds();
    let plain = data(&folder);
    run(&folder, CAMPAIGN).succeeds();
    run(&folder, &format!("{line} {arrange}")).succeeds();
    let arranged = data(&folder);
    assert_eq!(plain["shares"], arranged["shares"]);
    let sequence = &arranged["sequence"];
    let parts = sequence["parts"].as_array().unwrap();
    assert_eq!(parts.iter().map(|p| p["samples"].as_u64().unwrap()).sum::<u64>(), 1000);
    assert!(sequence["statement"].as_str().unwrap().contains("keeps the limits"), "{sequence}");
    run(&folder, CAMPAIGN).succeeds();
    edit(&folder, "campaign.toml", "duration_s = 125.0", "duration_s = 100.0");
    std::fs::remove_file(folder.path().join("campaign.parquet")).unwrap();
    let mixed = format!("{CAMPAIGN} --allow=mixed");
    refused(&folder, 3, &mixed, &["design.json", "`data.sequence`", "1000 samples", "800 samples"]);
    // The length of the moments' campaign, and no piece below 15 % of the maneuvers' 37.5 s.
    run(&folder, &format!("{FOR} {arrange}")).succeeds();
    assert_eq!(data(&folder)["sequence"], *sequence);
    assert!(parts.iter().all(|part| part["samples"].as_u64().unwrap() >= 45), "{parts:?}");
    refused(&folder, 2, &format!("{line} --arrange"), &["--vessel"]);
    refused(&folder, 2, &format!("{line} {arrange} --most-maneuvers 9"), &["--arrange", "--most-maneuvers"]);
}

#[test]
fn refusals_of_what_to_generate() {
    let folder = written(2);
    let try_with = |from: &str, to: &str, pieces: &[&str]| {
        assert!(GENERATE.contains(from));
        put(&folder, "dictionary.toml", &GENERATE.replace(from, to));
        refused(&folder, 3, DICTIONARY, pieces);
    };
    try_with("r_rad_s = 0.6", "r_rad_s = 0.6\nw_m_s = 1.0", &["dictionary.toml", "w_m_s", "v_m_s"]);
    try_with("tau2 = 1430.0", "tau4 = 1430.0", &["dictionary.toml", "`tau4`", "tau1, tau2, tau3"]);
    try_with("u_m_s = 1.2", "u_m_s = -1.2", &["generate.limits.u_m_s", "-1.2"]);
    try_with("candidates = 120", "candidates = 0", &["generate.candidates", "found 0"]);
    try_with("seed = 3", "seed = 3\nkinds = [\"zigzag\"]", &["zigzag", "zig-zag"]);
    try_with("seed = 3", "seed = 3\nperiod_s = [4.0, 2.0]", &["generate.period_s"]);
    try_with(
        "tau2 = 1430.0",
        "tau1 = 0.001",
        &["generate.limits.inputs.tau1", "tightest", "120 of 120", "raise `inputs.tau1`"],
    );
    let clash =
        "[[maneuver]]\nname = \"combined-00000\"\nkind = \"accelerate\"\nfrom_m_s = 0.0\nto_m_s = 1.0\n";
    put(&folder, "dictionary.toml", &format!("{GENERATE}{clash}"));
    refused(&folder, 3, DICTIONARY, &["combined-00000", "used twice"]);
    put(&folder, "dictionary.toml", "duration_s = 12.5\n");
    refused(&folder, 3, DICTIONARY, &["[[maneuver]]", "[generate]"]);
}

#[test]
fn designs_for_output_error_are_proved_where_there_is_no_current() {
    let folder = papers();
    for still in [false, true] {
        if still {
            edit(&folder, "campaign.toml", "std_m_s = 0.158", "std_m_s = 0.0 # 0.158");
            run(&folder, OUTPUT_ERROR).succeeds();
        }
        for name in ["d", "a", "a-relative", "v"] {
            run(&folder, &FOR.replace("a-relative", name)).succeeds();
            let found = data(&folder);
            assert_eq!(found["estimator"], "output-error");
            assert_eq!(
                found["status"],
                if still { "optimal" } else { "stationary" },
                "{name}: {}",
                found["statement"]
            );
        }
    }
}

#[test]
fn few_maneuvers_cost_what_they_say() {
    let folder = generated();
    run(&folder, &format!("{FOR} --duration-s 125 --most-maneuvers 4")).succeeds();
    let found = data(&folder);
    assert!(used(&found).len() <= 4 && found["status"] == "restricted", "{}", found["statement"]);
    assert!(found["statement"].as_str().unwrap().contains("not proved global"), "{}", found["statement"]);
    assert_eq!(found["restricted"]["most_maneuvers"], 4);
    let loss = found["restricted"]["gap"].as_f64().unwrap();
    assert!(loss > 0.0 && loss < 0.9, "{loss}");
    let papers = papers();
    run(&papers, &format!("{FOR} --most-maneuvers 3 --segments 10 --segment-samples 100")).succeeds();
    let found = data(&papers);
    assert_eq!(found["restricted"]["method"], "exhaustive");
    let counts = found["counts"].as_object().unwrap();
    let counted: Vec<u64> = counts.values().map(|n| n.as_u64().unwrap()).filter(|n| *n > 0).collect();
    assert!(counted.len() <= 3 && counted.iter().sum::<u64>() == 10, "{counts:?}");
}

#[test]
fn the_time_for_an_accuracy_is_that_of_its_own_prediction() {
    let folder = papers();
    run(&folder, &format!("{FOR} --accuracy 0.5")).succeeds();
    let found = data(&folder);
    let accuracy = &found["accuracy"];
    let seconds = accuracy["duration_s"].as_f64().unwrap();
    let reached = accuracy["reached"].as_f64().unwrap();
    assert!(reached <= 0.5 && reached > 0.4999, "{accuracy}");
    run(&folder, &format!("{FOR} --duration-s {seconds}")).succeeds();
    let again = data(&folder)["covariance"]["value"].as_f64().unwrap().sqrt();
    assert!((again - reached).abs() < 1e-6, "{again} {reached}");
    for point in accuracy["curve"].as_array().unwrap() {
        let own = point["design"].as_f64().unwrap();
        for other in ["paper", "equal", "random"] {
            assert!(point[other].as_f64().is_none_or(|other| other >= own * (1.0 - 1e-9)), "{point}");
        }
    }
    // Half of the time that spiral-fast would take is there.
    put(&folder, "available.toml", &format!("[seconds]\nspiral-fast = {}\n", 0.2 * seconds));
    run(&folder, &format!("{FOR} --accuracy 0.5 --available available.toml")).succeeds();
    let limited = data(&folder)["accuracy"]["duration_s"].as_f64().unwrap();
    assert!(limited > seconds, "{limited} {seconds}");
    assert!(data(&folder)["shares"]["spiral-fast"].as_f64().unwrap() * limited <= 0.2 * seconds + 1e-6);
}

#[test]
fn refusals_of_accuracies_and_estimators() {
    let folder = papers();
    let far = format!("{FOR} --accuracy 0.001");
    refused(&folder, 4, &far, &["moments.json", "--accuracy", "0.001", "86400 s", "the best is 0.0"]);
    let all: String = names(&folder).iter().map(|name| format!("{name} = 20.0\n")).collect();
    put(&folder, "available.toml", &format!("[seconds]\n{all}"));
    let line = format!("{FOR} --accuracy 0.5 --available available.toml");
    refused(&folder, 4, &line, &["--accuracy", "the best is"]);
    refused(&folder, 2, &format!("{FOR} --accuracy 0"), &["--accuracy", "above 0"]);
    let hessian = "design --moments moments.json --criterion d-hessian --relative-to value --accuracy 0.5 --out design.json";
    refused(&folder, 2, hessian, &["--accuracy", "d-hessian", "a-relative"]);
    refused(
        &folder,
        2,
        &FOR.replace("a-relative", "d-hessian"),
        &["--criterion", "d-hessian", "output-error"],
    );
    refused(
        &folder,
        2,
        "design --moments moments.json --criterion v --out design.json",
        &["--criterion", "v", "output-error"],
    );
    refused(&folder, 2, &OUTPUT_ERROR.replace("--campaign campaign.toml", ""), &["--campaign"]);
    run(&folder, MOMENTS).succeeds();
    refused(&folder, 3, FOR, &["moments.json", "no `output_error`", "--estimator output-error"]);
}

#[test]
fn the_report_shows_how_long_and_in_which_order() {
    let folder = papers();
    run(
        &folder,
        &format!("{FOR} --accuracy 1.0 --arrange --vessel vessel.toml --dictionary dictionary.toml"),
    )
    .succeeds();
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    for piece in ["How long?", "paper&#39;s criterion", "with the state carried over"] {
        assert!(page.contains(piece) || page.contains(&piece.replace("&#39;", "'")), "{piece}");
    }
}
