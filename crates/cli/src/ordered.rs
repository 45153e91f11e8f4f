//! Parallel map, ordered fold, in bounded memory.

use std::ops::Range;

use rayon::prelude::*;

/// Calls `work` on every item in parallel and `fold` on the results in order. Only a few results per thread are held at
/// a time. Stops at the first failure in order.
pub fn ordered<T: Send, E: Send>(
    items: Range<usize>,
    work: impl Fn(usize) -> Result<T, E> + Sync,
    mut fold: impl FnMut(T) -> Result<(), E>,
) -> Result<(), E> {
    let window = 2 * rayon::current_num_threads();
    let mut start = items.start;
    while start < items.end {
        let end = (start + window).min(items.end);
        let results: Vec<Result<T, E>> = (start..end).into_par_iter().map(&work).collect();
        results.into_iter().try_for_each(|result| fold(result?))?;
        start = end;
    }
    Ok(())
}

/// Number of blocks of a table per block of the table computed from it, so that small rows do not end up in small
/// blocks.
const JOINED: usize = 8;

/// Number of joined blocks of `blocks`.
pub fn joined_blocks(blocks: usize) -> usize {
    blocks.div_ceil(JOINED)
}

/// Calls `work` in parallel on the blocks of joined block `i` and concatenates their rows.
///
/// # Errors
/// The first failure in order.
pub fn joined<T: Send, E: Send>(
    i: usize,
    blocks: usize,
    work: impl Fn(usize) -> Result<Vec<T>, E> + Sync + Send,
) -> Result<Vec<T>, E> {
    let parts: Vec<Result<Vec<T>, E>> =
        (i * JOINED..blocks.min((i + 1) * JOINED)).into_par_iter().map(work).collect();
    let parts: Vec<Vec<T>> = parts.into_iter().collect::<Result<_, _>>()?;
    Ok(parts.into_iter().flatten().collect())
}
