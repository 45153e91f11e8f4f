//! The sensor of each channel, where there are several.

use refusal::Invalid;

use super::clock::has_time;
use super::clockwork::Clock;
use super::fields::Column;
use super::table::Table;
use crate::{Apart, ChannelSpec, WarningKind, WarningSummary};

/// The tables that the channels are taken from.
pub(super) struct Sources<'a> {
    pub(super) wanted: &'a [Column],
    pub(super) specs: &'a [ChannelSpec],
    /// Talkers, best first.
    pub(super) prefer: &'a [String],
    /// The clock's name in messages.
    pub(super) clock: &'a str,
}

/// Share of a table's sentences whose time may be far from the clock's.
const FEW: f64 = 0.1;

impl Sources<'_> {
    /// The tables as files of their own, with their channels; warnings are appended to `warnings`.
    ///
    /// # Errors
    /// Several sensors for a channel; times that are not the clock's.
    pub(super) fn apart(
        &self,
        tables: Vec<Table>,
        clock: &Clock,
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<Vec<Apart>, Invalid> {
        let mut ranks: Vec<Vec<(usize, usize)>> = tables.iter().map(|_| Vec::new()).collect();
        for place in 0..self.wanted.len() {
            for (rank, table) in self.of_channel(place, &tables, warnings)?.into_iter().enumerate() {
                ranks[table].push((place, rank));
            }
        }
        let used = || tables.iter().zip(&ranks).filter(|(_, ranks)| !ranks.is_empty());
        used().try_for_each(|(table, _)| check_times(table, self.clock))?;
        used().for_each(|(table, ranks)| self.warn(table, ranks, warnings));
        let all = tables.into_iter().zip(ranks).map(|(table, ranks)| {
            let channels: Vec<(usize, Option<usize>)> = table
                .places
                .iter()
                .map(|place| (*place, ranks.iter().find(|(own, _)| own == place).map(|(_, rank)| *rank)))
                .collect();
            let is_sorted = clock.is_in_order() && has_time(&table.address);
            Apart {
                source: table.address.clone(),
                channels,
                columns: table.into_columns(clock.is_stamping(), is_sorted),
            }
        });
        Ok(all.collect())
    }

    /// The tables that provide channel `place`, best first.
    fn of_channel(
        &self,
        place: usize,
        tables: &[Table],
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<Vec<usize>, Invalid> {
        let values = |table: &Table| {
            let column = table.places.iter().position(|own| *own == place);
            column.map(|column| table.seen[column].values)
        };
        let own: Vec<(usize, usize)> =
            (0..tables.len()).filter_map(|i| Some((i, values(&tables[i])?))).collect();
        let known: Vec<usize> = own.iter().filter(|(_, values)| *values > 0).map(|(i, _)| *i).collect();
        let address = |i: &usize| tables[*i].address.as_str();
        let rank = |i: &usize| self.prefer.iter().position(|talker| address(i).starts_with(talker.as_str()));
        let mut named: Vec<usize> = known.iter().copied().filter(|i| rank(i).is_some()).collect();
        named.sort_by_key(rank);
        match (known.as_slice(), named.as_slice()) {
            ([], _) if own.iter().any(|(i, _)| tables[*i].is_incomplete(&self.wanted[place].name)) => {
                let addresses: Vec<&str> = own.iter().map(|(i, _)| address(i)).collect();
                Err(Invalid::new(
                    format!("column `{}`", self.wanted[place].name),
                    format!("no variation with its E or W in any sentence {}", addresses.join(", ")),
                    "deviation and variation, each with its direction, which make a magnetic heading a true one",
                    "name `HDG.magnetic` and set its `offset` to deviation and variation in rad, east above 0, or name HDT or THS",
                ))
            }
            ([], _) => Ok(own.first().map(|(i, _)| *i).into_iter().collect()),
            ([only], _) => {
                let empty: Vec<&str> =
                    own.iter().filter(|(i, _)| i != only).map(|(i, _)| address(i)).collect();
                if !empty.is_empty() {
                    let text =
                        format!("is from {} alone: {} never has a value", address(only), empty.join(", "));
                    warnings.push(self.warning(place, empty.len(), &text));
                }
                Ok(vec![*only])
            }
            (_, []) => Err(self.several(place, &known.iter().map(address).collect::<Vec<_>>())),
            _ => Ok(named),
        }
    }

    fn several(&self, place: usize, addresses: &[&str]) -> Invalid {
        let column = &self.wanted[place].name;
        let (of, field) = column.split_once('.').unwrap_or((column, ""));
        let qualifier = of.find('-').map_or("", |dash| &of[dash..]);
        let talkers: Vec<String> = addresses.iter().map(|address| format!("\"{}\"", &address[..2])).collect();
        Invalid::new(
            format!("column `{column}`"),
            format!("values of it from {}", addresses.join(" and ")),
            "one sensor for a channel",
            format!(
                "name it, such as `{}{qualifier}.{field}`, or set `prefer = [{}]` in [[file]]: the first counts, the others fill \
                 its gaps",
                addresses[0],
                talkers.join(", ")
            ),
        )
    }

    fn warn(&self, table: &Table, ranks: &[(usize, usize)], warnings: &mut Vec<WarningSummary>) {
        for (place, seen) in table.places.iter().zip(&table.seen) {
            if !ranks.iter().any(|(own, _)| own == place) {
                continue;
            }
            if let Some((count, away)) = seen.alternation.found() {
                let text = format!(
                    "alternates by {away:.4} deg {count} times: two sensors may send {} under one name",
                    table.address
                );
                warnings.push(self.warning(*place, count, &text));
            }
            if seen.undeviated > 0 {
                let count = seen.undeviated;
                let text =
                    format!("is without deviation in {count} sentences of {}: 0 is assumed", table.address);
                warnings.push(self.warning(*place, count, &text));
            }
        }
    }

    /// A warning about channel `place` that occurred `count` times.
    pub(super) fn warning(&self, place: usize, count: usize, text: &str) -> WarningSummary {
        let channel = self.specs[place].channel.clone();
        let text = format!("`{channel}` {text}");
        WarningSummary { kind: WarningKind::Source, channel, count: count as u64, text }
    }
}

/// Refuses a table whose times often differ from the clock's.
fn check_times(table: &Table, clock: &str) -> Result<(), Invalid> {
    let all = table.far + table.rows();
    match table.first_far.filter(|_| table.far as f64 > FEW * all as f64) {
        Some((line, away)) => Err(Invalid::new(
            format!("times of {}", table.address),
            format!(
                "{} of {all} that differ from those of {clock}, the first in line {line}, {away:.0} s away",
                table.far
            ),
            "both on one clock",
            format!("name {} as the time's `column`, or another sentence for its channels", &table.address),
        )),
        None => Ok(()),
    }
}
