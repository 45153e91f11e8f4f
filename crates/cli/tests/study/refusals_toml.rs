//! Hand-written input that is refused, and models that diverge.

use tempfile::TempDir;

use crate::support::*;

/// Refuses the study after `from` in `name` has become `to`.
#[track_caller]
fn edited(name: &str, from: &str, to: &str, line: &str, pieces: &[&str]) {
    let folder = with(&["design.json"]);
    edit(&folder, name, from, to);
    refused(&folder, 3, line, &[&[name], pieces].concat());
}

/// The paper's vessel written out, without the preset.
fn written_out(folder: &TempDir) {
    let vessel = repository().join("pipelines/paper/vessel.toml");
    std::fs::copy(vessel, folder.path().join("vessel.toml")).unwrap();
}

#[test]
fn unknown_keys_are_refused_with_the_nearest_known_key() {
    edited("vessel.toml", "preset", "nmae = \"x\"\npreset", DICTIONARY, &["`nmae`", "line 1", "`name`?"]);
    let pieces = ["`perod_s`", "did you mean `period_s`?", "maneuver `zig-zag-slow-flat`"];
    edited("dictionary.toml", "period_s = 10.0", "perod_s = 10.0", DICTIONARY, &pieces);
    edited("dictionary.toml", "inputs_from", "input_from", DICTIONARY, &["`input_from`", "`inputs_from`?"]);
    edited("campaign.toml", "realizations", "realisations", CAMPAIGN, &["`realisations`", "`realizations`?"]);
    edited("campaign.toml", "dwell_s", "dwel_s", VALIDATION, &["`dwel_s`", "`dwell_s`?", "telegraph"]);
}

#[test]
fn the_known_keys_of_a_maneuver_are_keys_only() {
    let folder = with(&[]);
    edit(&folder, "dictionary.toml", "period_s = 10.0", "perod_s = 10.0");
    let ran = run(&folder, DICTIONARY).refuses(3, &[]);
    let known = ran.stderr.split_once("a known key: ").unwrap().1.split_once("; ").unwrap().0;
    assert!(known.contains("`period_s`") && !known.contains("zig-zag"), "{ran}");
}

#[test]
fn a_key_with_another_unit_is_refused_with_the_key_that_is_meant() {
    edited("dictionary.toml", "speed_m_s", "speed_kn", DICTIONARY, &["key `speed_kn`", "`speed_m_s`?"]);
    edited("campaign.toml", "duration_s", "duration_min", CAMPAIGN, &["`duration_min`", "`duration_s`?"]);
}

#[test]
fn numbers_that_are_not_finite_are_refused() {
    for (number, found) in [("nan", "NaN"), ("inf", "inf"), ("-inf", "-inf")] {
        for table in ["nominal", "value"] {
            let folder = with(&[]);
            put(
                &folder,
                "vessel.toml",
                &format!("preset = \"ljungberg-model-ship\"\n[{table}]\nX_u = {number}\n"),
            );
            refused(
                &folder,
                3,
                DICTIONARY,
                &["vessel.toml", &format!("`{table}.X_u`"), found, "a finite number"],
            );
        }
        let (from, to) = ("speed_m_s = 0.35", format!("speed_m_s = {number}"));
        edited("dictionary.toml", from, &to, DICTIONARY, &["`zig-zag-slow-flat`", "`speed_m_s`"]);
        let to = format!("duration_s = {number}");
        edited("dictionary.toml", "duration_s = 37.5", &to, DICTIONARY, &["`duration_s`"]);
        edited("campaign.toml", "duration_s = 125.0", &to, CAMPAIGN, &["`duration_s`", found]);
        let to = format!("std_u_m_s = {number} #");
        edited("campaign.toml", "std_u_m_s =", &to, CAMPAIGN, &["`measurement.std_u_m_s`", found]);
    }
}

#[test]
fn a_list_where_keys_belong_is_refused() {
    for (table, list) in
        [("[measurement]", "measurement = [0.1, 0.1, 0.1]"), ("[current]", "current = [\"white\", 0.1]")]
    {
        let folder = with(&["design.json"]);
        let text = std::fs::read_to_string(folder.path().join("campaign.toml")).unwrap();
        let (before, after) = text.split_once(table).unwrap();
        let rest = after.split_once("\n[").unwrap().1;
        put(&folder, "campaign.toml", &format!("{list}\n{before}[{rest}"));
        refused(
            &folder,
            3,
            CAMPAIGN,
            &["campaign.toml", "found a list (line 1, column 1)", "keys with values"],
        );
    }
    let list = "kind = \"combined\"\nspeed_m_s = [\"sine\", 0.5]";
    let folder = with(&[]);
    put(&folder, "dictionary.toml", &format!("duration_s = 9.0\n[[maneuver]]\nname = \"a\"\n{list}\n"));
    refused(&folder, 3, DICTIONARY, &["dictionary.toml", "found a list", "maneuver `a`"]);
}

