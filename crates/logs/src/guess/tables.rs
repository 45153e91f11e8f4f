//! What is in the columns of a table: by motion first, by names where that does not tell.

use super::names::{Named, ROLES, Role};
use super::{Head, Needed, Placed, SAME, usual_unit};
use crate::by_motion::{
    ActuatorChoice, ClockChoice, FoundChannel, FoundMotion, LoggedTable, clocks, motion_of, motion_with_clock,
};
use crate::{TimeUnit, factor};

/// Most columns that are looked at.
pub const MOST: usize = 40;

/// No rudder goes further \[rad\].
const HARD_OVER: f64 = 1.6;

/// Scores above this are not asked about where there is too little motion to tell.
const NEAR: f64 = 0.1;

/// Most choices of a question.
const CHOICES: usize = 9;

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

/// A channel that several columns may be.
#[derive(Clone, Debug, PartialEq)]
pub struct Question {
    /// The channel.
    pub channel: String,
    /// The columns, the best first.
    pub choices: Vec<ColumnChoice>,
}

/// A column that may be a channel, and why.
#[derive(Clone, Debug, PartialEq)]
pub struct ColumnChoice {
    /// How it would be placed.
    pub placed: Placed,
    /// What speaks for it.
    pub why: String,
}

/// What is in a log.
#[derive(Clone, Debug, PartialEq)]
pub struct Guess {
    /// The clock; `None` if no column of times was recognised.
    pub clock: Option<Clock>,
    /// Columns with their channels: motion first, then what the model needs, then what may help.
    pub placed: Vec<Placed>,
    /// Channels that are not placed, though columns come near: first those that the model needs.
    pub asked: Vec<Question>,
    /// Columns without a channel.
    pub unplaced: Vec<String>,
    /// Channels of the model without a column.
    pub missing: Vec<Needed>,
    /// Whether headings count counter-clockwise from east, and axes are those that go with it.
    pub is_east: bool,
    /// Whether columns are called by their numbers.
    pub is_numbered: bool,
}

/// Columns, and what they are as far as it is known.
#[derive(Default)]
pub(super) struct TableSearch<'a> {
    /// The topic of each column, and how it is called there.
    pub(super) columns: Vec<[String; 2]>,
    pub(super) names: Vec<Named>,
    pub(super) needed: &'a [Needed],
    pub(super) found: FoundMotion,
    /// The largest modulus in each column, and whether a number is below zero.
    pub(super) largest: Vec<(f64, bool)>,
    pub(super) free: Vec<bool>,
    pub(super) placed: Vec<Placed>,
    /// The columns of channels that are known by their types.
    pub(super) typed: Vec<(String, usize)>,
    pub(super) asked: Vec<Question>,
    pub(super) missing: Vec<Needed>,
    /// Whether motion says otherwise than types: then nothing is sure by it.
    pub(super) is_doubted: bool,
}

impl Guess {
    /// What `head` with the recordings in `table` is likely to have for a model with the channels `needed`.
    pub fn of(head: &Head, table: &LoggedTable, needed: &[Needed]) -> Self {
        let names: Vec<Named> = head.columns.iter().map(|column| Named::of(column)).collect();
        let fits =
            |at: usize, unit: &str| names[at].unit.is_none_or(|entry| factor(entry, unit) == Some(1.0));
        let looked = looked_at(table, &names, needed);
        let (clock, found) = with_clock(head, table, &names, &looked, &fits);
        let mut free = vec![true; names.len()];
        if let Some((at, _)) = &clock {
            free[*at] = false;
        }
        let most = |at: usize| {
            let all = table.columns.get(at).into_iter().flatten().filter(|value| value.is_finite());
            let largest = all.clone().fold(head.largest(at), |most: f64, value| most.max(value.abs()));
            (largest, all.clone().any(|value| *value < 0.0))
        };
        let largest = (0..names.len()).map(most).collect();
        let columns = head.columns.iter().map(|column| [String::new(), column.clone()]).collect();
        let mut search =
            TableSearch { columns, names, needed, found, largest, free, ..TableSearch::default() };
        search.all();
        let TableSearch { found, free, mut placed, mut asked, missing, .. } = search;
        let mut clock = clock.map(|(_, clock)| clock);
        let unplaced = head.columns.iter().zip(&free).filter(|(_, free)| **free);
        let unplaced: Vec<String> = unplaced.map(|(column, _)| column.clone()).collect();
        // Columns without a name alone are called by their numbers.
        let is_unique = |name: &String| {
            !name.is_empty() && head.columns.iter().filter(|entry| *entry == name).count() == 1
        };
        let used = placed.iter().map(|entry| &entry.column).chain(clock.iter().map(|entry| &entry.column));
        let is_numbered = !head.has_header || !used.clone().all(is_unique);
        if is_numbered && head.has_header {
            let number = |name: &mut String| {
                let at = head.columns.iter().position(|entry| entry == name).unwrap_or(0);
                *name = (at + 1).to_string();
            };
            placed.iter_mut().for_each(|entry| number(&mut entry.column));
            asked
                .iter_mut()
                .flat_map(|entry| &mut entry.choices)
                .for_each(|entry| number(&mut entry.placed.column));
            clock.iter_mut().for_each(|entry| number(&mut entry.column));
        }
        Self {
            clock,
            placed,
            asked,
            unplaced,
            missing,
            is_east: found.is_east && found.is_known,
            is_numbered,
        }
    }

