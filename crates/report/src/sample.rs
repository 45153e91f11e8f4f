use refusal::listed;
use study::documents::ValidationDocument;

/// Explains the brackets after numbers.
pub(super) const INTERVALS: &str = "In brackets: 95 % confidence intervals of what endless runs would give, of shares by Wilson's score, of quantiles by \
     ranks. A repeated study's value falls into them less often, some 83 times of 100.";

/// The number of runs of a validation, and their seed: `500 runs per design, seed 1`.
pub(super) fn drawn_from(validation: &ValidationDocument) -> String {
    let counts: Vec<u64> = validation.designs.iter().map(|d| d.runs).collect();
    let runs = match counts.split_first() {
        Some((first, others)) if others.iter().all(|count| count == first) => {
            format!("{first} runs per design")
        }
        _ => format!("{} runs", listed(&counts.iter().map(u64::to_string).collect::<Vec<_>>())),
    };
    let seed = validation.seed.map_or(String::new(), |seed| format!(", seed {seed}"));
    format!("{runs}{seed}")
}
