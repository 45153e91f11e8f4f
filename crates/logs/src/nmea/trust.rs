//! Which of the clock's times are trusted, once all of them are known.

use refusal::Invalid;

use super::clock::{has_time, is_dated};
use super::fields::Column;
use super::table::Table;
use super::timeline::Timeline;
use crate::stamp::moment;
use crate::{WarningKind, WarningSummary};

/// How many rows the tables had.
pub(super) type Lengths = Vec<usize>;

/// The rows whose times are not trusted.
#[derive(Default)]
pub(super) struct Trust {
    /// Before the rows of the last time.
    pub(super) last: Lengths,
    /// Where they became doubtful.
    pub(super) doubt: Option<Lengths>,
    /// Where they were doubtful.
    pub(super) doubted: Vec<[Lengths; 2]>,
    /// Where the clock was set.
    pub(super) set: Vec<Lengths>,
}

/// Share of the clock's sentences that may be late, or of another date.
const FEW: f64 = 0.1;

pub(super) fn lengths(tables: &[Table]) -> Lengths {
    tables.iter().map(Table::rows).collect()
}

impl Trust {
    /// Removes untrusted times. The clock's sentences are of `kind`, and `late` of them came late.
    ///
    /// # Errors
    /// No time, too many late ones, several dates.
    pub(super) fn check(
        &self,
        (kind, timeline, late): (&str, &Timeline, usize),
        tables: &mut [Table],
        wanted: &[Column],
        warnings: &mut Vec<WarningSummary>,
    ) -> Result<(), Invalid> {
        let main = main_era(kind, timeline)?;
        let stamps: usize = timeline.eras.iter().map(|era| era.stamps).sum();
        if late as f64 > FEW * stamps as f64 && late > 3 {
            let found = format!("{late} of {stamps} that are earlier than one before them");
            let remedy = "name one receiver as the time's `column`, or correct the file";
            return Err(Invalid::new("time of sentences", found, "times that increase", remedy));
        }
        let (weeks_s, moved) = timeline.weeks();
        let weeks = "has dates 1024 weeks off, as after a rollover of the GPS week: moved to the other dates";
        let leaps = "has a leap second: all times after it are taken as a second later";
        for (count, text) in [(moved, weeks), (timeline.leaps, leaps)] {
            let (count, text) = (count as u64, format!("`{kind}` {text}"));
            if count > 0 {
                let channel = kind.to_owned();
                warnings.push(WarningSummary { kind: WarningKind::Clock, channel, count, text });
            }
        }
        for (i, table) in tables.iter_mut().enumerate() {
            table.correct(&self.distrusted(i, table, main), weeks_s, wanted);
        }
        Ok(())
    }

    /// The rows of table `i` whose times are not trusted.
    fn distrusted(&self, i: usize, table: &Table, main: usize) -> Vec<[usize; 2]> {
        let at = |lengths: &Lengths| lengths.get(i).copied().unwrap_or(0);
        let starts = [0].into_iter().chain(self.set.iter().map(at));
        let ends = self.set.iter().map(at).chain([table.rows()]);
        let eras = starts.zip(ends).enumerate().filter(|(era, _)| *era != main);
        let eras = eras.map(|(_, (from, to))| [from, to]);
        // Sentences with times of their own do not depend on it.
        let doubted = self.doubted.iter().filter(|_| !has_time(&table.address));
        eras.chain(doubted.map(|[from, to]| [at(from), at(to)])).collect()
    }
}

/// The period of the clock that is the log's.
fn main_era(kind: &str, timeline: &Timeline) -> Result<usize, Invalid> {
    const YEAR_2000: f64 = 946_684_800.0;
    let eras = &timeline.eras;
    let is_of_log = |i: &usize| eras[*i].fixes > 0 || !is_dated(kind) || eras[*i].first.time > YEAR_2000;
    let main = (0..eras.len()).filter(is_of_log).max_by_key(|i| (eras[*i].fixes, eras[*i].stamps));
    let Some(main) = main else {
        return Err(Invalid::new(
            format!("column `{kind}`"),
            "sentences without a time, or without a date, throughout the file",
            "a time from a receiver with a fix",
            "name other sentences as the time's `column`, such as GGA or ZDA",
        ));
    };
    let fixes: usize = eras.iter().map(|era| era.fixes).sum();
    let other = eras.iter().enumerate().find(|(i, era)| *i != main && era.fixes as f64 > FEW * fixes as f64);
    match other {
        None => Ok(main),
        Some((_, other)) => Err(Invalid::new(
            "time of sentences",
            format!("{} and {}", moment(eras[main].first.time), moment(other.first.time)),
            "dates within a year of each other",
            "cut the file where the clock was set, or name other sentences as the time's `column`",
        )),
    }
}
