//! Which channels there are, what the vessel needs of them, and in which units.

use thiserror::Error;
use vessel::Vessel;

use crate::{ChannelSpec, Conventions, Derived, Group, KINEMATIC, Recipe, Setup, Unit, Wanted, factor, unit};

/// What is made of every recording.
#[derive(Clone, Debug)]
pub struct Plan {
    /// How the logs were made.
    pub setup: Setup,
    /// How channels become trajectories.
    pub recipe: Recipe,
    /// Inputs and measured disturbances, as in [`Recipe::exogenous`].
    pub exogenous: Vec<Exogenous>,
    /// Channels that may be absent, as in [`Recipe::further`]: name and unit.
    pub further: Vec<(String, String)>,
    /// Units of the channels of every group of files.
    pub(crate) units: Vec<Vec<Unit>>,
    provided: Vec<Provided>,
}

/// An input or a measured disturbance.
#[derive(Clone, Debug, PartialEq)]
pub struct Exogenous {
    /// Its name.
    pub name: String,
    /// The unit that the trajectories have it in.
    pub unit: String,
    /// What a channel's value is multiplied by to be in that unit.
    pub factor: f64,
}

/// Why channels do not become trajectories.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum ChannelError {
    /// A unit that is not in [`crate::UNITS`].
    #[error("unknown unit `{0}`")]
    UnknownUnit(String),
    /// A channel of motion in a unit of something else.
    #[error("channel `{channel}` is in `{unit}`, which does not convert to {expected}")]
    Unit {
        /// The channel.
        channel: String,
        /// Its unit.
        unit: String,
        /// The unit of the motion.
        expected: &'static str,
    },
    /// A source that nothing before it provides.
    #[error("channel `{of}` is computed from `{source_channel}`, which nothing before it provides")]
    NoSource {
        /// The computed channel.
        of: String,
        /// Its source.
        source_channel: String,
        /// What is provided.
        known: Vec<String>,
    },
    /// A name that is given twice.
    #[error("channel `{0}` is given twice")]
    Twice(String),
    /// A name that is no plain word, or that of another column of trajectories.
    #[error("channel `{0}` has a name that is taken or no plain name")]
    Name(String),
    /// Both kinds of positions.
    #[error("both x, y and latitude_deg, longitude_deg")]
    TwoPositions,
    /// One coordinate of two.
    #[error("a position with one coordinate")]
    OneCoordinate,
    /// Velocities that are neither measured nor follow from positions.
    #[error("nothing that provides `{}`", .0.join("`, `"))]
    NoMotion(Vec<&'static str>),
    /// An antenna off the reference point, and no heading to turn its place by.
    #[error("positions of an antenna without a heading")]
    NoHeading,
    /// Another rate than the vessel's parameters hold for.
    #[error("a rate of {found} Hz for a model at {expected} Hz")]
    Rate {
        /// That of the trajectories \[Hz\].
        found: f64,
        /// That of the vessel \[Hz\].
        expected: f64,
    },
    /// Channels that the vessel needs and nothing provides.
    #[error("nothing that provides `{}`", missing.join("`, `"))]
    Missing {
        /// The channels.
        missing: Vec<String>,
        /// What is provided.
        provided: Vec<String>,
    },
    /// A channel whose unit does not convert to the vessel's.
    #[error("channel `{channel}` is in `{unit}`, which does not convert to `{expected}`")]
    VesselUnit {
        /// The channel.
        channel: String,
        /// Its unit.
        unit: String,
        /// The vessel's.
        expected: String,
    },
}

/// A channel that something provides.
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

/// Names that columns of the trajectories have already.
const RESERVED: [&str; 9] = ["design", "run", "segment", "maneuver", "sample", "t", "u", "v", "r"];

