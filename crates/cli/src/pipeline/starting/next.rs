//! What the trial after logs may consist of: the folder `next` of a new study.

use files::Error;

use super::chart::{Charted, planned};
use super::presets::Preset;

/// Its maneuvers and its sea, in the folder `next`: a ship with forces sails the preset's maneuvers, of another the maneuvers are drawn
/// that inputs and motions of the logs allow.
///
/// # Errors
/// A chart that is refused.
pub(super) fn trial(preset: &Preset, charted: Option<&Charted>) -> Result<Vec<(String, String)>, Error> {
    let plan = charted.map(|charted| preset.plan().map_err(|why| Error::invalid(charted.file, why)));
    let plan = plan.transpose()?;
    let maneuvers = match preset.is_of_forces() {
        true => preset.dictionary().to_owned(),
        false => drawn(preset.dictionary(), plan.map_or("", |(template, _)| template)),
    };
    let campaign = preset.campaign().to_owned();
    let mut files = vec![("next/dictionary.toml", maneuvers), ("next/campaign.toml", campaign)];
    if let (Some(charted), Some((template, side_m))) = (charted, plan) {
        let by_shares = without_maneuvers(template, preset.campaign());
        let template = if preset.is_of_forces() { template } else { &by_shares };
        files.push(("next/plan.toml", planned(charted, "next", (template, side_m))?));
    }
    Ok(files.into_iter().map(|(name, text)| (name.to_owned(), text)).collect())
}

/// `template` with maneuvers by the design's shares, for a trial as long as that of `campaign`.
fn without_maneuvers(template: &str, campaign: &str) -> String {
    let length = campaign.lines().find_map(|line| line.strip_prefix("duration_s = "));
    let length = length.and_then(|own| own.split_whitespace().next()).unwrap_or("600.0");
    let Some((before, (_, after))) = template
        .split_once("maneuver = [\n")
        .and_then(|(before, rest)| Some((before, rest.split_once("]\n")?)))
    else {
        return template.to_owned();
    };
    format!("{before}informative_s = {length}\n{after}")
}

/// Candidates within the speeds and as long as the maneuvers of `dictionary`, which begin at the speeds of `plan`, if it has some.
fn drawn(dictionary: &str, plan: &str) -> String {
    let numbers = |text: &str, key: &str| {
        let number = |line: &str| {
            line.strip_prefix(key)?.trim_start().strip_prefix('=')?.split('#').next()?.trim().parse().ok()
        };
        text.lines().filter_map(number).collect::<Vec<f64>>()
    };
    let largest = |all: &[f64]| all.iter().copied().fold(0.0, f64::max);
    let modes = numbers(plan.split_once("[[speed_mode]]").map_or("", |(_, modes)| modes), "speed_m_s");
    let own = ["speed_m_s", "from_m_s", "to_m_s"].into_iter().flat_map(|key| numbers(dictionary, key));
    let speeds: Vec<f64> = own.chain(modes.iter().copied()).collect();
    let (speed, duration_s) = (largest(&speeds), largest(&numbers(dictionary, "duration_s")).max(1.0));
    let slow = speeds.into_iter().filter(|speed| *speed > 0.0).fold(speed, f64::min).min(0.8 * speed);
    let start = if modes.is_empty() { String::new() } else { format!("start_m_s = {modes:?}\n") };
    format!(
        "# What the helmsman may be asked for in the next trial: motions that are drawn, of which those stay that the inputs can hold within\n\
         # what was logged. Speeds [m/s], periods [s]; limits are wide, as the logs limit them.\n\
         duration_s = {duration_s}\n\n\
         [generate]\n\
         candidates = 200\n\
         kinds = [\"zig-zag\", \"accelerate\", \"decelerate\", \"steady-turn\", \"spiral\", \"pseudo-random-binary\", \"combined\"]\n\
         speed_m_s = [{slow}, {speed}]\n{start}\
         period_s = [{}, {}]\n\n\
         [generate.limits]\n\
         u_m_s = {}\nv_m_s = {speed}\nr_rad_s = 1.0\n",
        0.1 * duration_s,
        0.5 * duration_s,
        2.0 * speed
    )
}
