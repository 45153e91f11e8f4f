//! Models for other tools: exported code computes the same as `simulate`, and models for which it would not are
//! refused.

use std::fs;
use std::io::{Read, Write};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};

use approx::assert_abs_diff_eq;
use ship::engine::simulate_one;
use ship::model::{Source, Vessel};
use tempfile::TempDir;

use crate::support::*;

/// A ship with a propeller, a rudder and measured wind, and names that are no identifiers.
const SHIP: &str = include_str!("exported.toml");

/// How many samples make 1,000 s.
const SAMPLES: usize = 20_000;

const INITIAL: [f64; 3] = [3.0, 0.1, -0.002];

/// A folder with the ship and its inputs.
struct Ground {
    folder: TempDir,
    vessel: Vessel,
    inputs: Vec<f64>,
}

impl Ground {
    fn new() -> Self {
        let folder = tempfile::tempdir().unwrap();
        put(&folder, "vessel.toml", SHIP);
        let vessel = Vessel::from_file(toml::from_str(SHIP).unwrap()).unwrap();
        // Propeller ahead and astern, rudder and wind to both sides.
        let row = |k: usize| {
            let t = k as f64 / 20.0;
            [1.5 + 2.5 * (0.011 * t).sin(), 0.5 * (0.05 * t).sin(), 6.0 * (0.2 * t).sin() - 1.0]
        };
        let inputs: Vec<f64> = (0..SAMPLES).flat_map(row).collect();
        let rows = inputs.chunks(3).map(|row| format!("{:?},{:?},{:?}\n", row[0], row[1], row[2]));
        put(&folder, "inputs.csv", &("n,delta,wind_x\n".to_owned() + &rows.collect::<String>()));
        Self { folder, vessel, inputs }
    }

    /// Exports to `target` and says where.
    fn exported(&self, target: &str) -> PathBuf {
        run(&self.folder, &format!("export --vessel vessel.toml --to {target} --out {target}")).succeeds();
        self.folder.path().join(target)
    }

    fn simulated(&self) -> Vec<f64> {
        let parameters = self.vessel.parameters(Source::Value).unwrap();
        simulate_one(&self.vessel.model, &parameters, INITIAL, &self.inputs)
    }

    /// Runs `program` in `folder` with the inputs on stdin; returns its stdout.
    fn driven(&self, program: &str, arguments: &[&str], folder: &Path) -> String {
        let inputs = fs::File::open(self.folder.path().join("inputs.csv")).unwrap();
        let states = INITIAL.map(|state| format!("{state:?}"));
        let mut command = Command::new(program);
        command.args(arguments).args(states).current_dir(folder).stdin(inputs);
        let output = command.output().unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        String::from_utf8(output.stdout).unwrap()
    }
}

/// States, of which `simulate` says those of every `every`-th sample, in rows that end with u, v, r.
#[track_caller]
fn assert_simulated<'a>(rows: impl Iterator<Item = &'a str>, expected: &[f64], every: usize) {
    let expected: Vec<&[f64]> = expected.chunks(3).step_by(every).collect();
    let rows: Vec<&str> = rows.collect();
    assert_eq!(rows.len(), expected.len());
    let mut moved = false;
    for (row, expected) in rows.iter().zip(expected) {
        let found: Vec<f64> = row.rsplit(',').take(3).map(|cell| cell.trim().parse().unwrap()).collect();
        for (d, state) in expected.iter().enumerate() {
            assert_abs_diff_eq!(found[2 - d], *state, epsilon = 1e-9);
        }
        moved |= expected[0] < 0.0 && expected[2].abs() > 1e-3;
    }
    assert!(moved, "the ship never went astern");
}

/// Whether `program` runs with `arguments`; where not, `what` is skipped.
fn there(program: &str, arguments: &[&str], what: &str) -> bool {
    let mut command = Command::new(program);
    command.args(arguments).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let there = command.status().is_ok_and(|status| status.success());
    if !there {
        println!("skipped: {what}: `{program} {}` does not run here", arguments.join(" "));
    }
    there
}

fn compiled(folder: &Path, arguments: &[&str]) {
    let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2", "-ffp-contract=off"];
    let output = Command::new("cc").args(strict).args(arguments).current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
}

