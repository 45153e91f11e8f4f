//! Which channels there are, what the vessel needs of them, and in which units.

use std::path::Path;

use logs::{Conventions, Formula, KINEMATIC, Lever, Recipe, Thruster, UNITS, Unit, factor, unit};
use vessel::{Invalid, Vessel, nearest};

use super::config::{IngestFile, ThrusterSpec};
use crate::failure::Failure;
use study::trajectories::Layout;

/// What is made of every recording.
#[derive(Clone, Debug, PartialEq)]
pub struct Plan {
    /// Units of the channels of every group of files.
    pub units: Vec<Vec<Unit>>,
    /// How channels become trajectories.
    pub recipe: Recipe,
    /// Inputs and measured disturbances: name, unit, and what a channel's value is multiplied by to be in it.
    pub exogenous: Vec<(String, String, f64)>,
    /// Channels that may be absent: name and unit.
    pub further: Vec<(String, String)>,
}

/// A channel that something provides.
struct Provided {
    name: String,
    unit: String,
    optional: bool,
}

/// Names that columns of the trajectories have already.
const RESERVED: [&str; 9] = ["design", "run", "segment", "maneuver", "sample", "t", "u", "v", "r"];

/// Unit of each of [`KINEMATIC`].
const KINEMATIC_UNITS: [&str; 8] = ["m/s", "m/s", "rad/s", "m", "m", "rad", "rad", "rad"];

impl Plan {
    /// Decides what becomes of the channels of `config`; with a vessel, its inputs and measured disturbances are needed,
    /// without one all channels that are not optional.
    ///
    /// # Errors
    /// An unknown unit, a channel that is given twice or has no usable name or another unit than needed, a formula that
    /// cannot be read, a source that nothing provides, and all channels that the vessel needs and nothing provides at once.
    pub fn new(config: &IngestFile, path: &Path, vessel: Option<(&Vessel, &Path)>) -> Result<Self, Failure> {
        let invalid = |e: Invalid| Failure::invalid(path, &e);
        let units = units(config).map_err(invalid)?;
        let mut provided = measured(config, &units);
        provided.extend(computed(config, &provided).map_err(invalid)?);
        check_names(&provided).map_err(invalid)?;
        check_motion(config, &provided).map_err(invalid)?;
        let exogenous = match vessel {
            Some((vessel, file)) => of_vessel(vessel, file, config, path, &provided)?,
            None => everything(&provided),
        };
        let further = further(&provided, &exogenous);
        let recipe = Recipe {
            conventions: conventions(config).map_err(invalid)?,
            method: config.velocities.method,
            rate_hz: config.sample_rate_hz,
            average_s: config.average_s,
            exogenous: exogenous.iter().map(|(name, _, _)| name.clone()).collect(),
            further: further.iter().map(|(name, _)| name.clone()).collect(),
        };
        Ok(Self { units, recipe, exogenous, further })
    }

    /// The columns of inputs and measured disturbances.
    pub fn layout(&self) -> Layout {
        Layout {
            exogenous: self.exogenous.iter().map(|(name, unit, _)| (name.clone(), unit.clone())).collect(),
        }
    }

    /// Unit of a channel, where it is known.
    pub fn unit_of(&self, config: &IngestFile, name: &str) -> String {
        let specs =
            config.file.iter().zip(&self.units).flat_map(|(file, units)| file.channel.iter().zip(units));
        let measured =
            specs.into_iter().find(|(spec, _)| spec.channel == name).map(|(_, unit)| unit.si.to_owned());
        let derived = || config.derived.iter().find(|d| d.channel == name).map(|d| d.unit.clone());
        let motion =
            || KINEMATIC.iter().position(|known| *known == name).map(|i| KINEMATIC_UNITS[i].to_owned());
        let force = if name == "tau3" { "N m" } else { "N" };
        measured.or_else(derived).or_else(motion).unwrap_or_else(|| force.to_owned())
    }
}

fn units(config: &IngestFile) -> Result<Vec<Vec<Unit>>, Invalid> {
    let of = |name: &String| {
        unit(name).copied().ok_or_else(|| {
            let known = || UNITS.iter().map(|unit| unit.name);
            Invalid::new(
                format!("unit `{name}`"),
                "no unit that is known",
                known().collect::<Vec<_>>().join(", "),
                format!("did you mean `{}`? (or use \"1\" with a `scale`)", near_unit(name)),
            )
        })
    };
    let mut units = Vec::new();
    for file in &config.file {
        let all: Vec<Unit> =
            file.channel.iter().map(|channel| of(&channel.unit)).collect::<Result<_, _>>()?;
        for (channel, unit) in file.channel.iter().zip(&all) {
            let kinematic = KINEMATIC.iter().position(|name| *name == channel.channel);
            if let Some(expected) =
                kinematic.map(|i| KINEMATIC_UNITS[i]).filter(|expected| *expected != unit.si)
            {
                return Err(Invalid::new(
                    format!("unit of channel `{}`", channel.channel),
                    format!("`{}`", channel.unit),
                    format!("a unit that converts to {expected}"),
                    "correct the unit or the channel",
                ));
            }
        }
        units.push(all);
    }
    Ok(units)
}

