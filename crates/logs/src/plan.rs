//! Which channels there are, what the vessel needs of them, and in which units.

use std::fmt::Display;

use refusal::{Invalid, nearest};
use ship::model::{DerivedChannel, Variable, Vessel};

use crate::gate::Limit;
use crate::prepare::MOST_ROWS;
use crate::{
    ChannelSpec, Content, Conventions, Derived, FileSpec, KINEMATIC, Propulsor, Setup, Stamps, UNITS, Unit,
    WantedColumn, factor, shaft_factor, unit,
};

/// How every recording is processed.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the logs were made.
    pub setup: Setup,
    /// Inputs and measured disturbances, then what the vessel derives from them.
    pub exogenous: Vec<Exogenous>,
    /// How the latter are computed, sample by sample, once all others are on one clock.
    pub derived: Vec<DerivedChannel>,
    /// Channels that may be absent at some samples: name and unit.
    pub further: Vec<(String, String)>,
    /// Units of the channels of every group of files.
    pub(crate) units: Vec<Vec<Unit>>,
    /// The allowed ranges of these channels.
    pub(crate) limits: Vec<Vec<Limit>>,
    /// How times in text are read, per group of files.
    stamps: Vec<Stamps>,
    provided: Vec<Provided>,
    /// Most rows of a file and of a recording.
    pub most_rows: usize,
    /// Bytes of memory for a recording.
    pub memory: f64,
}

/// An input or a measured disturbance.
#[derive(Clone, Debug, PartialEq)]
pub struct Exogenous {
    /// Its name.
    pub name: String,
    /// The unit of the trajectories.
    pub unit: String,
    /// The factor from the channel's unit to that one.
    pub factor: f64,
}

/// A channel that the setup provides.
#[derive(Clone, Debug)]
struct Provided {
    name: String,
    unit: String,
    optional: bool,
}

impl Provided {
    fn new(name: &str, unit: &str) -> Self {
        Self { name: name.to_owned(), unit: unit.to_owned(), optional: false }
    }
}

/// Values of a channel that are moved to the store at a time.
pub const BLOCK: usize = 1 << 16;

/// How many times the memory may go to the store: larger recordings would take hours and are refused, and a
/// small compressed file may hold any number of rows.
const MOST_ASIDE: f64 = 8.0;

/// Names of the trajectories' own columns.
const RESERVED: [&str; 9] = ["design", "run", "segment", "maneuver", "sample", "t", "u", "v", "r"];

impl Plan {
    /// Decides how the channels of `setup` are used. With a vessel (and its name in messages), its inputs and
    /// measured disturbances are needed; without one, all channels that are not optional.
    ///
    /// # Errors
    /// An unknown unit, a channel that is given twice, has an unusable name or another unit than needed, a
    /// source that nothing provides, and all channels at once that the vessel needs and nothing provides.
    pub fn new(mut setup: Setup, vessel: Option<(&Vessel, &str)>) -> Result<Self, Invalid> {
        let body = setup.conventions.body;
        setup.files = setup.files.into_iter().map(|file| file.with_angles(body)).collect();
        let stamps = setup.files.iter().map(|file| Stamps::new(&file.time)).collect::<Result<_, _>>()?;
        let units = setup.files.iter().map(|file| units(file, &setup.conventions));
        let units = units.collect::<Result<Vec<_>, _>>()?;
        let mut provided = measured(&setup, &units);
        computed(&setup, &mut provided)?;
        check_names(&provided)?;
        check_motion(&setup, &provided)?;
        let exogenous = match vessel {
            Some((vessel, called)) => {
                check_derived(&setup, vessel, called, &provided)?;
                of_vessel(vessel, called, setup.conventions.rate_hz, &provided)?
            }
            None => everything(&provided),
        };
        let further = further(&provided, &exogenous);
        let derived = vessel.map_or(Vec::new(), |(vessel, _)| vessel.model.derived.clone());
        let limits = limits(&setup, &units, vessel, &exogenous);
        Ok(Self {
            setup,
            exogenous,
            derived,
            further,
            units,
            limits,
            stamps,
            provided,
            most_rows: MOST_ROWS,
            memory: f64::INFINITY,
        })
    }

