//! Presets are the ships of the studies that the project ships.

use std::collections::BTreeMap;
use std::path::Path;

use model::{TermSpec, VesselFile};
use pipeline::starting::{PRESETS, Preset, simulated};

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
        ("model-ship", "crates/model/presets/ljungberg-model-ship.toml", ""),
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
    assert_eq!(PRESETS.len(), 5, "a preset that is not compared");
}
