//! Designs for figures of merit, through the binaries.

use std::sync::OnceLock;

use serde_json::Value;
use tempfile::TempDir;

use crate::support::*;

const MERIT: &str =
    "validate merit --vessel vessel.toml --dictionary dictionary.toml --length-m 100 --out merit.json";
const SLOPES: &str = "validate merit --vessel vessel.toml --dictionary dictionary.toml --length-m 100 --slopes --out merit.json";
const EXPECTED: &str = "moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator \
                        output-error --out moments.json";
const OUTPUT_ERROR: &str =
    "design --moments moments.json --for output-error --duration-s 5400 --out design.json";

/// A folder with the coaster's moments and figures.
fn folder() -> TempDir {
    static MADE: OnceLock<Study> = OnceLock::new();
    let made = MADE.get_or_init(|| {
        let folder = TempDir::new().unwrap();
        for name in WRITTEN {
            let text = std::fs::read_to_string(repository().join("pipelines/coaster").join(name)).unwrap();
            put(&folder, name, &text);
        }
        [DICTIONARY, EXPECTED, SLOPES].into_iter().for_each(|line| drop(run(&folder, line).succeeds()));
        Study::of(&folder)
    });
    made.with(&["dictionary.parquet", "moments.json", "merit.json"])
}

fn designed(folder: &TempDir, line: &str) -> Value {
    run(folder, line).succeeds();
    json(folder, "design.json")["data"].clone()
}

fn figures(design: &Value) -> &Vec<Value> {
    design["figures"]["figures"].as_array().unwrap()
}

fn number(of: &Value, key: &str) -> f64 {
    of[key].as_f64().unwrap_or_else(|| panic!("{key}: {of}"))
}

fn figure<'a>(design: &'a Value, maneuver: &str, name: &str) -> &'a Value {
    let named = |own: &&Value| own["maneuver"] == maneuver && own["name"] == name;
    figures(design).iter().find(named).unwrap()
}

/// The sum of the relative variances of the figures with a weight; `key`: whose standard errors.
fn sum(design: &Value, key: &str) -> f64 {
    let one = |own: &Value| number(own, "weight") * (number(own, key) / number(own, "value")).powi(2);
    figures(design).iter().filter(|own| own["weight"] != 0.0).map(one).sum()
}

#[test]
fn law_a_design_for_figures_knows_them_better_than_the_d_optimal_one() {
    let folder = folder();
    let line = format!("{OUTPUT_ERROR} --criterion figures --figures merit.json");
    let all = designed(&folder, &line);
    assert_eq!((&all["criterion"], &all["covariance"]["name"]), (&"figures".into(), &"figures".into()));
    assert_eq!(all["figures"]["samples"], 10_800);
    let known = json(&folder, "merit.json");
    let maneuvers = known["data"]["maneuvers"].as_array().unwrap();
    // Others have no slopes: no criterion and no design knows them.
    let aside = ["check_time_1", "check_time_2", "period", "nomoto_gain", "nomoto_time"];
    let aside = [&aside[..], &["greatest_advance", "greatest_transfer", "drift_angle"]].concat();
    let of_maneuvers = maneuvers.iter().flat_map(|own| own["figures"].as_array().unwrap());
    let count = of_maneuvers.filter(|own| !aside.contains(&own["name"].as_str().unwrap())).count();
    let known = figures(&all).len();
    assert!(known > 30 && known == count, "{known} of {count}");
    assert!(sum(&all, "standard_error") < sum(&all, "d_optimal"), "{all}");
    let circle = figure(&all, "circle-starboard", "tactical_diameter");
    assert_eq!(circle["unit"], "m");
    let turned = maneuvers.iter().find(|own| own["name"] == "circle-starboard").unwrap();
    let mut own = turned["figures"].as_array().unwrap().iter();
    let lengths = number(own.find(|own| own["name"] == "tactical_diameter").unwrap(), "value");
    assert!((number(circle, "value") - 100.0 * lengths).abs() < 1e-9 * 100.0 * lengths);
    // Nothing turns a ship that stops.
    assert!(all["figures"]["left_out"].to_string().contains("crash-stop/lateral_deviation is 0"), "{all}");
    // The figures of one circle alone: that of the other side is the same for this ship.
    let one =
        designed(&folder, &format!("{line} --weight all=0 --weight circle-starboard/tactical-diameter=1"));
    let ratio = |design: &Value, name: &str| number(figure(design, name, "tactical_diameter"), "ratio");
    assert!(ratio(&one, "circle-starboard") < ratio(&all, "circle-starboard").min(0.9), "{one}");
    assert!(
        figures(&one).len() == known && figures(&one).iter().filter(|own| own["weight"] == 1.0).count() == 1
    );
    let (better, worse): (Vec<f64>, Vec<f64>) = figures(&one)
        .iter()
        .filter(|own| own["ratio"].is_number())
        .map(|own| number(own, "ratio"))
        .partition(|r| *r < 1.0);
    assert!(!better.is_empty() && !worse.is_empty(), "{one}");
    // A name without a maneuver is that of all maneuvers with the figure.
    let both = designed(&folder, &format!("{line} --weight tactical_diameter=2 --weight overshoot=0"));
    for own in figures(&both).iter().filter(|own| own["value"] != 0.0) {
        let name = own["name"].as_str().unwrap();
        let weight = match name {
            "tactical_diameter" => 2.0,
            "overshoot_1" | "overshoot_2" => 0.0,
            _ => 1.0,
        };
        let zero = number(own, "value").abs() < 1e-6;
        assert_eq!(number(own, "weight"), if zero { 0.0 } else { weight }, "{own}");
    }
}

