//! What is in a log: a proposal for a person to check. Columns of tables are known by how they move together; names decide
//! where that tells nothing. Messages and sentences are known by their types.

mod head;
mod names;
mod tables;
mod topics;

pub use head::Head;
pub use names::Named;
pub use tables::{Clock, ColumnChoice, Guess, MOST, Question};
pub use topics::{ATTITUDE, BagGuess, TopicGuess};

use std::collections::BTreeMap;

use crate::{Spoken, SpokenField, factor, shaft_factor};

/// A channel that is wanted of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Needed {
    /// Its name, such as `delta`.
    pub channel: String,
    /// Its unit in the model.
    pub unit: String,
}

/// A column that was given a channel.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Placed {
    /// The topic of its messages, in a bag.
    pub topic: String,
    /// Its name.
    pub column: String,
    /// The channel.
    pub channel: String,
    /// Its unit in the log.
    pub unit: String,
    /// Whether the channel was found by a name that is not its own.
    pub is_channel_guessed: bool,
    /// Whether the name of the column says no unit.
    pub is_unit_guessed: bool,
    /// Whether a model can do without it.
    pub is_optional: bool,
    /// Whether it counts the other way.
    pub is_reversed: bool,
    /// Whether some of its numbers are below zero; false where numbers were not looked at.
    pub has_negative: bool,
    /// How it was found by motion, if it was.
    pub by_motion: Option<String>,
}

/// Channels with the same information: positions, and velocities, are logged one way.
const SAME: [[&str; 2]; 4] = [["x", "latitude_deg"], ["y", "longitude_deg"], ["y_u", "v_x"], ["y_v", "v_y"]];

/// The unit of numbers up to `largest` whose column says none: angles beyond a turn are in degrees.
fn usual_unit(unit: &str, largest: f64) -> &str {
    const TURN: f64 = 2.0 * std::f64::consts::PI + 0.1;
    match unit {
        "rad" if largest > TURN => "deg",
        "rad/s" if largest > TURN => "deg/s",
        "1/s" if largest > 60.0 => "rpm",
        other => other,
    }
}

/// What is in a log of sentences.
#[derive(Clone, Debug, PartialEq)]
pub struct SentenceGuess {
    /// The kind of sentences whose time all others have.
    pub clock: &'static str,
    /// Whether others come several times between two of these.
    pub is_spread: bool,
    /// Whether sentences lack checksums.
    pub is_unchecked: bool,
    /// Talkers in the order in which they are taken, where several have one field.
    pub prefer: Vec<String>,
    /// Fields with their channels: motion first.
    pub placed: Vec<Placed>,
    /// Fields without a channel.
    pub unused: Vec<String>,
    /// Channels of the model without a field.
    pub missing: Vec<Needed>,
    /// Usual times between values of the fastest and the slowest placed field \[s\].
    pub steps_s: [f64; 2],
    /// How long the log is \[s\].
    pub length_s: f64,
}

/// Clocks, the best first.
const CLOCKS: [&str; 5] = ["RMC", "ZDA", "GGA", "GNS", "GLL"];

/// Channels that are logged together.
struct Together {
    /// Their fields and names.
    fields: &'static [(&'static str, &'static str)],
    /// The sentences that may have them, the best first.
    kinds: &'static [&'static str],
    /// Whether they are of use, but not needed.
    is_optional: bool,
}

/// Those of motion, then of wind.
const KNOWN: [Together; 5] = [
    Together {
        fields: &[("latitude", "latitude_deg"), ("longitude", "longitude_deg")],
        kinds: &["GGA", "GNS", "RMC", "GLL"],
        is_optional: false,
    },
    Together { fields: &[("heading", "psi")], kinds: &["HDT", "THS", "HDG", "VHW"], is_optional: false },
    Together { fields: &[("surge", "y_u"), ("sway", "y_v")], kinds: &["VBW"], is_optional: false },
    Together { fields: &[("rate", "y_r")], kinds: &["ROT"], is_optional: false },
    Together { fields: &[("speed", "wind"), ("angle", "wind_from")], kinds: &["MWV-R"], is_optional: true },
];

/// Times as many values of a field as there are of the clock from which on they are spread.
const SPREAD: f64 = 1.2;

