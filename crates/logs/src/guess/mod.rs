//! What is in a log, by the names of its columns and the first of its rows: a proposal for a person to check.

mod head;
mod messages;
mod names;
mod placed;
mod sentences;
mod topics;

pub use head::Head;
pub use names::Named;
pub use placed::{Needed, Placed};
pub use sentences::SentenceGuess;
pub use topics::{BagGuess, TopicGuess};

use crate::TimeUnit;
use names::{ROLES, Role};
use placed::usual_unit;

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
        let wanted = needed.iter().map(|own| (own.channel.as_str(), own.unit.as_str()));
        let motion = ROLES.iter().filter(|role| !role.is_optional).map(|role| (role.channel, role.unit));
        let further = ROLES.iter().filter(|role| role.is_optional).map(|role| (role.channel, role.unit));
        for (channel, unit) in motion.chain(wanted.clone()).chain(further) {
            // A position is logged one way: what else tells it is left out.
            let is_told = channel.ends_with("tude_deg") && placed.iter().any(|own| own.channel == "x");
            match best(&names, &free, channel, unit).filter(|_| !is_told) {
                Some(at) => {
                    free[at] = false;
                    placed.push(place(head, &names[at], at, (channel, unit)));
                }
                None => missing.extend(needed.iter().find(|own| own.channel == channel).cloned()),
            }
        }
        for own in &mut placed {
            own.is_optional &= !wanted.clone().any(|(channel, _)| channel == own.channel);
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