/// The unit that is meant by `name`: in other letters' case, or the nearest.
fn near_unit(name: &str) -> &'static str {
    let known = || UNITS.iter().map(|unit| unit.name);
    let same = known().find(|unit| unit.eq_ignore_ascii_case(name));
    same.or_else(|| nearest(name, known())).unwrap_or_default()
}

fn measured(config: &IngestFile, units: &[Vec<Unit>]) -> Vec<Provided> {
    let of = |(spec, unit): (&super::config::ChannelSpec, &Unit)| Provided {
        name: spec.channel.clone(),
        unit: unit.si.to_owned(),
        optional: spec.optional,
    };
    config.file.iter().zip(units).flat_map(|(file, units)| file.channel.iter().zip(units).map(of)).collect()
}

/// Derived channels and the forces of thrusters; their sources must be there.
fn computed(config: &IngestFile, measured: &[Provided]) -> Result<Vec<Provided>, Invalid> {
    let mut known: Vec<&str> = measured.iter().map(|channel| channel.name.as_str()).collect();
    let mut computed = Vec::new();
    for derived in &config.derived {
        let formula = formula(&derived.channel, &derived.formula)?;
        formula.channels.iter().try_for_each(|source| check_source(&derived.channel, source, &known))?;
        known.push(&derived.channel);
        let (name, unit) = (derived.channel.clone(), derived.unit.clone());
        computed.push(Provided { name, unit, optional: false });
    }
    for thruster in &config.thruster {
        let (speed, angle) = match thruster {
            ThrusterSpec::Azimuth { speed, angle, .. } => (speed, Some(angle)),
            ThrusterSpec::Tunnel { speed, .. } => (speed, None),
        };
        [speed].into_iter().chain(angle).try_for_each(|source| check_source("tau1", source, &known))?;
    }
    if !config.thruster.is_empty() {
        let force =
            |(name, unit): (&str, &str)| Provided { name: name.into(), unit: unit.into(), optional: false };
        computed.extend([("tau1", "N"), ("tau2", "N"), ("tau3", "N m")].map(force));
    }
    Ok(computed)
}

fn check_source(of: &str, source: &str, known: &[&str]) -> Result<(), Invalid> {
    if known.contains(&source) && !source.ends_with("_deg") {
        return Ok(());
    }
    let near = nearest(source, known.iter().copied()).unwrap_or_default();
    Err(Invalid::new(
        format!("source of channel `{of}`"),
        format!("`{source}`, which nothing before it provides"),
        format!("one of {}", known.join(", ")),
        format!("did you mean `{near}`?"),
    ))
}

fn formula(channel: &str, text: &str) -> Result<Formula, Invalid> {
    Formula::parse(text).map_err(|malformed| {
        Invalid::new(
            format!("`formula` of channel `{channel}`"),
            format!("`{text}` with {malformed}"),
            "a product such as `n |n|`, `negative(n)` or `-1 wind^2 cos(gamma)`",
            "write the formula again",
        )
    })
}

fn check_names(provided: &[Provided]) -> Result<(), Invalid> {
    for (i, channel) in provided.iter().enumerate() {
        let name = channel.name.as_str();
        let plain = !name.is_empty() && name.chars().all(|c| c.is_alphanumeric() || c == '_');
        let twice = provided[..i].iter().any(|other| other.name == name);
        if twice || !plain || RESERVED.contains(&name) {
            let found = if twice { "given twice" } else { "a name that is taken or no plain name" };
            let remedy = match name {
                "u" | "v" | "r" => format!("measured states are called y_{name}"),
                _ => "rename it".to_owned(),
            };
            let expected = "letters, digits and _, each name once, no column of the trajectories";
            return Err(Invalid::new(format!("channel `{name}`"), found, expected, remedy));
        }
    }
    Ok(())
}

/// Whether surge, sway and yaw rate are measured or follow from positions.
fn check_motion(config: &IngestFile, provided: &[Provided]) -> Result<(), Invalid> {
    let has = |name: &str| provided.iter().any(|channel| channel.name == name);
    let places = [["x", "y"], ["latitude_deg", "longitude_deg"]].map(|pair| pair.map(has));
    if places[0].contains(&true) && places[1].contains(&true) {
        return Err(Invalid::new(
            "position",
            "both x, y and latitude_deg, longitude_deg",
            "one of the two",
            "remove one",
        ));
    }
    let placed = places[0] == [true; 2] || places[1] == [true; 2];
    if !placed && places.as_flattened().contains(&true) {
        return Err(Invalid::new(
            "position",
            "one coordinate",
            "x and y, or latitude_deg and longitude_deg",
            "add the other",
        ));
    }
    let mut lacking: Vec<&str> =
        ["y_u", "y_v"].into_iter().filter(|name| !(has(name) || placed && has("psi"))).collect();
    lacking.extend(["y_r"].into_iter().filter(|name| !has(name) && !has("psi")));
    if !lacking.is_empty() {
        return Err(Invalid::new(
            "channels",
            format!("nothing that provides `{}`", lacking.join("`, `")),
            "y_u, y_v, y_r, or x, y (or latitude_deg, longitude_deg) and psi to make them from",
            "add a [[file.channel]] for each",
        ));
    }
    if placed && !has("psi") && config.antenna_m != [0.0; 2] {
        return Err(Invalid::new(
            "`antenna_m`",
            "positions without psi",
            "a heading to turn it by",
            "add psi or remove the positions",
        ));
    }
    Ok(())
}

