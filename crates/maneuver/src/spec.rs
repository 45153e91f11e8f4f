use std::borrow::Cow;

use refusal::{Contents, Invalid};
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::de::{DeserializeOwned, Error as _};
use serde::{Deserialize, Deserializer};

use super::kind::ManeuverKind;
use super::limits::Kept;
use super::signal::{LONGEST_S, SWING_SAMPLES, Signal, check_period};
use crate::feedback::{Controller, Executed};
use crate::standard::{Sensors, Settings};

/// One maneuver.
#[derive(Clone, Debug, PartialEq)]
pub struct ManeuverSpec {
    /// Its name, unique in the dictionary.
    pub name: String,
    /// For the report.
    pub description: String,
    /// Its duration in the dictionary \[s\].
    pub duration_s: Option<f64>,
    /// Ranges of its motion.
    pub keeps: Kept,
    /// How a motion is carried out; standard maneuvers react by themselves.
    pub executed: Executed,
    /// The controller of a motion that is executed by feedback; `None`: the usual one.
    pub feedback: Option<Controller>,
    /// Inputs of the approach of a standard maneuver; `None`: those that hold it steady.
    pub approach: Option<Settings>,
    /// Its kind and parameters.
    pub kind: ManeuverKind,
}

/// Greatest speeds and rates of turn of any ship \[m/s, rad/s\].
const FASTEST_M_S: f64 = 100.0;
const FASTEST_RAD_S: f64 = 10.0;

/// Keys of every kind of maneuver.
const COMMON_KEYS: [&str; 8] =
    ["name", "kind", "description", "duration_s", "keeps", "executed", "feedback", "approach"];

impl<'de> Deserialize<'de> for ManeuverSpec {
    /// The keys that all kinds share, then those of the kind: any other key is refused (which a flattened enum would let pass).
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        #[derive(Deserialize)]
        struct Common {
            name: String,
            #[serde(default)]
            description: String,
            duration_s: Option<f64>,
            executed: Option<Executed>,
        }
        let mut table = toml::Table::deserialize(deserializer)?;
        let mut common = toml::Table::new();
        for key in ["name", "description", "duration_s", "executed"] {
            common.extend(table.remove(key).map(|value| (key.to_owned(), value)));
        }
        let called = table_name(&common);
        let refused = |e: toml::de::Error| {
            let key = e
                .to_string()
                .lines()
                .find_map(|line| Some(line.strip_prefix("in `")?.strip_suffix('`')?.to_owned()));
            D::Error::custom(in_item(&e, called.as_deref(), key.as_deref()))
        };
        let [keeps, feedback, approach] = ["keeps", "feedback", "approach"].map(|key| table.remove(key));
        let Common { name, description, duration_s, executed } = common.try_into().map_err(refused)?;
        let within = |key: &'static str| {
            let name = &name;
            move |e: toml::de::Error| {
                D::Error::custom(format!("{} (maneuver `{name}`, `{key}`)", e.message()))
            }
        };
        let keeps = keeps.map(typed).transpose().map_err(within("keeps"))?.unwrap_or_default();
        let named = |e: toml::de::Error| D::Error::custom(in_item(&e, Some(&name), wrong_key(&table, &e)));
        let kind: ManeuverKind = typed(table.clone().into()).map_err(named)?;
        let executed = executed.unwrap_or(Executed::Inputs);
        let feedback = feedback.map(typed).transpose().map_err(within("feedback"))?;
        let approach = approach.map(typed).transpose().map_err(within("approach"))?;
        Ok(Self { name, description, duration_s, keeps, executed, feedback, approach, kind })
    }
}

/// As [`refusal::strictly`], without the bounds: what is read of the whole file has them.
fn typed<T: DeserializeOwned>(value: toml::Value) -> Result<T, toml::de::Error> {
    T::deserialize(&Contents::deserialize(value)?).map_err(toml::de::Error::custom)
}

/// The name in a table, if it has one.
fn table_name(table: &toml::Table) -> Option<String> {
    table.get("name")?.as_str().map(str::to_owned)
}

