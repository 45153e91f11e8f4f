//! `logs.toml`: the ship, the sensors and the days of simulated logs.

use std::collections::BTreeMap;

use logs::chain::{Actuator, Chain, Compass, Day, Gnss, Hull, Schedule};
use refusal::{Invalid, check_name};
use schemars::JsonSchema;
use serde::Deserialize;
use ship::model::Vessel;

/// `logs.toml` as written: maneuvers, days and instruments.
#[derive(Clone, Debug, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct LogsFile {
    /// Seed of every random number.
    pub seed: u64,
    /// Samples per second: those of the vessel.
    pub sample_rate_hz: f64,
    /// Samples per sub-experiment after differencing to velocities; two more rows are logged.
    #[schemars(range(min = 1, max = 100000))]
    pub samples: u32,
    /// Sub-experiments per maneuver.
    #[schemars(range(min = 1, max = 100000))]
    pub repeats: u32,
    /// Whether every other repeat is mirrored.
    #[serde(default)]
    pub alternate_sides: bool,
    /// Relative scatter of a repeat's forces.
    #[serde(default)]
    #[schemars(range(min = 0.0), extend("exclusiveMaximum" = 1e5))]
    pub scatter_std: f64,
    /// Heading at the start of every recording \[rad\]; without it each starts on a different course.
    pub course_rad: Option<f64>,
    /// Maneuver → its duration before logging begins \[s\].
    #[serde(default)]
    #[schemars(extend("additionalProperties" = {"type": "number", "minimum": 0, "exclusiveMaximum": 1e5, "x-unit": "s"}))]
    pub settle_s: BTreeMap<String, f64>,
    /// Position.
    pub gnss: Gnss,
    /// Heading.
    pub heading: Compass,
    /// Azimuth thrusters.
    pub thruster: Vec<Actuator>,
    /// The hull that the wind acts on.
    pub hull: Option<Hull>,
    /// The days; a maneuver on several has its repeats dealt out in turn.
    pub day: Vec<Day>,
}

impl LogsFile {
    /// Refuses invalid numbers, and names that are not among `maneuvers`.
    ///
    /// # Errors
    /// Names the key.
    pub fn check(&self, maneuvers: &[&str], rate_hz: f64) -> Result<(), Invalid> {
        self.check_numbers(rate_hz)?;
        if self.thruster.is_empty() {
            let expected = "an azimuth thruster for the forces";
            return Err(Invalid::new("[[thruster]]", "none", expected, "add one"));
        }
        for day in &self.day {
            check_name("`name` of a [[day]]", &day.name)?;
            if day.wind.is_some() && self.hull.is_none() {
                let thing = format!("day `{}`, [day.wind]", day.name);
                return Err(Invalid::new(thing, "a wind without [hull]", "what it acts on", "add [hull]"));
            }
        }
        let listed = self.day.iter().flat_map(|day| day.maneuvers.iter().map(|m| (m, &day.name)));
        for (name, day) in listed {
            known(&format!("`maneuvers` of day `{day}`"), name, maneuvers)?;
        }
        self.settle_s.keys().try_for_each(|name| known("[settle_s]", name, maneuvers))?;
        if self.day.iter().all(|day| day.maneuvers.is_empty()) {
            return Err(Invalid::new("[[day]]", "no maneuver", "a day with `maneuvers`", "add one"));
        }
        Ok(())
    }

    fn check_numbers(&self, rate_hz: f64) -> Result<(), Invalid> {
        let invalid = |key: &str, value: String, expected: String| {
            Err(Invalid::new(format!("`{key}`"), value, expected, "correct it"))
        };
        if (self.sample_rate_hz / rate_hz - 1.0).abs() > 1e-9 {
            let expected = format!("{rate_hz} Hz, which the vessel's parameters hold for");
            return invalid("sample_rate_hz", format!("{} Hz", self.sample_rate_hz), expected);
        }
        if self.gnss.every(rate_hz).is_none() {
            let expected = format!("{rate_hz} Hz divided by a whole number");
            return invalid("gnss.rate_hz", format!("{} Hz", self.gnss.rate_hz), expected);
        }
        Ok(())
    }

    /// Rows of all logs of those `maneuvers` that are on a day, including the time before logging.
    pub fn rows(&self, maneuvers: &[&str], rate_hz: f64) -> f64 {
        let on_a_day = |name: &&&str| self.day.iter().any(|day| day.maneuvers.iter().any(|m| m == **name));
        let settle = |name: &&str| self.settle_s.get(*name).map_or(0.0, |s| s * rate_hz);
        let rows = |name: &&str| f64::from(self.repeats) * (settle(name) + f64::from(self.samples) + 2.0);
        maneuvers.iter().filter(on_a_day).map(rows).sum()
    }

    /// The vessel with `parameters`, its thrusters and sensors; `units` are factors from newtons and newton metres to
    /// its inputs.
    pub fn chain<'a>(&'a self, vessel: &'a Vessel, parameters: &'a [f64], units: [f64; 3]) -> Chain<'a> {
        Chain {
            model: &vessel.model,
            parameters,
            rate_hz: vessel.sample_rate_hz,
            units,
            actuators: &self.thruster,
            gnss: self.gnss,
            compass: self.heading,
            hull: self.hull,
            scatter_std: self.scatter_std,
            course_rad: self.course_rad,
        }
    }

    /// The schedule of recordings: repeats and days.
    pub fn schedule(&self) -> Schedule {
        Schedule {
            samples: self.samples,
            repeats: self.repeats,
            alternate_sides: self.alternate_sides,
            settle_s: self.settle_s.clone(),
            days: self.day.clone(),
        }
    }
}

fn known(thing: &str, name: &str, maneuvers: &[&str]) -> Result<(), Invalid> {
    if maneuvers.contains(&name) {
        return Ok(());
    }
    let found = format!("`{name}`, which the dictionary does not have");
    let expected = format!("one of {}", maneuvers.join(", "));
    Err(Invalid { found, expected, ..Invalid::unknown(thing, name, maneuvers.iter().copied()) })
}
