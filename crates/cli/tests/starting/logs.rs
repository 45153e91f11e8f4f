//! Studies of logs: what is guessed, what is corrected, and what comes of them.

use std::collections::BTreeMap;
use std::f64::consts::TAU;
use std::fs;

use tempfile::TempDir;

use crate::support::{craft, *};

/// A folder with `logs` of the model ship's simulated trial, with every maneuver `repeats` times, as if they were measured, with `from`
/// in their headers replaced by `to`.
pub fn logged(repeats: u32, from: &str, to: &str) -> TempDir {
    let folder = tempfile::tempdir().unwrap();
    let study = repository().join("pipelines/model-ship");
    for name in ["vessel.toml", "dictionary.toml", "logs.toml"] {
        fs::copy(study.join(name), folder.path().join(name)).unwrap();
    }
    edit(&folder, "logs.toml", "repeats = 5", &format!("repeats = {repeats}"));
    fs::create_dir(folder.path().join("logs")).unwrap();
    run(&folder, "simulate logs --vessel vessel.toml --dictionary dictionary.toml --logs logs.toml --out logs/simulated.json")
        .succeeds();
    // Without their seal they are any logs.
    fs::remove_file(folder.path().join("logs/simulated.json")).unwrap();
    for entry in fs::read_dir(folder.path().join("logs")).unwrap() {
        let path = entry.unwrap().path();
        let text = fs::read_to_string(&path).unwrap();
        assert!(text.contains(from), "{} has no `{from}`", path.display());
        fs::write(path, text.replacen(from, to, 1)).unwrap();
    }
    folder
}

/// Fewer maneuvers for the next trial of the study `mine`: most of the time would go to them.
pub fn few_candidates(folder: &TempDir) {
    edit(folder, "mine/next/dictionary.toml", "candidates = 200", "candidates = 20");
}

/// The samples in `out/measured/ingest.json`.
fn samples(folder: &TempDir) -> u64 {
    json(folder, "out/measured/ingest.json")["data"]["samples"].as_u64().unwrap()
}

const NEW: &str = "new mine --vessel model-ship --logs logs";
const INGEST: &str = "run mine --out out --quiet --stage ingest";

#[test]
fn logs_come_to_their_page_by_two_commands() {
    let folder = logged(2, "heading", "heading");
    let ran = run(&folder, NEW).succeeds();
    assert!(ran.stdout.contains("22 logs") && ran.stdout.contains("0 channels missing"), "{ran}");
    few_candidates(&folder);
    run(&folder, "run mine --out out --quiet").succeeds();
    let page = String::from_utf8(bytes(&folder, "out/measured/report.html")).unwrap();
    assert!(page.contains("<svg"), "measured is shown against simulated");
    // The next trial needs no file by hand; one that cannot be sailed is named, and takes nothing else away.
    assert!(page.contains("The next trial") && page.contains("Predicted, this trial"));
    let whole = bytes(&folder, "mine/next/campaign.toml");
    edit(&folder, "mine/next/campaign.toml", "std_u_m_s = ", "std_u_m_s = -");
    let without = run(&folder, "run mine --out out --quiet").succeeds();
    assert!(without.stdout.contains("without next-moments, next-design"), "{without}");
    assert!(
        without.stderr.contains("without next-moments: ") && without.stderr.contains("std_u_m_s"),
        "{without}"
    );
    let page = String::from_utf8(bytes(&folder, "out/measured/report.html")).unwrap();
    assert!(!page.contains("Predicted, this trial"));
    run(&folder, "verify out --study mine").succeeds();
    fs::write(folder.path().join("mine/next/campaign.toml"), whole).unwrap();
    run(&folder, "run mine --out out --quiet").succeeds();
    assert!(samples(&folder) > 22 * 70, "{}", samples(&folder));
    // What is there is up to date, and a changed log is not
    let again = run(&folder, "run mine --out out --quiet").succeeds();
    assert!(again.stdout.contains(": 0 of 8 stages run"), "{again}");
    let log = fs::read_dir(folder.path().join("logs")).unwrap().next().unwrap().unwrap().path();
    let text = fs::read_to_string(&log).unwrap();
    fs::write(&log, text.trim_end().rsplit_once('\n').unwrap().0).unwrap();
    let changed = run(&folder, INGEST).succeeds();
    assert!(changed.stdout.contains(": 1 of 1 stages run"), "{changed}");
}