/// The message of `error` in the maneuver called `name`, with the key that it is about.
fn in_item(error: &toml::de::Error, name: Option<&str>, key: Option<&str>) -> String {
    let message = with_common_keys(error.message());
    match (name, key) {
        (None, _) => message,
        (Some(name), None) => format!("{message} (maneuver `{name}`)"),
        (Some(name), Some(key)) => format!("{message} (maneuver `{name}`, `{key}`)"),
    }
}

/// The key of a kind's table whose value is refused with `error`, which names no key as serde reads tagged enums: without it, the
/// table is refused otherwise or not at all.
fn wrong_key<'a>(table: &'a toml::Table, error: &toml::de::Error) -> Option<&'a str> {
    let without = |key: &&str| {
        let rest: toml::Table = table
            .iter()
            .filter(|(other, _)| other != key)
            .map(|(other, value)| (other.clone(), value.clone()))
            .collect();
        typed::<ManeuverKind>(rest.into()).err().is_none_or(|other| other.message() != error.message())
    };
    let of_value = error.message().starts_with("invalid") || error.message().starts_with("unknown variant");
    // Without its kind every table is refused otherwise.
    let keys = table.keys().map(String::as_str).filter(|key| *key != "kind");
    keys.chain(["kind"]).find(without).filter(|_| of_value)
}

/// Those of every kind of maneuver, for its schema.
#[derive(JsonSchema)]
#[allow(dead_code)]
struct CommonKeys {
    /// Its name, unique in the dictionary.
    name: String,
    /// For the report.
    description: Option<String>,
    /// Its duration in the dictionary \[s\].
    duration_s: Option<f64>,
    /// Ranges of its motion.
    keeps: Option<Kept>,
    /// How a motion is carried out; standard maneuvers react by themselves.
    executed: Option<Executed>,
    /// The controller of a motion that is executed by feedback.
    feedback: Option<Controller>,
    /// Inputs of the approach of a standard maneuver, in place of those that hold it steady.
    approach: Option<Settings>,
}

impl JsonSchema for ManeuverSpec {
    fn schema_name() -> Cow<'static, str> {
        "Maneuver".into()
    }

    /// Each kind with the keys that all kinds share.
    fn json_schema(generator: &mut SchemaGenerator) -> Schema {
        let (mut kinds, common) = (ManeuverKind::json_schema(generator), CommonKeys::json_schema(generator));
        let shared = common.get("properties").and_then(|keys| keys.as_object()).cloned().unwrap_or_default();
        let kinds_of = kinds.get_mut("oneOf").and_then(|all| all.as_array_mut()).into_iter().flatten();
        for kind in kinds_of.filter_map(|kind| kind.as_object_mut()) {
            if let Some(properties) = kind.get_mut("properties").and_then(|keys| keys.as_object_mut()) {
                properties.extend(shared.clone());
            }
            if let Some(required) = kind.get_mut("required").and_then(|keys| keys.as_array_mut()) {
                required.push("name".into());
            }
            kind.insert("additionalProperties".to_owned(), false.into());
        }
        kinds
    }
}

/// Adds [`COMMON_KEYS`] to the known keys that serde's message on an unknown field lists.
fn with_common_keys(message: &str) -> String {
    match message.split_once(", expected ") {
        Some((fault, known)) if fault.starts_with("unknown field") => {
            let names = known.split('`').skip(1).step_by(2);
            let all: Vec<String> = names.chain(COMMON_KEYS).map(|key| format!("`{key}`")).collect();
            format!("{fault}, expected one of {}", all.join(", "))
        }
        _ => message.to_owned(),
    }
}

impl ManeuverSpec {
    /// Its duration \[s\], or the default.
    pub fn duration(&self, default_s: Option<f64>) -> Option<f64> {
        self.duration_s.or(default_s)
    }

    /// Whether its inputs follow the noise of the logged sensors, and no instruments are known that do not: rates of turn are held
    /// by what they show. Triggers are reached once; a tracked motion has the inputs of the nominal ship as instruments.
    pub fn is_steered_by_the_log(&self) -> bool {
        matches!(&self.kind, ManeuverKind::ReverseSpiral(spiral) if spiral.sensors == Sensors::Logged)
    }

