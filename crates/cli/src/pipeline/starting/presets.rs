//! Ships that a new study can begin with.

use std::borrow::Cow;
use std::fmt::Write;
use std::path::Path;

use crate::pipeline::settings::{FILE, HEAD};
use files::{Error, parse_toml};
use logs::guess::Needed;
use refusal::Invalid;
use ship::engine::Streams;
use ship::forces::ShipSpec;
use ship::model::{Vessel, VesselFile};
use study::files::{file_name, kind_of};

/// A hand-written file of a new study: its name and its text.
pub type NewFile = (String, String);

/// A file with the line that editors find its schema by.
pub(super) fn with_schema((name, text): NewFile) -> NewFile {
    let (up, last) = name.rsplit_once('/').map_or(("", name.as_str()), |(_, last)| ("../", last));
    match kind_of(last).or((last == FILE).then_some("study")) {
        None => (name, text),
        Some(kind) => {
            let text = format!("#:schema {up}schemas/{}\n{text}", file_name(kind));
            (name, text)
        }
    }
}

/// A ship that a new study can begin with.
#[derive(Debug, Default)]
pub struct Preset {
    /// Its name.
    pub name: &'static str,
    /// What it is, in a few words.
    pub about: &'static str,
    pub(super) vessel: Cow<'static, str>,
    /// Its maneuvers; empty if it has none.
    pub(super) dictionary: Cow<'static, str>,
    /// Its simulated trials.
    pub(super) campaign: Cow<'static, str>,
    pub(super) settings: Cow<'static, str>,
    /// Inputs as a table, if a maneuver plays one.
    table: Option<(&'static str, &'static str)>,
    /// The thrusters that its forces are made by, as `ingest.toml` has them.
    thrusters: Option<&'static str>,
    /// `plan.toml` with places to be filled in, and the side of its area \[m\]; none for a ship whose speed nothing commands.
    plan: Option<(Cow<'static, str>, f64)>,
}

/// A preset by its folder: with a plan in an area of this side, with thrusters, with the table in this file.
macro_rules! preset {
    ($name:literal, $about:literal $(, plan $side:literal)? $(, thrusters $thrusters:literal)? $(, table $table:literal)?) => {
        Preset {
            name: $name,
            about: $about,
            vessel: Cow::Borrowed(include_str!(concat!("../../../presets/", $name, "/vessel.toml"))),
            dictionary: Cow::Borrowed(include_str!(concat!("../../../presets/", $name, "/dictionary.toml"))),
            campaign: Cow::Borrowed(include_str!(concat!("../../../presets/", $name, "/campaign.toml"))),
            settings: Cow::Borrowed(include_str!(concat!("../../../presets/", $name, "/study.toml"))),
            table: [$(Some(($table, include_str!(concat!("../../../presets/", $name, "/", $table)))),)? None][0],
            thrusters: [$(Some(include_str!(concat!("../../../presets/", $name, "/", $thrusters))),)? None][0],
            plan: first([$(Some((include_str!(concat!("../../../presets/", $name, "/plan.toml.in")), $side)),)? None]),
        }
    };
}

/// The first of those that there are, as [`Preset`] has it.
const fn first<const N: usize>(all: [Option<(&'static str, f64)>; N]) -> Option<(Cow<'static, str>, f64)> {
    match all[0] {
        Some((text, side_m)) => Some((Cow::Borrowed(text), side_m)),
        None => None,
    }
}

/// All of them.
pub static PRESETS: [Preset; 9] = [
    preset!(
        "model-ship",
        "a model ship of 1 m with two azimuth thrusters aft",
        plan 300.0,
        thrusters "thrusters.toml"
    ),
    preset!("coaster", "a coaster of 100 m with rudder and propeller, for standard maneuvers", plan 16_000.0),
    preset!(
        "full-scale",
        "a ship of 30 m with azimuth thrusters fore and aft",
        plan 7_000.0,
        thrusters "thrusters.toml"
    ),
    preset!("kvlcc2", "a 7 m model of the tanker KVLCC2, with rudder and measured thrust", plan 2_800.0),
    preset!(
        "esso-osaka",
        "a 3 m model of the tanker Esso Osaka, with rudder and propeller",
        plan 600.0,
        table "crash-stop.csv"
    ),
    preset!("esso-osaka-3m", "a 3 m model of the tanker Esso Osaka, by forces", plan 900.0),
    preset!("mariner", "the cargo ship Mariner of 160.93 m, by hydrodynamic derivatives"),
    preset!("kvlcc2-l7", "a 7 m model of the tanker KVLCC2, by the MMG standard method", plan 2_100.0),
    preset!("otter", "the uncrewed vessel Otter of 2 m with two propellers, by forces", plan 500.0),
];

impl Preset {
    /// The preset called `name`.
    ///
    /// # Errors
    /// No such preset: names them and the nearest.
    pub fn named(name: &str) -> Result<&'static Self, Invalid> {
        let unknown = || Invalid::unknown("preset", name, PRESETS.iter().map(|preset| preset.name));
        PRESETS.iter().find(|preset| preset.name == name).ok_or_else(unknown)
    }

    /// The ship in the text of a `vessel.toml`, without maneuvers.
    pub(super) fn of_vessel(text: String) -> Self {
        Self { name: "vessel.toml", about: "a ship of its own", vessel: text.into(), ..Self::default() }
    }

    /// The files of a study of it that is simulated.
    pub(super) fn files(&self) -> impl Iterator<Item = (&'static str, &str)> {
        let files = [
            ("vessel.toml", &*self.vessel),
            ("dictionary.toml", &*self.dictionary),
            ("campaign.toml", &*self.campaign),
            ("study.toml", &*self.settings),
        ];
        files.into_iter().filter(|(_, text)| !text.is_empty()).chain(self.table)
    }

    /// The thrusters that its forces are made by, as `ingest.toml` has them; empty if its inputs are logged.
    pub(super) fn thrusters(&self) -> &'static str {
        self.thrusters.unwrap_or_default()
    }

    /// Its `plan.toml` with places to be filled in, and the side of the area \[m\].
    pub(super) fn plan(&self) -> Result<(&str, f64), Invalid> {
        self.plan.as_ref().map(|(text, side_m)| (&**text, *side_m)).ok_or_else(|| {
            let others = PRESETS.iter().filter(|preset| preset.plan.is_some()).map(|preset| preset.name);
            let expected =
                format!("a ship whose speed can be commanded: {}", others.collect::<Vec<_>>().join(", "));
            let preset = format!("{}, {}", self.name, self.about);
            Invalid::new("--chart", preset, expected, "begin with one of them")
        })
    }

    /// `vessel.toml` without true parameters, which no real ship has, and with the relative wind where that `is_logged`.
    pub(super) fn without_truth(&self, is_wind_logged: bool) -> String {
        let text = self.vessel.split_once(TRUE_NUMBERS).map_or(&*self.vessel, |(text, _)| text);
        let lines = text.lines().filter(|line| !line.starts_with("value = "));
        let mut text: String = lines.map(|line| format!("{}\n", without_value(line))).collect();
        for (degree, asymmetry) in STRAIGHT_AHEAD {
            let name = &asymmetry[..3];
            let has_primes = self.is_of_forces() && text.contains("prime = ");
            if has_primes && !text.contains(&format!("\"{name}\"")) {
                let line = format!("  {{ parameter = \"{name}\", term = \"U^2\", {} }},", &asymmetry[4..]);
                text = text.replacen(&format!("\n{degree} = [\n"), &format!("\n{degree} = [\n{line}\n"), 1);
            }
        }
        if is_wind_logged {
            text += MEASURED_WIND;
            text += if self.is_of_forces() { WIND_FORCES } else { "" };
        }
        text
    }

    /// The channels that logs of it must have: speeds and angles of its thrusters, or else its inputs.
    pub(super) fn needed(&self) -> Vec<Needed> {
        let need = |channel: &str, unit: &str| Needed { channel: channel.to_owned(), unit: unit.to_owned() };
        let named = |key: &str, unit: &str| {
            let quoted = |line: &str| Some(line.strip_prefix(key)?.split('"').nth(1)?.to_owned());
            self.thrusters().lines().filter_map(quoted).map(|name| need(&name, unit)).collect::<Vec<_>>()
        };
        let thrusters = [named("speed = ", "1/s"), named("angle = ", "rad")].concat();
        if !thrusters.is_empty() {
            return thrusters;
        }
        // A preset that cannot be parsed needs nothing; a test parses all.
        let vessel = self.vessel.parse::<VesselFile>();
        vessel.map_or(Vec::new(), |vessel| {
            vessel.input.iter().map(|input| need(&input.name, &input.unit)).collect()
        })
    }

    /// Whether forces describe it, in continuous time.
    pub(super) fn is_of_forces(&self) -> bool {
        self.vessel.parse::<VesselFile>().is_ok_and(|vessel| vessel.is_of_forces())
    }

    /// The rate of its model \[Hz\].
    pub(super) fn sample_rate_hz(&self) -> f64 {
        self.vessel.parse::<VesselFile>().ok().and_then(|vessel| vessel.sample_rate_hz).unwrap_or(1.0)
    }
}

/// The force and the moment straight ahead, which logs show and a symmetric hull does not have.
const STRAIGHT_AHEAD: [(&str, &str); 2] =
    [("sway", "Y_0 prime = 0.0, prior = 0.003"), ("yaw", "N_0 prime = 0.0, prior = 0.001")];

/// Channels of a logged wind, as `vessel.toml` has them.
const MEASURED_WIND: &str = r#"
# Speed of the relative wind, and where it comes from, from the bow to starboard. Simulated trials have none.
[[measured]]
name = "wind"
unit = "m/s"
simulated = 0.0

[[measured]]
name = "wind_from"
unit = "rad"
simulated = 0.0
"#;

/// Its forces on a ship of which nothing above water is known: areas as parts of length times draught, usual coefficients of a bluff body.
const WIND_FORCES: &str = r#"
[[wind]]
name = "air"
speed = "wind"
direction = "wind_from"
frontal_area_m2 = { prime = 0.2, fixed = true }
lateral_area_m2 = { prime = 0.5, fixed = true }
surge = [{ nominal = 0.7, prior = 0.5 }]
sway = [{ nominal = 0.8, prior = 0.5 }]
yaw = [{ nominal = 0.0, prior = 0.1 }, { nominal = 0.0, prior = 0.1 }]
"#;

/// A line of tables without the true values in them.
fn without_value(line: &str) -> String {
    let mut parts = line.split(", value = ");
    let first = parts.next().unwrap_or_default();
    let rest = parts.map(|part| &part[part.find([' ', ',']).unwrap_or(part.len())..]);
    std::iter::once(first).chain(rest).collect()
}

/// The ship whose maneuvers are scaled, and the one whose sea is: preset, length \[m\] and speed \[m/s\].
const SAILED: (&str, f64, f64) = ("kvlcc2-l7", 7.0, 1.179);
const AT_SEA: (&str, f64, f64) = ("mariner", 160.93, 7.7175);
/// Shorter ships sail in tanks \[m\].
const AT_SEA_M: f64 = 20.0;
/// Simulated trials of each design: their page is there within a minute.
const TRIALS: u32 = 8;
/// Draws until a ship is one that can be.
const DRAWS: u64 = 100;

/// The line before the true numbers in a file that is written here.
const TRUE_NUMBERS: &str = "\n\n# The true numbers, which simulated trials follow: ";

/// The ship with forces in `text`, that of `file`: standard maneuvers and a sea for her length and speed, if a rudder steers her.
/// What she is simulated by is what the text says, or else its nominal numbers, or with a `seed` numbers drawn from their priors.
///
/// # Errors
/// A text that is no vessel; a ship without forces.
pub fn of_ship(file: &Path, text: &str, seed: Option<u64>) -> Result<Preset, Error> {
    let refuse = |invalid: Invalid| Error::invalid(file, invalid);
    let written: VesselFile = parse_toml(text, file)?;
    let vessel = Vessel::from_file(written.clone()).map_err(refuse)?;
    let text: String = text.split_inclusive('\n').filter(|line| !line.starts_with("#:schema ")).collect();
    let Some(ship) = written.ship.as_ref().filter(|_| vessel.model.forces.is_some()) else {
        let remedy = "begin with a preset, `seatrial new <folder> --vessel <preset>`, and replace its files";
        let expected = "a ship with forces, which standard maneuvers are written for";
        return Err(refuse(Invalid::new("[ship]", "none in this file", expected, remedy)));
    };
    let of_file = Preset::of_vessel(with_truth(&text, &written, &vessel, seed).map_err(refuse)?);
    // Of a ship without a rudder there are no standard maneuvers.
    let Some(rudder) = written.rudder.first().map(|rudder| rudder.input.as_str()) else { return Ok(of_file) };
    let (length_m, speed_m_s) = (ship.length_m, ship.speed_m_s);
    let of = |name: &str| Preset::named(name).map_err(refuse);
    let sea = if length_m < AT_SEA_M { SAILED } else { AT_SEA };
    let is_alone = vessel.model.inputs == 1;
    let scaled = |text: &str, (_, own_m, own_m_s): (&str, f64, f64)| {
        let time = length_m / own_m * own_m_s / speed_m_s;
        let lines = text.lines().filter(|line| !line.starts_with("approach = "));
        let mut scaled = String::new();
        for line in lines {
            scaled += &scaled_line(line, [speed_m_s, own_m_s], time, rudder);
            if is_alone && line.starts_with("speed_m_s = ") {
                _ = writeln!(scaled, "approach = {{ {rudder} = 0.0 }}");
            }
        }
        scaled
    };
    let settings = format!(
        "{HEAD}\n# Standard maneuvers and their figures, by the length between perpendiculars [m]\n[merit]\nlength_m = {length_m}\n"
    );
    Ok(Preset {
        dictionary: scaled(&of(SAILED.0)?.dictionary, SAILED).into(),
        campaign: scaled(&of(sea.0)?.campaign, sea).into(),
        settings: settings.into(),
        // Of a ship whose speed nothing commands no speed can be planned.
        plan: (!is_alone).then(|| scaled_plan(ship, vessel.is_guess())).transpose().map_err(refuse)?,
        ..of_file
    })
}

/// Sensors of a ship at sea, and unknown currents there, at most \[m, m/s\].
const POSITION_M: f64 = 3.0;
const SPEED_M_S: f64 = 0.1;
const CURRENT_M_S: f64 = 0.15;

/// The plan of the ship whose maneuvers are scaled, for another length and speed, and the side of its area \[m\]. Her beam is a part
/// of her length, depths are by her draught. Of a guess vessels within half of her priors' deviations are planned for: all of them would
/// hardly be steered by one autopilot.
fn scaled_plan(ship: &ShipSpec, is_guess: bool) -> Result<(Cow<'static, str>, f64), Invalid> {
    let (template, side_m) = Preset::named(SAILED.0)?.plan()?;
    let (length, speed) = (ship.length_m / SAILED.1, ship.speed_m_s / SAILED.2);
    let time = length / speed;
    let (mut text, mut section, mut sensed_m_s) = (String::new(), "", 0.0_f64);
    for line in template.lines() {
        section = if line.starts_with('[') { line } else { section };
        if is_guess && line.starts_with("parameter_error") {
            text += "standard_errors = 0.5            # vessels within so many standard deviations of her priors, jointly: 2, once \
                     she is identified\n";
            continue;
        }
        let value = numbered(line).and_then(|(key, given, rest)| {
            let value = match (section, key) {
                (_, "length_m") => ship.length_m,
                (_, "draught_m") => ship.draught_m,
                (_, "transit_depth_m") => 1.3 * ship.draught_m,
                (_, "trial_depth_m") => 2.0 * ship.draught_m,
                (_, "unknown_current_m_s") => (speed * given).min(CURRENT_M_S),
                (_, "position_m") => (length * given).min(POSITION_M),
                ("[sensors]", "speed_m_s") => {
                    sensed_m_s = (speed * given).min(SPEED_M_S);
                    sensed_m_s
                }
                (_, "cell_m" | "beam_m" | "margin_m") => length * given,
                (_, "speed_m_s") => {
                    let value = at_speed(given, [ship.speed_m_s, SAILED.2]);
                    return Some((key, value.to_string(), rest));
                }
                (_, "std_u_m_s" | "std_v_m_s") => speed * given,
                (_, "run_in_s") => time * given,
                (_, "tolerance_rad_s" | "std_r_rad_s") => given / time,
                _ => return None,
            };
            Some((key, rounded(value).to_string(), rest))
        });
        _ = match value {
            Some((key, value, rest)) => writeln!(text, "{key} = {value}{rest}"),
            None => writeln!(text, "{line}"),
        };
        if line.starts_with("tolerance_cells") {
            // Three standard deviations of what is measured.
            let tolerance = (3.0 * sensed_m_s).max(0.1);
            _ = writeln!(
                text,
                "tolerance_m_s = {}            # by which vessels may miss a speed",
                rounded(tolerance)
            );
        }
    }
    Ok((text.into(), length * side_m))
}

/// The key of a line, its number, and what follows that; `None` of any other line.
fn numbered(line: &str) -> Option<(&str, f64, &str)> {
    let (key, rest) = line.split_once(" = ")?;
    let number = rest.split_whitespace().next()?;
    Some((key, number.parse().ok()?, &rest[number.len()..]))
}

/// A speed of a ship whose own is the second one, for one whose own is the first \[m/s\].
fn at_speed(speed: f64, [speed_m_s, own_m_s]: [f64; 2]) -> f64 {
    if speed == own_m_s { speed_m_s } else { rounded(speed * speed_m_s / own_m_s) }
}

/// To three digits.
fn rounded(value: f64) -> f64 {
    format!("{value:.2e}").parse().unwrap_or(value)
}

fn parsed(text: &str) -> Result<VesselFile, Invalid> {
    text.parse()
        .map_err(|e: toml::de::Error| Invalid::new("file", e.message(), "a vessel.toml", "correct it"))
}

/// A line of a preset, for another speed than its own \[m/s\], by a factor on times and with another name of the rudder.
fn scaled_line(line: &str, [speed_m_s, own_m_s]: [f64; 2], time: f64, rudder: &str) -> String {
    let scaled = |speed: f64| at_speed(speed, [speed_m_s, own_m_s]);
    let words = line.strip_prefix("description = \"from ").and_then(|words| words.strip_suffix(" m/s\""));
    let speeds =
        words.and_then(|words| words.split_once(" to ")).map(|(from, to)| [from, to].map(str::parse));
    if let Some([Ok(from), Ok(to)]) = speeds {
        return format!("description = \"from {} to {} m/s\"\n", scaled(from), scaled(to));
    }
    match numbered(line) {
        Some((key @ ("from_m_s" | "to_m_s"), speed, rest)) => format!("{key} = {}{rest}\n", scaled(speed)),
        Some((key @ ("duration_s" | "turn_s" | "dwell_s"), seconds, rest)) => {
            format!("{key} = {:.1}{rest}\n", (time * seconds).round())
        }
        Some(("speed_m_s", _, rest)) => format!("speed_m_s = {speed_m_s}{rest}\n"),
        Some(("realizations", ..)) => format!("realizations = {TRIALS}\n"),
        _ => line.replace("{ delta = ", &format!("{{ {rudder} = ")) + "\n",
    }
}

/// `text` with the numbers that simulated trials follow, where it has none.
fn with_truth(text: &str, file: &VesselFile, vessel: &Vessel, seed: Option<u64>) -> Result<String, Invalid> {
    let names: Vec<&str> = vessel.model.parameter_names().collect();
    if !file.value.is_empty() || vessel.value.iter().all(Option::is_some) {
        return Ok(text.to_owned());
    }
    let priors = vessel.model.forces.iter().flat_map(|forces| forces.forces.parameters());
    let priors: Vec<f64> = priors.map(|parameter| parameter.prior.unwrap_or(0.0)).collect();
    let with_numbers = |draws: &[f64]| {
        let origin = match seed {
            None => "the nominal ones".to_owned(),
            Some(seed) => format!("drawn from the priors with seed {seed}"),
        };
        let mut text = format!("{}{TRUE_NUMBERS}{origin}.\n[value]\n", text.trim_end());
        for (i, name) in names.iter().enumerate().filter(|(i, _)| vessel.value[*i].is_none()) {
            _ = writeln!(
                text,
                "\"{name}\" = {}",
                vessel.nominal[i] + priors.get(i).unwrap_or(&0.0) * draws[i]
            );
        }
        text
    };
    let Some(seed) = seed else { return Ok(with_numbers(&vec![0.0; names.len()])) };
    let mut last = Invalid::new("--seed", "no ship", "one that can be", "take another");
    for draw in 0..DRAWS {
        let mut draws = vec![0.0; names.len()];
        Streams::new(seed, "truth").normals(draw as u32, 0, &mut draws);
        let text = with_numbers(&draws);
        match parsed(&text).and_then(Vessel::from_file) {
            Ok(_) => return Ok(text),
            Err(why) => last = why,
        }
    }
    Err(last)
}
