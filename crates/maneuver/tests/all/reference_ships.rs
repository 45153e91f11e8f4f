//! Figures of merit in sampled records of three published ships against those of continuous time.

use std::collections::BTreeMap;

use maneuver::merit::{Figure, Hull, Record, figures as found};
use maneuver::{ManeuverKind, Standard};
use refusal::Invalid;
use serde::Deserialize;
use ship::model::{Vessel, VesselFile};

/// The figures of a simulated maneuver.
fn figures(standard: Standard, record: &Record, hull: &Hull) -> Result<Vec<Figure>, Invalid> {
    found(Some(standard), record, hull).map(|found| found.figures)
}

/// A case of scripts/independent/reference_ships.py.
#[derive(Deserialize)]
pub struct Case {
    pub ship: String,
    pub length_m: f64,
    pub maneuver: ManeuverKind,
    pub figures: BTreeMap<String, f64>,
    pub inputs: Vec<String>,
    pub rate_hz: f64,
    /// u, v, r, north, east, heading and inputs of every sample.
    pub record: Vec<Vec<f64>>,
}

pub fn cases() -> Vec<Case> {
    let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../../fixtures/oracle/reference_ships.json");
    let mut document: serde_json::Value =
        serde_json::from_str(&std::fs::read_to_string(path).unwrap()).unwrap();
    serde_json::from_value(document["cases"].take()).unwrap()
}

impl Case {
    /// A vessel with the ship's inputs; figures of records depend on nothing else of it.
    pub fn vessel(&self) -> Vessel {
        let input = |name: &String| {
            let unit = if name == "delta" { "rad" } else { "1/s" };
            format!("{{ name = \"{name}\", unit = \"{unit}\" }}")
        };
        let inputs: Vec<String> = self.inputs.iter().map(input).collect();
        let term = |of: &str| {
            format!("[{{ parameter = \"p_{of}\", term = \"{of}\", value = -0.01, nominal = -0.01 }}]")
        };
        let text = format!(
            "name = \"ship\"\nsample_rate_hz = {:?}\ninput = [{}]\nsurge = {}\nsway = {}\nyaw = {}\n",
            self.rate_hz,
            inputs.join(", "),
            term("u"),
            term("v"),
            term("r"),
        );
        Vessel::from_file(text.parse::<VesselFile>().unwrap()).unwrap()
    }

    /// Every `stride`th sample of the record.
    fn sampled(&self, stride: usize) -> Record {
        let rows: Vec<&Vec<f64>> = self.record.iter().step_by(stride).collect();
        let states: Vec<f64> = rows.iter().flat_map(|row| row[..3].to_vec()).collect();
        let inputs = rows[..rows.len() - 1].iter().flat_map(|row| row[6..].to_vec()).collect();
        let poses: Vec<[f64; 3]> = rows.iter().map(|row| [row[3], row[4], row[5]]).collect();
        Record::of_states(&states, inputs, self.rate_hz / stride as f64).with_poses(&poses)
    }

    fn measured(&self, stride: usize) -> Vec<Figure> {
        let vessel = self.vessel();
        let hull = Hull { vessel: &vessel, length_m: self.length_m };
        figures(self.maneuver.standard().unwrap(), &self.sampled(stride), &hull).unwrap()
    }
}

/// How far a figure may be off. In the half turn that is measured as steady KVLCC2 still slows down a little.
fn tolerance(name: &str, unit: &str, seconds_per_length: f64) -> f64 {
    match (name, unit) {
        ("steady_diameter", _) => 0.01,
        (_, "L") => 0.005,
        (_, "deg") => 0.02,
        (_, "s") => 0.005 * seconds_per_length,
        (_, "deg/s") => 0.005,
        (_, "1") => 0.002,
        _ => panic!("{name} in {unit}"),
    }
}

#[test]
fn oracle_figures_of_published_ships_are_as_in_continuous_time() {
    let cases = cases();
    assert_eq!(cases.len(), 24);
    for case in cases {
        let standard = case.maneuver.standard().unwrap();
        let seconds = case.length_m / standard.speed_m_s();
        // Ten and five samples in the time in which the ship covers her length; fewer are refused.
        for stride in [1, 2] {
            let found = case.measured(stride);
            for (name, expected) in &case.figures {
                let own = found.iter().find(|own| own.name == name).unwrap_or_else(|| panic!("{name}"));
                let off = own.value - expected;
                assert!(
                    off.abs() < tolerance(name, &own.unit, seconds),
                    "{}, {standard:?}, {} samples: {name} off by {off} {}",
                    case.ship,
                    10 / stride,
                    own.unit
                );
            }
        }
    }
}
