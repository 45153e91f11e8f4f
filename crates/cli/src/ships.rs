//! `new`: the files of a study, also of a ship before her first trial: a similar one of another size, or one of main dimensions.

use std::path::{Path, PathBuf};

use clap::Parser;
use files::{Staged, commit, parse_toml, read_hand_written, whole_folder};
use refusal::Invalid;
use schemars::JsonSchema;
use serde::Deserialize;
use serde::de::DeserializeOwned;
use serde_json::json;
use ship::forces::{GRAVITY, MainDimensions, usual_froude};
use ship::model::{InputSpec, Vessel, VesselFile};
use study::plan::second;
use study::ship_file::{Notes, ShipFile, read_ship, vessel_text};

use crate::cli::{Common, folder_of};
use crate::failure::Failure;
use crate::pipeline::starting::{Charted, PRESETS, Preset, measured, of_ship, schemas, simulated};
use crate::stage::{Summary, Task};

/// A `vessel.toml` and what to say about it.
#[derive(Clone, Debug)]
pub struct Written {
    /// The file.
    pub text: String,
    /// One line.
    pub said: String,
}

/// Rudder angle to either side \[rad\]: 35°.
const RUDDER: f64 = 0.6109;
/// Rate of the rudder \[rad/s\]: 65° in 28 s, as SOLAS asks for.
const RUDDER_RATE: f64 = 0.0405;
/// Length of the ships whose rudder has that rate \[m\]; those of shorter ones are faster, as those of models are.
const FULL_SCALE_M: f64 = 100.0;
/// Samples per length sailed, at least.
const SAMPLES: f64 = 20.0;
/// Highest revolutions over those that hold the speed.
const MOST_REVOLUTIONS: f64 = 1.3;
/// Proportions of the ships that the formulas were made for: name, and between which they are.
const USUAL: [(&str, [f64; 2]); 3] =
    [("length over beam", [5.0, 8.5]), ("beam over draught", [2.0, 4.5]), ("block coefficient", [0.5, 0.87])];

/// A ship of these dimensions, with a prior for every free number and the source of each number as a comment.
pub fn guessed(ship: &MainDimensions) -> Result<Written, Invalid> {
    let guess = ship.guess()?;
    let speed = guess.description.ship.speed_m_s;
    let revolutions = guess.revolutions;
    let mut unusual = unusual(ship, speed);
    let file = VesselFile {
        name: Some(format!("Guessed ship of {} m", ship.length_m)),
        sample_rate_hz: Some(rate(speed / ship.length_m)),
        input: inputs(ship, revolutions),
        ..VesselFile::of_forces(guess.description)
    };
    // Her dimensions were given: what is unusual of them is said, and passes.
    let (file, other) = file.accepting_unusual()?;
    unusual.extend(other.map(|proportion| format!("{}: {}", proportion.thing, proportion.found)));
    let vessel = Vessel::from_file(file.clone())?;
    let numbers = guess.sources.into_iter().map(|(name, source)| (name, source.to_owned())).collect();
    let notes = Notes { head: head(ship, revolutions, &unusual), numbers };
    let mut said =
        format!("{speed:.4} m/s at {revolutions:.4} 1/s, {} free numbers with priors", vessel.nominal.len());
    if !unusual.is_empty() {
        said += &format!("; beyond the usual ships of the formulas: {}", unusual.join(", "));
    }
    Ok(Written { text: vessel_text(&file, &notes)?, said })
}

/// The lowest usual rate \[Hz\] with enough samples per length, where a second has `lengths` of them.
fn rate(lengths: f64) -> f64 {
    let decades = [0.1, 1.0, 10.0, 100.0].into_iter().flat_map(|decade| [decade, 2.0 * decade, 5.0 * decade]);
    decades.clone().find(|rate| *rate >= SAMPLES * lengths).unwrap_or(500.0)
}