    /// The columns of a file of group `group`: time, its nanoseconds if they stand on their own, the channels, the parts of
    /// quaternions, and the labels if there are any.
    pub fn wanted(&self, group: usize) -> Vec<WantedColumn> {
        let file @ FileSpec { time, quaternion, label_column, .. } = &self.setup.files[group];
        let wanted = |column: &String, content| WantedColumn { column: column.clone(), content };
        let number = |column| wanted(column, Content::Numbers);
        let first = wanted(&time.column, if time.is_text() { Content::Dates } else { Content::Numbers });
        let channels = file.plain().iter().map(|channel| number(&channel.column));
        let quaternions = quaternion.iter().flat_map(|quaternion| quaternion.columns()).map(number);
        let labels = label_column.iter().map(|column| wanted(column, Content::Labels));
        [first]
            .into_iter()
            .chain(time.nanoseconds.iter().map(number))
            .chain(channels)
            .chain(quaternions)
            .chain(labels)
            .collect()
    }

    /// How times in text are read in files of group `group`.
    pub fn stamps(&self, group: usize) -> &Stamps {
        &self.stamps[group]
    }

    /// Limits recordings to `memory` bytes each, or where blocks of long ones can be stored, to `disk` bytes.
    #[must_use]
    pub fn within(mut self, memory: f64, disk: f64) -> Self {
        self.memory = memory;
        let fits = memory >= self.memory_of(usize::MAX);
        let bytes = if fits { disk.min(MOST_ASIDE * memory) } else { memory };
        let rows = bytes / self.row_bytes();
        self.most_rows = self.most_rows.min(rows as usize);
        self
    }

    /// Bytes of memory that a recording of `rows` rows takes at most: for a long one a few blocks of every
    /// channel, those being read, changed and written (97 MB were measured for 30 channels).
    pub fn memory_of(&self, rows: usize) -> f64 {
        const BLOCKS: f64 = 2.5;
        self.row_bytes() * (rows as f64).min(BLOCKS * BLOCK as f64)
    }

    /// Bytes that a row takes at most until it is in a table, in memory or in the store: every channel before
    /// and after conversion, and intermediate results of a few channels at a time.
    pub fn row_bytes(&self) -> f64 {
        const AT_A_TIME: usize = 16;
        8.0 * (2 * self.provided.len() + AT_A_TIME) as f64
    }

    /// The refusal of a file with `rows` rows.
    pub fn too_many_rows(&self, rows: impl Display) -> Invalid {
        Invalid::new(
            "rows",
            rows.to_string(),
            format!("at most {}, as many as memory and disk hold", self.most_rows),
            "cut the recording into shorter ones, raise --memory-mib, or write to a disk with more free space",
        )
    }

    /// Unit of a channel.
    pub(crate) fn unit_of(&self, name: &str) -> &str {
        let provided = self.provided.iter().find(|channel| channel.name == name);
        provided.map(|channel| channel.unit.as_str()).or_else(|| motion_unit(name)).unwrap_or_default()
    }
}

/// Unit of a channel of motion.
pub(crate) fn motion_unit(name: &str) -> Option<&'static str> {
    KINEMATIC.into_iter().find(|(known, _)| *known == name).map(|(_, unit)| unit)
}

/// The units of a file's channels. What is a thruster's speed, or is summed in revolutions, converts to them.
fn units(file: &FileSpec, conventions: &Conventions) -> Result<Vec<Unit>, Invalid> {
    let mut units: Vec<Unit> = file.channel.iter().map(known_unit).collect::<Result<_, _>>()?;
    for (spec, unit) in file.channel.iter().zip(&mut units) {
        let is_speed = conventions.thrusters.iter().any(|thruster| thruster.speed == spec.channel);
        let mut sums = conventions.derived.iter().filter(|derived| derived.formula.is_sum_of_channels());
        let is_summed =
            sums.any(|derived| derived.unit == "1/s" && derived.formula.channels.contains(&spec.channel));
        if let Some(factor) = shaft_factor(unit.name, "1/s").filter(|_| is_speed || is_summed) {
            *unit = Unit { si: "1/s", factor, ..*unit };
        }
    }
    for (spec, unit) in file.channel.iter().zip(&units) {
        if let Some(expected) = motion_unit(&spec.channel).filter(|expected| *expected != unit.si) {
            let expected = format!("a unit that converts to {expected}");
            return Err(wrong_unit(&spec.channel, &spec.unit, expected, "correct the unit or the channel"));
        }
    }
    Ok(units)
}