#[test]
fn law_python_steps_as_simulate_does() {
    if !there("python3", &["-c", "pass"], "the model in Python") {
        return;
    }
    let ground = Ground::new();
    let folder = ground.exported("python");
    let said = ground.driven("python3", &["-W", "error", "test_ship_2.py"], &folder);
    assert_simulated(said.lines().skip(1), &ground.simulated(), 1);
}

#[test]
fn law_c_steps_as_simulate_does() {
    if !there("cc", &["--version"], "the model in C") {
        return;
    }
    let ground = Ground::new();
    let folder = ground.exported("c");
    compiled(&folder, &["test_ship_2.c", "test_ship_2_example.c", "-o", "ship", "-lm"]);
    let said = ground.driven("./ship", &[], &folder);
    assert_simulated(said.lines().skip(1), &ground.simulated(), 1);
}

#[test]
fn law_octave_steps_as_simulate_does() {
    let octave = std::env::var("SEATRIAL_OCTAVE").unwrap_or("octave-cli".to_owned());
    if !there(&octave, &["--version"], "the model in MATLAB's language") {
        return;
    }
    let ground = Ground::new();
    let folder = ground.exported("matlab");
    let script = "model = test_ship_2(); rows = dlmread('../inputs.csv', ',', 1, 0); \
        x = model.simulate(rows, [3.0, 0.1, -0.002], model.parameters); \
        assert(model.within_ranges(x(1, :), rows(1, :))); printf('%.17g,%.17g,%.17g\\n', x');";
    let mut command = Command::new(octave);
    command.args(["--no-gui", "--norc", "--quiet", "--eval", script]).current_dir(&folder);
    let output = command.output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let said = String::from_utf8(output.stdout).unwrap();
    assert_simulated(said.lines(), &ground.simulated(), 1);
}

/// The files of a unit.
fn unpacked(unit: &Path) -> Vec<(String, Vec<u8>)> {
    let mut archive = zip::ZipArchive::new(fs::File::open(unit).unwrap()).unwrap();
    let all = (0..archive.len()).map(|place| {
        let mut file = archive.by_index(place).unwrap();
        let mut bytes = Vec::new();
        file.read_to_end(&mut bytes).unwrap();
        (file.name().to_owned(), bytes)
    });
    all.collect()
}

#[test]
fn law_the_unit_steps_as_simulate_does_and_takes_no_other_step() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) || !there("cc", &["--version"], "the unit") {
        return;
    }
    let ground = Ground::new();
    let files = unpacked(&ground.exported("fmu").join("test_ship_2.fmu"));
    let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
    let sources = ["sources/test_ship_2_fmi2.c", "sources/test_ship_2.c", "sources/test_ship_2.h"];
    assert_eq!(names[..2], ["modelDescription.xml", "binaries/linux64/test_ship_2.so"]);
    assert_eq!(names[2..], sources);
    let folder = ground.folder.path();
    fs::write(folder.join("unit.so"), &files[1].1).unwrap();
    let description = String::from_utf8(files[0].1.clone()).unwrap();
    let guid = description.split("guid=\"").nth(1).unwrap().split('"').next().unwrap();
    // Its sources compile without a word, its host with what POSIX has.
    files[2..]
        .iter()
        .for_each(|(name, bytes)| fs::write(folder.join(name.replace('/', "_")), bytes).unwrap());
    fs::rename(folder.join("sources_test_ship_2.h"), folder.join("test_ship_2.h")).unwrap();
    compiled(folder, &["-c", "sources_test_ship_2_fmi2.c", "-o", "unit.o"]);
    put(&ground.folder, "host.c", include_str!("unit_host.c"));
    let host = Command::new("cc").args(["-O1", "host.c", "-o", "host", "-ldl"]).current_dir(folder).status();
    assert!(host.unwrap().success());
    let simulated = ground.simulated();
    // Inputs that are held for several steps apply to each.
    let held: Vec<f64> = ground.inputs.chunks(3).step_by(4).flat_map(|row| row.repeat(4)).collect();
    let parameters = ground.vessel.parameters(Source::Value).unwrap();
    let slower = simulate_one(&ground.vessel.model, &parameters, INITIAL, &held);
    for (every, expected) in [(1, &simulated), (4, &slower)] {
        let mut command = Command::new("./host");
        command.args(["./unit.so", guid, "3", "0.05", &every.to_string(), "3.0", "0.1", "-0.002", "14"]);
        command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped()).current_dir(folder);
        let rows = ground.inputs.chunks(3).step_by(every);
        let rows: String = rows.map(|row| format!("{:?},{:?},{:?}\n", row[0], row[1], row[2])).collect();
        let mut child = command.spawn().unwrap();
        let mut stdin = child.stdin.take().unwrap();
        let writer = std::thread::spawn(move || stdin.write_all(rows.as_bytes()));
        let output = child.wait_with_output().unwrap();
        writer.join().unwrap().unwrap();
        let told = String::from_utf8(output.stderr).unwrap();
        assert!(output.status.success(), "{:?} {told}", output.status.code());
        assert_simulated(String::from_utf8(output.stdout).unwrap().lines(), expected, every);
        for piece in ["another than this unit's", "half: 3", "more: 3", "within: 1"] {
            assert!(told.contains(piece), "{piece}: {told}");
        }
        let refused = "ship 3 logStatusError: communication step: found 0.025000000000000001 s, expected a whole number";
        assert!(told.contains(refused), "{told}");
    }
}