#[test]
fn what_was_guessed_is_marked_on_its_line() {
    let folder = logged(5, "heading [deg]", "heading");
    run(&folder, NEW).succeeds();
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    for line in [
        "channel = \"psi\"  # guessed",
        "unit = \"deg\"  # guessed",
        "frame = \"ned\"  # guessed",
        "max_gap_s = 0.62  # guessed",
    ] {
        assert!(text.contains(line), "no `{line}` in\n{text}");
    }
    assert!(text.contains("unit = \"rpm\"\n") && text.contains("channel = \"alpha_2\""), "{text}");
}

#[test]
fn columns_of_parquet_are_recognised() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("logs")).unwrap();
    for name in ["a_thruster.parquet", "b_thruster.parquet"] {
        fs::copy(repository().join("fixtures/logs").join(name), folder.path().join("logs").join(name))
            .unwrap();
    }
    let ran = run(&folder, "new mine --vessel esso-osaka --logs logs").succeeds();
    assert!(ran.stdout.contains("2 logs"), "{ran}");
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    for piece in [
        "2 files in Parquet",
        "pattern = [\"*.parquet\"]",
        "# A row about every 0.25 s.\n[file.time]\ncolumn = \"t_ns\"\nunit = \"ns\"  # guessed",
        "column = \"rpm\"\nchannel = \"n\"",
    ] {
        assert!(text.contains(piece), "no `{piece}` in\n{text}");
    }
    put(&folder, "logs/b_thruster.parquet", "PAR1");
    refused(&folder, 3, "new other --vessel esso-osaka --logs logs", &["logs/b_thruster.parquet: "]);
}

#[test]
fn a_column_that_is_not_placed_is_listed_and_works_once_it_is_named() {
    let folder = logged(5, "thruster 1 [rpm]", "port [rpm]");
    let ran = run(&folder, NEW).succeeds();
    assert!(ran.stdout.contains("1 channels missing"), "{ran}");
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    assert!(text.contains("#   \"port [rpm]\"\n"), "{text}");
    run(&folder, INGEST).refuses(3, &["n_1"]);
    let template = "# [[file.channel]]\n# column = \"\"\n# channel = \"n_1\"\n# unit = \"1/s\"\n";
    let named = "[[file.channel]]\ncolumn = \"port [rpm]\"\nchannel = \"n_1\"\nunit = \"rpm\"\n";
    edit(&folder, "mine/ingest.toml", template, named);
    run(&folder, INGEST).succeeds();
}

