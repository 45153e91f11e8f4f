//! What is refused before anything is written.

use crate::support::*;

#[test]
fn a_folder_that_is_there_already() {
    let folder = with(&[]);
    std::fs::create_dir(folder.path().join("mine")).unwrap();
    refused(
        &folder,
        3,
        "new mine --vessel coaster",
        &["mine: folder: found it there already", "name another"],
    );
    put(&folder, "file", "");
    refused(&folder, 3, "new file --vessel coaster", &["file: folder: found it there already"]);
    // Folders above it are made.
    run(&folder, "new a/b/mine --vessel coaster").succeeds();
    assert!(folder.path().join("a/b/mine/vessel.toml").exists());
}

#[test]
fn a_preset_that_is_not() {
    let folder = with(&[]);
    let pieces = ["--vessel: preset: found `coster`", "model-ship", "did you mean `coaster`?"];
    refused(&folder, 2, "new mine --vessel coster", &pieces);
    let pieces =
        ["vessel.toml: [ship]: found none", "a ship with forces", "seatrial new <folder> --vessel <preset>"];
    refused(&folder, 3, "new mine --vessel vessel.toml", &pieces);
    refused(&folder, 2, "new mine", &["--vessel <PRESET|vessel.toml>"]);
    put(&folder, "otter.toml", "preset = \"otter\"\n");
    refused(&folder, 3, "new mine --vessel otter.toml", &["otter.toml: [ship]: found none"]);
    assert!(!folder.path().join("mine").exists());
}

#[test]
fn charts_that_a_study_cannot_begin_with() {
    let folder = with(&[]);
    let chart = repository().join("fixtures/charts/helsinki_land_gshhg.geojson").display().to_string();
    let new = |vessel: &str, flags: &str| format!("new mine --vessel {vessel} {flags}");
    for (vessel, flags, code, pieces) in [
        ("full-scale", format!("--chart {chart}"), 2, ["--place", "LONGITUDE,LATITUDE"]),
        ("full-scale", "--place 24.97,60.12".to_owned(), 2, ["--chart", "PATH"]),
        ("full-scale", format!("--chart {chart} --place 24.97"), 2, ["24.97", "such as 24.97,60.12"]),
        (
            "full-scale",
            format!("--chart {chart} --place 24.97,95.0"),
            3,
            ["--place: found 24.97,95", "degrees"],
        ),
        (
            "full-scale",
            format!("--chart {chart} --place 24.95,60.30"),
            3,
            ["latitude 60.009 to 60.250", "name a place on it"],
        ),
        (
            "full-scale",
            format!("--chart {chart} --place 60.12,24.97"),
            3,
            ["a place on the chart: longitude 24.", "exchange them: --place 24.97,60.12"],
        ),
        (
            "full-scale",
            format!("--chart {chart} --place 5.0,52.0"),
            3,
            ["a place on the chart: longitude 24.", "or another chart"],
        ),
        (
            "full-scale",
            "--chart nowhere.geojson --place 24.97,60.12".to_owned(),
            3,
            ["nowhere.geojson", "no such file"],
        ),
        (
            "mariner",
            format!("--chart {chart} --place 24.97,60.12"),
            3,
            ["mariner, the cargo ship", "coaster, full-scale"],
        ),
        (
            "full-scale",
            format!("--chart {chart} --place 24.97,60.12 --slot 2026-06-01T08:00:00Z"),
            2,
            ["--slot", "expected FROM/UNTIL"],
        ),
        (
            "full-scale",
            format!("--chart {chart} --place 24.97,60.12 --slot 2026-06-01T18:00:00Z/2026-06-01T08:00:00Z"),
            2,
            ["--slot", "the earlier time first"],
        ),
    ] {
        refused(&folder, code, &new(vessel, &flags), &pieces);
        assert!(!folder.path().join("mine").exists());
    }
}

