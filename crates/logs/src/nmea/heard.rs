//! Sentences that have been read and wait for a time, which depends on the clock's next one.

use refusal::Invalid;

use super::clock::Reported;
use super::fields::Column;
use super::quality::Accepted;
use super::sentence::Sentence;
use super::table::Table;
use super::timeline::{Stamp, own_time};

/// Sentences since the clock's last one.
#[derive(Default)]
pub(super) struct Heard {
    sentences: Vec<One>,
    /// Their values, concatenated.
    values: Vec<f64>,
}

struct One {
    table: usize,
    line: usize,
    /// The sentence's own time.
    own: Option<Reported>,
    /// The index of its first value.
    from: usize,
}

/// The clock's times before and after sentences.
pub(super) struct Between {
    /// The time of sentences without one of their own \[s\]; NaN where it is unknown.
    pub(super) time: f64,
    pub(super) before: Option<Stamp>,
    pub(super) after: Option<Stamp>,
}

/// How far a sentence's own time may differ from the clock's \[s\].
const FAR: f64 = 3.0;

impl Heard {
    /// How many sentences there are.
    pub(super) fn len(&self) -> usize {
        self.sentences.len()
    }

    /// Reads a sentence of `table`, which stands on `line` and has the time `own`.
    pub(super) fn hear(
        &mut self,
        (place, table): (usize, &mut Table),
        sentence: &Sentence,
        (line, own): (usize, Option<Reported>),
        how: (&[Column], &Accepted),
    ) -> Result<(), Invalid> {
        let from = self.values.len();
        table.read(sentence, line, how, &mut self.values)?;
        self.sentences.push(One { table: place, line, own, from });
        Ok(())
    }

    /// Puts the first `count` sentences into their tables.
    pub(super) fn put(&mut self, count: usize, between: &Between, tables: &mut [Table], wanted: &[Column]) {
        for one in &self.sentences[..count] {
            let table = &mut tables[one.table];
            let values = &self.values[one.from..one.from + table.places.len()];
            let own = one.own.map(|reported| own_time(&reported, between.before, between.after));
            match own {
                None => table.push(between.time, one.line, values),
                Some(None) => table.push(f64::NAN, one.line, values),
                Some(Some((_, away))) if away > FAR && values.iter().any(|value| value.is_finite()) => {
                    table.leave(away, one.line, values, wanted);
                }
                Some(Some((time, _))) => table.push_timed(time, one.line, values),
            }
        }
        let values = self.sentences.get(count).map_or(self.values.len(), |one| one.from);
        self.values.drain(..values);
        self.sentences.drain(..count);
        self.sentences.iter_mut().for_each(|one| one.from -= values);
    }
}