/// The vessel's inputs and measured disturbances.
fn of_vessel(
    vessel: &Vessel,
    file: &Path,
    config: &IngestFile,
    path: &Path,
    provided: &[Provided],
) -> Result<Vec<(String, String, f64)>, Failure> {
    if (vessel.sample_rate_hz / config.sample_rate_hz - 1.0).abs() > 1e-9 {
        return Err(Failure::refuse(
            path,
            "`sample_rate_hz`",
            &format!("{} Hz", config.sample_rate_hz),
            &format!("{} Hz, which the parameters in {} hold for", vessel.sample_rate_hz, file.display()),
            "make them equal",
        ));
    }
    let needed = &vessel.model.variables[3..];
    let find = |name: &str| provided.iter().find(|channel| channel.name == name);
    let missing: Vec<&str> =
        needed.iter().map(|v| v.name.as_str()).filter(|name| find(name).is_none()).collect();
    if !missing.is_empty() {
        return Err(Failure::refuse(
            path,
            "channels",
            &format!("nothing that provides `{}`, which {} needs", missing.join("`, `"), file.display()),
            &format!(
                "channels among {}",
                provided.iter().map(|c| c.name.as_str()).collect::<Vec<_>>().join(", ")
            ),
            &lacking_remedy(&missing, provided),
        ));
    }
    let mut exogenous = Vec::new();
    for (variable, channel) in needed.iter().filter_map(|v| find(&v.name).map(|channel| (v, channel))) {
        let Some(factor) = factor(&channel.unit, &variable.unit) else {
            return Err(Failure::refuse(
                path,
                &format!("unit of channel `{}`", channel.name),
                &format!("`{}`", channel.unit),
                &format!("`{}`, as declared in {}", variable.unit, file.display()),
                "correct one of them",
            ));
        };
        exogenous.push((variable.name.clone(), variable.unit.clone(), factor));
    }
    Ok(exogenous)
}

fn lacking_remedy(missing: &[&str], provided: &[Provided]) -> String {
    let names =
        || provided.iter().map(|channel| channel.name.as_str()).filter(|name| !KINEMATIC.contains(name));
    let one = |name: &&str| match nearest(name, names()) {
        Some(near) => format!("did you mean `{name}` by `{near}`?"),
        None => format!("add a [[file.channel]] for `{name}`"),
    };
    missing.iter().map(one).collect::<Vec<_>>().join(" ")
}

/// All channels but those of motion and the optional ones.
fn everything(provided: &[Provided]) -> Vec<(String, String, f64)> {
    let needed = provided.iter().filter(|c| !c.optional && !KINEMATIC.contains(&c.name.as_str()));
    needed.map(|channel| (channel.name.clone(), channel.unit.clone(), 1.0)).collect()
}

/// What else is known: position, heading, channels that are not needed.
fn further(provided: &[Provided], exogenous: &[(String, String, f64)]) -> Vec<(String, String)> {
    let has = |name: &str| provided.iter().any(|channel| channel.name == name);
    let placed = has("x") || has("latitude_deg");
    let pose = [("x", "m", placed), ("y", "m", placed), ("psi", "rad", has("psi"))];
    let pose = pose
        .into_iter()
        .filter(|(_, _, known)| *known)
        .map(|(name, unit, _)| (name.to_owned(), unit.to_owned()));
    let other = |channel: &&Provided| {
        !KINEMATIC.contains(&channel.name.as_str())
            && exogenous.iter().all(|(name, _, _)| *name != channel.name)
    };
    pose.chain(provided.iter().filter(other).map(|c| (c.name.clone(), c.unit.clone()))).collect()
}

fn conventions(config: &IngestFile) -> Result<Conventions, Invalid> {
    let derived = |d: &super::config::DerivedSpec| Ok((d.channel.clone(), formula(&d.channel, &d.formula)?));
    Ok(Conventions {
        frame: config.frame,
        heading: config.heading.unwrap_or(config.frame.heading()),
        body: config.body,
        lever: Lever(config.antenna_m),
        window_s: config.velocities.window_s,
        derived: config.derived.iter().map(derived).collect::<Result<_, _>>()?,
        thrusters: config.thruster.iter().map(thruster).collect(),
    })
}

fn thruster(spec: &ThrusterSpec) -> (Thruster, String, Option<String>) {
    match spec.clone() {
        ThrusterSpec::Azimuth { speed, angle, coefficient, law, position_m } => {
            (Thruster { law, coefficient, position_m }, speed, Some(angle))
        }
        ThrusterSpec::Tunnel { speed, coefficient, law, position_m } => {
            (Thruster { law, coefficient, position_m }, speed, None)
        }
    }
}
