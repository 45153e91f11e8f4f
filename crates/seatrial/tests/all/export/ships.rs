//! Ships with forces, and terms at other rates: the generated code steps as the engine does, and has no components that the ship
//! has not.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::{Command, Stdio};

use seatrial::export::{Knowledge, Origin, Portable, Target};
use ship::engine::simulate_one;
use ship::model::{Source, Vessel};
use tempfile::TempDir;

const SHIPS: [(&str, &str); 4] = [
    ("mariner", include_str!("../../../../ship/presets/mariner.toml")),
    ("kvlcc2_l7", include_str!("../../../../ship/presets/kvlcc2-l7.toml")),
    ("otter", include_str!("../../../../ship/presets/otter.toml")),
    ("craft", include_str!("craft.toml")),
];

/// A ship of terms, with what its code has to hold apart: a constant, tied and known terms, a measured disturbance.
const TERMS: &str = "name = \"terms\"\nsample_rate_hz = 8.0\nconstant = [1e-3, 0.0, 0.0]\n\
    input = [{ name = \"n\", unit = \"1\", range = [-1.0, 1.0] }, { name = \"δ\", unit = \"rad\", range = [-0.5, 0.5] }]\n\
    measured = [{ name = \"w\", unit = \"m/s\" }]\n\
    surge = [{ parameter = \"X\", term = \"u |u|\", nominal = -0.02 }, { parameter = \"T\", term = \"n\", nominal = 0.02 }]\n\
    sway = [{ parameter = \"Y\", term = \"v\", nominal = -0.1 }, { parameter = \"Y_w\", term = \"w |w|\", nominal = 1e-5 },\n\
    { parameter = \"Y_r\", term = \"u r\", nominal = -0.1, fixed = true }]\n\
    yaw = [{ parameter = \"N\", term = \"r\", nominal = -0.15 }, { parameter = \"N_d\", term = \"u δ\", nominal = -0.04 },\n\
    { parameter = \"N_v\", term = \"|u| v\", tied_to = \"N_d\", factor = 0.2 }]\n";

/// Rates of the ship of terms: her own, a part of her step, her step repeated.
const RATES_HZ: [f64; 3] = [8.0, 80.0, 2.0];

/// All ships with the names of their modules.
fn vessels() -> Vec<(&'static str, Vessel)> {
    let forces = SHIPS.into_iter().map(|(name, text)| (name, vessel(text)));
    let terms = RATES_HZ.into_iter().map(|rate_hz| ("terms", vessel(TERMS).at_rate(rate_hz).unwrap()));
    forces.chain(terms).collect()
}

/// Largest difference, in largest values of the same state.
const TOLERANCE: f64 = 1e-12;

fn vessel(text: &str) -> Vessel {
    Vessel::from_file(text.parse().unwrap()).unwrap()
}

fn portable(vessel: &Vessel) -> Portable {
    Portable::new(vessel, Source::Nominal, &Knowledge::default(), Origin::default()).unwrap()
}

/// Numbers from −1 to 1, the same every time.
fn spread(i: usize, k: usize) -> f64 {
    let turn = ((i + 1) as f64 * ((k * k + 3 * k + 2) as f64 + 0.5).sqrt()).fract();
    2.0 * turn - 1.0
}

/// Inputs and measured disturbances within their ranges.
fn row(vessel: &Vessel, i: usize) -> Vec<f64> {
    let count = vessel.model.exogenous() - vessel.model.derived.len();
    let one = |k: usize| {
        let [low, high] = vessel.actuators.get(k).and_then(|own| own.range).unwrap_or([-30.0, 30.0]);
        low + (high - low) * 0.5 * (1.0 + spread(i, 3 + k))
    };
    (0..count).map(one).collect()
}

/// A row with the channels that are computed from it.
fn completed(vessel: &Vessel, row: &[f64]) -> Vec<f64> {
    let mut all = row.to_vec();
    for own in &vessel.model.derived {
        all.push(own.value(&all));
    }
    all
}

/// States that follow the engine's from single states and in one run.
struct Truth {
    /// State and inputs of each case.
    cases: Vec<Vec<f64>>,
    /// The states after them.
    next: Vec<[f64; 3]>,
    /// The run's inputs, and its states.
    inputs: Vec<Vec<f64>>,
    states: Vec<[f64; 3]>,
}

