use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::sync::Arc;

use design::apportion;
use maneuver::{Generator, PlayedTable, Realized};
use refusal::Invalid;
use ship::engine::Helm;

use super::Refusal;

/// Maneuvers at the lengths of plans, realized once.
#[derive(Clone, Default)]
pub struct Parts {
    /// Maneuvers that are stretched to their length.
    stretched: BTreeMap<(usize, usize), Realized>,
    /// The others at the greatest length so far: shorter ones are their beginnings.
    longest: BTreeMap<usize, (usize, Arc<Realized>)>,
}

impl Parts {
    /// Realizes the missing parts of `plan`.
    ///
    /// # Errors
    /// A maneuver that the model cannot hold.
    pub fn make(&mut self, generator: &Generator, plan: &[(usize, usize)]) -> Result<(), Invalid> {
        for (index, samples) in plan {
            if !generator.is_unstretched(*index) {
                if let Entry::Vacant(entry) = self.stretched.entry((*index, *samples)) {
                    entry.insert(generator.realize(*index, *samples)?);
                }
            } else if self.longest.get(index).is_none_or(|(longest, _)| longest < samples) {
                // A length that was too short once will be so again: realize half as much more, if the model can hold it.
                let more = if self.longest.contains_key(index) { samples + samples / 2 } else { *samples };
                let made = match generator.realize(*index, more) {
                    Ok(made) => (more, Arc::new(made)),
                    Err(_) => (*samples, Arc::new(generator.realize(*index, *samples)?)),
                };
                self.longest.insert(*index, made);
            }
        }
        Ok(())
    }

    /// Takes over the unstretched maneuvers of `others`, for other plans.
    pub(crate) fn take(&mut self, others: Self) {
        for (index, other) in others.longest {
            if self.longest.get(&index).is_none_or(|(longest, _)| *longest < other.0) {
                self.longest.insert(index, other);
            }
        }
    }

    /// Initial state u, v \[m/s\], r \[rad/s\] and inputs, N × inputs, of a realized plan.
    pub fn joined(&self, plan: &[(usize, usize)]) -> ([f64; 3], Vec<f64>) {
        let initial = plan.first().map_or([0.0; 3], |part| self.part(part).0.initial);
        (initial, plan.iter().map(|part| self.part(part).1).collect::<Vec<_>>().concat())
    }

    /// The helms of a realized plan, each for its samples; tables for parts that do not react.
    pub(crate) fn helms(&self, plan: &[(usize, usize)]) -> Vec<(Helm, usize)> {
        let experiment = |part: &(usize, usize)| {
            let (made, inputs) = self.part(part);
            (made.helm.clone().unwrap_or_else(|| Helm::table(inputs)), part.1)
        };
        plan.iter().map(experiment).collect()
    }

    /// Whether any part that was realized reacts.
    pub(crate) fn react(&self) -> bool {
        let mut all = self.stretched.values().chain(self.longest.values().map(|(_, longest)| &**longest));
        all.any(|experiment| experiment.helm.is_some())
    }

    /// A realized part, and its inputs.
    fn part(&self, part: &(usize, usize)) -> (&Realized, &[f64]) {
        match self.stretched.get(part) {
            Some(stretched) => (stretched, &stretched.inputs),
            None => {
                let (samples, longest) = &self.longest[&part.0];
                (longest, &longest.inputs[..longest.inputs.len() / samples * part.1])
            }
        }
    }
}

impl FromIterator<((usize, usize), Realized)> for Parts {
    fn from_iter<I: IntoIterator<Item = ((usize, usize), Realized)>>(parts: I) -> Self {
        Self { stretched: parts.into_iter().collect(), longest: BTreeMap::new() }
    }
}

/// An experiment as a design states it.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Designed {
    /// Share of the samples of each maneuver, by name; zero for others.
    pub shares: BTreeMap<String, f64>,
    /// Maneuvers and samples in the design's own order; by default that of the dictionary.
    pub order: Option<Vec<(String, usize)>>,
}

impl Designed {
    /// The plan of a run of `samples` samples; `names` are those of the dictionary, of which `tables` are played whole.
    ///
    /// # Errors
    /// A maneuver that the dictionary does not have, invalid shares, an order of another length or with parts
    /// of tables, no sample, samples that no maneuver fills.
    pub fn plan(&self, names: &[String], tables: &Tables, samples: usize) -> Result<Plan, Refusal> {
        if let Some(unknown) = self.shares.keys().find(|name| !names.contains(name)) {
            return Err(Refusal::UnknownManeuver { name: unknown.clone(), ordered: false });
        }
        check_shares(&self.shares).map_err(Refusal::Design)?;
        if let Some(order) = &self.order {
            return ordered(order, names, tables, samples);
        }
        if samples == 0 {
            return Err(too_short(samples, "duration_s"));
        }
        shared_out(&self.of(names), tables, samples).map_err(Refusal::Campaign)
    }

