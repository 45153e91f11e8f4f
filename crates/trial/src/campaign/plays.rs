//! Maneuvers with tables of inputs in experiments: each is played whole, so its share is rounded.

use std::collections::BTreeMap;

use design::apportion;
use maneuver::PlayedTable;
use refusal::Invalid;

/// The content of a run: maneuver (its index in the dictionary) and samples, in order.
pub type Plan = Vec<(usize, usize)>;

/// Maneuvers with tables of inputs, by index in the dictionary.
pub type Tables = BTreeMap<usize, PlayedTable>;

/// An experiment of `samples` samples by `shares` of all maneuvers: the number of whole plays of tables that
/// is nearest to their shares, the rest for the others.
///
/// # Errors
/// A rest that no maneuver has a share in.
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
    let own = |(q, n): (usize, u64)| match plays.get(&q) {
        Some(times) => vec![(q, tables[&q].samples); *times],
        None => vec![(q, n as usize); usize::from(n > 0)],
    };
    Ok(counts.into_iter().enumerate().flat_map(own).collect())
}

/// How often every table with a share is played: rounded, within the available time.
fn plays(shares: &[f64], tables: &Tables, samples: usize) -> BTreeMap<usize, usize> {
    let wanted = |q: &usize| shares[*q] * samples as f64;
    let used = tables.iter().filter(|(q, _)| shares.get(**q).is_some_and(|share| *share > 0.0));
    let nearest =
        |(q, table): (&usize, &PlayedTable)| (*q, (wanted(q) / table.samples as f64).round() as usize);
    let mut plays: BTreeMap<usize, usize> = used.map(nearest).collect();
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
pub(super) fn said(shares: &[f64], tables: &Tables, plan: &Plan) -> Vec<String> {
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

/// Those of `maneuvers` that can be drawn for segments of `lengths` samples: all but tables of another
/// length.
pub(crate) fn drawable(maneuvers: &[usize], tables: &Tables, lengths: &[usize]) -> Vec<usize> {
    let fits = |q: &&usize| tables.get(*q).is_none_or(|table| lengths.iter().all(|n| *n == table.samples));
    maneuvers.iter().filter(fits).copied().collect()
}

/// The maneuvers that random trials leave out, for users.
pub(super) fn left_out(
    maneuvers: &[usize],
    kept: &[usize],
    tables: &Tables,
    lengths: &[usize],
) -> Option<String> {
    let left_out = maneuvers.iter().filter(|q| !kept.contains(q)).filter_map(|q| tables.get(q));
    let names: Vec<String> = left_out.map(|t| format!("{} ({} samples)", t.maneuver, t.samples)).collect();
    let longest = lengths.iter().max().copied().unwrap_or(0);
    let why = || format!("tables are not cut to segments of {longest} samples: {}", names.join(", "));
    match (names.is_empty(), kept.is_empty()) {
        (true, _) => None,
        (false, true) => Some(format!("no random trials, since {}", why())),
        (false, false) => {
            Some(format!("random trials go without {} of {}, since {}", names.len(), maneuvers.len(), why()))
        }
    }
}