impl Plan {
    /// Decides what becomes of the channels of `setup`; with a vessel, its inputs and measured disturbances are needed,
    /// without one all channels that are not optional.
    ///
    /// # Errors
    /// An unknown unit, a channel that is given twice or has no usable name or another unit than needed, a source that nothing provides, and all channels that the vessel needs and nothing provides at once.
    pub fn new(setup: Setup, vessel: Option<&Vessel>) -> Result<Self, ChannelError> {
        let units = setup.groups.iter().map(units).collect::<Result<Vec<_>, _>>()?;
        let mut provided = measured(&setup, &units);
        computed(&setup, &mut provided)?;
        check_names(&provided)?;
        check_motion(&setup, &provided)?;
        let exogenous = match vessel {
            Some(vessel) => of_vessel(vessel, setup.rate_hz, &provided)?,
            None => everything(&provided),
        };
        let further = further(&provided, &exogenous);
        let recipe = Recipe {
            conventions: setup.conventions.clone(),
            method: setup.method,
            rate_hz: setup.rate_hz,
            average_s: setup.average_s,
            exogenous: exogenous.iter().map(|channel| channel.name.clone()).collect(),
            further: further.iter().map(|(name, _)| name.clone()).collect(),
        };
        Ok(Self { setup, recipe, exogenous, further, units, provided })
    }

    /// The columns of a file of group `group`: time, the channels, and the labels if there are any.
    pub fn wanted(&self, group: usize) -> Vec<Wanted> {
        let Group { time, channels, label_column } = &self.setup.groups[group];
        let wanted = |column: &String, text: bool| Wanted { column: column.clone(), text };
        let channels = channels.iter().map(|channel| wanted(&channel.column, false));
        let labels = label_column.iter().map(|column| wanted(column, true));
        let time = wanted(&time.column, time.unit.seconds().is_none());
        [time].into_iter().chain(channels).chain(labels).collect()
    }

    /// Unit of a channel.
    pub(crate) fn unit_of(&self, name: &str) -> &str {
        let provided = self.provided.iter().find(|channel| channel.name == name);
        provided.map(|channel| channel.unit.as_str()).or_else(|| motion_unit(name)).unwrap_or_default()
    }
}

/// Unit of a channel of motion.
fn motion_unit(name: &str) -> Option<&'static str> {
    KINEMATIC.into_iter().find(|(known, _)| *known == name).map(|(_, unit)| unit)
}

fn units(group: &Group) -> Result<Vec<Unit>, ChannelError> {
    let known = |spec: &ChannelSpec| {
        unit(&spec.unit).copied().ok_or_else(|| ChannelError::UnknownUnit(spec.unit.clone()))
    };
    let units: Vec<Unit> = group.channels.iter().map(known).collect::<Result<_, _>>()?;
    for (spec, unit) in group.channels.iter().zip(&units) {
        if let Some(expected) = motion_unit(&spec.channel).filter(|expected| *expected != unit.si) {
            let (channel, unit) = (spec.channel.clone(), spec.unit.clone());
            return Err(ChannelError::Unit { channel, unit, expected });
        }
    }
    Ok(units)
}

fn measured(setup: &Setup, units: &[Vec<Unit>]) -> Vec<Provided> {
    let of = |(spec, unit): (&ChannelSpec, &Unit)| Provided {
        optional: spec.optional,
        ..Provided::new(&spec.channel, unit.si)
    };
    setup.channels().zip(units.iter().flatten()).map(of).collect()
}

/// Adds derived channels and the forces of thrusters; their sources must be there.
fn computed(setup: &Setup, provided: &mut Vec<Provided>) -> Result<(), ChannelError> {
    let Conventions { derived, thrusters, .. } = &setup.conventions;
    for Derived { channel, formula, unit } in derived {
        formula.channels.iter().try_for_each(|source| check_source(channel, source, provided))?;
        provided.push(Provided::new(channel, unit));
    }
    for (_, speed, angle) in thrusters {
        [speed].into_iter().chain(angle).try_for_each(|source| check_source("tau1", source, provided))?;
    }
    if !thrusters.is_empty() {
        let forces = [("tau1", "N"), ("tau2", "N"), ("tau3", "N m")];
        provided.extend(forces.map(|(name, unit)| Provided::new(name, unit)));
    }
    Ok(())
}