/// How many steps a unit of a ship with forces is compared over.
const STEPS: usize = 100;

#[test]
fn law_the_unit_of_a_ship_with_forces_steps_as_simulate_does() {
    if !cfg!(all(target_os = "linux", target_arch = "x86_64")) || !there("cc", &["--version"], "the unit") {
        return;
    }
    // A unit's inputs follow its three states, then come its parameters: the host sets none of them.
    for (preset, base, inputs) in
        [("mariner", "mariner", 1), ("kvlcc2-l7", "kvlcc2_l7", 2), ("otter", "otter", 2)]
    {
        let folder = tempfile::tempdir().unwrap();
        put(&folder, "vessel.toml", &format!("preset = \"{preset}\"\nsample_rate_hz = 10.0\n"));
        run(&folder, "export --vessel vessel.toml --to fmu --out fmu").succeeds();
        let files = unpacked(&folder.path().join(format!("fmu/{base}.fmu")));
        let description = String::from_utf8(files[0].1.clone()).unwrap();
        let guid = description.split("guid=\"").nth(1).unwrap().split('"').next().unwrap();
        fs::write(folder.path().join("unit.so"), &files[1].1).unwrap();
        put(&folder, "host.c", include_str!("unit_host.c"));
        let compile = ["-O1", "host.c", "-o", "host", "-ldl"];
        assert!(Command::new("cc").args(compile).current_dir(&folder).status().unwrap().success());
        let vessel = Vessel::from_file(
            fs::read_to_string(folder.path().join("vessel.toml")).unwrap().parse().unwrap(),
        );
        let vessel = vessel.unwrap();
        let row = |k: usize| (0..inputs).map(move |i| [0.3, 9.0][i] * (0.05 * k as f64 + i as f64).cos());
        let rows: Vec<f64> = (0..STEPS).flat_map(row).map(f64::abs).collect();
        let initial = [1.5, 0.05, -0.01];
        let expected = simulate_one(&vessel.model, &vessel.nominal, initial, &rows);
        let text: String = rows
            .chunks(inputs)
            .map(|row| row.iter().map(f64::to_string).collect::<Vec<_>>().join(",") + "\n")
            .collect();
        put(&folder, "rows.csv", &text);
        let parameters = description.matches("causality=\"parameter\" variability=\"tunable\"").count();
        let output = Command::new("./host")
            .args([
                "./unit.so",
                guid,
                &inputs.to_string(),
                "0.1",
                "1",
                "1.5",
                "0.05",
                "-0.01",
                &parameters.to_string(),
            ])
            .stdin(fs::File::open(folder.path().join("rows.csv")).unwrap())
            .current_dir(&folder)
            .output()
            .unwrap();
        assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
        let said = String::from_utf8(output.stdout).unwrap();
        assert_eq!(said.lines().count(), STEPS + 1, "{said}");
        for (line, expected) in said.lines().zip(expected.chunks(3)) {
            let found: Vec<f64> = line.split(',').map(|cell| cell.trim().parse().unwrap()).collect();
            (0..3)
                .for_each(|d| assert_abs_diff_eq!(found[found.len() - 3 + d], expected[d], epsilon = 1e-12));
        }
    }
}