#[test]
fn values_beyond_those_that_a_list_takes_are_refused() {
    let to = "[generate]\ncandidates = 9\nspeed_m_s = [0.2, 0.4, 0.6]\nlimits = { u_m_s = 1.0, v_m_s = 0.2, r_rad_s = 0.3 }";
    let pieces =
        ["dictionary.toml", "speed_m_s", "found a value too many (line 4, column 1)", "a list of 2 values"];
    let folder = with(&[]);
    put(&folder, "dictionary.toml", &format!("duration_s = 9.0\n{to}\n"));
    refused(&folder, 3, DICTIONARY, &pieces);
}

#[test]
fn speeds_that_no_ship_has_are_refused() {
    let pieces = ["`zig-zag-slow-flat`, `speed_m_s`", "found 350", "from -100 to 100 m/s"];
    edited("dictionary.toml", "speed_m_s = 0.35", "speed_m_s = 350.0", DICTIONARY, &pieces);
    let pieces = ["telegraph", "`yaw_rate_amplitude_rad_s`", "found 30", "from -10 to 10 rad/s"];
    let (from, to) = ("yaw_rate_amplitude_rad_s = 0.3", "yaw_rate_amplitude_rad_s = 30.0");
    edited("campaign.toml", from, to, VALIDATION, &pieces);
}

#[test]
fn cells_of_an_inputs_file_that_are_not_finite_are_refused_with_line_and_column() {
    for cell in ["nan", "inf", "-Infinity", "", "fast"] {
        let folder = with(&[]);
        put(
            &folder,
            "dictionary.toml",
            "[[maneuver]]\nname = \"recorded\"\nkind = \"inputs\"\nfile = \"log.csv\"\n",
        );
        put(&folder, "log.csv", &format!("tau1,tau2,tau3\n1,2,3\n4,{cell},6\n"));
        let pieces = ["dictionary.toml", "log.csv", "line 3", "`tau2`", "a finite number"];
        refused(&folder, 3, DICTIONARY, &pieces);
    }
}

#[test]
fn maneuvers_without_samples_are_refused() {
    let zero = "name = \"decelerate\"\nduration_s = 0.0";
    edited("dictionary.toml", "name = \"decelerate\"", zero, DICTIONARY, &["`decelerate`", "`duration_s`"]);
    let negative = "name = \"decelerate\"\nduration_s = -1.0";
    edited("dictionary.toml", "name = \"decelerate\"", negative, DICTIONARY, &["`decelerate`", "-1"]);
    let half = "name = \"decelerate\"\nduration_s = 0.05";
    let pieces = ["`decelerate`", "zero samples", "0.125 s", "lengthen"];
    edited("dictionary.toml", "name = \"decelerate\"", half, DICTIONARY, &pieces);
    edited("campaign.toml", "duration_s = 125.0", "duration_s = 0.1", CAMPAIGN, &["segments"]);
}

#[test]
fn maneuvers_and_runs_of_absurd_length_are_refused() {
    let pieces = ["`duration_s`", "samples"];
    edited("dictionary.toml", "duration_s = 37.5", "duration_s = 9e8", DICTIONARY, &pieces);
    edited("campaign.toml", "duration_s = 125.0", "duration_s = 9e8", CAMPAIGN, &pieces);
    let pieces = ["`random.segments`", "1000 samples"];
    edited("campaign.toml", "segments = 5", "segments = 4000000000", CAMPAIGN, &pieces);
}

#[test]
fn misspelt_and_repeated_names_are_refused() {
    let (from, to) = ("name = \"accelerate\"", "name = \"decelerate\"");
    edited("dictionary.toml", from, to, DICTIONARY, &["maneuver `decelerate`", "used twice", "rename"]);
    let pieces = ["`sprial`", "did you mean `spiral`?"];
    edited("dictionary.toml", "kind = \"spiral\"", "kind = \"sprial\"", DICTIONARY, &pieces);
    edited("campaign.toml", "kind = \"white\"", "kind = \"whit\"", CAMPAIGN, &["`whit`", "`white`?"]);
    let pieces = ["`ljungberg-model-shp`", "did you mean `ljungberg-model-ship`?"];
    edited("vessel.toml", "model-ship", "model-shp", DICTIONARY, &pieces);
}