    /// Whether it is commanded by what logged sensors show.
    pub fn reads_logged_sensors(&self) -> bool {
        let by_kind = self.kind.standard().is_some_and(|standard| standard.sensors() == Sensors::Logged);
        let tracked = self.executed == Executed::Feedback
            && self.feedback.unwrap_or_default().sensors == Sensors::Logged;
        by_kind || tracked
    }

    pub(super) fn check(&self, default_s: Option<f64>) -> Result<(), Invalid> {
        if !matches!(self.kind, ManeuverKind::Inputs { .. }) {
            let missing = || {
                let thing = format!("maneuver `{}`, `duration_s`", self.name);
                Invalid::new(thing, "none", "a duration here or for the whole dictionary", "add it")
            };
            self.above_zero("duration_s", self.duration(default_s).ok_or_else(missing)?)?;
        }
        self.keeps.check(&self.name)?;
        self.check_feedback()?;
        self.check_approach()?;
        if let Some(standard) = self.kind.standard() {
            standard.check(&self.name, self.duration(default_s))?;
        }
        for (key, value) in self.kind.numbers() {
            if !value.is_finite() {
                return Err(self.invalid(key, value, "a finite number"));
            }
            let (most, unit) = match key {
                _ if key.ends_with("_m_s") => (FASTEST_M_S, "m/s"),
                _ if key.ends_with("_rad_s") => (FASTEST_RAD_S, "rad/s"),
                "heading_amplitude_rad" => (FASTEST_RAD_S, "rad"),
                _ => continue,
            };
            if value.abs() > most {
                return Err(self.invalid(key, value, &format!("a number from -{most} to {most} {unit}")));
            }
        }
        match self.kind {
            ManeuverKind::Accelerate { from_m_s, to_m_s, .. } if to_m_s <= from_m_s => {
                Err(self.invalid("to_m_s", to_m_s, "more than from_m_s"))
            }
            ManeuverKind::Decelerate { from_m_s, to_m_s, .. } if to_m_s >= from_m_s => {
                Err(self.invalid("to_m_s", to_m_s, "less than from_m_s"))
            }
            ManeuverKind::Accelerate { hold_s, .. } | ManeuverKind::Decelerate { hold_s, .. }
                if !(0.0..=LONGEST_S).contains(&hold_s) =>
            {
                Err(self.invalid("hold_s", hold_s, &format!("from 0 to {LONGEST_S:e} s")))
            }
            ManeuverKind::ZigZag {
                period_s,
                yaw_rate_amplitude_rad_s: rate,
                heading_amplitude_rad: heading,
                ..
            } => {
                if rate.is_some() == heading.is_some() {
                    return Err(Invalid::new(
                        format!("maneuver `{}`", self.name),
                        "both or none of `yaw_rate_amplitude_rad_s` and `heading_amplitude_rad`",
                        "one of them",
                        "keep one",
                    ));
                }
                self.above_zero("period_s", period_s)
            }
            ManeuverKind::SwayZigZag { period_s, .. } => self.above_zero("period_s", period_s),
            ManeuverKind::PseudoRandomBinary { dwell_s, .. } => self.above_zero("dwell_s", dwell_s),
            ManeuverKind::Combined { exact, start_m_s, sway_m_s, .. } => {
                let mut signals = self.kind.signals().into_iter();
                signals.try_for_each(|(key, signal)| self.check_signal(key, &signal))?;
                if exact { self.check_exact(start_m_s, sway_m_s) } else { Ok(()) }
            }
            _ => Ok(()),
        }
    }

