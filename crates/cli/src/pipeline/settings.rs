//! `study.toml`: what the stages of a study are to do other than usual. Its tables are stages, their keys the stages' flags: what a
//! flag takes, and what its help says, is said of the key, too.

use std::any::TypeId;
use std::fmt;
use std::marker::PhantomData;
use std::path::{Path, PathBuf};

use clap::{Arg, Command, CommandFactory};
use files::{Changes, Error, Provenance, parse_toml};
use refusal::Contents;
use schemars::{JsonSchema, Schema, SchemaGenerator};
use serde::Deserialize;
use serde::de::{DeserializeSeed, Deserializer, Error as _, MapAccess, Unexpected, Visitor};
use serde_json::{Map, Value, json};
use study::refuse;

use crate::commands::{
    MeritArguments, MomentsArguments, MonteCarloArguments, PlanArguments, ValidateArguments,
};
use crate::design::DesignArguments;
use crate::pool::EstimateArguments;

/// What `study.toml` says: of each stage the flags that are not as usual, in its table.
#[derive(Default, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields, default)]
pub struct StudySettings {
    /// The maneuvers, where another study's are taken: the file, seen from this one
    pub dictionary: Option<PathBuf>,
    /// Folder of the logs, seen from this file (default: `logs` beside it)
    pub logs: Option<PathBuf>,
    /// Recordings that a second model is not fitted to, and that the page shows beside its predictions
    pub test: Vec<String>,
    /// Whether the next trial is designed for a model of few terms that is searched for, and what it promises is simulated
    pub search_next: bool,
    /// The information of each maneuver
    pub moments: StageSettings<MomentsArguments>,
    /// How long to run which maneuver
    pub design: StageSettings<DesignArguments>,
    /// The estimates of simulated trials, or the model of all recordings
    pub estimate: StageSettings<EstimateArguments>,
    /// With this table the simulated trials are estimated and scored in memory, and not kept
    pub monte_carlo: Option<StageSettings<MonteCarloArguments>>,
    /// With this table standard maneuvers are simulated, and their figures are on the page
    pub merit: Option<StageSettings<MeritArguments>>,
    /// The layout on a chart
    pub plan: StageSettings<PlanArguments>,
    /// The model that the next trial is designed for, with `search_next`
    pub search: StageSettings<EstimateArguments>,
    /// The second model on the recordings of `test`
    pub compare: StageSettings<ValidateArguments>,
    /// With this table sub-experiments are designed, picked from the logs and compared
    pub selection: Option<StageSettings<ValidateArguments>>,
    /// How the next trial is designed
    pub next: StageSettings<DesignArguments>,
}

/// The name of the file.
pub const FILE: &str = "study.toml";
/// How a new one begins.
pub const HEAD: &str = "# What the stages are to do other than usual, by their flags: `seatrial design --help` has those of [design].\n";

impl StudySettings {
    /// Reads `study.toml` in the folder `study` with those of `changes` that are its own; none if it is absent.
    pub fn read(study: &Path, changes: Changes) -> Result<Self, Error> {
        let (file, before) = (study.join(FILE), study.join("study.mk"));
        if before.exists() {
            let (found, expected) = ("settings as text, as they were before 0.3", "study.toml");
            let remedy = "write its settings as keys of study.toml, as a table of docs/own-ship.md has them, and remove it";
            return Err(refuse(&before, "file", found, expected, remedy));
        }
        if file.exists() {
            let mut provenance = Provenance { changes, ..Provenance::default() };
            return provenance.read_toml("study", "study", &file);
        }
        let text = changes.applied("study", "").map_err(|e| Error::invalid(&file, e))?;
        parse_toml(&text, &file)
    }

    /// Its JSON Schema.
    pub fn schema() -> Value {
        schemars::schema_for!(Self).to_value()
    }
}

/// The flags of the stage `A` that are set, by their names in order, each with the words of its value.
pub struct StageSettings<A> {
    flags: Vec<(String, Vec<String>)>,
    stage: PhantomData<fn() -> A>,
}

impl<A> Default for StageSettings<A> {
    fn default() -> Self {
        Self { flags: Vec::new(), stage: PhantomData }
    }
}

impl<A> StageSettings<A> {
    /// Whether one of these flags is set.
    pub fn has(&self, flags: &[&str]) -> bool {
        self.flags.iter().any(|(name, _)| flags.contains(&name.as_str()))
    }

    /// Whether none is set.
    pub fn is_empty(&self) -> bool {
        self.flags.is_empty()
    }