fn inputs(ship: &MainDimensions, revolutions: f64) -> Vec<InputSpec> {
    let faster = (FULL_SCALE_M / ship.length_m).max(1.0).sqrt();
    let rate = ship.rudder_rate_deg_s.map_or(RUDDER_RATE * faster, f64::to_radians);
    let rudder = InputSpec {
        name: "delta".to_owned(),
        unit: "rad".to_owned(),
        range: Some([-RUDDER, RUDDER]),
        rate_per_s: Some(digits(rate)),
        ..InputSpec::default()
    };
    let propeller = InputSpec {
        name: "n".to_owned(),
        unit: "1/s".to_owned(),
        range: Some([0.0, digits(MOST_REVOLUTIONS * revolutions)]),
        ..InputSpec::default()
    };
    vec![rudder, propeller]
}

/// With four digits.
fn digits(number: f64) -> f64 {
    format!("{number:.3e}").parse().unwrap_or(number)
}

/// Proportions that are none of the usual ships, with their values.
fn unusual(ship: &MainDimensions, speed: f64) -> Vec<String> {
    let froude = speed / (GRAVITY * ship.length_m).sqrt();
    let most = usual_froude(ship.block);
    let fast = (froude > most)
        .then(|| format!("Froude number {froude:.2} (at most {most:.2} at this block coefficient)"));
    let values = [ship.length_m / ship.beam_m, ship.beam_m / ship.draught_m, ship.block];
    let all = USUAL.into_iter().zip(values);
    all.filter(|((_, [low, high]), value)| !(*low..=*high).contains(value))
        .map(|((name, [low, high]), value)| format!("{name} {value:.3} ({low} to {high})"))
        .chain(fast)
        .collect()
}

fn head(ship: &MainDimensions, revolutions: f64, unusual: &[String]) -> Vec<String> {
    let MainDimensions { length_m, beam_m, draught_m, block, .. } = ship;
    let mut all = vec![
        format!(
            "A ship of {length_m} m, beam {beam_m} m, draught {draught_m} m, block coefficient {block}, from textbook \
             formulas. Nothing in it was measured."
        ),
        "`prior` is the standard deviation of what is known: two of them to either side are the 95 % interval. Numbers \
         without one are not fitted, because free runs know forces over masses alone. Replace what you know better."
            .to_owned(),
        format!("She holds her speed at n = {revolutions:.4} revolutions per second."),
    ];
    if !unusual.is_empty() {
        all.push(format!("Beyond the usual ships that the formulas were made for: {}.", unusual.join(", ")));
    }
    all
}

/// The file of a ship.
const VESSEL: &str = "vessel.toml";

/// Writes the commented files of a new study: of a ship that is known, or of your logs
#[derive(Parser)]
#[command(name = "new", after_help = help())]
pub struct NewArguments {
    /// Folder of the study; made here
    #[arg(value_name = "FOLDER")]
    out: PathBuf,
    /// The ship to begin with: a preset, or a vessel.toml with forces
    #[arg(long, value_name = "PRESET|vessel.toml", required_unless_present_any = ["guess", "logs"])]
    vessel: Option<String>,
    /// A ship from her main dimensions, by textbook formulas, with a prior for every free parameter: length_m, beam_m, draught_m
    /// and block; if known, also density_kg_m3, speed_m_s, mass_kg, propeller_diameter_m, rudder_area_m2, rudder_height_m,
    /// rudder_rate_deg_s, x_g_m
    #[arg(long, value_name = "KEY=VALUE,…", conflicts_with = "vessel")]
    guess: Option<String>,
    /// The ship geometrically similar to --vessel, a preset, file or fitted model with forces: length_m, and density_kg_m3 of
    /// her water; draught_m, if given, is compared
    #[arg(long, value_name = "KEY=VALUE,…", requires = "vessel")]
    scale: Option<String>,
    /// Folder of logs, of the ship that the others name or of one that is not known: what is in them is found by how it moves,
    /// and what was guessed is marked
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// A chart, or the folder of an exchange set: the trial is planned on it
    #[arg(long, value_name = "PATH", requires = "place")]
    chart: Option<PathBuf>,
    /// Where the trial is to be, such as 24.97,60.12
    #[arg(long, value_name = "LONGITUDE,LATITUDE", requires = "chart", allow_hyphen_values = true, value_parser = place)]
    place: Option<[f64; 2]>,
    /// When it may be, such as 2026-06-01T08:00:00Z/2026-06-01T18:00:00Z
    #[arg(long, value_name = "FROM/UNTIL", requires = "chart", value_parser = slot)]
    slot: Option<[String; 2]>,
}

