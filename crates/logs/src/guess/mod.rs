//! What is in a log, by the names of its columns and the first of its rows: a proposal for a person to check.

mod names;
mod topics;

pub use names::{Head, Named};
pub use topics::{BagGuess, TopicGuess};

use std::collections::BTreeMap;

use crate::{Spoken, SpokenField, TimeUnit, factor, shaft_factor};
use names::{ROLES, Role};

/// The clock of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Clock {
    /// Its column.
    pub column: String,
    /// What it counts.
    pub unit: TimeUnit,
    /// Whether the name of the column says no unit.
    pub is_unit_guessed: bool,
    /// Usual time between rows \[s\].
    pub step_s: f64,
}

/// What is in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// The clock; `None` if no column of times was recognised.
    pub clock: Option<Clock>,
    /// Columns with their channels: motion first, then what the model needs, then what may help.
    pub placed: Vec<Placed>,
    /// Columns without a channel.
    pub unplaced: Vec<String>,
    /// Channels of the model without a column.
    pub missing: Vec<Needed>,
}

impl Guess {
    /// What `head` is likely to have for a model with the channels `needed`.
    pub fn of(head: &Head, needed: &[Needed]) -> Self {
        let names: Vec<Named> = head.columns.iter().map(|column| Named::of(column)).collect();
        let mut free: Vec<bool> = vec![true; names.len()];
        let clock = clock(head, &names);
        if let Some((at, _)) = &clock {
            free[*at] = false;
        }
        let (mut placed, mut missing) = (Vec::<Placed>::new(), Vec::new());
        let wanted = needed.iter().map(|need| (need.channel.as_str(), need.unit.as_str()));
        let motion = ROLES.iter().filter(|role| !role.is_optional).map(|role| (role.channel, role.unit));
        let further = ROLES.iter().filter(|role| role.is_optional).map(|role| (role.channel, role.unit));
        for (channel, unit) in motion.chain(wanted.clone()).chain(further) {
            // A position is logged one way: what else tells it is left out.
            let is_told = channel.ends_with("tude_deg") && placed.iter().any(|known| known.channel == "x");
            match best(&names, &free, channel, unit).filter(|_| !is_told) {
                Some(at) => {
                    free[at] = false;
                    placed.push(place(head, &names[at], at, (channel, unit)));
                }
                None => missing.extend(needed.iter().find(|need| need.channel == channel).cloned()),
            }
        }
        for column in &mut placed {
            column.is_optional &= !wanted.clone().any(|(channel, _)| channel == column.channel);
        }
        let left = head.columns.iter().zip(free).filter(|(_, free)| *free);
        let unplaced = left.map(|(column, _)| column.clone()).collect();
        Self { clock: clock.map(|(_, clock)| clock), placed, unplaced, missing }
    }
}

/// The free column whose name fits `channel` best and whose unit, if its name says one, measures the same as `unit`.
fn best(names: &[Named], free: &[bool], channel: &str, unit: &str) -> Option<usize> {
    let fits = |at: &usize| free[*at] && names[*at].measures(channel, unit);
    let rated = (0..names.len()).filter(fits).filter_map(|at| Some((names[at].likeness(channel)?, at)));
    // Of two that fit alike the first.
    rated.min_by_key(|(rank, at)| (*rank, *at)).map(|(_, at)| at)
}

fn place(head: &Head, name: &Named, at: usize, (channel, unit): (&str, &str)) -> Placed {
    let usual = || usual_unit(unit, head.largest(at)).to_owned();
    let role: Option<&Role> = ROLES.iter().find(|role| role.channel == channel);
    Placed {
        column: head.columns[at].clone(),
        channel: channel.to_owned(),
        unit: name.unit.map_or_else(usual, str::to_owned),
        is_channel_guessed: name.likeness(channel) != Some(0),
        is_unit_guessed: name.unit.is_none(),
        is_optional: role.is_some_and(|role| role.is_optional),
    }
}

/// The first column that is called a time, or else a first column that only increases.
fn clock(head: &Head, names: &[Named]) -> Option<(usize, Clock)> {
    let called = names.iter().position(|name| name.is_time());
    let at = called.or_else(|| head.increases(0).then_some(0))?;
    let (unit, is_unit_guessed) = match (head.has_iso_times(at), names[at].unit) {
        (true, _) => (TimeUnit::Iso8601, false),
        (false, Some("ms")) => (TimeUnit::Ms, false),
        (false, Some("s")) => (TimeUnit::S, false),
        (false, _) if head.is_text(at) => return None,
        (false, _) => (count_of(head.largest(at)), true),
    };
    let step_s = head.step(at)? * unit.seconds().unwrap_or(1.0);
    Some((at, Clock { column: head.columns[at].clone(), unit, is_unit_guessed, step_s }))
}

/// What a time up to `largest` counts, if it counts from 1970: else seconds.
fn count_of(largest: f64) -> TimeUnit {
    match largest {
        _ if largest > 1e17 => TimeUnit::Ns,
        _ if largest > 1e14 => TimeUnit::Us,
        _ if largest > 1e11 => TimeUnit::Ms,
        _ => TimeUnit::S,
    }
}

/// A channel that is wanted of a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Needed {
    /// Its name, such as `delta`.
    pub channel: String,
    /// Its unit in the model.
    pub unit: String,
}

/// A column that was given a channel.
#[derive(Clone, Debug, PartialEq)]
pub struct Placed {
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
}

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
            is_unit_guessed: false,
            is_optional,
        });
    }
}

/// Whether a channel's name is `name`, or that with more behind an underscore or a number.
fn is_called(channel: &str, name: &str) -> bool {
    let rest = channel.strip_prefix(name);
    rest.is_some_and(|rest| rest.is_empty() || rest.starts_with(|c: char| c == '_' || c.is_ascii_digit()))
}