fn known_unit(spec: &ChannelSpec) -> Result<Unit, Invalid> {
    let names = || UNITS.iter().map(|unit| unit.name);
    unit(&spec.unit).copied().ok_or_else(|| {
        Invalid::new(
            format!("unit `{}`", spec.unit),
            "not a known unit",
            names().collect::<Vec<_>>().join(", "),
            format!(
                "did you mean `{}`? (or use \"1\" with a `scale`)",
                nearest(&spec.unit, names()).unwrap_or_default()
            ),
        )
    })
}

/// The allowed ranges of all channels; for the vessel's inputs those that it declares.
fn limits(
    setup: &Setup,
    units: &[Vec<Unit>],
    vessel: Option<(&Vessel, &str)>,
    exogenous: &[Exogenous],
) -> Vec<Vec<Limit>> {
    let range = |channel: &str| {
        let (vessel, called) = vessel?;
        let (input, actuator) =
            exogenous.iter().zip(&vessel.actuators).find(|(input, _)| input.name == channel)?;
        Some((actuator.range?.map(|end| end / input.factor), called))
    };
    let of = |(spec, unit): (&ChannelSpec, &Unit)| {
        Limit::new(spec, unit, range(&spec.channel), setup.max_speed_m_s)
    };
    let group = |(file, units): (&FileSpec, &Vec<Unit>)| file.channel.iter().zip(units).map(of).collect();
    setup.files.iter().zip(units).map(group).collect()
}

fn wrong_unit(channel: &str, unit: &str, expected: String, remedy: &str) -> Invalid {
    Invalid::new(format!("unit of channel `{channel}`"), format!("`{unit}`"), expected, remedy)
}

fn measured(setup: &Setup, units: &[Vec<Unit>]) -> Vec<Provided> {
    let of = |file: &FileSpec, spec: &ChannelSpec, unit: &Unit| Provided {
        optional: file.optional || spec.optional,
        ..Provided::new(&spec.channel, unit.si)
    };
    let group = |(file, units): (&FileSpec, &Vec<Unit>)| -> Vec<Provided> {
        file.channel.iter().zip(units).map(|(spec, unit)| of(file, spec, unit)).collect()
    };
    setup.files.iter().zip(units).flat_map(group).collect()
}

/// Adds derived channels and the forces of thrusters; their sources must be there.
fn computed(setup: &Setup, provided: &mut Vec<Provided>) -> Result<(), Invalid> {
    let Conventions { derived, thrusters, .. } = &setup.conventions;
    for Derived { channel, formula, unit } in derived {
        formula.channels.iter().try_for_each(|source| check_source(channel, source, provided))?;
        if formula.is_sum_of_channels() {
            formula.channels.iter().try_for_each(|source| check_summand(channel, source, unit, provided))?;
        }
        provided.push(Provided::new(channel, unit));
    }
    for Propulsor { speed, angle, table, .. } in thrusters {
        let pitch = table.iter().filter_map(|(_, pitch)| pitch.as_ref());
        let units = [(speed, Some("1/s"))].into_iter().chain(angle.iter().map(|angle| (angle, Some("rad"))));
        for (source, unit) in units.chain(pitch.map(|pitch| (pitch, None))) {
            check_source("tau1", source, provided)?;
            unit.map_or(Ok(()), |unit| check_thruster_unit(source, unit, provided))?;
        }
    }
    if !thrusters.is_empty() {
        let forces = [("tau1", "N"), ("tau2", "N"), ("tau3", "N m")];
        provided.extend(forces.map(|(name, unit)| Provided::new(name, unit)));
    }
    Ok(())
}

/// Refuses a sum in `sum_unit` of a `source` that measures something else, or that is not converted to it.
fn check_summand(of: &str, source: &str, sum_unit: &str, provided: &[Provided]) -> Result<(), Invalid> {
    let summand =
        provided.iter().find(|channel| channel.name == source).and_then(|channel| unit(&channel.unit));
    match summand.filter(|summand| unit(sum_unit).is_some() && factor(summand.name, sum_unit) != Some(1.0)) {
        Some(summand) => {
            let units = format!("`{sum_unit}` for a sum of `{source}` in {}", summand.name);
            let expected = "the unit of all that is summed, in SI units, radians or 1/s";
            Err(Invalid::new(format!("unit of channel `{of}`"), units, expected, "correct one of the units"))
        }
        None => Ok(()),
    }
}

