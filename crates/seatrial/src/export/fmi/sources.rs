//! The unit's C sources, and how they are compiled.

use crate::export::portable::Portable;
use crate::export::template::fill;
use crate::export::text::{number, quoted};

/// The standard's name of this platform, if it has one.
pub const PLATFORM: Option<&str> = if cfg!(all(target_os = "linux", target_arch = "x86_64")) {
    Some("linux64")
} else if cfg!(target_os = "macos") {
    Some("darwin64")
} else {
    None
};

/// The extension of shared libraries on this platform.
pub(super) const LIBRARY: &str = if cfg!(target_os = "macos") { "dylib" } else { "so" };

/// Compiler flags besides sources and output. Sums keep their order, so that results have the same bits.
pub const COMPILED_WITH: [&str; 6] =
    ["-std=c99", "-O2", "-ffp-contract=off", "-fPIC", "-shared", "-fvisibility=hidden"];

impl Portable {
    /// The unit's C sources, name and text: the functions of the standard, the model, its header.
    pub fn unit_sources(&self) -> Vec<(String, String)> {
        let [header, source] = self.c_model();
        let starts = |channels: std::ops::Range<usize>| {
            channels.map(|place| number(self.start(place))).collect::<Vec<_>>().join(", ")
        };
        let inputs = starts(3..self.given().len());
        let values = [
            ("base", self.base.clone()),
            ("BASE", self.upper()),
            ("header", self.c_header()),
            ("guid", quoted(&self.guid())),
            ("ranges_are", self.ranges_are().to_owned()),
            ("initial_states", starts(0..3)),
            ("initial_inputs", if inputs.is_empty() { "0.0".to_owned() } else { inputs }),
        ];
        let text = fill(include_str!("../templates/fmi2.c"), &values);
        vec![(format!("{}_fmi2.c", self.base), text), source, header]
    }

    /// Identifies a unit: derived from its source and the producing program.
    pub(super) fn guid(&self) -> String {
        let origin = &self.origin;
        format!("{} {} {}", origin.digest, origin.values, origin.producer)
    }
}