#[test]
fn law_fmpy_runs_the_unit_as_simulate_does() {
    let python = std::env::var("SEATRIAL_FMPY").unwrap_or("python3".to_owned());
    if !there(
        &python,
        &["-c", "import fmpy"],
        "the unit in FMPy (scripts/requirements-fmpy.txt, SEATRIAL_FMPY)",
    ) || !there("cc", &["--version"], "the unit in FMPy")
    {
        return;
    }
    let ground = Ground::new();
    ground.exported("fmu");
    put(&ground.folder, "unit.py", include_str!("unit.py"));
    let mut command = Command::new(python);
    command.args([
        "unit.py",
        "fmu/test_ship_2.fmu",
        "inputs.csv",
        "states.csv",
        "3.0",
        "0.1",
        "-0.002",
        "0.05",
    ]);
    let output = command.current_dir(&ground.folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    let states = String::from_utf8(bytes(&ground.folder, "states.csv")).unwrap();
    assert_simulated(states.lines(), &ground.simulated(), 1);
}

#[test]
fn a_unit_is_the_same_twice_and_has_its_source_alone_where_there_is_no_compiler() {
    let ground = Ground::new();
    let line = "export --vessel vessel.toml --to fmu --json --out";
    let by = |compiler: &str, line: &str| run_with(&ground.folder, line, ("CC", compiler));
    let ran = by("no-such-compiler", &format!("{line} one")).succeeds();
    let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    assert_eq!((&said["built"], &said["files"][0]), (&false.into(), &"test_ship_2.fmu".into()));
    let told = by("no-such-compiler", &line.replace("--json --out", "--out two")).succeeds();
    assert!(told.stdout.contains("its source alone: found no C compiler `no-such-compiler`"), "{told}");
    assert_eq!(bytes(&ground.folder, "one/test_ship_2.fmu"), bytes(&ground.folder, "two/test_ship_2.fmu"));
    assert_eq!(unpacked(&ground.folder.path().join("one/test_ship_2.fmu")).len(), 4);
}

#[test]
fn names_that_are_no_identifiers_are_told() {
    let ground = Ground::new();
    let ran = run(&ground.folder, "export --vessel vessel.toml --to c --json --out c").succeeds();
    let said: serde_json::Value = serde_json::from_str(&ran.stdout).unwrap();
    let expected = serde_json::json!({"delta": "δ", "X_u_u": "X_u|u|", "X_u_u_2": "X_u|u", "for_2": "for"});
    assert_eq!(said["renamed"], expected, "{ran}");
    let header = String::from_utf8(bytes(&ground.folder, "c/test_ship_2.h")).unwrap();
    for line in
        ["δ is called delta here.", "Y_nd is -0.25 times Y_d", "#define TEST_SHIP_2_SAMPLE_RATE_HZ 20.0"]
    {
        assert!(header.contains(line), "{line}");
    }
    let told = run(&ground.folder, "export --vessel vessel.toml --to c --out c").succeeds();
    assert!(
        told.stdout.contains("X_u|u is called X_u_u_2; δ is called delta; for is called for_2"),
        "{told}"
    );
}

#[test]
fn an_estimated_model_brings_its_errors_and_its_range() {
    let folder = with(&["campaign.parquet"]);
    let pool = "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --runs random/1,random/2";
    run(&folder, &format!("{pool} --estimator ls --out estimates.parquet")).succeeds();
    run(&folder, "export --model model.json --to python --out python").succeeds();
    let model = json(&folder, "model.json")["data"].clone();
    let text = String::from_utf8(bytes(&folder, "python/ljungberg_model_ship.py")).unwrap();
    let parameter = &model["degrees"][0]["parameters"][0];
    let number = |value: &serde_json::Value| format!("{:?}", value.as_f64().unwrap());
    let name = parameter["name"].as_str().unwrap();
    assert!(text.contains(&format!("    \"{name}\": {},  # [m/s per (m/s)]", number(&parameter["value"]))));
    assert!(text.contains(&format!("    \"{name}\": {},\n", number(&parameter["standard_error"]))));
    let covered = model["covered"].as_array().unwrap();
    assert!(covered.len() >= 6);
    for own in covered {
        let [low, high] = ["low", "high"].map(|end| number(&own[end]));
        assert!(text.contains(&format!("    {}: ({low}, {high}),\n", own["name"])), "{own}");
    }
    if there("python3", &["-c", "pass"], "the range of validity in Python") {
        let high = covered[0]["high"].as_f64().unwrap();
        let script = format!(
            "import ljungberg_model_ship as m; middle = [sum(m.RANGES[n]) / 2 for n in m.STATES + m.INPUTS]; \
             assert m.within_ranges(middle[:3], middle[3:]); \
             assert m.outside([{high:?} + 0.1, *middle[1:3]], middle[3:]) == ['u']"
        );
        let folder = folder.path().join("python");
        let status = Command::new("python3").args(["-c", &script]).current_dir(folder).status();
        assert!(status.unwrap().success());
    }
}

/// Runs `program` with `words` in `folder` and `table` on its stdin.
fn fed(folder: &Path, program: &str, words: &[&str], table: &str) -> std::process::Output {
    let mut command = Command::new(program);
    command.args(words).args(["1.179", "0", "0"]).current_dir(folder);
    command.stdin(Stdio::piped()).stdout(Stdio::piped()).stderr(Stdio::piped());
    let mut child = command.spawn().unwrap();
    child.stdin.take().unwrap().write_all(table.as_bytes()).unwrap();
    child.wait_with_output().unwrap()
}

#[test]
fn tables_of_another_step_are_refused_by_exported_programs_and_marks_of_the_byte_order_are_skipped() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "vessel.toml", "preset = \"kvlcc2-l7\"\n");
    for target in ["c", "python"] {
        run(&folder, &format!("export --vessel vessel.toml --to {target} --out {target}")).succeeds();
    }
    let (c, python) = (folder.path().join("c"), folder.path().join("python"));
    let mut programs = Vec::new();
    if there("cc", &["--version"], "tables of the program in C") {
        compiled(&c, &["kvlcc2_l7.c", "kvlcc2_l7_example.c", "-o", "ship", "-lm"]);
        programs.push((&c, "./ship", &[][..]));
    }
    if there("python3", &["-c", "pass"], "tables of the module in Python") {
        programs.push((&python, "python3", &["kvlcc2_l7.py"][..]));
    }
    for (folder, program, words) in programs {
        let slow = fed(folder, program, words, "t,delta,n\n0,0.1,11.85\n1,0.1,11.85\n2,0.1,11.85\n");
        let said = String::from_utf8_lossy(&slow.stderr).into_owned();
        assert!(!slow.status.success() && slow.stdout.is_empty(), "{program}: {said}");
        for piece in ["row 2: found t = 1 s, expected 0.1 s", "--rate"] {
            assert!(said.contains(piece), "{program}: {said}");
        }
        let other = fed(folder, program, words, "time,delta,n\n0,0.1,11.85\n");
        assert!(String::from_utf8_lossy(&other.stderr).contains("column time"), "{program}");
        let plain = fed(folder, program, words, "delta,n\n0.1,11.85\n0.1,11.85\n");
        let marked = fed(folder, program, words, "\u{feff}delta,n\r\n0.1,11.85\r\n0.1,11.85\r\n");
        let timed = fed(folder, program, words, "\u{feff}t,delta,n\n5,0.1,11.85\n5.1,0.1,11.85\n");
        assert_eq!(String::from_utf8_lossy(&plain.stdout).lines().count(), 4, "{program}");
        assert!(marked.stdout == plain.stdout && timed.stdout == plain.stdout, "{program}");
    }
}