impl SentenceGuess {
    /// What a log with what `spoken` counts is likely to have for a model with the channels `needed`; `None` without a clock.
    pub fn of(spoken: &Spoken, needed: &[Needed]) -> Option<Self> {
        let most = spoken.timed.values().max()?;
        // A clock that speaks seldom leaves long gaps.
        let is_clock = |kind: &&str| spoken.timed.get(*kind).is_some_and(|count| 2 * count >= *most);
        let clock = CLOCKS.into_iter().find(is_clock)?;
        let mut search = FieldSearch { fields: &spoken.fields, needed, placed: Vec::new() };
        KNOWN.iter().for_each(|together| search.known(together));
        search.steered();
        let placed = search.placed;
        let is_missing = |need: &&Needed| placed.iter().all(|known| known.channel != need.channel);
        let missing = needed.iter().filter(is_missing).cloned().collect();
        let is_placed = |field: &&SpokenField| placed.iter().any(|known| known.column == field.column);
        let mut unused: Vec<String> = spoken
            .fields
            .iter()
            .filter(|field| !is_placed(field))
            .map(|field| field.column.clone())
            .collect();
        unused.dedup();
        let (mut fastest, mut slowest) = (f64::INFINITY, 0.0_f64);
        for field in spoken.fields.iter().filter(is_placed) {
            let step_s = spoken.length_s / (field.values as f64 - 1.0).max(1.0);
            (fastest, slowest) = (fastest.min(step_s), slowest.max(step_s));
        }
        let clocked = spoken.timed[clock] as f64;
        let is_timed = |spoken_field: &SpokenField| CLOCKS.contains(&&spoken_field.column[..3]);
        let untimed = spoken.fields.iter().filter(is_placed).filter(|field| !is_timed(field));
        Some(Self {
            clock,
            is_spread: untimed.map(|field| field.values as f64).any(|values| values > SPREAD * clocked),
            is_unchecked: spoken.sentences[1] > spoken.sentences[0] / 2,
            prefer: talkers(spoken.fields.iter().filter(is_placed)),
            placed,
            unused,
            missing,
            steps_s: [fastest, slowest],
            length_s: spoken.length_s,
        })
    }
}

/// The talkers of fields that several talkers have, those with most values first.
fn talkers<'a>(fields: impl Iterator<Item = &'a SpokenField>) -> Vec<String> {
    let mut by_column = BTreeMap::<&str, Vec<&SpokenField>>::new();
    fields.for_each(|field| by_column.entry(field.column.as_str()).or_default().push(field));
    let mut values = BTreeMap::<&str, usize>::new();
    for field in by_column.values().filter(|several| several.len() > 1).flatten() {
        *values.entry(field.talker.as_str()).or_default() += field.values;
    }
    let mut talkers: Vec<(&str, usize)> = values.into_iter().collect();
    talkers.sort_by_key(|(_, values)| usize::MAX - values);
    talkers.into_iter().map(|(talker, _)| talker.to_owned()).collect()
}

struct FieldSearch<'a> {
    fields: &'a [SpokenField],
    needed: &'a [Needed],
    placed: Vec<Placed>,
}

impl FieldSearch<'_> {
    /// Places the fields of `together` of the first kind that has values of all of them.
    fn known(&mut self, together: &Together) {
        let Together { fields, kinds, is_optional } = together;
        let column = |kind: &str, field: &str| format!("{kind}.{field}");
        let has_all =
            |kind: &&&str| fields.iter().all(|(field, _)| self.find(&column(kind, field)).is_some());
        let Some(kind) = kinds.iter().find(has_all) else { return };
        for (field, channel) in *fields {
            let is_needed = self.needed.iter().any(|need| need.channel == *channel);
            self.place(&column(kind, field), channel, (false, *is_optional && !is_needed));
        }
    }

    /// Places rudders and propellers: those of the model in its order, by the numbers that their names and the sentences have.
    fn steered(&mut self) {
        for need in
            self.needed.iter().filter(|need| !self.is_placed(&need.channel)).cloned().collect::<Vec<_>>()
        {
            let name = need.channel.as_str();
            let number = name.rsplit('_').next().filter(|part| part.chars().all(|c| c.is_ascii_digit()));
            let fits = |field: &&SpokenField| {
                let is_kind = match name {
                    _ if is_called(name, "delta") => field.column.starts_with("RSA."),
                    _ if is_called(name, "n") => {
                        field.column.starts_with("RPM-") && field.column.ends_with(".speed")
                    }
                    _ => false,
                };
                let measures =
                    factor(field.unit, &need.unit).or(shaft_factor(field.unit, &need.unit)).is_some();
                let has_number = number.is_none_or(|number| {
                    !field.column.starts_with("RPM-") || field.column.ends_with(&format!("{number}.speed"))
                });
                is_kind
                    && measures
                    && has_number
                    && self.placed.iter().all(|known| known.column != field.column)
            };
            // The sole rudder of a ship is the one to starboard.
            let field = self.fields.iter().filter(fits).min_by_key(|field| field.column.ends_with(".port"));
            if let Some(column) = field.map(|field| field.column.clone()) {
                self.place(&column, name, (true, false));
            }
        }
    }

    fn find(&self, column: &str) -> Option<&SpokenField> {
        self.fields.iter().find(|field| field.column == column)
    }

    fn is_placed(&self, channel: &str) -> bool {
        self.placed.iter().any(|known| known.channel == channel)
    }

    fn place(&mut self, column: &str, channel: &str, (is_channel_guessed, is_optional): (bool, bool)) {
        let Some(unit) = self.find(column).map(|field| field.unit.to_owned()) else { return };
        self.placed.push(Placed {
            column: column.to_owned(),
            channel: channel.to_owned(),
            unit,
            is_channel_guessed,
            is_optional,
            ..Placed::default()
        });
    }
}

/// Whether a channel's name is `name`, or that with more behind an underscore or a number.
fn is_called(channel: &str, name: &str) -> bool {
    let rest = channel.strip_prefix(name);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(|c: char| c == '_' || c.is_ascii_digit()))
}