fn truth(vessel: &Vessel) -> Truth {
    let ship = vessel.model.forces.as_ref().map(|own| &own.forces.description().ship);
    let (speed, length) = ship.map_or((1.0, 2.0), |own| (own.speed_m_s, own.length_m));
    let speeds = [1.2 * speed, 0.5 * speed, speed / length];
    let simulated = |initial: [f64; 3], rows: &[Vec<f64>]| {
        let all: Vec<f64> = rows.iter().flat_map(|row| completed(vessel, row)).collect();
        let states = simulate_one(&vessel.model, &vessel.nominal, initial, &all);
        states.as_chunks::<3>().0.to_vec()
    };
    let (mut cases, mut next) = (Vec::new(), Vec::new());
    for i in 0..200 {
        let (state, row) = ([0, 1, 2].map(|d: usize| speeds[d] * spread(i, d)), row(vessel, i));
        next.push(simulated(state, std::slice::from_ref(&row))[1]);
        cases.push([&state[..], &row].concat());
    }
    // Each setting for a quarter of the run.
    let inputs: Vec<Vec<f64>> = (0..100).map(|k| row(vessel, k / 25)).collect();
    let states = simulated([speed, 0.0, 0.0], &inputs);
    Truth { cases, next, inputs, states }
}

fn numbers(rows: &[Vec<f64>]) -> String {
    let mut text = String::new();
    for row in rows {
        let cells: Vec<String> = row.iter().map(|own| format!("{own:?}")).collect();
        writeln!(text, "{}", cells.join(" ")).unwrap();
    }
    text
}

#[track_caller]
fn agree(what: &str, found: &[[f64; 3]], expected: &[[f64; 3]]) {
    assert_eq!(found.len(), expected.len(), "{what}");
    let largest = [0, 1, 2].map(|d: usize| expected.iter().fold(0.0_f64, |most, own| most.max(own[d].abs())));
    for (found, expected) in found.iter().zip(expected) {
        for d in 0..3 {
            let off = (found[d] - expected[d]).abs();
            assert!(off <= TOLERANCE * largest[d], "{what}: {found:?} {expected:?} {off}");
        }
    }
}

/// Whether `program` runs here.
fn there(program: &str, argument: &str) -> bool {
    let mut command = Command::new(program);
    command.arg(argument).stdin(Stdio::null()).stdout(Stdio::null()).stderr(Stdio::null());
    let there = command.status().is_ok_and(|status| status.success());
    if !there {
        println!("skipped: `{program}` does not run here");
    }
    there
}

/// The files of a ship in a folder, with its cases and run as text.
fn exported(portable: &Portable, target: Target, truth: &Truth) -> TempDir {
    let folder = TempDir::new().unwrap();
    let names = portable.file_names(target);
    for (name, bytes) in names.iter().zip(portable.files(target, None).unwrap()) {
        fs::write(folder.path().join(name), bytes).unwrap();
    }
    fs::write(folder.path().join("cases.txt"), numbers(&truth.cases)).unwrap();
    fs::write(folder.path().join("inputs.txt"), numbers(&truth.inputs)).unwrap();
    folder
}

fn done(command: &mut Command, folder: &Path) -> String {
    let output = command.current_dir(folder).output().unwrap();
    assert!(output.status.success(), "{}", String::from_utf8_lossy(&output.stderr));
    String::from_utf8(output.stdout).unwrap()
}

/// Compares what a program says: the states after the cases, then those of the run.
fn compare(name: &str, said: &str, truth: &Truth) {
    let state = |line: &str| {
        let all: Vec<f64> = line.split_whitespace().map(|cell| cell.parse().unwrap()).collect();
        [all[0], all[1], all[2]]
    };
    let all: Vec<[f64; 3]> = said.lines().map(state).collect();
    let (next, states) = all.split_at(truth.cases.len());
    agree(name, next, &truth.next);
    agree(name, states, &truth.states);
}