/// Two times.
fn slot(text: &str) -> Result<[String; 2], String> {
    let expected = || {
        "expected FROM/UNTIL, the earlier time first, such as 2026-06-01T08:00:00Z/2026-06-01T18:00:00Z"
            .to_owned()
    };
    let (from, until) = text.split_once('/').ok_or_else(expected)?;
    let [at, end] = [from, until].map(|time| second("--slot", time));
    let is_in_order = at.and_then(|at| Ok(at < end?)).map_err(|_| expected())?;
    is_in_order.then(|| [from.to_owned(), until.to_owned()]).ok_or_else(expected)
}

/// A longitude and a latitude \[deg\].
fn place(text: &str) -> Result<[f64; 2], String> {
    let parts = text
        .split_once(',')
        .and_then(|(lon, lat)| Some([lon.trim().parse().ok()?, lat.trim().parse().ok()?]));
    parts.ok_or_else(|| "expected LONGITUDE,LATITUDE in degrees, such as 24.97,60.12".to_owned())
}

/// The presets and an example.
fn help() -> String {
    let presets = PRESETS.iter().map(|preset| format!("{}: {}\n", preset.name, preset.about));
    format!(
        "Presets:\n{}\nExample:\n  new my-study --vessel model-ship\n  \
        new my-tanker --guess length_m=320,beam_m=58,draught_m=20.8,block=0.81,speed_m_s=7.97\n  \
        new my-tanker --vessel kvlcc2-l7 --scale length_m=320,density_kg_m3=1025",
        presets.collect::<String>()
    )
}

impl Task for NewArguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = &common.out;
        if out.symlink_metadata().is_ok() {
            let remedy = "name another, or run this one";
            return Err(Failure::refuse(out, "folder", "it there already", "a new folder", remedy));
        }
        let slot = self.slot.as_ref();
        let charted =
            self.chart.as_deref().zip(self.place).map(|(file, place)| Charted { file, place, slot });
        let name = out.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        let written = self.written(common)?;
        let of_file;
        let preset = match (&written, &self.vessel) {
            (Some((written, named)), _) => {
                of_file = of_ship(named, &written.text, common.seed)?;
                Some(&of_file)
            }
            (None, None) => None,
            (None, Some(vessel)) if Path::new(vessel).is_file() => {
                let file = Path::new(vessel);
                of_file = of_ship(file, &read_hand_written(file)?, common.seed)?;
                Some(&of_file)
            }
            (None, Some(name)) => {
                let unknown = |e| Failure::Usage(format!("--vessel: {e}, or a vessel.toml"));
                Some(Preset::named(name).map_err(unknown)?)
            }
        };
        let (files, mut said) = match (&self.logs, preset) {
            (Some(logs), preset) => {
                let (files, looked) = measured(preset, logs, charted.as_ref(), common.quiet)?;
                let (guessed, missing) = (looked.guessed(), looked.missing().len());
                let half = looked.half_a_wind().map(|[channel, what]| {
                    format!("; `{channel}` is not used: no {what} of the wind was found")
                });
                let logs = looked.files.len();
                let said = format!("; {logs} logs, {guessed} lines guessed, {missing} channels missing");
                (files, said + &half.unwrap_or_default())
            }
            (None, Some(preset)) => (simulated(preset, &name, charted.as_ref())?, String::new()),
            (None, None) => {
                return Err(Failure::Usage(
                    "--vessel: found none, expected a ship; name a preset".to_owned(),
                ));
            }
        };
        if let Some((written, _)) = &written {
            said += &format!("; {}", written.said);
        }
        let schemas = schemas();
        std::fs::create_dir_all(folder_of(out)).map_err(|e| files::Error::io(out, "create", e))?;
        let has_next = files.iter().any(|(name, _)| name.starts_with("next/"));
        let within: &[&str] = if has_next { &["schemas", "next"] } else { &["schemas"] };
        whole_folder(out, within, |folder| {
            // One by one: this process holds the folder, which a set would wait for.
            let mut all = files.iter().chain(&schemas);
            all.try_for_each(|(name, text)| commit(vec![Staged::bytes(folder.join(name), text.as_bytes())?]))
        })?;
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        let next = match names.as_slice() {
            [VESSEL] => "write dictionary.toml and campaign.toml, as a preset has them".to_owned(),
            _ => format!("seatrial run {}", out.display()),
        };
        let line = format!("{}{said}; next: {next}", names.join(", "));
        Ok(Summary::of(out, line, json!({"files": names})))
    }
}

