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

/// The numbers of a ship with forces; none of terms per sample.
pub(super) fn numbers(vessel: &Vessel, parameters: &[f64]) -> BTreeMap<String, f64> {
    let own = parameters.iter().filter(|_| vessel.model.forces.is_some());
    vessel.model.parameter_names().map(str::to_owned).zip(own.copied()).collect()
}

/// The parameters of a vessel that are off the nominal ones, in words.
pub(super) fn parameters_in_words(vessel: &Vessel, parameters: &[f64]) -> String {
    in_words(&percent_off(vessel, parameters))
}

/// Most parameters that are named.
const NAMED: usize = 10;

/// Parameters that are off, in words: those that are most off, where there are many.
pub(super) fn in_words(percent: &BTreeMap<String, f64>) -> String {
    let mut sizes: Vec<f64> = percent.values().map(|off| off.abs()).collect();
    sizes.sort_by(|a, b| b.total_cmp(a));
    let least = sizes.get(NAMED - 1).map_or(SAID, |size| size.max(SAID));
    let all = percent.iter().filter(|(_, off)| off.abs() >= SAID);
    let said = all.clone().filter(|(_, off)| off.abs() >= least).take(NAMED);
    let said: Vec<String> = said.map(|(name, off)| format!("{name} {off:+.0}")).collect();
    let others = match all.count() - said.len() {
        0 => String::new(),
        others => format!(" and {others} others"),
    };
    if said.is_empty() { "nominal parameters".to_owned() } else { format!("{} %{others}", said.join(", ")) }
}

/// Smaller differences are not said \[%\].
const SAID: f64 = 0.5;