    fn check_feedback(&self) -> Result<(), Invalid> {
        let refuse = |key: &str, given: &str, expected: &str, remedy: &str| {
            Err(Invalid::new(format!("maneuver `{}`, `{key}`", self.name), given, expected, remedy))
        };
        match (self.executed, &self.feedback) {
            (Executed::Feedback, _) if self.kind.standard().is_some() => {
                let expected = "no such key, since a standard maneuver reacts to the ship by itself";
                refuse("executed", "feedback", expected, "remove it")
            }
            (Executed::Inputs, Some(_)) => {
                let expected = "`executed = \"feedback\"` beside it";
                refuse(
                    "feedback",
                    "a controller of a motion that is executed by inputs",
                    expected,
                    "add that",
                )
            }
            (_, Some(controller)) => controller.check(&self.name),
            (_, None) => Ok(()),
        }
    }

    fn check_approach(&self) -> Result<(), Invalid> {
        let Some(approach) = &self.approach else { return Ok(()) };
        let refuse = |given: String, expected: &str, remedy: &str| {
            Err(Invalid::new(format!("maneuver `{}`, `approach`", self.name), given, expected, remedy))
        };
        if self.kind.standard().is_none() {
            let expected = "the approach of a standard maneuver, such as `kind = \"zig-zag-test\"`";
            return refuse("inputs of an approach".to_owned(), expected, "remove it");
        }
        match approach.iter().find(|(_, value)| !value.is_finite()) {
            Some((name, value)) => refuse(format!("{name} = {value}"), "finite numbers", "correct it"),
            None => Ok(()),
        }
    }

    fn check_signal(&self, key: &str, signal: &Signal) -> Result<(), Invalid> {
        if signal.has_period() {
            self.above_zero(&format!("{key}.period_s"), signal.period_s)?;
        }
        signal.check_shape().map_err(|(shape_key, given, expected)| {
            let given = given.map_or("none".into(), |given| given.to_string());
            let thing = format!("maneuver `{}`, `{key}.{shape_key}`", self.name);
            Invalid::new(thing, given, expected, "correct it")
        })
    }

    /// Refuses an exact motion that does not determine all of the ship's speeds from the start on.
    fn check_exact(&self, start_m_s: Option<f64>, sway_m_s: Option<Signal>) -> Result<(), Invalid> {
        let refuse = |key: &str, given: &str, expected: &str, remedy: &str| {
            let thing = format!("maneuver `{}`, `{key}`", self.name);
            Err(Invalid::new(thing, given, expected, remedy))
        };
        match (start_m_s, sway_m_s) {
            (Some(start), _) => refuse(
                "start_m_s",
                &start.to_string(),
                "none with `exact`: the ship starts as its signals do",
                "remove it",
            ),
            (None, None) => refuse(
                "sway_m_s",
                "none",
                "a signal, since an exact motion leaves no sway speed to the turn",
                "add it, or remove `exact`",
            ),
            _ => Ok(()),
        }
    }

    /// Refuses swings that are too fast to be represented at `rate_hz`.
    pub(super) fn check_sampling(&self, rate_hz: f64) -> Result<(), Invalid> {
        let check = |key: &str, period_s, least| {
            check_period(format!("maneuver `{}`, `{key}`", self.name), period_s, least, rate_hz)
        };
        match self.kind {
            ManeuverKind::ZigZag { period_s, .. } | ManeuverKind::SwayZigZag { period_s, .. } => {
                check("period_s", period_s, SWING_SAMPLES)
            }
            ManeuverKind::PseudoRandomBinary { dwell_s, .. } => check("dwell_s", dwell_s, 1),
            ManeuverKind::Combined { .. } => self.kind.signals().into_iter().try_for_each(|(key, signal)| {
                signal
                    .least_samples()
                    .map_or(Ok(()), |n| check(&format!("{key}.period_s"), signal.period_s, n))
            }),
            _ => Ok(()),
        }
    }

    fn above_zero(&self, key: &str, value: f64) -> Result<(), Invalid> {
        if !(value.is_finite() && value > 0.0) {
            return Err(self.invalid(key, value, "more than 0 s"));
        }
        if value > LONGEST_S {
            return Err(self.invalid(key, value, &format!("at most {LONGEST_S:e} s")));
        }
        Ok(())
    }

    fn invalid(&self, key: &str, value: f64, expected: &str) -> Invalid {
        Invalid::new(format!("maneuver `{}`, `{key}`", self.name), value.to_string(), expected, "correct it")
    }
}
