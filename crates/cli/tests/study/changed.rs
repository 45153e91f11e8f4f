//! `--set`: values that override those of the hand-written files.

use serde_json::json;
use study::documents::ValidationDocument;
use tempfile::TempDir;

use crate::support::*;

const LINE: &str = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml \
                    --design design.json";

fn tallied(folder: &TempDir, name: &str) -> serde_json::Value {
    serde_json::to_value(document::<ValidationDocument>(folder, name).data.counted).unwrap()
}

#[test]
fn law_a_value_that_is_set_is_as_good_as_one_that_is_written() {
    let folder = with(&["design.json"]);
    let set = "--set campaign.realizations=8 --set campaign.measurement.std_u_m_s=0.25 \
               --set campaign.validation.maneuver.telegraph.seed=7 --set campaign.wind=";
    // Both ways of naming an item of a list; a table that the file does not have.
    let wind = "{std_surge_m_s2=0.01,std_sway_m_s2=0.01,std_yaw_rad_s2=0.001,time_constant_s=30.0}";
    let set = format!("{set}{wind}");
    run(&folder, &format!("{LINE} {set} --out set.json")).succeeds();
    run(&folder, &format!("{LINE} {} --out place.json", set.replace(".telegraph.", ".0."))).succeeds();
    assert_eq!(tallied(&folder, "set.json"), tallied(&folder, "place.json"));
    edit(&folder, "campaign.toml", "realizations = 24", &format!("realizations = 8\nwind = {wind}"));
    edit(&folder, "campaign.toml", "std_u_m_s = 0.15811388300841897", "std_u_m_s = 0.25");
    edit(&folder, "campaign.toml", "dwell_s = 10.0\nseed = 1", "dwell_s = 10.0\nseed = 7");
    run(&folder, &format!("{LINE} --out written.json")).succeeds();
    assert_eq!(tallied(&folder, "set.json"), tallied(&folder, "written.json"));
}

#[test]
fn what_was_set_is_written_and_belongs_to_the_study() {
    let folder = with(&[]);
    let set = "--set vessel.value.X_u=-0.05 --set dictionary.duration_s=20";
    run(&folder, &format!("{DICTIONARY} {set}")).succeeds();
    let moments = format!("{MOMENTS} --set vessel.value.X_u=-0.05");
    refused(&folder, 3, MOMENTS, &["dictionary.parquet", "another vessel", "vessel.toml"]);
    let other = moments.replace("-0.05", "-0.07");
    refused(&folder, 3, &other, &["dictionary.parquet", "another vessel", "vessel.toml"]);
    run(&folder, &moments).succeeds();
    let whole = json(&folder, "moments.json");
    assert_eq!(whole["settings"]["set"], json!({"vessel.value.X_u": -0.05}));
    let unset = with(&["moments.json"]);
    assert_ne!(whole["inputs"]["vessel"], json(&unset, "moments.json")["inputs"]["vessel"]);
    assert_eq!(json(&unset, "moments.json")["settings"].get("set"), None);
    // The same values in two orders and spellings are the same study.
    let again = "--set dictionary.duration_s=20.0 --set vessel.value.X_u=-5e-2";
    run(&folder, &DICTIONARY.replace("--out dictionary", &format!("{again} --out again"))).succeeds();
    let told = |name| craft::read(&folder.path().join(name), "trajectories").provenance.inputs;
    assert_eq!(told("again.parquet")["vessel"], told("dictionary.parquet")["vessel"]);
}

#[test]
fn shards_of_other_values_are_not_gathered() {
    let folder = with(&["design.json"]);
    for (k, std) in [(1, 0.1), (2, 0.2)] {
        let set = format!("--realizations 8 --set campaign.current.std_m_s={std}");
        run(&folder, &format!("{LINE} {set} --shard {k}/2 --out part-{k}.json")).succeeds();
    }
    let says = ["part-2.json", "inputs.campaign", "shards of one computation"];
    refused(&folder, 3, "monte-carlo --gather part-1.json part-2.json --out validation.json", &says);
}

#[test]
fn a_value_that_is_set_is_checked_as_one_that_is_written() {
    let folder = with(&["design.json"]);
    let refused = |set: &str, says: &[&str]| {
        let says: Vec<&str> = [&["campaign.toml"], says].concat();
        refused(&folder, 3, &format!("{CAMPAIGN} --set {set}"), &says);
    };
    let says = ["`realisations`", "with campaign.realisations=3", "did you mean `realizations`?"];
    refused("campaign.realisations=3", &says);
    refused("campaign.realizations=0", &["`realizations`", "found 0"]);
    refused("campaign.realizations=many", &["the text \"many\"", "a whole number", "with campaign"]);
    refused("campaign.current.kind=whit", &["`whit`", "`white`?"]);
    refused("campaign.seed.x=1", &["`campaign.seed.x`", "`x` below 1", "a table or a list"]);
    let says = ["`telegrph`", "did you mean `telegraph`?"];
    refused("campaign.validation.maneuver.telegrph.seed=1", &says);
    refused("campaign.validation.maneuver.1.seed=1", &["`1`", "expected telegraph"]);
}

#[test]
fn what_is_wrong_with_the_file_itself_is_said_with_its_line() {
    let folder = with(&["design.json"]);
    edit(&folder, "campaign.toml", "seed = 1\n", "seed = 1\nsede = 1\n");
    refused(
        &folder,
        3,
        &format!("{CAMPAIGN} --set campaign.realizations=3"),
        &["`sede`", "(line 3, column 1)"],
    );
    edit(&folder, "campaign.toml", "sede = 1", "[");
    refused(&folder, 3, &format!("{CAMPAIGN} --set campaign.realizations=3"), &["campaign.toml", "line 3"]);
}

#[test]
fn a_change_that_nothing_would_apply_is_refused() {
    let folder = with(&["design.json", "moments.json", "dictionary.parquet"]);
    let refused = |line: &str, says: &[&str]| refused(&folder, 2, line, says);
    let known = "expected vessel, dictionary, campaign";
    refused(&format!("{CAMPAIGN} --set campain.seed=1"), &["`campain`", known, "did you mean `campaign`?"]);
    refused(&format!("{MOMENTS} --set campaign.seed=1"), &["--set", "`campaign`", "expected vessel"]);
    refused(&format!("{DESIGN} --set vessel.value.X_u=1"), &["`vessel`", "no TOML file is named here"]);
    let json = MOMENTS.replace("vessel.toml", "model.json");
    refused(&format!("{json} --set vessel.value.X_u=1"), &["`vessel`", "no TOML file is named here"]);
    let twice = "--set campaign.seed=1 --set campaign.\"seed\"=1";
    refused(&format!("{CAMPAIGN} {twice}"), &["`campaign.seed`", "it twice", "remove one"]);
    for wrong in ["campaign=1", "campaign.seed", "=1", "campaign..seed=1"] {
        refused(&format!("{CAMPAIGN} --set {wrong}"), &["--set", "campaign"]);
    }
}

#[test]
fn a_report_of_results_takes_what_was_set() {
    let folder = with(&[]);
    let set = "--set vessel.value.X_u=-0.05";
    [DICTIONARY, MOMENTS].iter().for_each(|stage| drop(run(&folder, &format!("{stage} {set}")).succeeds()));
    run(&folder, DESIGN).succeeds();
    refused(&folder, 3, REPORT, &["another vessel"]);
    run(&folder, &format!("{REPORT} {set}")).succeeds();
}