impl NewArguments {
    /// The ship of --guess or of --scale, if one is asked for, and what to call where she comes from.
    fn written(&self, common: &Common) -> Result<Option<(Written, PathBuf)>, Failure> {
        if let Some(given) = &self.guess {
            let ship = keyed::<MainDimensions>("--guess", given)?;
            let written = guessed(&ship).map_err(|e| Failure::Usage(format!("--guess: {e}")))?;
            return Ok(Some((written, PathBuf::from("--guess"))));
        }
        let Some((given, vessel)) = self.scale.as_ref().zip(self.vessel.as_ref()) else { return Ok(None) };
        let size = keyed::<Size>("--scale", given)?;
        let vessel = PathBuf::from(vessel);
        let ship = read_ship(&vessel, &mut common.provenance("new"))?;
        let written = scaled(&ship, &size).map_err(|e| Failure::invalid(&vessel, &e))?;
        Ok(Some((written, vessel)))
    }
}

/// The keys and values of `flag`, with commas between them.
fn keyed<T: DeserializeOwned + JsonSchema>(flag: &str, given: &str) -> Result<T, Failure> {
    parse_toml(&given.replace(',', "\n"), flag).map_err(|e| Failure::Usage(e.to_string()))
}

/// Standard deviation of a prior from a fit, at least, over that with which the fit was made: a sister's fit as prior
/// predicts best with about this weight.
const FLOOR: f64 = 0.3;
/// The largest share by which the similar draught may differ from the stated one.
const ROUNDING: f64 = 0.005;

/// The size of a similar ship.
#[derive(Clone, Copy, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Size {
    /// Length \[m\].
    pub length_m: f64,
    /// Density of her water \[kg/m³\]; that of the first ship's without it.
    pub density_kg_m3: Option<f64>,
    /// Draught \[m\], if one is expected.
    pub draught_m: Option<f64>,
}