fn names(provided: &[Provided]) -> Vec<String> {
    provided.iter().map(|channel| channel.name.clone()).collect()
}

fn check_source(of: &str, source: &str, provided: &[Provided]) -> Result<(), ChannelError> {
    if provided.iter().any(|channel| channel.name == source) && !source.ends_with("_deg") {
        return Ok(());
    }
    let (of, source_channel) = (of.to_owned(), source.to_owned());
    Err(ChannelError::NoSource { of, source_channel, known: names(provided) })
}

fn check_names(provided: &[Provided]) -> Result<(), ChannelError> {
    for (i, channel) in provided.iter().enumerate() {
        let name = channel.name.as_str();
        if provided[..i].iter().any(|other| other.name == name) {
            return Err(ChannelError::Twice(name.to_owned()));
        }
        let plain = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        if !plain || RESERVED.contains(&name) {
            return Err(ChannelError::Name(name.to_owned()));
        }
    }
    Ok(())
}

/// Whether surge, sway and yaw rate are measured or follow from positions.
fn check_motion(setup: &Setup, provided: &[Provided]) -> Result<(), ChannelError> {
    let has = |name: &str| provided.iter().any(|channel| channel.name == name);
    let places = [["x", "y"], ["latitude_deg", "longitude_deg"]].map(|pair| pair.map(has));
    if places[0].contains(&true) && places[1].contains(&true) {
        return Err(ChannelError::TwoPositions);
    }
    let placed = places.contains(&[true; 2]);
    if !placed && places.as_flattened().contains(&true) {
        return Err(ChannelError::OneCoordinate);
    }
    let mut lacking: Vec<&str> =
        ["y_u", "y_v"].into_iter().filter(|name| !(has(name) || placed && has("psi"))).collect();
    lacking.extend(["y_r"].into_iter().filter(|name| !has(name) && !has("psi")));
    if !lacking.is_empty() {
        return Err(ChannelError::NoMotion(lacking));
    }
    if placed && !has("psi") && !setup.conventions.lever.is_zero() {
        return Err(ChannelError::NoHeading);
    }
    Ok(())
}

/// The vessel's inputs and measured disturbances.
fn of_vessel(vessel: &Vessel, rate_hz: f64, provided: &[Provided]) -> Result<Vec<Exogenous>, ChannelError> {
    if (vessel.sample_rate_hz / rate_hz - 1.0).abs() > 1e-9 {
        return Err(ChannelError::Rate { found: rate_hz, expected: vessel.sample_rate_hz });
    }
    let needed = &vessel.model.variables[3..];
    let find = |name: &str| provided.iter().find(|channel| channel.name == name);
    let missing: Vec<String> =
        needed.iter().map(|v| v.name.clone()).filter(|name| find(name).is_none()).collect();
    if !missing.is_empty() {
        return Err(ChannelError::Missing { missing, provided: names(provided) });
    }
    let found = needed.iter().filter_map(|variable| Some((variable, find(&variable.name)?)));
    found
        .map(|(variable, channel)| match factor(&channel.unit, &variable.unit) {
            Some(factor) => {
                Ok(Exogenous { name: variable.name.clone(), unit: variable.unit.clone(), factor })
            }
            None => Err(ChannelError::VesselUnit {
                channel: channel.name.clone(),
                unit: channel.unit.clone(),
                expected: variable.unit.clone(),
            }),
        })
        .collect()
}

/// All channels but those of motion and the optional ones.
fn everything(provided: &[Provided]) -> Vec<Exogenous> {
    let needed = provided.iter().filter(|c| !c.optional && motion_unit(&c.name).is_none());
    needed.map(|c| Exogenous { name: c.name.clone(), unit: c.unit.clone(), factor: 1.0 }).collect()
}

/// What else is known: position, heading, channels that are not needed.
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
