/// Fewest draws of which two enclose the median of their distribution at 95 %.
pub const LEAST_FOR_MEDIAN: u64 = 6;

/// The 95 % interval of the median of `pairs` pairs in words, such as `0.9 to 1.1`. An end is missing where
/// the pairs do not bound it.
///
/// # Errors
/// Why there is none: too few pairs, or too many of which one has no value.
pub fn median_interval_in_words(
    ends: [Option<f64>; 2],
    pairs: u64,
    number: impl Fn(f64) -> String,
) -> Result<String, String> {
    if pairs < LEAST_FOR_MEDIAN {
        return Err(format!("too few pairs for a 95 % interval: {pairs}, at least {LEAST_FOR_MEDIAN}"));
    }
    match ends.map(|end| end.filter(|end| end.is_finite()).map(&number)) {
        [Some(low), Some(high)] => Ok(format!("{low} to {high}")),
        [Some(low), None] => Ok(format!("from {low} up")),
        [None, Some(high)] => Ok(format!("up to {high}")),
        [None, None] => Err("no 95 % interval: too many pairs of which one has no value".to_owned()),
    }
}