#[test]
fn inputs_beyond_the_ranges_of_the_vessel_are_outside() {
    let folder = tempfile::tempdir().unwrap();
    put(&folder, "vessel.toml", "preset = \"kvlcc2-l7\"\n");
    for target in ["c", "python", "matlab"] {
        run(&folder, &format!("export --vessel vessel.toml --to {target} --out {target}")).succeeds();
    }
    let [low, high] = Vessel::preset("kvlcc2-l7").unwrap().actuators[0].range.unwrap();
    let matlab = String::from_utf8(bytes(&folder, "matlab/kvlcc2_l7.m")).unwrap();
    assert!(matlab.contains(&format!("[{low:?}, {high:?}]")), "{matlab}");
    assert!(String::from_utf8(bytes(&folder, "c/kvlcc2_l7.h")).unwrap().contains("KVLCC2_L7_RANGES 2"));
    if there("python3", &["-c", "pass"], "ranges of inputs in Python") {
        let script = "import kvlcc2_l7 as s; x = (1.179, 0, 0); assert s.outside(x, [35.0, 711.0]) == ['delta', 'n']; \
                      assert s.within_ranges(x, [0.1, 11.85])";
        let ran =
            Command::new("python3").args(["-c", script]).current_dir(folder.path().join("python")).status();
        assert!(ran.unwrap().success());
    }
}