#[test]
fn law_figures_stand_beside_every_criterion_and_estimator() {
    let folder = folder();
    let flags = "--figures merit.json";
    let d = designed(&folder, &format!("{OUTPUT_ERROR} {flags}"));
    assert!(figures(&d).iter().all(|own| own["standard_error"] == own["d_optimal"]), "{d}");
    let a = designed(&folder, &format!("{OUTPUT_ERROR} --criterion a {flags}"));
    for (own, other) in figures(&d).iter().zip(figures(&a)) {
        let [one, other] = [own, other].map(|own| number(own, "d_optimal"));
        assert!((one - other).abs() <= 1e-6 * one, "{own}");
    }
    let iv = "design --moments moments.json --out design.json";
    let paper = designed(&folder, &format!("{iv} {flags}"));
    assert_eq!((&paper["criterion"], &paper["figures"]["samples"]), (&"D".into(), &1.into()));
    let own = designed(&folder, &format!("{iv} --criterion figures {flags}"));
    assert!(sum(&own, "standard_error") < sum(&own, "d_optimal"), "{own}");
    let limited =
        format!("{iv} --criterion figures {flags} --most-maneuvers 11 --segments 18 --segment-samples 600");
    let limited = designed(&folder, &limited);
    assert_eq!((&limited["status"], &limited["counted"]["segments"]), (&"restricted".into(), &18.into()));
    assert!(sum(&limited, "standard_error") < sum(&limited, "d_optimal"), "{limited}");
    run(&folder, REPORT).succeeds();
    let page = String::from_utf8(bytes(&folder, "report.html")).unwrap();
    assert!(page.contains("How well will figures of merit be known?") && page.contains("of 10800 samples"));
    assert!(designed(&folder, iv).get("figures").is_none());
}

#[test]
fn law_a_figure_is_as_well_known_as_is_wanted_and_no_better() {
    let folder = folder();
    let line = "design --moments moments.json --for output-error --figures merit.json --out design.json";
    let asked = |wanted: &str| {
        designed(&folder, &format!("{line} --accuracy circle-port/tactical-diameter={wanted}"))
    };
    let found = asked("0.5m");
    assert_eq!((&found["accuracy"]["of"], &found["criterion"]), (&"figures".into(), &"figures".into()));
    let own = figure(&found, "circle-port", "tactical_diameter");
    let over = number(own, "standard_error") / number(own, "wanted");
    assert!(own["wanted"] == 0.5 && over <= 1.0 && over > 0.99, "{own}");
    assert_eq!(figures(&found).iter().filter(|own| own["weight"] == 1.0).count(), 1);
    let time = |design: &Value| number(&design["accuracy"], "duration_s");
    assert!((time(&asked("0.25m")) / time(&found) - 4.0).abs() < 0.05);
    assert!((time(&asked("0.005L")) - time(&found)).abs() < 1e-6);
    // Of several the one that needs most time counts.
    let line = format!("{line} --accuracy advance=0.5m --accuracy overshoot-1=0.05deg");
    let both = designed(&folder, &line);
    let over = figures(&both).iter().filter(|own| own["wanted"].is_number());
    let over: Vec<f64> = over.map(|own| number(own, "standard_error") / number(own, "wanted")).collect();
    let largest = over.iter().copied().fold(0.0, f64::max);
    assert!(over.len() == 6 && largest <= 1.0 && largest > 0.99, "{over:?}");
    assert!(number(&both["accuracy"], "duration_s") < d_optimal_time(&both), "{both}");
}