    /// The shares of maneuvers `names`.
    fn of(&self, names: &[String]) -> Vec<f64> {
        names.iter().map(|name| self.shares.get(name).copied().unwrap_or(0.0)).collect()
    }

    /// The effect of rounding the shares of tables in `plan`, one line each.
    pub(super) fn said(&self, names: &[String], tables: &Tables, plan: &Plan) -> Vec<String> {
        if self.order.is_some() { Vec::new() } else { said(&self.of(names), tables, plan) }
    }

    /// Stops whose share is one piece longer than the maneuver itself, one line each: the ship is at rest for the remainder.
    pub(super) fn at_rest(&self, generator: &Generator, plan: &Plan, rate_hz: f64) -> Vec<String> {
        let one = |(q, samples): &(usize, usize)| {
            let whole =
                generator.samples(*q).ok().filter(|needed| needed < samples && generator.stops(*q))?;
            let [piece_s, whole_s] = [*samples, whole].map(|samples| samples as f64 / rate_hz);
            let name = &generator.maneuvers()[*q].name;
            Some(format!(
                "{name} has its share in one piece of {piece_s:.0} s, though it takes {whole_s:.0} s at most: \
                 `seatrial design --arrange` cuts it into several"
            ))
        };
        if self.order.is_some() { Vec::new() } else { plan.iter().filter_map(one).collect() }
    }
}

/// Refuses shares that are invalid or do not sum to one.
///
/// # Errors
/// Names the share.
pub fn check_shares(shares: &BTreeMap<String, f64>) -> Result<(), Invalid> {
    let refuse = |thing: String, found: f64, expected: &str| {
        Err(Invalid::new(thing, found.to_string(), expected, "make the design again"))
    };
    if let Some((name, share)) = shares.iter().find(|(_, share)| !(0.0..=1.0).contains(*share)) {
        return refuse(format!("`data.shares` of `{name}`"), *share, "a share from 0 to 1");
    }
    let sum = shares.values().fold(0.0, |sum, share| sum + share);
    if (sum - 1.0).abs() > 1e-6 { refuse("sum of `data.shares`".into(), sum, "1") } else { Ok(()) }
}

/// The design's own order and lengths.
fn ordered(
    order: &[(String, usize)],
    names: &[String],
    tables: &Tables,
    samples: usize,
) -> Result<Plan, Refusal> {
    let total = order.iter().map(|(_, n)| n).sum();
    if total != samples {
        return Err(Refusal::OtherLength { ordered: total, samples });
    }
    let refuse = |found, expected: &str| {
        Err(Refusal::Design(Invalid::new("`data.sequence`", found, expected, "arrange it again")))
    };
    let mut plan = Plan::new();
    for (name, n) in order {
        let Some(q) = names.iter().position(|known| known == name) else {
            return Err(Refusal::UnknownManeuver { name: name.clone(), ordered: true });
        };
        let part = tables.get(&q).map_or(*n, |table| table.samples);
        if *n == 0 {
            return refuse(format!("`{name}` without a sample"), "at least one");
        }
        if n % part != 0 {
            let value = format!("{n} samples of `{name}`, which has a table of {part}");
            return refuse(value, "whole plays of its table");
        }
        plan.extend(std::iter::repeat_n((q, part), n / part));
    }
    Ok(plan)
}

/// The refusal of runs of `samples` samples that `key` makes too short.
pub(super) fn too_short(samples: usize, key: &str) -> Refusal {
    Refusal::Campaign(Invalid::new(
        format!("`{key}`"),
        format!("runs of {samples} samples"),
        "at least one sample per segment",
        "lengthen `duration_s` or take fewer segments",
    ))
}

/// The content of a run: maneuver (its index in the dictionary) and samples, in order.
pub type Plan = Vec<(usize, usize)>;

/// Maneuvers with tables of inputs, by index in the dictionary.
pub type Tables = BTreeMap<usize, PlayedTable>;

