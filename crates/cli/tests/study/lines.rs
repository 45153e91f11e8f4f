//! Mistakes in hand-written files are refused with the line and the column of the key.

use crate::support::*;

const COASTER: &str = "coaster";
const HELSINKI: &str = "helsinki";
const LOGS: &str =
    "simulate logs --vessel vessel.toml --dictionary dictionary.toml --logs logs.toml --out logs/";
const MODEL_SHIP: &str = "model-ship";
const PLAN: &str = "plan --vessel vessel.toml --trajectories dictionary.parquet --design design.json --config plan.toml --out plan.json";
const SMOKE: &str = "smoke";

/// A study, one of its files, a text in it, what stands there by mistake, the key with its line, and the stage that reads it.
type Mistake = (&'static str, &'static str, &'static str, &'static str, &'static str, &'static str);

/// Unknown keys, units and types, and values that mean nothing.
const MISTAKES: [Mistake; 44] = [
    (SMOKE, "vessel.toml", "preset = ", "preste = ", "preste", DICTIONARY),
    (SMOKE, "vessel.toml", "preset = \"", "preset = 1 # \"", "preset", DICTIONARY),
    (COASTER, "vessel.toml", "sample_rate_hz = 2.0", "sample_rate = 2.0", "sample_rate", DICTIONARY),
    (COASTER, "vessel.toml", "sample_rate_hz = 2.0", "sample_rate_hz = \"2\"", "sample_rate_hz", DICTIONARY),
    (COASTER, "vessel.toml", "sample_rate_hz = 2.0", "sample_rate_hz = -2.0", "sample_rate_hz", DICTIONARY),
    (COASTER, "vessel.toml", "range = [-0.611, 0.611]", "rang = [-0.611, 0.611]", "rang", DICTIONARY),
    (COASTER, "vessel.toml", "range = [-0.611, 0.611]", "range = [-0.611]", "range", DICTIONARY),
    (COASTER, "vessel.toml", "term = \"v r\"\nvalue", "term = \"v r\"\nvalu", "valu", DICTIONARY),
    (COASTER, "vessel.toml", "nominal = -0.0005002", "nominal = true", "nominal", DICTIONARY),
    (COASTER, "vessel.toml", "[[yaw]]\nparameter = \"N_rr\"", "[[yaw]]\nname = \"N_rr\"", "name", DICTIONARY),
    (
        SMOKE,
        "dictionary.toml",
        "inputs_from = \"value\"",
        "inputs_from = \"truth\"",
        "inputs_from",
        DICTIONARY,
    ),
    (SMOKE, "dictionary.toml", "duration_s = 37.5", "duration_min = 37.5", "duration_min", DICTIONARY),
    (SMOKE, "dictionary.toml", "to_m_s = 1.0", "to_kn = 1.0", "to_kn", DICTIONARY),
    (SMOKE, "dictionary.toml", "from_m_s = 1.0", "from_m_s = \"1\"", "from_m_s", DICTIONARY),
    (SMOKE, "dictionary.toml", "speed_m_s = 1.15", "speed_m_s = inf", "speed_m_s", DICTIONARY),
    (SMOKE, "dictionary.toml", "speed_m_s = 1.15", "speed_kn = 1.15", "speed_kn", DICTIONARY),
    (SMOKE, "dictionary.toml", "sway_speed_m_s = 0.125", "sway_m_s = 0.125", "sway_m_s", DICTIONARY),
    (
        SMOKE,
        "dictionary.toml",
        "sway_speed_m_s = 0.2",
        "sway_speed_m_s = [0.2]",
        "sway_speed_m_s",
        DICTIONARY,
    ),
    (
        COASTER,
        "dictionary.toml",
        "turn_s = 150.0\n\n[[maneuver]]\nname = \"zig-zag-10-port\"",
        "turn_min = 2.5\n\n[[maneuver]]\nname = \"zig-zag-10-port\"",
        "turn_min",
        DICTIONARY,
    ),
    (COASTER, "dictionary.toml", "to = \"port\"\nturn_s", "to = \"left\"\nturn_s", "to", DICTIONARY),
    (
        COASTER,
        "dictionary.toml",
        "yaw_rate_rad_s = 0.0105",
        "yaw_rate_deg_s = 0.6",
        "yaw_rate_deg_s",
        DICTIONARY,
    ),
    (COASTER, "dictionary.toml", "steps = 3", "steps = 3.5", "steps", DICTIONARY),
    (
        COASTER,
        "dictionary.toml",
        "executed = \"feedback\"",
        "executed = \"autopilot\"",
        "executed",
        DICTIONARY,
    ),
    (SMOKE, "campaign.toml", "seed = 1\nrealizations", "sed = 1\nrealizations", "sed", CAMPAIGN),
    (SMOKE, "campaign.toml", "realizations = 40", "realizations = 40.5", "realizations", CAMPAIGN),
    (SMOKE, "campaign.toml", "realizations = 40", "realizations = 0", "realizations", CAMPAIGN),
    (
        SMOKE,
        "campaign.toml",
        "std_r_rad_s = 0.15811388300841897",
        "std_r_deg_s = 9.0",
        "std_r_deg_s",
        CAMPAIGN,
    ),
    (SMOKE, "campaign.toml", "std_v_m_s = 0.15811388300841897", "std_v_m_s = -0.1", "std_v_m_s", CAMPAIGN),
    (SMOKE, "campaign.toml", "segments = 5", "segment = 5", "segment", CAMPAIGN),
    (
        SMOKE,
        "campaign.toml",
        "parameter_error_bound = 5.0",
        "parameter_error_bound = 0.0",
        "parameter_error_bound",
        CAMPAIGN,
    ),
    (SMOKE, "campaign.toml", "dwell_s = 10.0", "dwel_s = 10.0", "dwel_s", VALIDATION),
    (SMOKE, "campaign.toml", "dwell_s = 10.0", "dwell_s = \"10\"", "dwell_s", VALIDATION),
    (HELSINKI, "plan.toml", "cell_m = 120.0", "cell = 120.0", "cell", PLAN),
    (HELSINKI, "plan.toml", "headings = 8", "headings = \"8\"", "headings", PLAN),
    (HELSINKI, "plan.toml", "beam_m = 8.0", "beam_ft = 26.0", "beam_ft", PLAN),
    (HELSINKI, "plan.toml", "tolerance_deg = 6.0", "tolerance_rad = 0.1", "tolerance_rad", PLAN),
    (HELSINKI, "plan.toml", "speed_m_s = 3.0", "speed_kn = 6.0", "speed_kn", PLAN),
    (
        HELSINKI,
        "plan.toml",
        "name = \"sway-zig-zag\"\ncount = 3",
        "name = \"sway-zig-zag\"\ncount = -3",
        "count",
        PLAN,
    ),
    (HELSINKI, "plan.toml", "kind = \"land\"", "kind = \"lands\"", "kind", PLAN),
    (MODEL_SHIP, "logs.toml", "repeats = 5", "repeat = 5", "repeat", LOGS),
    (MODEL_SHIP, "logs.toml", "sample_rate_hz = 8.0", "sample_rate_hz = 7.0", "sample_rate_hz", LOGS),
    (MODEL_SHIP, "logs.toml", "resolution_m = 0.001", "resolution_mm = 1", "resolution_mm", LOGS),
    (MODEL_SHIP, "logs.toml", "coefficient = 1.44", "coefficient = \"1.44\"", "coefficient", LOGS),
    (MODEL_SHIP, "logs.toml", "angle_std_rad = 0.01", "angle_std_deg = 0.6", "angle_std_deg", LOGS),
];

