//! The ships of presets.

use forces::{Channel, Description, Forces};
use refusal::Invalid;

pub const MARINER: &str = include_str!("../../../model/presets/mariner.toml");
pub const KVLCC2: &str = include_str!("../../../model/presets/kvlcc2-l7.toml");
pub const OTTER: &str = include_str!("../../../model/presets/otter.toml");

/// The forces of a `vessel.toml`.
pub fn forces(text: &str) -> Result<Forces, Invalid> {
    let mut table: toml::Table = text.parse().unwrap();
    let inputs = table.remove("input").unwrap();
    for key in ["name", "model", "sample_rate_hz"] {
        table.remove(key);
    }
    let channel = |own: &toml::Value| {
        let text = |key: &str| own[key].as_str().unwrap().to_owned();
        let range = own.get("range").map(|range| [0, 1].map(|i: usize| range[i].as_float().unwrap()));
        Channel { name: text("name"), unit: text("unit"), range }
    };
    let channels: Vec<Channel> = inputs.as_array().unwrap().iter().map(channel).collect();
    let description: Description = table.try_into().unwrap();
    Forces::new(&description, &channels)
}