#[test]
fn what_cannot_be_exported_is_refused() {
    let ground = Ground::new();
    let folder = &ground.folder;
    let line = "export --vessel vessel.toml --to python --out python";
    refused(folder, 2, &line.replace("python", "fortran"), &["fortran", "python, c, matlab, fmu"]);
    refused(folder, 2, &format!("{line} --rate-hz 0"), &["--rate", "above 0"]);
    let rate = ["vessel.toml: sampling rate: found 30 Hz wanted, expected a whole multiple or part", "20 Hz"];
    refused(folder, 3, &format!("{line} --rate 30"), &rate);
    let range = ["vessel.toml: input `n`: found no `range`", "own rate"];
    refused(folder, 3, &format!("{line} --rate 40"), &range);
    run(folder, &format!("{line} --rate-hz 20")).succeeds();
    let other =
        ["c: folder: found `notes.txt` in it, expected none but test_ship_2.c, test_ship_2.h", "--out"];
    fs::create_dir(folder.path().join("c")).unwrap();
    put(folder, "c/notes.txt", "mine");
    refused(folder, 3, "export --vessel vessel.toml --to c --out c", &other);
    refused(
        folder,
        3,
        "export --vessel vessel.toml --to c --out python",
        &["python: folder", "`test_ship_2.py`"],
    );
    run(folder, "export --vessel vessel.toml --to c --out vessel.toml").refuses(1, &["vessel.toml"]);
    run(folder, "export --vessel vessel.toml --to c --out none/c").refuses(1, &["none/c"]);
    edit(folder, "vessel.toml", "value = -0.01\nnominal = -0.01\n", "nominal = -0.01\n");
    let line = "export --vessel vessel.toml --to python --out new";
    refused(folder, 3, &format!("{line} --parameters value"), &["parameter `Y_v`", "no `value`"]);
    run(folder, line).succeeds();
    let text = String::from_utf8(bytes(folder, "new/test_ship_2.py")).unwrap();
    assert!(text.contains("nominal") && text.contains("\"X_u_u_2\": 0.001,"));
}

#[test]
fn a_model_without_estimates_is_refused() {
    let folder = with(&["campaign.parquet", "estimates.parquet", "estimate.json"]);
    refused(&folder, 3, "export --model estimate.json --to c --out c", &["estimate.json: schema", "model"]);
    let pool =
        "estimate --structure own --vessel vessel.toml --trajectories campaign.parquet --runs random/1";
    run(&folder, &format!("{pool} --estimator ls --out pooled.parquet")).succeeds();
    let name = "pooled-model.json";
    let mut model = json(&folder, name);
    model["seal"] = serde_json::Value::Null;
    model["data"]["degrees"][1]["parameters"] = serde_json::json!([]);
    put(&folder, name, &model.to_string());
    refused(&folder, 3, &format!("export --model {name} --to c --out c"), &[name, "[[sway]]", "no term"]);
}

#[cfg(all(target_os = "linux", target_arch = "x86_64"))]
#[test]
fn a_compiler_that_compiles_nothing_is_told() {
    let ground = Ground::new();
    let line = "export --vessel vessel.toml --to fmu --out fmu";
    run_with(&ground.folder, line, ("CC", "false")).refuses(1, &["false", "does not compile"]);
    assert!(!ground.folder.path().join("fmu").exists());
}
