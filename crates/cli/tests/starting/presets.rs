//! Presets are the ships of the studies that the project ships.

use std::collections::BTreeMap;
use std::path::Path;

use cli::pipeline::starting::{PRESETS, Preset, simulated};
use ship::model::{TermSpec, Vessel, VesselFile};

/// Terms and true parameters, or nominal ones where no truth is stated, by the names of the parameters.
fn parameters(file: &VesselFile) -> BTreeMap<String, (String, Option<f64>)> {
    let terms = file.surge.iter().chain(&file.sway).chain(&file.yaw);
    let own = |term: &TermSpec| (term.parameter.clone(), (term.term.clone(), term.value.or(term.nominal)));
    terms.map(own).collect()
}

fn vessel_of(name: &str) -> VesselFile {
    let files = simulated(Preset::named(name).unwrap(), name, None).unwrap();
    files.iter().find(|(name, _)| name == "vessel.toml").unwrap().1.parse().unwrap()
}

#[test]
fn law_presets_have_the_parameters_of_the_shipped_studies() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (name, file, without) in [
        ("model-ship", "crates/ship/presets/ljungberg-model-ship.toml", ""),
        ("coaster", "pipelines/coaster/vessel.toml", ""),
        ("full-scale", "pipelines/full-scale/vessel.toml", ""),
        ("kvlcc2", "pipelines/kvlcc2/vessel.toml", ""),
        ("esso-osaka", "pipelines/esso-osaka/vessel.toml", "wind"),
    ] {
        let shipped: VesselFile = std::fs::read_to_string(repository.join(file)).unwrap().parse().unwrap();
        let mut expected = parameters(&shipped);
        expected.retain(|parameter, _| without.is_empty() || !parameter.contains(without));
        assert_eq!(parameters(&vessel_of(name)), expected, "{name}");
        assert!(expected.len() >= 10, "{name}");
    }
    assert_eq!(PRESETS.len(), 5 + FORCES.len(), "a preset that is not compared");
}

/// Ships with forces, and how many of their numbers a trial is to find.
const FORCES: [(&str, usize); 4] = [("mariner", 16), ("kvlcc2-l7", 26), ("esso-osaka-3m", 32), ("otter", 5)];

#[test]
fn law_presets_with_forces_know_what_the_published_ships_are() {
    let repository = Path::new(env!("CARGO_MANIFEST_DIR")).join("../..");
    for (name, free) in FORCES {
        // Her published ship has no wind and no thrust astern, which her logs need.
        let file = match name {
            "esso-osaka-3m" => "pipelines/esso-osaka/vessel-forces.toml".to_owned(),
            _ => format!("crates/ship/presets/{name}.toml"),
        };
        let file = repository.join(file);
        let published: VesselFile = std::fs::read_to_string(file).unwrap().parse().unwrap();
        let own = vessel_of(name);
        let terms = |file: &VesselFile| -> Vec<(String, String, Option<f64>)> {
            let all = file.surge.iter().chain(&file.sway).chain(&file.yaw);
            let still = all.filter(|own| !own.parameter.ends_with("wind"));
            still.map(|own| (own.parameter.clone(), own.term.clone(), own.prime)).collect()
        };
        assert_eq!(terms(&own), terms(&published), "{name}");
        let vessel = Vessel::from_file(own).unwrap();
        assert_eq!(vessel.model.parameters(), free, "{name}");
        let moved = vessel.model.forces.as_ref().unwrap();
        for (own, truth) in moved.forces.parameters().iter().zip(&vessel.value) {
            let (prior, truth) = (own.prior.unwrap(), truth.unwrap());
            assert!((truth - own.nominal).abs() < prior && truth != own.nominal, "{name}: {}", own.name);
        }
    }
}
