//! Values of a channel or a clock in blocks, most of which may be in a store: a long recording does not fit into memory.

use std::borrow::Cow;
use std::fmt::Debug;
use std::ops::Range;
use std::sync::Arc;

use refusal::foreign;

/// Holds blocks of long channels. It never fails: a block that it could not store is returned as zeros, and
/// its creator asks in the end whether that happened.
pub trait Store: Debug + Send + Sync {
    /// Values of a block; shorter channels stay in memory.
    fn block(&self) -> usize;

    /// Stores a block and returns its place.
    fn put(&self, values: &[f64]) -> u64;

    /// Appends the values of the block at `place` to `values`.
    fn get(&self, place: u64, values: &mut Vec<f64>);

    /// Frees the block at `place`, which is not read any more.
    fn forget(&self, place: u64);
}

/// A block in a store.
#[derive(Debug)]
struct SampleBlock {
    store: Arc<dyn Store>,
    place: u64,
}

impl Drop for SampleBlock {
    fn drop(&mut self) {
        self.store.forget(self.place);
    }
}

/// A sequence of numbers. Clones share stored blocks.
#[derive(Clone, Debug)]
pub struct Samples {
    /// `None` where all values stay in memory.
    store: Option<Arc<dyn Store>>,
    /// Values of a block.
    block: usize,
    /// Full blocks.
    aside: Vec<Arc<SampleBlock>>,
    /// The values after them.
    rest: Vec<f64>,
}

impl Default for Samples {
    fn default() -> Self {
        Self { store: None, block: usize::MAX, aside: Vec::new(), rest: Vec::new() }
    }
}

impl Samples {
    /// No values yet; `store` takes the blocks to come.
    pub fn new(store: &Arc<dyn Store>) -> Self {
        Self { store: Some(Arc::clone(store)), block: store.block().max(1), ..Self::default() }
    }

    /// `values`, stored where these are.
    pub fn made(&self, values: impl IntoIterator<Item = f64>) -> Self {
        let mut made = self.none();
        values.into_iter().for_each(|value| made.push(value));
        made.rest.shrink_to_fit();
        made
    }

    /// No values yet; those to come are stored where these are.
    pub fn none(&self) -> Self {
        Self { store: self.store.clone(), block: self.block, ..Self::default() }
    }

    /// Number of values.
    pub fn len(&self) -> usize {
        self.rest_from() + self.rest.len()
    }

    /// Whether there are none.
    pub fn is_empty(&self) -> bool {
        self.aside.is_empty() && self.rest.is_empty()
    }

    /// Appends a value.
    pub fn push(&mut self, value: f64) {
        self.rest.push(value);
        if self.rest.len() >= self.block {
            self.put_aside();
        }
    }

    /// The first value.
    pub fn first(&self) -> Option<f64> {
        self.iter().next()
    }

    /// The last value.
    pub fn last(&self) -> Option<f64> {
        self.rest.last().copied().or_else(|| self.range(self.len().checked_sub(1)?..self.len()).next())
    }

    /// All values, in order.
    pub fn iter(&self) -> Values<'_> {
        self.range(0..self.len())
    }

    /// The values at these places, in order.
    pub fn range(&self, places: Range<usize>) -> Values<'_> {
        let end = places.end.min(self.len());
        let rest_from = self.rest_from();
        Values { samples: self, next: places.start, end, loaded: Vec::new(), from: 0, rest_from }
    }

    /// The first `len` values alone.
    pub fn truncate(&mut self, len: usize) {
        if len >= self.len() {
            return;
        }
        let (whole, rest) = (len / self.block, len % self.block);
        if let Some(SampleBlock { store, place }) = self.aside.get(whole).map(|block| &**block) {
            self.rest.clear();
            store.get(*place, &mut self.rest);
            self.aside.truncate(whole);
        }
        self.rest.truncate(rest);
    }

    /// All values in memory.
    pub fn to_vec(&self) -> Vec<f64> {
        self.iter().collect()
    }

    fn put_aside(&mut self) {
        if let Some(store) = &self.store {
            let block = SampleBlock { place: store.put(&self.rest), store: Arc::clone(store) };
            self.aside.push(Arc::new(block));
            self.rest.clear();
        }
    }

    /// The index of the first value that is in memory.
    fn rest_from(&self) -> usize {
        self.aside.len() * self.block
    }

    fn load(&self, i: usize, values: &mut Vec<f64>) {
        match self.aside.get(i) {
            Some(block) => block.store.get(block.place, values),
            None => values.extend_from_slice(&self.rest),
        }
    }
}

impl From<Vec<f64>> for Samples {
    fn from(rest: Vec<f64>) -> Self {
        Self { rest, ..Self::default() }
    }
}

impl From<&[f64]> for Samples {
    fn from(values: &[f64]) -> Self {
        values.to_vec().into()
    }
}

impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        self.len() == other.len() && self.iter().eq(other.iter())
    }
}

/// Iterates over values with one block in memory.
#[derive(Clone, Debug)]
pub struct Values<'a> {
    samples: &'a Samples,
    next: usize,
    end: usize,
    /// The block that was read last, and the index of its first value.
    loaded: Vec<f64>,
    from: usize,
    /// The index of the first value that is always in memory.
    rest_from: usize,
}