#[test]
fn a_study_that_lacks_a_file() {
    for (name, command) in [
        ("vessel.toml", "seatrial new <folder> --vessel <preset>"),
        ("dictionary.toml", "seatrial new <folder> --vessel <preset>"),
        ("campaign.toml", "seatrial new <folder> --vessel <preset>"),
    ] {
        let folder = with(&[]);
        std::fs::remove_file(folder.path().join(name)).unwrap();
        refused(&folder, 3, "run . --out out", &[&format!("{name}: file: found no such file"), command]);
    }
    let folder = with(&[]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let command = "`seatrial new <folder> --vessel <preset>`";
    refused(&folder, 3, "run empty", &["empty: study: found none of a study's files", command]);
    refused(&folder, 3, "run nowhere", &["nowhere: study: found no such folder", command]);
}

#[test]
fn logs_that_are_not_there() {
    let folder = with(&[]);
    put(&folder, "ingest.toml", "sample_rate_hz = 1.0\nmax_gap_s = 1.0\nfile = []\n");
    refused(&folder, 3, "run . --out out", &["./logs: --logs: found no such folder", "logs = \"<folder>\""]);
    refused(
        &folder,
        3,
        "new mine --vessel coaster --logs nowhere",
        &["nowhere: --logs: found no such folder"],
    );
}

#[test]
fn settings_that_no_stage_has() {
    let folder = with(&[]);
    let line = "run . --out out";
    for (text, pieces) in [
        (
            "[design]\nsegmnts = 5\n",
            ["study.toml: key: found key `segmnts` (line 2", "did you mean `segments`?"],
        ),
        (
            "[desing]\nsegments = 5\n",
            ["study.toml: key: found key `desing` (line 1", "did you mean `design`?"],
        ),
        ("[design]\nsegments = \"5\"\n", ["segments: found the text \"5\" (line 2", "a whole number"]),
        ("[design]\nduration_s = true\n", ["duration_s: found", "expected a number"]),
        ("[design]\narrange = \"yes\"\n", ["arrange: found the text \"yes\" (line 2", "true or false"]),
        ("[design]\ncriterion = \"dd\"\n", ["`dd` (line 2", "`d-hessian`"]),
        ("[design]\nmoments = \"other.json\"\n", ["found key `moments`", "known"]),
        ("[design]\nout = \"/tmp\"\n", ["found key `out`", "key"]),
        ("[plan]\nset = [\"plan.cell_m=1\"]\n", ["found key `set`", "key"]),
        ("test = \"one\"\n", ["study.toml", "expected a list"]),
        (
            "[design]\nsegments = 0\nsegment_samples = 5\n",
            ["study.toml: flags of `design`: found", "--segments"],
        ),
        ("[design]\nsegments = 5\n", ["study.toml: flags of `design`: found", "--segment-samples"]),
        ("segments = 5\n", ["study.toml: key: found key `segments`", "a known key"]),
    ] {
        put(&folder, "study.toml", text);
        refused(&folder, 3, line, &pieces);
    }
    std::fs::remove_file(folder.path().join("study.toml")).unwrap();
    for (changed, piece) in [
        ("study.design.segmnts=5", "did you mean `segments`?"),
        ("study.design.segments=five", "a whole number"),
        ("study.desing.segments=5", "did you mean `design`?"),
    ] {
        refused(&folder, 3, &format!("{line} --set {changed}"), &["study.toml", piece]);
    }
    refused(&folder, 2, &format!("{line} --setting DESIGN_FLAGS=1"), &["--setting", "--set study.design."]);
    put(&folder, "study.mk", "DESIGN_FLAGS = --segments 5\n");
    refused(&folder, 3, line, &["study.mk: file: found settings as text", "study.toml", "docs/own-ship.md"]);
}

#[test]
fn a_stage_and_a_change_of_nothing() {
    let folder = with(&[]);
    refused(
        &folder,
        2,
        "run . --out out --stage desing",
        &["--stage: stage: found `desing`", "did you mean `design`?"],
    );
    refused(
        &folder,
        2,
        "run . --out out --set plan.cell_m=1.0",
        &["--set: file: found `plan`", "a stage of this run reads"],
    );
}

#[test]
fn logs_of_two_ships() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("logs")).unwrap();
    let line = "new mine --vessel kvlcc2 --logs logs";
    put(&folder, "logs/a.csv", "t [s],vessel,heading [deg]\n0,Alpha,1\n1,Alpha,2\n2,Alpha,3\n");
    put(&folder, "logs/b.csv", "t [s],vessel,heading [deg]\n0,Beta,1\n1,Beta,2\n2,Beta,3\n");
    refused(
        &folder,
        3,
        line,
        &["logs/b.csv: column `vessel`: found `Beta` beside `Alpha` of a.csv", "a folder of its own"],
    );
    put(&folder, "logs/b.csv", "t [s],heading [deg],rudder [deg]\n0,1,1\n1,2,1\n2,3,1\n");
    let pieces = ["logs/b.csv: columns: found a column `rudder [deg]` that a.csv has not", "one ship"];
    refused(&folder, 3, line, &pieces);
}

