//! Converts between the rows of single runs and [`Lane`]s, and between these and registers.

use std::cell::RefCell;

use pulp::Simd;

use crate::{LANES, Lane, vectorized};

/// The value for each lane of `count` runs, up to [`LANES`]; idle lanes repeat the last run.
pub fn by_lane<T>(count: usize, mut of: impl FnMut(usize) -> T) -> [T; LANES] {
    std::array::from_fn(|lane| of(lane.min(count - 1)))
}

/// Most recycled buffers that are kept per thread.
const KEPT: usize = 12;
thread_local! {
    static RECYCLED: RefCell<Vec<Vec<Lane>>> = const { RefCell::new(Vec::new()) };
}

/// A recycled buffer of `lanes` lanes, not cleared, or a new one.
pub fn buffer(lanes: usize) -> Vec<Lane> {
    let mut buffer = RECYCLED.with_borrow_mut(Vec::pop).unwrap_or_default();
    buffer.resize(lanes, Lane::ZERO);
    buffer
}

/// Recycles buffers on this thread.
pub fn recycle<const N: usize>(buffers: [Vec<Lane>; N]) {
    RECYCLED.with_borrow_mut(|kept| {
        kept.extend(buffers);
        kept.truncate(KEPT);
    });
}

/// A number of each of `count` runs.
pub fn lane(count: usize, of: impl FnMut(usize) -> f64) -> Lane {
    Lane(by_lane(count, of))
}

/// Interleaves rows of up to [`LANES`] runs. Shorter ones are padded with zeros.
pub fn interleave(runs: &[&[f64]]) -> Vec<Lane> {
    let mut out = buffer(0);
    interleave_into(runs, &mut out);
    out
}

/// [`interleave`] into `out`, which is overwritten.
pub fn interleave_into(runs: &[&[f64]], out: &mut Vec<Lane>) {
    let length = runs.iter().map(|run| run.len()).max().unwrap_or(0);
    out.clear();
    out.reserve(length);
    if length == 0 {
        return;
    }
    let rows: [&[f64]; LANES] = by_lane(runs.len(), |run| runs[run]);
    // Whole blocks, up to the end of the shortest run.
    let blocks = rows.map(|run| run.as_chunks::<LANES>().0);
    let whole = blocks.iter().map(|chunks| chunks.len()).min().unwrap_or(0);
    vectorized!(transpose(blocks.map(|chunks| &chunks[..whole]), out));
    let entry = |run: &[f64], i: usize| run.get(i).copied().unwrap_or(0.0);
    out.extend((out.len()..length).map(|i| Lane(rows.map(|run| entry(run, i)))));
}

/// Appends blocks of equally many numbers of every lane.
#[inline(always)]
fn transpose(blocks: [&[[f64; LANES]]; LANES], out: &mut Vec<Lane>) {
    for block in 0..blocks[0].len() {
        let mut transposed = [Lane::ZERO; LANES];
        for (lane, blocks) in blocks.iter().enumerate() {
            for i in 0..LANES {
                transposed[i].0[lane] = blocks[block][i];
            }
        }
        out.extend_from_slice(&transposed);
    }
}

/// The rows of one lane.
pub fn lane_of(values: &[Lane], lane: usize) -> Vec<f64> {
    values.iter().map(|v| v[lane]).collect()
}

/// Indices of neighbours with the same key, in groups of at most [`LANES`].
pub fn groups<K: PartialEq>(keys: &[K]) -> Vec<std::ops::Range<usize>> {
    let mut groups: Vec<std::ops::Range<usize>> = Vec::new();
    for (i, key) in keys.iter().enumerate() {
        match groups.last_mut() {
            Some(group) if group.len() < LANES && keys[group.start] == *key => group.end = i + 1,
            _ => groups.push(i..i + 1),
        }
    }
    groups
}

// In the processor's registers: where compilers, left to themselves, gather numbers one by one.

/// Samples that are summed up before their sum is added to the others.
pub const BLOCK: usize = 8;

/// A signal at [`BLOCK`] samples.
pub type Block<X> = [X; BLOCK];

/// The registers that a lane fills.
#[inline(always)]
pub fn parts<S: Simd>() -> usize {
    LANES / S::F64_LANES
}

/// Register `part` of a lane.
#[inline(always)]
pub fn part<S: Simd>(lane: &Lane, part: usize) -> S::f64s {
    S::as_simd_f64s(&lane.0).0[part]
}

/// Puts `value` into register `part` of a lane.
#[inline(always)]
pub fn put<S: Simd>(lane: &mut Lane, part: usize, value: S::f64s) {
    S::as_mut_simd_f64s(&mut lane.0).0[part] = value;
}

/// Adds `value` to register `part` of a lane.
#[inline(always)]
pub fn add<S: Simd>(simd: S, lane: &mut Lane, part: usize, value: S::f64s) {
    put::<S>(lane, part, simd.add_f64s(self::part::<S>(lane, part), value));
}
