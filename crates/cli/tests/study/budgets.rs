//! Work that would not finish or fit is refused before it begins.

use crate::support::*;

/// Refuses the study after `from` in `name` has become `to`, in little memory.
#[track_caller]
fn edited(name: &str, from: &str, to: &str, line: &str, pieces: &[&str]) {
    let folder = with(&["dictionary.parquet", "design.json"]);
    edit(&folder, name, from, to);
    let before = listing(folder.path());
    let ran = run_in_little_memory(&folder, line).refuses(3, &[&[name], pieces].concat());
    assert_eq!(listing(folder.path()), before, "the folder changed{ran}");
}

#[test]
fn campaigns_that_no_disk_holds_are_refused() {
    let (many, pieces) =
        ("realizations = 1000000000", ["`realizations`", "3000000000 runs", "TiB", "free there"]);
    edited("campaign.toml", "realizations = 24", many, CAMPAIGN, &pieces);
}

#[test]
fn runs_without_end_are_refused_by_every_stage_that_simulates() {
    let long = "duration_s = 9e8\nspeed_m_s = 0.6";
    let pieces = ["maneuver `telegraph`, `duration_s`", "at most 4194304 samples"];
    edited("campaign.toml", "duration_s = 125.0\nspeed_m_s = 0.6", long, VALIDATION, &pieces);
    let moments = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml \
        --estimator output-error --out moments.json";
    edited("campaign.toml", "duration_s = 125.0\nspeed_m_s = 0.6", long, moments, &pieces);
    edited(
        "campaign.toml",
        "duration_s = 125.0",
        "duration_s = 9e8",
        CAMPAIGN,
        &["`duration_s`", "at most 4194304"],
    );
    let generate =
        "duration_s = 9e8\n[generate]\ncandidates = 9\nlimits = { u_m_s = 1, v_m_s = 1, r_rad_s = 1 }\n#";
    edited(
        "dictionary.toml",
        "duration_s = 37.5",
        "duration_s = 9e8",
        DICTIONARY,
        &["`duration_s`", "at most"],
    );
    let folder = with(&[]);
    put(&folder, "dictionary.toml", generate);
    refused(&folder, 3, DICTIONARY, &["dictionary.toml", "`duration_s`", "at most 4194304 samples"]);
}

#[test]
fn maneuvers_that_do_not_fit_into_memory_side_by_side_are_refused() {
    // Of 400,000 samples each, all of them in one block.
    let pieces = ["`duration_s`", "maneuvers of", "GiB of memory", "fits the 64 MiB of --memory-mib"];
    let line = format!("{DICTIONARY} --memory-mib 64");
    edited("dictionary.toml", "duration_s = 37.5", "duration_s = 50000.0", &line, &pieces);
}

#[test]
fn the_memory_that_the_system_leaves_is_known() {
    let pieces = ["`duration_s`", "of memory", "fits the 4.0 GiB of the address space (ulimit -v)"];
    edited("dictionary.toml", "duration_s = 37.5", "duration_s = 500000.0", DICTIONARY, &pieces);
}

#[test]
fn trajectories_that_do_not_fit_into_memory_are_refused() {
    let folder = with(&["campaign.parquet"]);
    for stage in ["estimate", "estimate --structure own"] {
        let line = format!(
            "{stage} --vessel vessel.toml --trajectories campaign.parquet --out e.parquet --memory-mib 1"
        );
        refused(
            &folder,
            3,
            &line,
            &["campaign.parquet: rows: found ", " of memory", "1.0 MiB of --memory-mib"],
        );
    }
}

#[test]
fn swings_that_the_sampling_rate_does_not_show_are_refused() {
    let zig_zag = |period: &str, expected: &str| {
        let to = format!("period_s = {period}");
        let pieces = ["maneuver `zig-zag-slow-flat`, `period_s`", expected, "at 8 Hz"];
        edited("dictionary.toml", "period_s = 10.0", &to, DICTIONARY, &pieces);
    };
    zig_zag("0.125", "found 0.125 s (line ");
    zig_zag("0.125", ", expected at least 0.5 s: 4 samples");
    zig_zag("1e-9", "at least 0.5 s");
    edited(
        "campaign.toml",
        "dwell_s = 10.0",
        "dwell_s = 0.1",
        VALIDATION,
        &["`dwell_s`", "0.125 s: 1 sample at"],
    );
    let folder = with(&[]);
    let generate = |period: &str| {
        let limits = "limits = { u_m_s = 1.2, v_m_s = 0.25, r_rad_s = 0.6 }";
        put(
            &folder,
            "dictionary.toml",
            &format!("duration_s = 9.0\n[generate]\ncandidates = 9\nperiod_s = {period}\n{limits}\n"),
        );
        run_in_little_memory(&folder, DICTIONARY)
    };
    generate("[1e-9, 10]").refuses(3, &["dictionary.toml", "`generate.period_s`", "1.375 s: 11 samples"]);
    generate("[1.375, 10]").succeeds();
}

#[test]
fn rounds_whose_rows_do_not_fit_are_refused() {
    let folder = with(&[]);
    in_rounds(
        &folder,
        "realizations = 1000000000\nduration_s = 90.0\nrounds = 3\nnominal_spread = 0.4\naccuracy = 0.5\n",
    );
    let line = "monte-carlo --vessel vessel.toml --dictionary dictionary.toml --campaign campaign.toml --out s.parquet";
    refused(&folder, 3, line, &["campaign.toml", "`rounds.realizations`", "TiB of memory"]);
}