/// The time after which the D-optimal design of the same maneuvers has the wanted errors.
fn d_optimal_time(design: &Value) -> f64 {
    let wanted = figures(design).iter().filter(|own| own["wanted"].is_number());
    let over = wanted.map(|own| (number(own, "d_optimal") / number(own, "wanted")).powi(2));
    over.fold(0.0, f64::max) * number(&design["accuracy"], "duration_s")
}

#[test]
fn figures_of_another_model_are_refused() {
    let folder = folder();
    let line = "design --moments moments.json --criterion figures --figures merit.json --out design.json";
    run(&folder, MERIT).succeeds();
    refused(&folder, 3, line, &["merit.json: `data.slopes_at`: found none", "validate merit --slopes"]);
    edit(&folder, "vessel.toml", "name = \"Coaster\"", "name = \"Other\"");
    run(&folder, SLOPES).succeeds();
    refused(&folder, 3, line, &["merit.json: `data.vessel`: found `Other`, expected `Coaster`"]);
    edit(&folder, "vessel.toml", "name = \"Other\"", "name = \"Coaster\"");
    edit(&folder, "vessel.toml", "value = -0.4\n", "value = -0.41\n");
    run(&folder, SLOPES).succeeds();
    refused(&folder, 3, line, &["merit.json: provenance: found another vessel than that of moments.json"]);
    edit(&folder, "vessel.toml", "value = -0.41\nnominal = -0.48\n", "value = -0.41\nfixed = true\n");
    run(&folder, SLOPES).succeeds();
    let parameters = "merit.json: `data.slopes_at.parameters`: found no `N_rr`";
    refused(&folder, 3, &format!("{line} --allow=mixed"), &[parameters]);
    edit(&folder, "vessel.toml", "value = 0.2\n", "value = 0.0\n");
    std::fs::remove_file(folder.path().join("merit.json")).unwrap();
    refused(&folder, 3, SLOPES, &["vessel.toml: parameter `X_vr`: found 0", "a step is relative to"]);
}

#[test]
fn wishes_that_no_figure_meets_are_refused() {
    let folder = folder();
    let line = "design --moments moments.json --figures merit.json --out design.json";
    let refuse =
        |code: i32, flags: &str, pieces: &[&str]| refused(&folder, code, &format!("{line} {flags}"), pieces);
    let unknown =
        ["merit.json: --weight: found `tactical-diametre`", "expected", "did you mean `tactical_diameter`?"];
    refuse(3, "--criterion figures --weight tactical-diametre=2", &unknown);
    refuse(
        3,
        "--criterion figures --weight circle/advance=2",
        &["merit.json: --weight: found `circle/advance`"],
    );
    refuse(
        2,
        "--criterion figures --weight advance=-1",
        &["--weight", "found `-1`, expected a number from 0"],
    );
    refuse(2, "--criterion figures --weight advance", &["--weight", "found no `=`"]);
    refuse(3, "--criterion figures --weight all=0", &["merit.json: --weight: found 0 for every figure"]);
    let zero = ["--weight lateral_deviation: found 0 of crash-stop", "leave it out"];
    refuse(3, "--criterion figures --weight lateral_deviation=1", &zero);
    refuse(3, "--accuracy advance=2deg", &["merit.json: --accuracy advance: found `deg`, expected m, or L"]);
    refuse(3, "--accuracy overshoot=2", &["merit.json: --accuracy overshoot: found no unit, expected deg"]);
    refuse(3, "--accuracy heel=2deg", &["merit.json: --accuracy: found `heel`"]);
    refuse(4, "--accuracy advance=1e-9m", &["--accuracy", "86400 s can reach"]);
    refuse(2, "--accuracy advance=2m --accuracy 0.1", &["--accuracy: found several, one a share"]);
    refuse(2, "--accuracy advance=-2m", &["--accuracy", "expected a number above 0"]);
    let line = "design --moments moments.json --out design.json";
    let without = ["--criterion: found figures without --figures", "add --figures merit.json"];
    refused(&folder, 2, &format!("{line} --criterion figures"), &without);
    refused(
        &folder,
        2,
        &format!("{line} --accuracy advance=2m"),
        &["--accuracy: found a figure without --figures"],
    );
    refused(&folder, 2, &format!("{line} --weight advance=2"), &["--figures"]);
    run(&folder, MOMENTS).succeeds();
    let pieces = ["moments.json: `data.disturbances`", "--campaign campaign.toml"];
    refused(&folder, 3, &format!("{line} --figures merit.json"), &pieces);
}
