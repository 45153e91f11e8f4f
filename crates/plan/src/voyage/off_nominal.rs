//! How far parameters are from the nominal ones, for messages.

use std::collections::BTreeMap;

use ship::model::Vessel;

/// Differences of parameters from the nominal ones, relative to these \[%\]; 0 for a nominal 0, which is left out of a ship
/// with forces.
pub(super) fn percent_off(vessel: &Vessel, parameters: &[f64]) -> BTreeMap<String, f64> {
    let off = |(p, nominal): (&f64, &f64)| {
        if *nominal == 0.0 { 0.0 } else { (1e4 * (p / nominal - 1.0)).round() / 100.0 }
    };
    let is_given = |nominal: f64| nominal != 0.0 || vessel.model.forces.is_none();
    let names = vessel.model.parameter_names().map(str::to_owned);
    let all = names.zip(parameters.iter().zip(&vessel.nominal));
    all.filter(|(_, (_, nominal))| is_given(**nominal)).map(|(name, own)| (name, off(own))).collect()
}

/// The numbers of a ship with forces; none of terms per sample.
pub(super) fn numbers(vessel: &Vessel, parameters: &[f64]) -> BTreeMap<String, f64> {
    let own = parameters.iter().filter(|_| vessel.model.forces.is_some());
    vessel.model.parameter_names().map(str::to_owned).zip(own.copied()).collect()
}

/// The parameters of a vessel that are off the nominal ones, in words.
pub(super) fn parameters_in_words(vessel: &Vessel, parameters: &[f64]) -> String {
    in_words(&percent_off(vessel, parameters), &numbers(vessel, parameters))
}

/// Most parameters that are named.
const NAMED: usize = 10;

/// Parameters that are off, in words: those that are most off, where there are many. Of a ship with forces, `numbers` has all
/// of them, and those without a percentage are off a nominal 0.
pub(super) fn in_words(percent: &BTreeMap<String, f64>, numbers: &BTreeMap<String, f64>) -> String {
    let percent_words = percentages_in_words(percent);
    let off_zero = numbers.iter().filter(|(name, own)| !percent.contains_key(*name) && **own != 0.0);
    let off_zero: Vec<String> = off_zero.map(|(name, own)| format!("{name} = {own:.1e}")).collect();
    let more = off_zero.len().saturating_sub(NAMED);
    let more = if more > 0 { format!(" and {more} others off 0") } else { String::new() };
    let zeros = off_zero[..off_zero.len().min(NAMED)].join(", ") + &more;
    match (percent_words, zeros.is_empty()) {
        (Some(words), true) => words,
        (Some(words), false) => format!("{words}, {zeros}"),
        (None, false) => zeros,
        (None, true) => "nominal parameters".to_owned(),
    }
}

/// Percentages in words; `None` where none is worth naming.
fn percentages_in_words(percent: &BTreeMap<String, f64>) -> Option<String> {
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
    (!said.is_empty()).then(|| format!("{} %{others}", said.join(", ")))
}

/// Smaller differences are not said \[%\].
const SAID: f64 = 0.5;