#[test]
fn logs_without_columns_or_times() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("logs")).unwrap();
    let line = "new mine --vessel kvlcc2 --logs logs";
    refused(&folder, 3, line, &["logs: logs: found none", "name the folder"]);
    put(&folder, "logs/a.mat", "");
    refused(
        &folder,
        3,
        line,
        &["logs: logs: found `a.mat` and 0 more files, of formats that are not known", "or their files so"],
    );
    put(&folder, "logs/a.nmea", "");
    refused(&folder, 3, line, &["logs/a.nmea: time: found none, expected sentences with a time"]);
    put(&folder, "logs/a.mcap", "");
    refused(&folder, 3, line, &["logs/a.mcap: file", "a whole MCAP file"]);
    put(&folder, "logs/a.ulg", "");
    refused(&folder, 3, line, &["logs: logs: found `a.ulg` beside `a.mcap`", "bags of one format"]);
    put(&folder, "logs/a.csv", "1,speed\n3,4\n5,6\n");
    refused(&folder, 3, line, &["logs/a.csv: columns: found `1` in the first line"]);
    put(&folder, "logs/a.csv", "heading,speed\n3,4\n2,6\n1,6\n");
    refused(&folder, 3, line, &["logs/a.csv: time: found none", "write ingest.toml yourself"]);
}

/// `new` in a folder with logs that are not read must name the file, its format, and what converts it.
#[track_caller]
fn named(name: &str, log: &[u8], pieces: &[&str]) {
    let folder = tempfile::tempdir().unwrap();
    std::fs::create_dir(folder.path().join("logs")).unwrap();
    std::fs::write(folder.path().join("logs").join(name), log).unwrap();
    let at = format!("logs/{name}: format: found ");
    refused(&folder, 3, "new mine --vessel kvlcc2 --logs logs", &[&[at.as_str()], pieces].concat());
}

#[test]
fn logs_of_other_formats_are_refused_by_name_with_what_converts_them() {
    named("a.mat", b"MATLAB 5.0 MAT-file, Platform: GLNX86", &["a MATLAB file", "scipy.io.loadmat"]);
    named("a.mat", b"MATLAB 7.3 MAT-file, Platform: GLNX86", &["version 7.3", "h5py"]);
    let old = b"\0\0\0\0\x3d\0\0\0\x01\0\0\0\0\0\0\0\x02\0\0\0t\0\0\0\0\0\0\0\xF0\x3F";
    named("a.mat", old, &["version 4", "scipy.io.loadmat"]);
    named("a.xlsx", b"PK\x03\x04..[Content_Types].xml", &["an Excel workbook", "as CSV"]);
    named("a.log", b"(1744362500.000000) can0 09F11207#00E02EFF7FFF7FFC\n", &["candump", "analyzer -json"]);
    named(
        "a.csv",
        b"# canboat\n2011-11-24-22:42:04.388,2,127251,36,255,8,7d,0b,7d,02,00,ff,ff,ff\n",
        &["NMEA 2000"],
    );
    named("a.json", b"{\"timestamp\":\"2016\",\"pgn\":127250,\"fields\":{}}\n", &["canboat", "lines=True"]);
    named("a.bag", b"\x89MCAP0\r\n", &["a bag of MCAP"]);
    if let Ok(log) = std::fs::read(repository().join("../shared/cases-2/137-new-candump/a.log")) {
        named("a.log", &log, &["candump", "analyzer -json"]);
    } else {
        println!("skipped: there is no ../shared/cases-2");
    }
}

#[test]
fn a_page_of_a_folder_without_a_study() {
    let folder = with(&["design.json"]);
    std::fs::create_dir(folder.path().join("empty")).unwrap();
    let line = "report --study empty --results . --out page.html";
    refused(&folder, 3, line, &["empty: study: found none of a study's files", "--study"]);
    // A study in this folder has the name of its ship.
    run(&folder, "report --study . --results . --out page.html").succeeds();
    let page = String::from_utf8(bytes(&folder, "page.html")).unwrap();
    assert!(page.contains("<title>Ljungberg model ship"), "{}", &page[..400]);
}
