//! The ships of presets.

use refusal::Invalid;
use ship::forces::{Channel, Description, Forces};

pub const MARINER: &str = include_str!("../../../../ship/presets/mariner.toml");
pub const ESSO_OSAKA: &str = include_str!("../../../../ship/presets/esso-osaka-3m.toml");
pub const KVLCC2: &str = include_str!("../../../../ship/presets/kvlcc2-l7.toml");
pub const OTTER: &str = include_str!("../../../../ship/presets/otter.toml");

/// The channels of a `vessel.toml`.
pub fn channels(text: &str) -> Vec<Channel> {
    let table: toml::Table = text.parse().unwrap();
    let channel = |own: &toml::Value| {
        let text = |key: &str| own[key].as_str().unwrap().to_owned();
        let range = own.get("range").map(|range| [0, 1].map(|i: usize| range[i].as_float().unwrap()));
        Channel { name: text("name"), unit: text("unit"), range }
    };
    table["input"].as_array().unwrap().iter().map(channel).collect()
}

/// The forces of a `vessel.toml`.
pub fn forces(text: &str) -> Result<Forces, Invalid> {
    let mut table: toml::Table = text.parse().unwrap();
    for key in ["name", "model", "sample_rate_hz", "input"] {
        table.remove(key);
    }
    let description: Description = table.try_into().unwrap();
    Forces::new(&description, &channels(text))
}