/// The ship similar to `ship`, of another size.
pub fn scaled(ship: &ShipFile, size: &Size) -> Result<Written, Invalid> {
    let fitted = ship.fitted.is_some();
    let file = ship.file.clone().completed()?;
    let file = if fitted { file.without_truth()? } else { file };
    let own_length = file.ship.as_ref().map_or(0.0, |ship| ship.length_m);
    let deviations = deviations(ship, &file)?;
    let (file, usual) = file.with_usual_priors(&deviations)?;
    let mut file = file.similar(size.length_m, size.density_kg_m3)?;
    check_form(&file, size)?;
    let name = named(file.name.as_deref().unwrap_or_default(), size.length_m);
    file.name = Some(name.clone());
    let rate = file.sample_rate_hz.unwrap_or_default();
    let speed = file.ship.as_ref().map_or(0.0, |ship| ship.speed_m_s);
    let mut notes = Notes { head: head_of_scaled(&name, own_length, fitted), ..Notes::default() };
    notes.head.extend(usual_priors(&usual));
    file.fitted = false;
    let (file, unusual) = file.accepting_unusual()?;
    let mut said = format!("{name}: {speed:.4} m/s, {rate:.4} Hz, {} usual priors", usual.len());
    if let Some(unusual) = unusual {
        said += &format!("; unusual: {}: {}", unusual.thing, unusual.found);
        notes.head.push(format!("Unusual of ships: {}: {}.", unusual.thing, unusual.found));
    }
    Ok(Written { text: vessel_text(&file, &notes)?, said })
}

/// Standard deviations of priors from a fit: its standard errors, not below a share of its priors.
fn deviations(ship: &ShipFile, file: &VesselFile) -> Result<Vec<(String, f64)>, Invalid> {
    let Some(fitted) = &ship.fitted else { return Ok(Vec::new()) };
    let (with, _) = file.clone().with_usual_priors(&[])?;
    let vessel = Vessel::from_file(with)?;
    let Some(model) = &vessel.model.forces else { return Ok(Vec::new()) };
    let known = model.forces.parameters().iter();
    let one = |parameter: &study::documents::FittedParameter| {
        let prior = known.clone().find(|known| known.name == parameter.name).and_then(|known| known.prior)?;
        let deviation = parameter.standard_error.map_or(prior, |error| error.max(FLOOR * prior));
        Some((parameter.name.clone(), deviation))
    };
    Ok(fitted.iter().filter_map(one).collect())
}

/// Refuses a draught of another hull form.
fn check_form(file: &VesselFile, size: &Size) -> Result<(), Invalid> {
    let similar = file.ship.as_ref().map_or(0.0, |ship| ship.draught_m);
    match size.draught_m {
        Some(draught) if ((draught - similar) / similar).abs() > ROUNDING || !draught.is_finite() => {
            let expected = format!("{similar:.4} m: a similar ship has the same hull form");
            let remedy = "leave it out, or take a ship of these dimensions by --guess";
            Err(Invalid::new("the draught", format!("{draught} m"), expected, remedy))
        }
        _ => Ok(()),
    }
}

/// The name of a similar ship.
fn named(name: &str, length_m: f64) -> String {
    let plain = match name.rsplit_once(" at ") {
        Some((plain, size)) if size.strip_suffix(" m").is_some_and(|size| size.parse::<f64>().is_ok()) => {
            plain
        }
        _ => name,
    };
    format!("{plain} at {length_m} m")
}

fn head_of_scaled(name: &str, own_length: f64, fitted: bool) -> Vec<String> {
    let origin = if fitted { "of which a model was fitted" } else { "that this file was written from" };
    let mut all = vec![
        format!("{name}: geometrically similar to the ship of {own_length} m {origin}, at the same Froude number."),
        "Numbers of the prime system, angles and pure numbers are hers. Speeds and times are scaled by the root of the \
         length, revolutions by its inverse, areas by its square, masses and forces by its cube. The sampling rate has as \
         many samples per length sailed; any other is right, too."
            .to_owned(),
        "Friction is not similar: in the prime system the longer ship has less resistance, and a weaker wake.".to_owned(),
    ];
    if fitted {
        all.push(format!(
            "Priors: the standard error of the fit, at least {FLOOR} of the standard deviation that it began with."
        ));
    }
    all
}

/// Which priors are none of the first ship's.
fn usual_priors(usual: &[String]) -> Option<String> {
    let names = usual.join(", ");
    (!usual.is_empty())
        .then(|| format!("Priors that are usual of such numbers, and not this ship's own: {names}."))
}