#[test]
fn a_term_with_an_unknown_variable_is_refused_with_the_nearest() {
    let folder = with(&[]);
    written_out(&folder);
    edit(&folder, "vessel.toml", "term = \"tau2\"", "term = \"tua2\"");
    refused(&folder, 3, DICTIONARY, &["vessel.toml", "term `tua2`", "did you mean `tau2`?"]);
}

#[test]
fn missing_keys_wrong_types_and_broken_syntax_are_refused_with_their_line() {
    edited("campaign.toml", "seed = 1\n", "", CAMPAIGN, &["no key `seed`", "add `seed`"]);
    let pieces = ["realizations", "line 3", "expected a whole number from 0"];
    edited("campaign.toml", "realizations = 24", "realizations = \"many\"", CAMPAIGN, &pieces);
    edited("campaign.toml", "realizations = 24", "realizations = -3", CAMPAIGN, &["line 3"]);
    edited("campaign.toml", "realizations = 24", "realizations = 0", CAMPAIGN, &["`realizations`", "0"]);
    edited("campaign.toml", "[current]", "[current", CAMPAIGN, &["line 7"]);
    let folder = with(&["design.json"]);
    std::fs::write(folder.path().join("campaign.toml"), b"seed = 1 # \xff").unwrap();
    refused(&folder, 3, CAMPAIGN, &["campaign.toml", "UTF-8", "line 1"]);
}

#[test]
fn a_nominal_model_that_diverges_is_refused_where_no_model_can_replace_it() {
    let folder = with(&["dictionary.parquet", "campaign.parquet"]);
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n[nominal]\nX_u = 2.5\n");
    let pieces = ["vessel.toml", "nominal model", "u leaves every bound", "at sample", "damping"];
    refused(
        &folder,
        3,
        &format!("{MOMENTS} --allow=mixed"),
        &[&pieces[..], &["design dictionary", "run 0", "0.8 s"]].concat(),
    );
    // Over a run of a campaign its own model can, but not over one maneuver alone.
    let said = run(&folder, &format!("{ESTIMATE} --allow=mixed")).succeeds().stdout;
    assert!(said.contains("with instruments by output error: the nominal model diverges"), "{said}");
    refused(
        &folder,
        3,
        "estimate --vessel vessel.toml --trajectories dictionary.parquet --out of-maneuvers.parquet --allow=mixed",
        &[&pieces[..], &["design dictionary", "run 0", "0.8 s"]].concat(),
    );
    run(&folder, &format!("{ESTIMATE} --estimator ls --allow=mixed")).succeeds();
}

#[test]
fn a_true_model_that_diverges_is_refused_with_maneuver_and_sample() {
    let folder = with(&["design.json"]);
    put(&folder, "vessel.toml", "preset = \"ljungberg-model-ship\"\n[value]\nN_r = 1.5\n");
    edit(&folder, "dictionary.toml", "inputs_from = \"value\"", "inputs_from = \"nominal\"");
    let pieces = ["vessel.toml", "maneuver `zig-zag-slow-flat`", "diverges", "at sample", "damping"];
    refused(&folder, 3, DICTIONARY, &pieces);
    refused(
        &folder,
        3,
        &format!("{CAMPAIGN} --allow=mixed"),
        &["vessel.toml", "design optimized, run 0", "diverges", "at sample"],
    );
}

#[test]
fn a_current_of_no_sea_is_refused_and_not_put_down_to_the_vessel() {
    let folder = with(&["design.json"]);
    edit(&folder, "campaign.toml", "std_m_s = ", "std_m_s = 1e12 # ");
    refused(&folder, 3, CAMPAIGN, &["campaign.toml", "`current.std_m_s`", "0 to 15 m/s"]);
    edit(&folder, "campaign.toml", "std_m_s = 1e12", "std_m_s = 15");
    let pieces = ["campaign.toml", "`current.std_m_s`", "run 0, which diverges in it", "in still water"];
    refused(&folder, 3, &format!("{CAMPAIGN} --allow=mixed"), &pieces);
}
