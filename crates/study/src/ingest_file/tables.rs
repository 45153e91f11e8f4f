//! Logs in Parquet: the requested columns, and times by their types.

use std::path::Path;
use std::sync::Arc;

use files::{Error, ForeignTable, Timed};
use logs::{
    Cells, ClockNotes, Columns, Content, Labels, Moments, Numbering, Plan, Samples, Store, TimeUnit, WantedColumn,
    places,
};
use refusal::{Invalid, foreign};

/// Reads the columns of the file at `path` that `plan` needs from group `group`; numbers are spilled to `store`.
///
/// # Errors
/// A file that cannot be read, columns that are missing or of another type, invalid times.
pub(super) fn parquet(
    path: &Path,
    plan: &Plan,
    group: usize,
    store: &Arc<dyn Store>,
) -> Result<Columns, Error> {
    let (table, wanted) = (ForeignTable::open(path)?, plan.wanted(group));
    let refused = |invalid| crate::invalid(path, &invalid);
    places(table.columns(), &wanted).map_err(refused)?;
    if table.rows() > plan.most_rows {
        return Err(refused(plan.too_many_rows(table.rows())));
    }
    let mut clock = ClockNotes::default();
    let mut column = |(place, w): (usize, &WantedColumn)| {
        let timed = table.timed(&w.column).filter(|_| place == 0);
        Ok::<_, Error>(match w.content {
            _ if timed.is_some() => {
                let of_type = TypedTime { path, table: &table, column: &w.column, plan, group };
                Cells::Numbers(of_type.seconds(timed, &mut clock, store)?)
            }
            Content::Labels => Cells::Labels(labels(&table, &w.column)?),
            Content::Dates => {
                Cells::Numbers(dates((path, &table), &w.column, (plan, group), &mut clock, store)?)
            }
            Content::Numbers => {
                let mut numbers = Samples::new(store);
                table.numbers(&w.column, |number| numbers.push(number))?;
                Cells::Numbers(numbers)
            }
        })
    };
    let cells = wanted.iter().enumerate().map(&mut column).collect::<Result<_, _>>()?;
    Ok(Columns { cells, lines: Numbering::of_rows(table.rows()), clock, ..Columns::default() })
}

fn labels(table: &ForeignTable, column: &str) -> Result<Labels, Error> {
    let mut labels = Labels::default();
    texts(table, column, |text| labels.push(text))?;
    Ok(labels)
}

/// A column of times whose type has a unit.
struct TypedTime<'a> {
    path: &'a Path,
    table: &'a ForeignTable,
    column: &'a str,
    plan: &'a Plan,
    group: usize,
}

impl TypedTime<'_> {
    fn seconds(
        &self,
        timed: Option<Timed>,
        clock: &mut ClockNotes,
        store: &Arc<dyn Store>,
    ) -> Result<Samples, Error> {
        let spec = &self.plan.setup.files[self.group].time;
        let refuse = |found: &str, expected: &str, remedy: &str| {
            let thing = format!("column `{}`", foreign(self.column));
            Err(crate::invalid(self.path, &Invalid::new(thing, found, expected, remedy)))
        };
        let (per_second, is_shown) = match timed {
            Some(Timed::Moments { per_second, is_utc }) => (per_second, !is_utc),
            Some(Timed::OfDay { per_second }) => {
                clock.of_day = true;
                (per_second, false)
            }
            Some(Timed::Days) | None => {
                return refuse("days without a time", "times", "write date and time into one column");
            }
        };
        let own = match per_second {
            1000 => TimeUnit::Ms,
            1_000_000 => TimeUnit::Us,
            _ => TimeUnit::Ns,
        };
        if spec.format.is_some()
            || spec.nanoseconds.is_some()
            || ![Some(own), Some(TimeUnit::Iso8601)].contains(&spec.unit)
        {
            let found = format!("times that are no text, in {own:?} by their type").to_lowercase();
            let remedy = "set `unit = \"iso8601\"` in its `time`: the type says the rest";
            return refuse(&found, "the time's `unit` or `format` as it is stated", remedy);
        }
        let (mut seconds, mut wrong) = (Samples::new(store), None);
        // If a unit is stated, times are expected in it.
        let unit = spec.unit.and_then(TimeUnit::seconds).unwrap_or(1.0);
        let stamps = self.plan.stamps(self.group);
        self.table.seconds(self.column, |shown| {
            let known = if is_shown { stamps.shown(shown) } else { Ok(shown) };
            if let (Err(why), None) = (known, &wrong) {
                wrong = Some((seconds.len() + 1, shown, why));
            }
            seconds.push(known.unwrap_or(f64::NAN) / unit);
        })?;
        match wrong {
            None => Ok(seconds),
            Some((row, shown, why)) => {
                let shown = format!("{shown} s after 1970");
                let refused = stamps.refused(row, self.column, &shown, why, self.plan.setup.written_in);
                Err(crate::invalid(self.path, &refused))
            }
        }
    }
}

fn dates(
    (path, table): (&Path, &ForeignTable),
    column: &str,
    (plan, group): (&Plan, usize),
    clock: &mut ClockNotes,
    store: &Arc<dyn Store>,
) -> Result<Samples, Error> {
    let (mut seconds, mut wrong) = (Samples::new(store), None);
    let stamps = plan.stamps(group);
    let mut moments = Moments::new(stamps);
    texts(table, column, |text| {
        let known = moments.next(text);
        clock.fractions.see(text, '.');
        if let (Err(why), None) = (known, &wrong) {
            wrong = Some((seconds.len() + 1, text.to_owned(), why));
        }
        seconds.push(known.unwrap_or(f64::NAN));
    })?;
    clock.leap_s = moments.leap_s();
    match wrong {
        None => Ok(seconds),
        Some((row, found, why)) => {
            Err(crate::invalid(path, &stamps.refused(row, column, &found, why, plan.setup.written_in)))
        }
    }
}

/// Calls `each` with the texts of a column, or numbers as text: labels may be either.
fn texts(table: &ForeignTable, column: &str, mut each: impl FnMut(&str)) -> Result<(), Error> {
    let Err(refused) = table.texts(column, &mut each) else { return Ok(()) };
    let label = |n: f64| each(&if n.is_finite() { n.to_string() } else { String::new() });
    table.numbers(column, label).map_err(|_| refused)
}