    /// Takes an answer to a question: the column at `choice`.
    pub fn answer(&mut self, question: usize, choice: usize) {
        let Question { channel, choices } = self.asked.remove(question);
        let mut placed = choices[choice].placed.clone();
        placed.by_motion = Some(format!("as answered, {}", choices[choice].why));
        let is_same = |other: &Placed| (&other.topic, &other.column) == (&placed.topic, &placed.column);
        self.missing.retain(|need| need.channel != channel);
        self.unplaced.retain(|column| *column != placed.column);
        for other in &mut self.asked {
            other.choices.retain(|entry| !is_same(&entry.placed));
        }
        self.asked.retain(|other| !other.choices.is_empty());
        self.placed.retain(|other| other.channel != channel);
        self.placed.push(placed);
    }
}

/// The columns that are looked at: those that names say something of before others.
fn looked_at(table: &LoggedTable, names: &[Named], needed: &[Needed]) -> Vec<usize> {
    let moves = |at: &usize| {
        *at < table.columns.len() && table.columns[*at].windows(2).any(|pair| pair[0] != pair[1])
    };
    let mut all: Vec<usize> = (0..names.len()).filter(moves).collect();
    if all.len() > MOST {
        all.sort_by_key(|at| (!is_called(&names[*at], needed), *at));
        all.truncate(MOST);
        all.sort_unstable();
    }
    all
}

/// Whether a name says something.
pub(super) fn is_called(name: &Named, needed: &[Needed]) -> bool {
    let wanted = needed.iter().map(|need| need.channel.as_str());
    ROLES.iter().map(|role| role.channel).chain(wanted).any(|channel| name.likeness(channel).is_some())
}

