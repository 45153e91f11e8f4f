//! How far parameters are from the nominal ones, for messages.

use std::collections::BTreeMap;

use model::Vessel;

/// Differences of parameters from the nominal ones, relative to these \[%\]; 0 for a nominal 0.
pub(super) fn percent_off(vessel: &Vessel, parameters: &[f64]) -> BTreeMap<String, f64> {
    let off = |(p, nominal): (&f64, &f64)| {
        if *nominal == 0.0 { 0.0 } else { (1e4 * (p / nominal - 1.0)).round() / 100.0 }
    };
    let names = vessel.model.parameter_names().map(str::to_owned);
    names.zip(parameters.iter().zip(&vessel.nominal).map(off)).collect()
}

/// The parameters of a vessel that are off the nominal ones, in words.
pub(super) fn parameters_in_words(vessel: &Vessel, parameters: &[f64]) -> String {
    in_words(&percent_off(vessel, parameters))
}

/// Parameters that are off, in words.
pub(super) fn in_words(percent: &BTreeMap<String, f64>) -> String {
    let off = percent.iter().filter(|(_, off)| off.abs() >= 0.5);
    let all: Vec<String> = off.map(|(name, off)| format!("{name} {off:+.0}")).collect();
    if all.is_empty() { "nominal parameters".to_owned() } else { format!("{} %", all.join(", ")) }
}
