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