/// Refuses a thruster's channel `source` that is not in `unit`: the force is defined in N per unit of its speed.
fn check_thruster_unit(source: &str, unit: &str, provided: &[Provided]) -> Result<(), Invalid> {
    match provided.iter().find(|channel| channel.name == source && factor(&channel.unit, unit).is_none()) {
        Some(other) => {
            let expected = format!("a unit that converts to {unit}, for a thruster's speed or angle");
            Err(wrong_unit(source, &other.unit, expected, "correct the unit, or name the thruster's channel"))
        }
        None => Ok(()),
    }
}

fn names(provided: &[Provided]) -> Vec<&str> {
    provided.iter().map(|channel| channel.name.as_str()).collect()
}

fn check_source(of: &str, source: &str, provided: &[Provided]) -> Result<(), Invalid> {
    let known = names(provided);
    if known.contains(&source) && !source.ends_with("_deg") {
        return Ok(());
    }
    let name = format!("`{source}`, which nothing before it provides");
    let expected = format!("one of {}", known.join(", "));
    let unknown = Invalid::unknown(format!("source of channel `{of}`"), source, known);
    Err(Invalid { found: name, expected, ..unknown })
}

fn check_names(provided: &[Provided]) -> Result<(), Invalid> {
    for (i, channel) in provided.iter().enumerate() {
        let name = channel.name.as_str();
        let plain = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        let defect = if provided[..i].iter().any(|other| other.name == name) {
            "given twice"
        } else if !plain || RESERVED.contains(&name) {
            "a name that is taken or not a plain one"
        } else {
            continue;
        };
        let expected = "letters, digits and _, each name once, no column of the trajectories";
        let remedy = match name {
            "u" | "v" | "r" => format!("measured states are called y_{name}"),
            _ => "rename it".to_owned(),
        };
        return Err(Invalid::new(format!("channel `{name}`"), defect, expected, remedy));
    }
    Ok(())
}

/// Whether surge, sway and yaw rate are measured or follow from positions.
fn check_motion(setup: &Setup, provided: &[Provided]) -> Result<(), Invalid> {
    let has = |name: &str| provided.iter().any(|channel| channel.name == name);
    let places = [["x", "y"], ["latitude_deg", "longitude_deg"]].map(|pair| pair.map(has));
    if places[0].contains(&true) && places[1].contains(&true) {
        let both = "both x, y and latitude_deg, longitude_deg";
        return Err(Invalid::new("position", both, "one of the two", "remove one"));
    }
    let placed = places.contains(&[true; 2]);
    if !placed && places.as_flattened().contains(&true) {
        let expected = "x and y, or latitude_deg and longitude_deg";
        return Err(Invalid::new("position", "one coordinate", expected, "add the other"));
    }
    let along = ["v_x", "v_y"].map(has);
    if along.contains(&true) && (along != [true; 2] || !has("psi") || has("y_u") || has("y_v")) {
        let velocities = "`v_x` or `v_y` without the other, without `psi`, or together with `y_u` or `y_v`";
        let expected = "both, and a heading to rotate them by";
        return Err(Invalid::new("velocities", velocities, expected, "add what is missing, or remove them"));
    }
    let turned = along == [true; 2] || placed && has("psi");
    let mut lacking: Vec<&str> = ["y_u", "y_v"].into_iter().filter(|name| !(has(name) || turned)).collect();
    lacking.extend(["y_r"].into_iter().filter(|name| !has(name) && !has("psi")));
    if !lacking.is_empty() {
        let expected = "y_u, y_v, y_r, or x, y (or latitude_deg, longitude_deg) and psi to make them from";
        let remedy = "add a [[file.channel]] for each";
        return Err(Invalid::new("channels", nothing_provides(&lacking), expected, remedy));
    }
    if placed && !has("psi") && !setup.conventions.lever.is_zero() {
        let remedy = "add psi or remove the positions";
        return Err(Invalid::new(
            "`antenna_m`",
            "positions without psi",
            "a heading to rotate it by",
            remedy,
        ));
    }
    Ok(())
}

fn nothing_provides(channels: &[&str]) -> String {
    format!("nothing that provides `{}`", channels.join("`, `"))
}