    /// What `flag` is set to.
    pub fn value(&self, flag: &str) -> Option<&str> {
        let (_, words) = self.flags.iter().find(|(name, _)| name == flag)?;
        words.get(1).map(String::as_str)
    }

    /// The words of the `usual` flags and of those that are set, which take the place of usual ones of the same name.
    pub fn over(&self, usual: &str) -> Vec<String> {
        let mut is_kept = true;
        let mut words: Vec<String> = usual.split_whitespace().map(str::to_owned).collect();
        words.retain(|word| {
            if let Some(name) = word.strip_prefix("--") {
                is_kept = !self.has(&[name]);
            }
            is_kept
        });
        words.extend(self.flags.iter().flat_map(|(_, flag)| flag.clone()));
        words
    }

    /// Without these `flags`.
    pub fn without(&self, flags: &[&str]) -> Self {
        let kept = self.flags.iter().filter(|(name, _)| !flags.contains(&name.as_str()));
        Self { flags: kept.cloned().collect(), stage: PhantomData }
    }
}

/// What the value of a flag may be.
enum SettingKind {
    Truth,
    Whole,
    Number,
    Choice(Vec<String>),
    Text,
}

/// The flags that a study may set: not its files and folders, which are known, nor how the work is divided, nor where a ship is.
fn settable(command: &Command) -> impl Iterator<Item = &Arg> {
    let is_path = |arg: &Arg| arg.get_value_parser().type_id() == TypeId::of::<PathBuf>();
    let is_divided = |arg: &Arg| ["shard", "gather", "from", "done"].contains(&arg.get_id().as_str());
    command.get_arguments().filter(move |arg| arg.get_long().is_some() && !is_path(arg) && !is_divided(arg))
}

/// The key that sets a flag.
fn key_of(arg: &Arg) -> String {
    arg.get_long().unwrap_or_default().replace('-', "_")
}

fn kind_of(arg: &Arg) -> SettingKind {
    let kind = arg.get_value_parser().type_id();
    let of = |kinds: &[TypeId]| kinds.iter().any(|one| kind == *one);
    let choices = arg.get_possible_values();
    if !arg.get_action().takes_values() {
        SettingKind::Truth
    } else if !choices.is_empty() {
        SettingKind::Choice(choices.iter().map(|choice| choice.get_name().to_owned()).collect())
    } else if of(&[TypeId::of::<u16>(), TypeId::of::<u32>(), TypeId::of::<u64>(), TypeId::of::<usize>()]) {
        SettingKind::Whole
    } else if of(&[TypeId::of::<f64>()]) {
        SettingKind::Number
    } else {
        SettingKind::Text
    }
}

/// Whether a flag takes several values.
fn is_list(arg: &Arg) -> bool {
    arg.get_value_delimiter().is_some() || matches!(arg.get_action(), clap::ArgAction::Append)
}

impl<A: CommandFactory> JsonSchema for StageSettings<A> {
    fn inline_schema() -> bool {
        true
    }

    fn schema_name() -> std::borrow::Cow<'static, str> {
        format!("{}_settings", A::command().get_name()).into()
    }

    fn json_schema(_: &mut SchemaGenerator) -> Schema {
        let of = |arg: &Arg| {
            let value = match kind_of(arg) {
                SettingKind::Truth => json!({"type": "boolean"}),
                SettingKind::Whole => json!({"type": "integer", "minimum": 0}),
                SettingKind::Number => json!({"type": "number"}),
                SettingKind::Choice(names) => json!({"type": "string", "enum": names}),
                SettingKind::Text => json!({"type": ["string", "number"]}),
            };
            let mut schema = match is_list(arg) {
                true => json!({"anyOf": [value.clone(), {"type": "array", "items": value}]}),
                false => value,
            };
            schema["description"] = json!(arg.get_help().map(ToString::to_string));
            (key_of(arg), schema)
        };
        let command = A::command();
        let keys: Map<String, Value> = settable(&command).map(of).collect();
        let schema = json!({"type": "object", "properties": keys, "additionalProperties": false});
        Schema::try_from(schema).unwrap_or_default()
    }
}

impl<'de, A: CommandFactory> Deserialize<'de> for StageSettings<A> {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        let command = A::command();
        let flags = deserializer.deserialize_map(SettingsReader(&command))?;
        Ok(Self { flags, stage: PhantomData })
    }
}

/// Reads the flags of a command.
struct SettingsReader<'a>(&'a Command);