#[test]
fn law_a_wrong_guess_works_once_it_is_corrected() {
    let right = logged(5, "heading", "heading");
    run(&right, NEW).succeeds();
    run(&right, INGEST).succeeds();
    // Degrees below a turn's 6.28, and no unit: they could be radians.
    let wrong = logged(5, "thruster 1 [deg]", "azimuth 1");
    run(&wrong, NEW).succeeds();
    run(&wrong, INGEST).succeeds();
    let summary = |folder: &TempDir| json(folder, "out/measured/ingest.json");
    let channels = |folder: &TempDir| summary(folder)["data"]["recordings"][0]["channels"].clone();
    assert_ne!(channels(&wrong), channels(&right), "the guess is wrong");
    edit(
        &wrong,
        "mine/ingest.toml",
        "unit = \"rad\"  # guessed: the column's name says none",
        "unit = \"deg\"",
    );
    run(&wrong, INGEST).succeeds();
    assert_eq!(channels(&wrong), channels(&right));
    assert!(channels(&right).as_array().unwrap().len() > 7);
    assert_eq!(samples(&wrong), samples(&right));
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn published_logs_come_to_their_page_by_two_commands() {
    let logs = repository().join("../shared/data/kvlcc2_hsva");
    if !logs.is_dir() {
        println!("skipped: there is no {}", logs.display());
        return;
    }
    let folder = tempfile::tempdir().unwrap();
    let ran = run(&folder, &format!("new mine --vessel kvlcc2 --logs {}", logs.display())).succeeds();
    assert!(ran.stdout.contains("13 logs") && ran.stdout.contains("0 channels missing"), "{ran}");
    run(&folder, "run mine --out out --quiet").succeeds();
    let page = String::from_utf8(bytes(&folder, "out/measured/report.html")).unwrap();
    assert!(page.contains("KVLCC2") && page.contains("<svg"));
    let document = json(&folder, "out/measured/ingest.json");
    assert_eq!(
        (document["data"]["runs"].as_u64(), document["data"]["samples"].as_u64()),
        (Some(13), Some(2120))
    );
}

/// The runs of `table.parquet` as logs in CSV, one file each, of the motion and of these `inputs`, by column and channel. Columns in
/// `rps` are those of propellers in rad/s.
fn logs_of_runs(folder: &TempDir, inputs: &[(&str, &str)]) {
    let table = craft::read(&folder.path().join("table.parquet"), "trajectories");
    let place = |name: &str| table.schema.columns.iter().position(|own| own.name == name).unwrap();
    let logged =
        [("t_s", "t"), ("x_m", "x"), ("y_m", "y"), ("psi_rad", "psi"), ("u_mps", "u"), ("v_mps", "v")];
    let logged = logged.into_iter().chain([("r_radps", "r")]).chain(inputs.iter().copied());
    let (names, places): (Vec<&str>, Vec<usize>) = logged.map(|(own, name)| (own, place(name))).unzip();
    fs::create_dir(folder.path().join("logs")).unwrap();
    for block in &table.blocks {
        let (maneuver, mut files) = (&block.columns[place("maneuver")], BTreeMap::<&str, String>::new());
        for row in 0..maneuver.len() {
            // The last state of a run has no inputs.
            let cells = places.iter().map(|&place| block.columns[place].value_at(row));
            let Some(cells) = cells.collect::<Option<Vec<f64>>>() else { continue };
            let cells = cells.into_iter().zip(&names).map(|(value, name)| match name.ends_with("_rps") {
                true => (value / TAU).to_string(),
                false => value.to_string(),
            });
            let line = cells.collect::<Vec<_>>().join(",");
            let text = files.entry(maneuver.text_at(row).unwrap());
            *text.or_insert_with(|| format!("{}\n", names.join(","))) += &format!("{line}\n");
        }
        for (name, text) in files {
            fs::write(folder.path().join(format!("logs/{name}.csv")), text).unwrap();
        }
    }
}

#[test]
fn logs_of_a_ship_with_forces_come_to_their_page_by_two_commands() {
    let folder = tempfile::tempdir().unwrap();
    run(&folder, "new otter --vessel otter").succeeds();
    let simulate = "simulate dictionary --vessel otter/vessel.toml --dictionary otter/dictionary.toml";
    run(&folder, &format!("{simulate} --out table.parquet")).succeeds();
    logs_of_runs(&folder, &[("n1_radps", "n1"), ("n2_rps", "n2")]);
    let ran = run(&folder, "new mine --vessel otter --logs logs").succeeds();
    assert!(ran.stdout.contains("8 logs") && ran.stdout.contains("0 channels missing"), "{ran}");
    let settings = String::from_utf8(bytes(&folder, "mine/study.toml")).unwrap();
    let short = settings.lines().filter(|line| !line.starts_with("fitted_window_s"));
    put(&folder, "mine/study.toml", &short.collect::<Vec<_>>().join("\n"));
    run(&folder, "run mine --out out --quiet --set study.estimate.window_s=10 --set study.test=[]")
        .succeeds();
    let model = json(&folder, "out/measured/model.json");
    assert_eq!(model["data"]["estimator"], "output-error");
    let page = String::from_utf8(bytes(&folder, "out/measured/report.html")).unwrap();
    assert!(page.contains("<svg") && page.contains("The delivered model"), "{page}");
    // The search cannot predict a stop that it never saw: it is named, and the forces are delivered.
    let searched = json(&folder, "out/measured/estimate.json")["data"]["search"].clone();
    assert_eq!(searched["beside"]["delivered"], "forces", "{}", searched["statements"]);
    let said = searched["statements"][1].as_str().unwrap();
    assert!(
        said.starts_with("the searched terms are left out of the average: ") && said.contains("behind"),
        "{said}"
    );
    assert!(page.contains("the searched terms are left out of the average"), "{page}");
    // What the fit knows counts for the next trial.
    let next = json(&folder, "out/measured/next/design.json")["data"].clone();
    let shares = next["prior"]["shares"].as_object().unwrap();
    assert!(shares.values().all(|own| (0.0..=1.0).contains(&own.as_f64().unwrap())), "{shares:?}");
    let forces = &model["data"]["forces"]["parameters"];
    for own in forces.as_array().unwrap() {
        let after = next["covariance"]["standard_errors"][own["name"].as_str().unwrap()].as_f64().unwrap();
        // Better known than by the logs alone.
        assert!(own["standard_error"].as_f64().is_none_or(|before| after < before), "{own} after {after}");
    }
    // Without a ship the twin propellers are found, too.
    let ran = run(&folder, "new unknown --logs logs").succeeds();
    let ingest = String::from_utf8(bytes(&folder, "unknown/ingest.toml")).unwrap();
    assert!(ran.stdout.contains("0 channels missing"), "{ran}{ingest}");
    let unknown = String::from_utf8(bytes(&folder, "unknown/vessel.toml")).unwrap();
    assert!(unknown.contains("role = \"port\""), "{unknown}");
    // The only model of an average stands for a vessel.
    assert!(model["data"]["members"].is_null());
    run(&folder, "export --model out/measured/model.json --to python --out alone/").succeeds();
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn five_logs_and_a_wind_without_direction_give_the_core_of_a_ship_without_forces() {
    let folder = tempfile::tempdir().unwrap();
    run(&folder, "new coaster --vessel coaster").succeeds();
    let simulate = "simulate dictionary --vessel coaster/vessel.toml --dictionary coaster/dictionary.toml";
    run(&folder, &format!("{simulate} --out table.parquet")).succeeds();
    logs_of_runs(&folder, &[("n", "n"), ("delta_rad", "delta")]);
    let mut logs: Vec<_> =
        fs::read_dir(folder.path().join("logs")).unwrap().map(|own| own.unwrap().path()).collect();
    logs.sort();
    logs.drain(5..).for_each(|path| fs::remove_file(path).unwrap());
    for path in logs {
        let text = fs::read_to_string(&path).unwrap();
        let mut lines = text.lines();
        let mut blown = format!("{},relative_wind_mps\n", lines.next().unwrap());
        for (i, line) in lines.enumerate() {
            blown += &format!("{line},{}\n", 3 + i % 2);
        }
        fs::write(&path, blown).unwrap();
    }
    let chart = repository().join("fixtures/charts/helsinki_land_gshhg.geojson").display().to_string();
    let new = format!("new mine --vessel coaster --logs logs --place 24.97,60.05 --chart {chart}");
    let ran = run(&folder, &new).succeeds();
    let said = "`wind` is not used: no direction of the wind was found";
    assert!(ran.stdout.contains("5 logs") && ran.stdout.contains(said), "{ran}");
    let ingest = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    assert!(ingest.contains("not used: no direction of the wind is logged"), "{ingest}");
    let ran = run(&folder, "run mine --out out --quiet --set study.estimate.bootstrap=2 --set study.estimate.folds=2 --set study.test=[]")
        .succeeds();
    let model = json(&folder, "out/measured/model.json")["data"].clone();
    assert_eq!(model["estimator"], "prediction-error");
    let terms = |d: usize| -> Vec<String> {
        let all = model["degrees"][d]["parameters"].as_array().unwrap();
        all.iter().map(|own| own["term"].as_str().unwrap().to_owned()).collect()
    };
    assert_eq!([terms(1), terms(2)].concat(), ["v", "u r", "r", "u^2 delta"]);
    assert_eq!(json(&folder, "out/measured/estimate.json")["data"]["structure"]["chosen"], "core");
    // What they taught counts for the next trial. The model of five logs cannot hold the plan's speeds: that is said.
    // Nothing is known of the ship but her logs, or else her main dimensions.
    let known = run(&folder, "new unknown --logs logs").succeeds();
    assert!(known.stdout.contains("0 channels missing") && !known.stdout.contains("next/"), "{known}");
    run(&folder, "run unknown --out unknown-out --quiet --stage ingest").succeeds();
    let guess = "--guess length_m=100,beam_m=16,draught_m=6,block=0.7";
    run(&folder, &format!("new dimensions {guess} --logs logs")).succeeds();
    let text = |name: &str| String::from_utf8(bytes(&folder, name)).unwrap();
    assert!(text("dimensions/vessel.toml").contains("[[rudder]]"));
    assert!(!text("dimensions/vessel.toml").contains("[value]"));
    assert!(
        text("dimensions/ingest.toml").contains("delta")
            && text("dimensions/next/dictionary.toml").contains("zig-zag")
    );
    // And a ship in a file of her own.
    run(&folder, "new again --vessel dimensions/vessel.toml --logs logs").succeeds();
    assert_eq!(text("again/vessel.toml"), text("dimensions/vessel.toml"));
    let next = json(&folder, "out/measured/next/design.json")["data"].clone();
    assert!(next["prior"]["shares"].is_object() && next["sequence"]["foretold"].is_object(), "{next}");
    assert!(ran.stdout.contains("without next-plan") && ran.stderr.contains("[[speed_mode]]"), "{ran}");
}

#[test]
fn columns_are_the_same_without_names_and_as_excel_and_pandas_write_them() {
    let folder = tempfile::tempdir().unwrap();
    run(&folder, "new coaster --vessel coaster").succeeds();
    let simulate = "simulate dictionary --vessel coaster/vessel.toml --dictionary coaster/dictionary.toml";
    run(&folder, &format!("{simulate} --out table.parquet")).succeeds();
    logs_of_runs(&folder, &[("n", "n"), ("delta_rad", "delta")]);
    let logs: Vec<_> =
        fs::read_dir(folder.path().join("logs")).unwrap().map(|own| own.unwrap().path()).collect();
    let whole: Vec<String> = logs.iter().map(|path| fs::read_to_string(path).unwrap()).collect();
    let rewrite = |of: &dyn Fn(&str) -> String| {
        logs.iter().zip(&whole).for_each(|(path, text)| fs::write(path, of(text)).unwrap());
    };
    let ingested = |name: &str, pieces: &[&str]| {
        run(&folder, &format!("new {name} --vessel coaster --logs logs")).succeeds();
        let text = String::from_utf8(bytes(&folder, &format!("{name}/ingest.toml"))).unwrap();
        pieces.iter().for_each(|piece| assert!(text.contains(piece), "no `{piece}` in\n{text}"));
        let named = text.contains("channel = \"n\"\n") && !text.contains("# channel = \"n\"");
        if named && !text.contains("# channel = \"delta\"") {
            run(&folder, &format!("run {name} --out out-{name} --quiet --stage ingest")).succeeds();
            let found =
                json(&folder, &format!("out-{name}/measured/ingest.json"))["data"]["samples"].as_u64();
            assert!(found.unwrap() > 1000, "{found:?}");
        }
    };
    ingested("plain", &["column = \"psi_rad\"\nchannel = \"psi\"", "column = \"t_s\"\n"]);
    let excel = |text: &str| {
        format!("\u{FEFF}sep=;\r\n{}", text.replace(',', ";").replace('.', ",").replace('\n', "\r\n"))
    };
    rewrite(&excel);
    ingested("excel", &["separator = \";\"", "decimal = \",\"", "skip_lines = 1", "channel = \"psi\""]);
    let pandas = |text: &str| {
        let number = |(row, line): (usize, &str)| match row {
            0 => format!(",{line}\n"),
            row => format!("{},{line}\n", row - 1),
        };
        text.lines().enumerate().map(number).collect::<String>()
    };
    rewrite(&pandas);
    ingested("pandas", &["column = \"psi_rad\"\nchannel = \"psi\"", "column = \"t_s\"\n", "#   \"\"\n"]);
    rewrite(&|text| text.split_once('\n').unwrap().1.to_owned());
    let motion = [
        "header = false\ncolumns = 9",
        "column = \"1\"\n",
        "column = \"4\"\nchannel = \"psi\"  # guessed: by motion",
    ];
    ingested("nameless", &[&motion[..], &["column = \"7\"\nchannel = \"y_r\""]].concat());
}

#[test]
fn logs_too_short_to_show_their_steps_give_times_above_zero() {
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("logs")).unwrap();
    let sentence = "$GPRMC,081758.00,A,6008.4253933,N,02456.3510317,E,3.0,90.0,010626,,,A*64\n";
    fs::write(folder.path().join("logs/a.nmea"), sentence).unwrap();
    for preset in ["coaster", "kvlcc2-l7"] {
        run(&folder, &format!("new {preset} --vessel {preset} --logs logs")).succeeds();
        for name in ["ingest.toml", "study.toml"] {
            let text = String::from_utf8(bytes(&folder, &format!("{preset}/{name}"))).unwrap();
            let zero = |line: &&str| {
                line.split([' ', '=']).any(|word| ["0", "0.0"].contains(&word)) && !line.starts_with('#')
            };
            assert_eq!(text.lines().find(zero), None, "{preset}/{name}");
        }
    }
}

#[test]
fn names_of_recordings_may_have_commas() {
    let folder = logged(2, "heading", "heading");
    let mut logs: Vec<_> =
        fs::read_dir(folder.path().join("logs")).unwrap().map(|own| own.unwrap().path()).collect();
    logs.sort();
    for (log, name) in logs.iter().zip(["zig,zag", "zig,zag, again", "zig"]) {
        fs::rename(log, log.with_file_name(format!("{name}.csv"))).unwrap();
    }
    run(&folder, NEW).succeeds();
    run(&folder, INGEST).succeeds();
    let pool = |flags: &[&str]| {
        let mut command = std::process::Command::new(SEATRIAL);
        let line = "estimate --structure own --vessel mine/vessel.toml --trajectories out/measured/trajectories.parquet --estimator ls --quiet --out estimates.parquet";
        let ended = command.args(line.split_whitespace()).args(flags).current_dir(&folder).output().unwrap();
        assert!(ended.status.success(), "{flags:?}: {}", String::from_utf8_lossy(&ended.stderr));
        let sources = json(&folder, "estimate.json")["data"]["trust"]["runs"].as_array().unwrap().clone();
        sources.iter().map(|own| own["source"].as_str().unwrap().to_owned()).collect::<Vec<_>>()
    };
    assert_eq!(pool(&["--runs", "zig,zag, again"]), ["zig,zag, again"]);
    assert_eq!(pool(&["--runs", "zig,zag", "--runs", "zig,zag, again"]), ["zig,zag", "zig,zag, again"]);
    let left = pool(&["--leave-out", "zig,zag,zig"]);
    assert!(left.len() == logs.len() - 2 && !left.contains(&"zig".to_owned()), "{left:?}");
}

#[test]
fn nothing_of_a_battery_is_taken_for_the_rudder() {
    let log = repository().join("../shared/cases-2/136-new-battery-as-rudder/a.ulg");
    let Ok(log) = fs::read(&log) else {
        println!("skipped: there is no {}", log.display());
        return;
    };
    let folder = tempfile::tempdir().unwrap();
    fs::create_dir(folder.path().join("logs")).unwrap();
    fs::write(folder.path().join("logs/a.ulg"), log).unwrap();
    let ran = run(&folder, "new mine --vessel mariner --logs logs").succeeds();
    assert!(ran.stdout.contains("1 channels missing"), "{ran}");
    let text = String::from_utf8(bytes(&folder, "mine/ingest.toml")).unwrap();
    assert!(text.contains("#    { column = \"\", channel = \"delta\"") && !text.contains("cell"), "{text}");
}