/// The clock, and what moves by it.
fn with_clock(
    head: &Head,
    table: &LoggedTable,
    names: &[Named],
    looked: &[usize],
    fits: &dyn Fn(usize, &str) -> bool,
) -> (Option<(usize, Clock)>, FoundMotion) {
    let clock = |at: usize, unit: TimeUnit| {
        let is_unit_guessed = names[at].unit.is_none() && unit != TimeUnit::Iso8601;
        let step_s = head.step(at)? * unit.seconds().unwrap_or(1.0);
        Some((at, Clock { column: head.columns[at].clone(), unit, is_unit_guessed, step_s }))
    };
    let is_text = |at: usize| head.is_text(at) && head.has_iso_times(at);
    let unit_fits = |entry: &ClockChoice| match names[entry.column].unit {
        Some("s") => entry.unit == TimeUnit::S,
        Some("ms") => entry.unit == TimeUnit::Ms,
        Some(_) => false,
        None => entry.unit == TimeUnit::S || !is_text(entry.column),
    };
    let mut choices: Vec<ClockChoice> = clocks(table).into_iter().filter(unit_fits).collect();
    // Of clocks that explain alike, one that is called so, and one that is text.
    choices.sort_by_key(|entry| (!is_text(entry.column), !names[entry.column].is_time(), entry.is_counter));
    let free: Vec<usize> = looked.to_vec();
    if let Some((choice, moved)) = motion_with_clock(table, &choices, &free, fits) {
        let unit = match is_text(choice.column) {
            true => TimeUnit::Iso8601,
            false if !moved.is_known && names[choice.column].unit.is_none() => {
                count_of(head.largest(choice.column))
            }
            false => choice.unit,
        };
        return (clock(choice.column, unit), moved);
    }
    // An uneven clock is known by its name; a few rows by their order.
    let called = names.iter().position(Named::is_time);
    let Some(at) = called.or_else(|| head.increases(0).then_some(0)) else {
        return (None, FoundMotion::default());
    };
    let unit = match (head.has_iso_times(at), names[at].unit) {
        (true, _) => TimeUnit::Iso8601,
        (false, Some("ms")) => TimeUnit::Ms,
        (false, Some("s")) => TimeUnit::S,
        (false, _) if head.is_text(at) => return (None, FoundMotion::default()),
        (false, _) => count_of(head.largest(at)),
    };
    let size = unit.seconds().unwrap_or(1.0);
    let known = table.columns.get(at).filter(|entry| entry.iter().all(|time| time.is_finite()));
    let free: Vec<usize> = looked.iter().copied().filter(|other| *other != at).collect();
    let time: Option<Vec<f64>> = known.map(|entry| entry.iter().map(|count| size * count).collect());
    let moved = time.map_or_else(FoundMotion::default, |time| motion_of(table, &time, &free, fits));
    (clock(at, unit), moved)
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

impl TableSearch<'_> {
    /// Places all that can be placed.
    pub(super) fn all(&mut self) {
        self.motion();
        self.actuators();
        self.further();
        let missing = &self.missing;
        self.asked.sort_by_key(|question| !missing.iter().any(|need| need.channel == question.channel));
    }

    /// Places the channels of the motion.
    fn motion(&mut self) {
        let roles = ROLES.iter().filter(|role| !role.is_optional).map(|role| (role.channel, role.unit));
        for (channel, unit) in [("v_x", "m/s"), ("v_y", "m/s")].into_iter().chain(roles) {
            let nearest = self.found.channels.iter().find(|entry| entry.channel == channel).cloned();
            let is_sure = |entry: &FoundChannel| {
                entry.is_sure && !self.names[entry.column].is_other() && !self.is_doubted
            };
            let is_said = self.has(channel) || self.is_said_otherwise(channel);
            match nearest {
                Some(nearest) if is_said && !self.typed.is_empty() => self.contradicted(&nearest),
                None if is_said && !self.typed.is_empty() => {}
                Some(nearest) if is_sure(&nearest) => self.place_found(&nearest),
                Some(nearest) => self.near(&nearest, unit),
                // Where motion told all that there is, it told that nothing is this channel; sway may be too little to be seen.
                None if self.found.is_known && (channel != "y_v" || self.has("v_x")) => {}
                None if self.is_said_otherwise(channel) => {}
                None => self.by_name(channel, unit),
            }
        }
    }

    fn has(&self, channel: &str) -> bool {
        self.placed.iter().any(|known| known.channel == channel)
    }

    /// Whether another channel with the same information is placed: positions are logged one way.
    fn is_said_otherwise(&self, channel: &str) -> bool {
        let is_typed = |other: &str| self.typed.iter().any(|(typed, _)| typed == other);
        if SAME.iter().any(|pair| pair.contains(&channel) && pair.iter().any(|other| is_typed(other))) {
            return true;
        }
        let places = |entry: &FoundChannel| entry.channel.ends_with("tude_deg") && entry.is_sure;
        channel.ends_with("tude_deg") && self.has("x")
            || ["x", "y"].contains(&channel) && self.found.channels.iter().any(places)
    }

    /// Places the best column of what is not sure by its name, or else asks.
    fn near(&mut self, found: &FoundChannel, unit: &str) {
        let all: Vec<usize> =
            [found.column].into_iter().chain(found.rivals.iter().map(|(at, _)| *at)).collect();
        let rank = |at: &usize| self.names[*at].likeness(found.channel);
        let called = all.into_iter().filter(|at| self.free[*at] && rank(at).is_some()).min_by_key(rank);
        match called {
            Some(at) if at == found.column => self.place_found(found),
            Some(at) => self.place(at, (found.channel, unit)),
            None if self.best(found.channel, unit).is_some() && !self.found.is_known => {
                self.by_name(found.channel, unit);
            }
            None if self.is_said_otherwise(found.channel) || !self.found.is_known && found.score > NEAR => {}
            None => {
                let scores = [(found.column, found.score)].into_iter().chain(found.rivals.iter().copied());
                let choices =
                    scores.filter(|(at, _)| self.free[*at] && !self.names[*at].is_other()).take(CHOICES);
                let choice = |(at, score): (usize, f64)| {
                    let placed = match at == found.column {
                        true => self.as_found(found),
                        false => self.placed_at(at, (found.channel, unit)),
                    };
                    ColumnChoice { placed, why: format!("score {score:.3}") }
                };
                let choices: Vec<ColumnChoice> = choices.map(choice).collect();
                if !choices.is_empty() {
                    self.asked.push(Question { channel: found.channel.to_owned(), choices });
                }
            }
        }
    }

    /// Lists a column that by motion is what another is by its type, where that is sure.
    fn contradicted(&mut self, found: &FoundChannel) {
        let typed = self.typed.iter().find(|(channel, _)| channel == found.channel);
        if found.is_sure && typed.is_some_and(|(_, at)| *at != found.column || found.sign < 0.0) {
            let way = if found.sign < 0.0 { "reversed, " } else { "" };
            let why = format!("{way}by motion, score {:.3}, against the type of the message", found.score);
            let choices = vec![ColumnChoice { placed: self.as_found(found), why }];
            self.asked.push(Question { channel: found.channel.to_owned(), choices });
        }
    }

    fn place_found(&mut self, found: &FoundChannel) {
        if self.free[found.column] {
            self.free[found.column] = false;
            self.placed.push(self.as_found(found));
        }
    }

    fn as_found(&self, found: &FoundChannel) -> Placed {
        let by_motion = format!(
            "by motion, score {:.3}{}",
            found.score,
            if found.is_sure { "" } else { ", and its name" }
        );
        Placed {
            unit: self.names[found.column].unit.unwrap_or(found.unit).to_owned(),
            is_reversed: found.sign < 0.0,
            by_motion: Some(by_motion),
            ..self.placed_at(found.column, (found.channel, found.unit))
        }
    }

    fn placed_at(&self, at: usize, (channel, unit): (&str, &str)) -> Placed {
        let name = &self.names[at];
        let (largest, has_negative) = self.largest[at];
        let usual = || match unit {
            "rad" if channel.starts_with("delta") && largest > HARD_OVER => "deg".to_owned(),
            unit => usual_unit(unit, largest).to_owned(),
        };
        let role: Option<&Role> = ROLES.iter().find(|role| role.channel == channel);
        let is_needed = self.needed.iter().any(|need| need.channel == channel);
        Placed {
            topic: self.columns[at][0].clone(),
            column: self.columns[at][1].clone(),
            channel: channel.to_owned(),
            unit: name.unit.map_or_else(usual, str::to_owned),
            is_channel_guessed: name.likeness(channel) != Some(0),
            is_unit_guessed: name.unit.is_none(),
            is_optional: role.is_some_and(|role| role.is_optional) && !is_needed,
            has_negative,
            ..Placed::default()
        }
    }

    /// The free column whose name fits `channel` best and whose unit, if its name says one, measures the same as `unit`.
    fn best(&self, channel: &str, unit: &str) -> Option<usize> {
        let fits = |at: &usize| self.free[*at] && self.names[*at].measures(channel, unit);
        let all = (0..self.names.len()).filter(fits);
        let rated = all.filter_map(|at| Some((self.names[at].likeness(channel)?, at)));
        // Of two that fit alike the one that says its unit, or else the first.
        rated.min_by_key(|(rank, at)| (*rank, self.names[*at].unit.is_none(), *at)).map(|(_, at)| at)
    }

    fn by_name(&mut self, channel: &str, unit: &str) {
        if let Some(at) = self.best(channel, unit) {
            self.place(at, (channel, unit));
        }
    }

    fn place(&mut self, at: usize, wanted: (&str, &str)) {
        self.free[at] = false;
        self.placed.push(self.placed_at(at, wanted));
    }

    /// Places what the model needs: what is sure by motion, then by names among what may be actuators.
    fn actuators(&mut self) {
        let needed: Vec<Needed> =
            self.needed.iter().filter(|need| !self.has(&need.channel)).cloned().collect();
        let steers = |need: &Needed| need.unit == "rad";
        self.sides(&needed);
        for need in &needed {
            if self.has(&need.channel) {
                continue;
            }
            let entry = if steers(need) { &self.found.steering } else { &self.found.drive };
            let is_alone = needed.iter().filter(|other| steers(other) == steers(need)).count() == 1;
            let sure = entry.first().filter(|first| is_alone && self.is_sure(first, need)).cloned();
            match sure {
                Some(first) => self.place_actuator(first.columns[0], need, first.gain),
                None => {
                    let moved = self.placed.len();
                    self.by_name(&need.channel, &need.unit);
                    if self.placed.len() == moved {
                        self.missing.push(need.clone());
                    }
                }
            }
        }
        for need in self.missing.clone() {
            let entry = if steers(&need) { &self.found.steering } else { &self.found.drive };
            let ranked = entry
                .iter()
                .filter(|entry| entry.columns.len() == 1)
                .map(|entry| (entry.columns[0], entry.gain));
            let mut all: Vec<(usize, Option<f64>)> = ranked.map(|(at, gain)| (at, Some(gain))).collect();
            let others = self.found.candidates.iter().filter(|at| all.iter().all(|(known, _)| known != *at));
            let others: Vec<(usize, Option<f64>)> = others.map(|at| (*at, None)).collect();
            all.extend(others);
            all.retain(|(at, _)| self.may_be(*at, &need));
            let choice = |(at, gain): &(usize, Option<f64>)| ColumnChoice {
                placed: self.placed_at(*at, (&need.channel, &need.unit)),
                why: gain.map_or("does not stand out".to_owned(), |gain| format!("gain {gain:.2}")),
            };
            let choices: Vec<ColumnChoice> = all.iter().take(CHOICES).map(choice).collect();
            if !choices.is_empty() && self.found.is_known {
                self.asked.push(Question { channel: need.channel.clone(), choices });
            }
        }
    }

    /// Places the propellers to port and to starboard that names do not tell: what turns the ship to starboard is the one to port.
    fn sides(&mut self, needed: &[Needed]) {
        let [port, starboard] = needed else { return };
        let are_sides = port.channel.ends_with("port") && starboard.channel.ends_with("starboard");
        let pair = self.found.steering.first().filter(|pair| are_sides && self.stands_out(pair, port));
        let Some(&ActuatorChoice { columns: ref pair, gain, sign, .. }) = pair else { return };
        let &[a, b] = &pair[..] else { return };
        let is_named = |need: &Needed| self.best(&need.channel, &need.unit).is_some();
        if is_named(port) && is_named(starboard) {
            return;
        }
        let sides = if sign > 0.0 { [a, b] } else { [b, a] };
        for (at, need) in sides.into_iter().zip([port, starboard]) {
            self.place_actuator(at, need, gain);
        }
    }

    fn place_actuator(&mut self, at: usize, need: &Needed, gain: f64) {
        self.free[at] = false;
        let by_motion = Some(format!("by motion, gain {gain:.2}"));
        let placed = self.placed_at(at, (&need.channel, &need.unit));
        self.placed.push(Placed { by_motion, ..placed });
    }

    /// Whether one column steers or drives beyond doubt.
    fn is_sure(&self, first: &ActuatorChoice, need: &Needed) -> bool {
        first.columns.len() == 1 && self.stands_out(first, need)
    }

    /// Whether columns steer or drive beyond doubt, and none of them is called something else.
    fn stands_out(&self, choice: &ActuatorChoice, need: &Needed) -> bool {
        let known = self.found.is_known && !self.is_doubted && choice.is_sure;
        known && choice.columns.iter().all(|at| self.may_be(*at, need))
    }

    /// Whether a column is free, called nothing else, and in a unit that may be that of `need`.
    fn may_be(&self, at: usize, need: &Needed) -> bool {
        let unit = self.names[at].unit;
        let fits = unit.is_none_or(|unit| crate::shaft_factor(unit, &need.unit).is_some());
        self.free[at] && fits && !self.names[at].is_other()
    }

    /// Places what is of use, but not needed, by its name.
    fn further(&mut self) {
        for role in ROLES.iter().filter(|role| role.is_optional) {
            if !self.has(role.channel) {
                self.by_name(role.channel, role.unit);
            }
        }
    }
}