#[test]
fn mistakes_are_refused_with_the_line_and_the_column_of_the_key() {
    let mut wrong = Vec::new();
    for (study, file, from, to, key, stage) in MISTAKES {
        let folder = with(&["dictionary.parquet", "design.json"]);
        let pipeline = repository().join("pipelines").join(study);
        for name in ["vessel.toml", "dictionary.toml", "campaign.toml", "plan.toml", "logs.toml"] {
            let _ = std::fs::copy(pipeline.join(name), folder.path().join(name));
        }
        let text = String::from_utf8(bytes(&folder, file)).unwrap();
        assert!(text.contains(from), "{study}/{file}: {from}");
        let text = text.replacen(from, to, 1);
        put(&folder, file, &text);
        let at = text.find(to).unwrap() + to.find(key).unwrap();
        let line = 1 + text[..at].matches('\n').count();
        let place = format!("(line {line}, column 1");
        let ran = run(&folder, stage);
        if ran.code != Some(3) || !ran.stderr.contains(&place) || ran.stderr.trim_end().contains('\n') {
            wrong.push(format!("{study}/{file}, {to}, {place}: {ran}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}

#[test]
fn a_second_item_without_a_key_is_told_by_its_own_line() {
    let folder = with(&[]);
    edit(&folder, "dictionary.toml", "kind = \"accelerate\"\nfrom_m_s = 0.0\n", "kind = \"accelerate\"\n");
    let text = String::from_utf8(bytes(&folder, "dictionary.toml")).unwrap();
    let line = 1 + text[..text.find("name = \"accelerate\"").unwrap()].matches('\n').count();
    refused(&folder, 3, DICTIONARY, &["no key `from_m_s`", &format!("(line {line}, column 1")]);
}

/// What is changed by a flag stands in no line.
#[test]
fn a_value_of_a_flag_is_told_without_the_line_of_another() {
    let folder = with(&["design.json"]);
    let ran =
        run(&folder, &format!("{CAMPAIGN} --set campaign.realizations=0")).refuses(3, &["`realizations`"]);
    assert!(!ran.stderr.contains("(line"), "{ran}");
}