/// The inputs and measured disturbances of the vessel, whose name in messages is `called`.
fn of_vessel(
    vessel: &Vessel,
    called: &str,
    rate_hz: f64,
    provided: &[Provided],
) -> Result<Vec<Exogenous>, Invalid> {
    if (vessel.sample_rate_hz / rate_hz - 1.0).abs() > 1e-9 {
        let expected = format!("{} Hz, which the parameters in {called} hold for", vessel.sample_rate_hz);
        return Err(Invalid::new("`sample_rate_hz`", format!("{rate_hz} Hz"), expected, "make them equal"));
    }
    let logged = vessel.model.variables.len() - vessel.model.derived.len();
    let (needed, derived) = vessel.model.variables[3..].split_at(logged - 3);
    let find = |name: &str| provided.iter().find(|channel| channel.name == name);
    let missing: Vec<&str> =
        needed.iter().map(|v| v.name.as_str()).filter(|name| find(name).is_none()).collect();
    if !missing.is_empty() {
        return Err(Invalid::new(
            "channels",
            format!("{}, which {called} needs", nothing_provides(&missing)),
            format!("channels among {}", names(provided).join(", ")),
            missing.iter().map(|name| add_channel(name, provided)).collect::<Vec<_>>().join(" "),
        ));
    }
    let known = needed.iter().filter_map(|variable| Some((variable, find(&variable.name)?)));
    let made = derived
        .iter()
        .map(|Variable { name, unit }| Ok(Exogenous { name: name.clone(), unit: unit.clone(), factor: 1.0 }));
    known
        .map(|(Variable { name, unit, .. }, channel)| match shaft_factor(&channel.unit, unit) {
            Some(factor) => Ok(Exogenous { name: name.clone(), unit: unit.clone(), factor }),
            None => {
                let expected = format!("`{unit}`, as declared in {called}");
                Err(wrong_unit(name, &channel.unit, expected, "correct one of them"))
            }
        })
        .chain(made)
        .collect()
}

/// Refuses a channel that both the logs provide and the vessel derives, unless they are the same: one of them
/// would be ignored.
fn check_derived(setup: &Setup, vessel: &Vessel, called: &str, provided: &[Provided]) -> Result<(), Invalid> {
    for derivation in &vessel.model.derived {
        let Variable { name, unit } = &vessel.model.variables[derivation.variable];
        let Some(channel) = provided.iter().find(|channel| channel.name == *name) else { continue };
        let expected = format!("`{}` in {unit}, which {called} derives", derivation.text);
        let same = setup.conventions.derived.iter().find(|derived| derived.channel == *name);
        let other = match same {
            Some(derived) if derived.formula == derivation.formula && derived.unit == *unit => continue,
            Some(derived) if derived.formula == derivation.formula => format!("the same in {}", derived.unit),
            Some(_) => "another formula".to_owned(),
            None => format!("a logged channel in {}", channel.unit),
        };
        let remedy =
            format!("remove it from the configuration: {called} already declares it; or rename one of them");
        return Err(Invalid::new(format!("channel `{name}`"), other, expected, remedy));
    }
    Ok(())
}

fn add_channel(name: &str, provided: &[Provided]) -> String {
    let others = names(provided).into_iter().filter(|other| motion_unit(other).is_none());
    match nearest(name, others).filter(|near| near.starts_with(|letter| name.starts_with(letter))) {
        Some(near) => format!("did you mean `{name}` by `{near}`?"),
        None => format!("add a [[file.channel]] for `{name}`"),
    }
}

/// All channels but those of motion and the optional ones.
fn everything(provided: &[Provided]) -> Vec<Exogenous> {
    let needed = provided.iter().filter(|c| !c.optional && motion_unit(&c.name).is_none());
    needed.map(|c| Exogenous { name: c.name.clone(), unit: c.unit.clone(), factor: 1.0 }).collect()
}

/// The other known channels: position, heading, channels that are not needed.
fn further(provided: &[Provided], exogenous: &[Exogenous]) -> Vec<(String, String)> {
    let has = |name: &str| provided.iter().any(|channel| channel.name == name);
    let placed = has("x") || has("latitude_deg");
    let pose = [("x", "m", placed), ("y", "m", placed), ("psi", "rad", has("psi"))];
    let pose = pose
        .into_iter()
        .filter(|(_, _, known)| *known)
        .map(|(name, unit, _)| (name.to_owned(), unit.to_owned()));
    let other = |channel: &&Provided| {
        motion_unit(&channel.name).is_none() && exogenous.iter().all(|known| known.name != channel.name)
    };
    pose.chain(provided.iter().filter(other).map(|c| (c.name.clone(), c.unit.clone()))).collect()
}