const PYTHON: &str = "import importlib, sys\n\
    ship = importlib.import_module(sys.argv[1])\n\
    rows = lambda name: [[float(cell) for cell in line.split()] for line in open(name)]\n\
    found = [ship.step(row[:3], row[3:]) for row in rows('cases.txt')]\n\
    found += ship.simulate(rows('inputs.txt'), (float(sys.argv[2]), 0.0, 0.0))\n\
    print('\\n'.join(' '.join(map(repr, state)) for state in found))\n";

#[test]
fn law_python_steps_as_the_engine_does() {
    if !there("python3", "--version") {
        return;
    }
    for (name, vessel) in vessels() {
        let (truth, portable) = (truth(&vessel), portable(&vessel));
        let folder = exported(&portable, Target::Python, &truth);
        let speed = format!("{:?}", truth.states[0][0]);
        let mut command = Command::new("python3");
        command.args(["-W", "error", "-c", PYTHON, name, &speed]);
        compare(name, &done(&mut command, folder.path()), &truth);
    }
}

const C: &str = r#"
#include "SHIP.h"
#include <stdio.h>
#include <stdlib.h>
static double rows[512 * 64];
static size_t read_rows(const char *name, size_t width)
{
    FILE *file = fopen(name, "r");
    size_t count = 0;
    while (fscanf(file, "%lf", rows + count) == 1) {
        count++;
    }
    fclose(file);
    return count / width;
}
int main(int count, char **words)
{
    static double states[3 * 512];
    double initial[3] = {0.0, 0.0, 0.0};
    size_t k, samples = read_rows("cases.txt", 3 + INPUTS);
    for (k = 0; k < samples; k++) {
        const double *row = rows + (3 + INPUTS) * k;
        SHIP_step(row, row + 3, NULL, states);
        printf("%.17g %.17g %.17g\n", states[0], states[1], states[2]);
    }
    initial[0] = count > 1 ? strtod(words[1], NULL) : 0.0;
    samples = read_rows("inputs.txt", INPUTS);
    SHIP_simulate(initial, rows, samples, NULL, states);
    for (k = 0; k <= samples; k++) {
        printf("%.17g %.17g %.17g\n", states[3 * k], states[3 * k + 1], states[3 * k + 2]);
    }
    return 0;
}
"#;

#[test]
fn law_c_steps_as_the_engine_does() {
    if !there("cc", "--version") {
        return;
    }
    for (name, vessel) in vessels() {
        let (truth, portable) = (truth(&vessel), portable(&vessel));
        let folder = exported(&portable, Target::C, &truth);
        let host = C.replace("INPUTS", &portable.inputs().len().to_string()).replace("SHIP", name);
        fs::write(folder.path().join("host.c"), host).unwrap();
        let strict = ["-std=c99", "-Wall", "-Wextra", "-Werror", "-pedantic", "-O2", "-ffp-contract=off"];
        let model = format!("{name}.c");
        let mut command = Command::new("cc");
        command.args(strict).args([&model, "host.c", "-o", "host", "-lm"]);
        done(&mut command, folder.path());
        let mut command = Command::new(folder.path().join("host"));
        command.arg(format!("{:?}", truth.states[0][0]));
        compare(name, &done(&mut command, folder.path()), &truth);
    }
}

#[test]
fn law_octave_steps_as_the_engine_does() {
    let octave = std::env::var("SEATRIAL_OCTAVE").unwrap_or("octave-cli".to_owned());
    if !there(&octave, "--version") {
        return;
    }
    for (name, vessel) in vessels() {
        let (truth, portable) = (truth(&vessel), portable(&vessel));
        let folder = exported(&portable, Target::Matlab, &truth);
        let script = format!(
            "m = {name}(); rows = load('cases.txt'); for k = 1:size(rows, 1); \
             printf('%.17g %.17g %.17g\\n', m.step(rows(k, 1:3), rows(k, 4:end), m.parameters)); end; \
             x = m.simulate(load('inputs.txt'), [{:?}, 0, 0], m.parameters); printf('%.17g %.17g %.17g\\n', x');",
            truth.states[0][0]
        );
        let mut command = Command::new(&octave);
        command.args(["--no-gui", "--norc", "--quiet", "--eval", &script]);
        compare(name, &done(&mut command, folder.path()), &truth);
    }
}