/// An experiment of `samples` samples by `shares` of all maneuvers: the number of whole plays of tables that
/// is nearest to their shares, the rest for the others.
pub(crate) fn shared_out(shares: &[f64], tables: &Tables, samples: usize) -> Result<Plan, Invalid> {
    let plays = plays(shares, tables, samples);
    let mut others = shares.to_vec();
    if !plays.is_empty() {
        plays.keys().for_each(|q| others[*q] = 0.0);
        let sum: f64 = others.iter().sum();
        others.iter_mut().filter(|share| **share > 0.0).for_each(|share| *share /= sum);
    }
    let taken: usize = plays.iter().map(|(q, n)| n * tables[q].samples).sum();
    if taken < samples && others.iter().all(|share| *share <= 0.0) {
        return Err(unfilled(&plays, tables, taken, samples));
    }
    let counts = apportion(&others, (samples - taken) as u64);
    let plays_of = |(q, n): (usize, u64)| match plays.get(&q) {
        Some(times) => vec![(q, tables[&q].samples); *times],
        None => vec![(q, n as usize); usize::from(n > 0)],
    };
    Ok(counts.into_iter().enumerate().flat_map(plays_of).collect())
}

/// How often every table with a share is played: rounded, within the available time.
fn plays(shares: &[f64], tables: &Tables, samples: usize) -> BTreeMap<usize, usize> {
    let wanted = |q: &usize| shares[*q] * samples as f64;
    let used = tables.iter().filter(|(q, _)| shares.get(**q).is_some_and(|share| *share > 0.0));
    let near = |(q, table): (&usize, &PlayedTable)| (*q, (wanted(q) / table.samples as f64).round() as usize);
    let mut plays: BTreeMap<usize, usize> = used.map(near).collect();
    while plays.iter().map(|(q, n)| n * tables[q].samples).sum::<usize>() > samples {
        let over = |(q, n): &(&usize, &usize)| (**n * tables[*q].samples) as f64 - wanted(q);
        let played = plays.iter().filter(|(_, n)| **n > 0);
        let Some(most) = played.max_by(|a, b| over(a).total_cmp(&over(b))).map(|(q, _)| *q) else { break };
        plays.entry(most).and_modify(|n| *n -= 1);
    }
    plays
}

fn unfilled(plays: &BTreeMap<usize, usize>, tables: &Tables, taken: usize, samples: usize) -> Invalid {
    let each =
        plays.iter().map(|(q, n)| format!("{n} of {} ({} s)", tables[q].maneuver, tables[q].duration_s()));
    let each = each.collect::<Vec<_>>().join(", ");
    Invalid::new(
        "`duration_s`",
        format!("runs of {samples} samples, of which whole plays of tables fill {taken}: {each}"),
        "whole plays, or a maneuver without a table that has a share of the rest",
        "change it to whole plays",
    )
}

/// The effect of rounding the shares of tables in `plan`, for users.
fn said(shares: &[f64], tables: &Tables, plan: &Plan) -> Vec<String> {
    let samples: usize = plan.iter().map(|(_, n)| n).sum();
    let used = tables.iter().filter(|(q, _)| shares.get(**q).is_some_and(|share| *share > 0.0));
    let one = |(q, table): (&usize, &PlayedTable)| {
        let times = plan.iter().filter(|(part, _)| part == q).count();
        let took = 100.0 * (times * table.samples) as f64 / samples.max(1) as f64;
        let (name, seconds, share) = (&table.maneuver, table.duration_s(), 100.0 * shares[*q]);
        let times = if times == 1 { "once".to_owned() } else { format!("{times} times") };
        format!(
            "{name}, a table of {seconds} s, is played {times}: {took:.1} % of the time for a share of {share:.1} %"
        )
    };
    used.map(one).collect()
}

/// Those of `maneuvers` that can be drawn for segments of `lengths` samples: all but tables of another length.
pub(crate) fn drawable(maneuvers: &[usize], tables: &Tables, lengths: &[usize]) -> Vec<usize> {
    let fits = |q: &&usize| tables.get(*q).is_none_or(|table| lengths.iter().all(|n| *n == table.samples));
    maneuvers.iter().filter(fits).copied().collect()
}

/// The maneuvers that random trials leave out, for users.
pub(super) fn left_out(all: &[usize], kept: &[usize], tables: &Tables, lengths: &[usize]) -> Option<String> {
    let left_out = all.iter().filter(|q| !kept.contains(q)).filter_map(|q| tables.get(q));
    let names: Vec<String> = left_out.map(|t| format!("{} ({} samples)", t.maneuver, t.samples)).collect();
    let longest = lengths.iter().max().copied().unwrap_or(0);
    let why = || format!("tables are not cut to segments of {longest} samples: {}", names.join(", "));
    match (names.is_empty(), kept.is_empty()) {
        (true, _) => None,
        (false, true) => Some(format!("no random trials, since {}", why())),
        _ => Some(format!("random trials go without {} of {}, since {}", names.len(), all.len(), why())),
    }
}