impl Iterator for Values<'_> {
    type Item = f64;

    #[inline]
    fn next(&mut self) -> Option<f64> {
        if self.next >= self.end {
            return None;
        }
        let value = if self.next >= self.rest_from {
            self.samples.rest[self.next - self.rest_from]
        } else {
            if self.next >= self.from + self.loaded.len() {
                let block = self.samples.block;
                self.loaded.clear();
                self.samples.load(self.next / block, &mut self.loaded);
                self.from = self.next / block * block;
            }
            self.loaded[self.next - self.from]
        };
        self.next += 1;
        Some(value)
    }

    fn size_hint(&self) -> (usize, Option<usize>) {
        let left = self.end.saturating_sub(self.next);
        (left, Some(left))
    }
}

impl ExactSizeIterator for Values<'_> {}

/// Access to neighbouring values at advancing indices.
pub(crate) struct View<'a> {
    samples: &'a Samples,
    /// The values in memory, and the index of the first.
    loaded: Cow<'a, [f64]>,
    from: usize,
}

impl<'a> View<'a> {
    pub(crate) fn new(samples: &'a Samples) -> Self {
        let loaded = if samples.aside.is_empty() { samples.rest.as_slice() } else { &[] };
        Self { samples, loaded: Cow::Borrowed(loaded), from: 0 }
    }

    /// The values at these indices.
    pub(crate) fn slice(&mut self, places: Range<usize>) -> &[f64] {
        if places.start < self.from || places.end > self.from + self.loaded.len() {
            self.load(&places);
        }
        &self.loaded[places.start - self.from..places.end - self.from]
    }

    /// The value at place `i`.
    #[inline]
    pub(crate) fn at(&mut self, i: usize) -> f64 {
        match self.loaded.get(i.wrapping_sub(self.from)) {
            Some(value) => *value,
            None => self.slice(i..i + 1)[0],
        }
    }

    /// Loads one block more than needed, so that advancing indices load rarely.
    fn load(&mut self, places: &Range<usize>) {
        let block = self.samples.block;
        let first = places.start / block;
        let end = places.end.saturating_add(block).min(self.samples.len());
        let mut values = std::mem::take(&mut self.loaded).into_owned();
        values.clear();
        for i in first..end.div_ceil(block) {
            self.samples.load(i, &mut values);
        }
        (self.loaded, self.from) = (Cow::Owned(values), first * block);
    }
}

/// Differences between neighbours.
pub(crate) fn steps(values: impl Iterator<Item = f64>) -> impl Iterator<Item = f64> {
    let mut before = None;
    values.filter_map(move |value| before.replace(value).map(|before| value - before))
}

/// Labels of rows. Consecutive rows share one.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Labels {
    /// Each label with the row after the last that has it.
    runs: Vec<(Arc<str>, usize)>,
}

impl Labels {
    /// Number of rows.
    pub fn len(&self) -> usize {
        self.runs.last().map_or(0, |(_, end)| *end)
    }

    /// Whether there are no rows.
    pub fn is_empty(&self) -> bool {
        self.runs.is_empty()
    }

    /// Appends a row.
    pub fn push(&mut self, label: &str) {
        let end = self.len() + 1;
        match self.runs.last_mut().filter(|(last, _)| **last == *label) {
            Some((_, last)) => *last = end,
            None => self.runs.push((Arc::from(label), end)),
        }
    }

    /// The label of a row; empty where there is no such row.
    pub fn at(&self, row: usize) -> &str {
        let place = self.runs.partition_point(|(_, end)| *end <= row);
        self.runs.get(place).map_or("", |(label, _)| label)
    }
}

/// Lines of a file that rows stand on, from 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Numbering {
    /// The first rows of the source files, and their names, where there are several.
    parts: Vec<(usize, String)>,
    rows: usize,
    /// Rows that do not stand on the line after that of the previous row, and their lines.
    breaks: Vec<(usize, usize)>,
}

impl Numbering {
    /// Rows that stand on the lines from 1 on.
    pub fn of_rows(rows: usize) -> Self {
        Self { rows, breaks: vec![(0, 1)], ..Self::default() }
    }

    /// Number of rows.
    pub fn rows(&self) -> usize {
        self.rows
    }

    /// Appends a row that stands on `line`.
    pub fn push(&mut self, line: usize) {
        if self.rows == 0 || self.line(self.rows) != line {
            self.breaks.push((self.rows, line));
        }
        self.rows += 1;
    }

    /// Names the file that the rows are from; its rows come before those of others.
    #[must_use]
    pub fn of_part(mut self, name: &str) -> Self {
        self.parts = vec![(0, name.to_owned())];
        self
    }

    /// The first rows of all files but the first.
    pub(crate) fn seams(&self) -> impl Iterator<Item = (usize, &str)> {
        self.parts.iter().skip(1).map(|(row, name)| (*row, name.as_str()))
    }

    pub(crate) fn append(&mut self, others: Self) {
        let before = self.rows;
        self.parts.extend(others.parts.into_iter().map(|(row, name)| (row + before, name)));
        self.breaks.extend(others.breaks.into_iter().map(|(row, line)| (row + before, line)));
        self.rows += others.rows;
    }

    /// The line of `row` in words, with its file where there are several.
    pub(crate) fn place(&self, row: usize) -> String {
        let line = self.line(row);
        match self.parts.iter().rfind(|(first, _)| *first <= row).filter(|_| self.parts.len() > 1) {
            Some((_, name)) => format!("{line} of `{}`", foreign(name)),
            None => line.to_string(),
        }
    }

    /// The line that `row` stands on.
    pub fn line(&self, row: usize) -> usize {
        let last = self.breaks.last().filter(|(first, _)| *first <= row);
        let jump = last.or_else(|| {
            self.breaks.get(self.breaks.partition_point(|(first, _)| *first <= row).checked_sub(1)?)
        });
        jump.map_or(0, |(first, line)| line + row - first)
    }
}
