//! A study of a ship whose `vessel.toml` is there already: by hand, by `guess`, or by `scale`.

use std::fmt::Write;
use std::path::Path;

use files::{Error, Provenance, read_hand_written};
use refusal::Invalid;
use ship::engine::Streams;
use ship::model::{Vessel, VesselFile};
use study::files::read_any_vessel;

use super::{NewFile, Preset, with_schema};

/// The ship whose maneuvers are scaled, and the one whose sea is: preset, length \[m\] and speed \[m/s\].
const SAILED: (&str, f64, f64) = ("kvlcc2-l7", 7.0, 1.179);
const AT_SEA: (&str, f64, f64) = ("mariner", 160.93, 7.7175);
/// Shorter ships sail in tanks \[m\].
const AT_SEA_M: f64 = 20.0;
/// Simulated trials of each design: their page is there within a minute.
const TRIALS: u32 = 8;
/// Draws until a ship is one that can be.
const DRAWS: u64 = 100;

/// The files of a study of the ship with rudders in `file`: standard maneuvers and a sea for her length and speed. What she is
/// simulated by is what the file says, or else its nominal numbers, or with a `seed` numbers drawn from their priors.
///
/// # Errors
/// A file that cannot be read; a ship that no rudder steers.
pub fn of_ship(file: &Path, seed: Option<u64>) -> Result<Vec<NewFile>, Error> {
    let refuse = |invalid: Invalid| Error::invalid(file, invalid);
    let vessel = read_any_vessel(file, &mut Provenance::default())?;
    let text = read_hand_written(file)?;
    let text: String = text.split_inclusive('\n').filter(|line| !line.starts_with("#:schema ")).collect();
    let written = parsed(&text).map_err(refuse)?;
    let remedy = "begin with a preset, `seatrial new <folder> --vessel <preset>`, and replace its files";
    let none = |thing: &str, found: &str| {
        let expected = "a ship with forces and a rudder, which standard maneuvers are written for";
        refuse(Invalid::new(thing, found, expected, remedy))
    };
    let Some(ship) = written.ship.as_ref().filter(|_| vessel.model.forces.is_some()) else {
        return Err(none("[ship]", "none in this file"));
    };
    let Some(rudder) = written.rudder.first().map(|own| own.input.as_str()) else {
        return Err(none("[[rudder]]", "none"));
    };
    let (length_m, speed_m_s) = (ship.length_m, ship.speed_m_s);
    let of = |name: &str| Preset::named(name).map_err(refuse);
    let sea = if length_m < AT_SEA_M { SAILED } else { AT_SEA };
    let is_alone = vessel.model.inputs == 1;
    let scaled = |text: &str, (_, own_m, own_m_s): (&str, f64, f64)| {
        let time = length_m / own_m * own_m_s / speed_m_s;
        let lines = text.lines().filter(|line| !line.starts_with("approach = "));
        let mut scaled = String::new();
        for line in lines {
            scaled += &scaled_line(line, speed_m_s, time, rudder);
            if is_alone && line.starts_with("speed_m_s = ") {
                _ = writeln!(scaled, "approach = {{ {rudder} = 0.0 }}");
            }
        }
        scaled
    };
    let flags = format!(
        "# Flags of the stages, where they are to differ from the usual ones.\n\
         # Length between perpendiculars [m], for the figures of merit.\nLENGTH_M = {length_m}\n"
    );
    let files = [
        ("vessel.toml", with_truth(&text, &written, &vessel, seed).map_err(refuse)?),
        ("dictionary.toml", scaled(of(SAILED.0)?.dictionary(), SAILED)),
        ("campaign.toml", scaled(of(sea.0)?.campaign(), sea)),
        ("study.mk", flags),
    ];
    Ok(files.into_iter().map(|(name, text)| with_schema((name.to_owned(), text))).collect())
}

fn parsed(text: &str) -> Result<VesselFile, Invalid> {
    text.parse()
        .map_err(|e: toml::de::Error| Invalid::new("file", e.message(), "a vessel.toml", "correct it"))
}

/// A line of a preset, for another speed \[m/s\], by a factor on times and with another name of the rudder.
fn scaled_line(line: &str, speed_m_s: f64, time: f64, rudder: &str) -> String {
    let number = |key: &str| {
        let rest = line.strip_prefix(key)?.strip_prefix(" = ")?;
        let text = rest.split_whitespace().next()?;
        Some((text.parse::<f64>().ok()?, &rest[text.len()..]))
    };
    let timed = ["duration_s", "turn_s", "dwell_s"].into_iter().find_map(|key| Some((key, number(key)?)));
    match (timed, number("speed_m_s")) {
        (Some((key, (seconds, rest))), _) => format!("{key} = {:.1}{rest}\n", (time * seconds).round()),
        (None, Some((_, rest))) => format!("speed_m_s = {speed_m_s}{rest}\n"),
        (None, None) if line.starts_with("realizations = ") => format!("realizations = {TRIALS}\n"),
        (None, None) => line.replace("{ delta = ", &format!("{{ {rudder} = ")) + "\n",
    }
}

/// `text` with the numbers that simulated trials follow, where it has none.
fn with_truth(text: &str, file: &VesselFile, vessel: &Vessel, seed: Option<u64>) -> Result<String, Invalid> {
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    if !file.value.is_empty() || vessel.value.iter().all(Option::is_some) {
        return Ok(text.to_owned());
    }
    let priors = vessel.model.forces.iter().flat_map(|own| own.forces.parameters());
    let priors: Vec<f64> = priors.map(|own| own.prior.unwrap_or(0.0)).collect();
    let own = |draws: &[f64]| {
        let origin = match seed {
            None => "the nominal ones".to_owned(),
            Some(seed) => format!("drawn from the priors with seed {seed}"),
        };
        let mut text = format!(
            "{}\n\n# The true numbers, which simulated trials follow: {origin}.\n[value]\n",
            text.trim_end()
        );
        for (i, name) in names.iter().enumerate().filter(|(i, _)| vessel.value[*i].is_none()) {
            _ = writeln!(
                text,
                "\"{name}\" = {}",
                vessel.nominal[i] + priors.get(i).unwrap_or(&0.0) * draws[i]
            );
        }
        text
    };
    let Some(seed) = seed else { return Ok(own(&vec![0.0; names.len()])) };
    let mut last = Invalid::new("--seed", "no ship", "one that can be", "take another");
    for draw in 0..DRAWS {
        let mut draws = vec![0.0; names.len()];
        Streams::new(seed, "truth").normals(draw as u32, 0, &mut draws);
        let text = own(&draws);
        match parsed(&text).and_then(Vessel::from_file) {
            Ok(_) => return Ok(text),
            Err(why) => last = why,
        }
    }
    Err(last)
}