/// The main file of a ship.
fn text(portable: &Portable, target: Target) -> String {
    String::from_utf8(portable.files(target, None).unwrap().remove(0)).unwrap()
}

#[test]
fn a_ship_has_one_function_for_each_of_her_components_and_no_others() {
    let components = |text: &str| -> Vec<String> {
        let starts = text.lines().filter_map(|line| line.split_once("_forces(").map(|(start, _)| start));
        let names =
            starts.filter_map(|start| start.strip_prefix("def ").or(start.strip_prefix("function out = ")));
        names.map(str::to_owned).collect()
    };
    let expected: [&[&str]; 4] = [
        &["hull"],
        &["hull", "propeller", "rudder"],
        &["hull", "port", "starboard", "strips"],
        &["hull", "propeller", "rudder", "fin", "tunnel", "pod", "wind", "strips"],
    ];
    for ((_, ship), expected) in SHIPS.into_iter().zip(expected) {
        let portable = portable(&vessel(ship));
        for target in [Target::Python, Target::Matlab] {
            assert_eq!(components(&text(&portable, target)), expected);
        }
    }
    // Abkowitz's equations have no products of mass and yaw rate, and a ship without `astern` has no code for it.
    let mariner = text(&portable(&vessel(SHIPS[0].1)), Target::Python);
    assert!(!mariner.contains("coupling") && !mariner.contains("if_positive"), "{mariner}");
    let tanker = text(&portable(&vessel(SHIPS[1].1)), Target::Python);
    assert!(!tanker.contains("by_inflow") && !tanker.contains("munk"), "{tanker}");
    assert!(tanker.contains("    \"rudder_x_m\": -3.5,  # [m] rudder.x_m, known\n"), "{tanker}");
}

#[test]
fn matlab_has_as_many_ends_as_beginnings() {
    for (name, ship) in SHIPS {
        let text = text(&portable(&vessel(ship)), Target::Matlab);
        let code = text.lines().map(|line| line.split('%').next().unwrap_or_default().trim());
        let (mut open, mut functions) = (0, 0);
        for line in code {
            let word = line.split(|c: char| !c.is_alphanumeric()).next().unwrap_or_default();
            match word {
                "function" | "for" | "if" | "while" => open += 1,
                "end" => open -= 1,
                _ => {}
            }
            functions += usize::from(word == "function");
            assert!(open >= 0, "{name}: {line}");
        }
        assert_eq!(open, 0, "{name}");
        assert!(functions >= 7, "{name}");
    }
}

#[test]
fn terms_at_another_rate_say_which_steps_they_hold_for() {
    // Its comment in one line.
    let at = |rate_hz: f64| {
        text(&portable(&vessel(TERMS).at_rate(rate_hz).unwrap()), Target::Python).replace("\n# ", " ")
    };
    let fast = at(80.0);
    for line in [
        "They hold for steps of 0.125 s;",
        "a step of 0.0125 s (80 Hz) is a part of them",
        "SAMPLE_RATE_HZ = 80.0",
    ] {
        assert!(fast.contains(line), "{line}: {fast}");
    }
    assert!(at(2.0).contains("a step of 0.5 s (2 Hz) is 4 of them."));
    assert!(at(8.0).contains("and for no others") && !at(8.0).contains("own_step"));
}

#[test]
fn what_the_code_leaves_out_is_in_its_comment_or_refused() {
    let mariner = text(&portable(&vessel(SHIPS[0].1)), Target::C);
    assert!(mariner.contains("delta follows commands with a lag of 1 s"), "{mariner}");
    let craft = text(&portable(&vessel(SHIPS[3].1)), Target::Python);
    for line in ["is 3 of Runge and Kutta's method of order 4.", "Y_δ is", "δ is called delta here."] {
        assert!(craft.contains(line), "{line}: {craft}");
    }
    let late = SHIPS[2].1.replacen("curve = ", "dead_time_s = 0.2\ncurve = ", 1);
    let refused = Portable::new(&vessel(&late), Source::Nominal, &Knowledge::default(), Origin::default());
    assert!(refused.unwrap_err().to_string().contains("dead_time_s"));
}