impl<'de> Visitor<'de> for SettingsReader<'_> {
    type Value = Vec<(String, Vec<String>)>;

    fn expecting(&self, f: &mut fmt::Formatter) -> fmt::Result {
        write!(f, "the settings of {}", self.0.get_name())
    }

    fn visit_map<M: MapAccess<'de>>(self, mut table: M) -> Result<Self::Value, M::Error> {
        let mut flags = Vec::new();
        while let Some(arg) = table.next_key_seed(KeyReader(self.0))? {
            let value: Contents = table.next_value_seed(ValueReader(arg))?;
            let name = arg.get_long().unwrap_or_default();
            let flag = format!("--{name}");
            let words = match value {
                Contents::Truth(true) => vec![flag],
                Contents::Truth(false) => Vec::new(),
                Contents::List(items) if arg.get_value_delimiter().is_none() => {
                    items.iter().flat_map(|item| [flag.clone(), word(item)]).collect()
                }
                Contents::List(items) => vec![flag, items.iter().map(word).collect::<Vec<_>>().join(",")],
                value => vec![flag, word(&value)],
            };
            flags.push((name.to_owned(), words));
        }
        Ok(flags)
    }
}

/// A value as it stands on a command line.
fn word(value: &Contents) -> String {
    match value {
        Contents::Signed(number) => number.to_string(),
        Contents::Whole(number) => number.to_string(),
        Contents::Real(number) => number.to_string(),
        Contents::Text(text) => text.clone(),
        _ => String::new(),
    }
}

struct KeyReader<'a>(&'a Command);

impl<'de, 'a> DeserializeSeed<'de> for KeyReader<'a> {
    type Value = &'a Arg;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<&'a Arg, D::Error> {
        let key = String::deserialize(deserializer)?;
        settable(self.0).find(|arg| key_of(arg) == key).ok_or_else(|| {
            let known: Vec<String> = settable(self.0).map(|arg| format!("`{}`", key_of(arg))).collect();
            // In the words of serde, which tell the nearest one
            D::Error::custom(format_args!("unknown field `{key}`, expected one of {}", known.join(", ")))
        })
    }
}

struct ValueReader<'a>(&'a Arg);

impl<'de> DeserializeSeed<'de> for ValueReader<'_> {
    type Value = Contents;

    fn deserialize<D: Deserializer<'de>>(self, deserializer: D) -> Result<Contents, D::Error> {
        let value = Contents::deserialize(deserializer)?;
        let (kind, is_list) = (kind_of(self.0), is_list(self.0));
        let all = match &value {
            Contents::List(items) if is_list => items.as_slice(),
            value => std::slice::from_ref(value),
        };
        for one in all {
            let expected = match (&kind, one) {
                (SettingKind::Truth, Contents::Truth(_))
                | (SettingKind::Whole, Contents::Signed(0..) | Contents::Whole(_))
                | (
                    SettingKind::Number | SettingKind::Text,
                    Contents::Signed(_) | Contents::Whole(_) | Contents::Real(_),
                )
                | (SettingKind::Text, Contents::Text(_)) => continue,
                (SettingKind::Choice(names), Contents::Text(name)) if names.contains(name) => continue,
                (SettingKind::Choice(names), Contents::Text(name)) => {
                    let known = names.iter().map(|name| format!("`{name}`")).collect::<Vec<_>>().join(", ");
                    let unknown = format_args!("unknown variant `{name}`, expected one of {known}");
                    return Err(D::Error::custom(unknown));
                }
                (SettingKind::Truth, _) => "true or false",
                (SettingKind::Whole, _) => "a whole number from 0 on",
                (SettingKind::Number, _) => "a number",
                (SettingKind::Choice(_) | SettingKind::Text, _) => "a text",
            };
            return Err(D::Error::invalid_type(told(one), &expected));
        }
        Ok(value)
    }
}

/// What a value is.
fn told(value: &Contents) -> Unexpected<'_> {
    match value {
        Contents::Nothing => Unexpected::Unit,
        Contents::Truth(value) => Unexpected::Bool(*value),
        Contents::Signed(number) => Unexpected::Signed(*number),
        Contents::Whole(number) => Unexpected::Unsigned(*number),
        Contents::Real(number) => Unexpected::Float(*number),
        Contents::Text(text) => Unexpected::Str(text),
        Contents::List(_) => Unexpected::Seq,
        Contents::Table(_) => Unexpected::Map,
    }
}
