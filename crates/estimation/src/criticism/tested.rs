//! Score tests of all candidates for what a model lacks.

use super::chance::Draws;
use super::found::{Absent, called};
use super::library::{Candidate, Lifted};
use super::score::{Projected, Score};

/// A model is rejected if the likeliest candidate has a smaller probability than this under the model.
pub const LEVEL: f64 = 0.05;
/// Size in standard errors at which a trial nearly always detects an absent term.
const SEEN: f64 = 3.9;
/// Candidates within this distance in −2 log p of the first may be what is missing too.
const CLOSE: f64 = 6.0;

/// The tests of all candidates, the likeliest first, and the names of those that cannot be tested.
pub(super) fn tested(lifted: &Lifted, draws: &Draws, projected: &Projected) -> (Vec<Absent>, Vec<String>) {
    let scored = lifted.candidates.iter().map(|candidate| (candidate, projected.score(&candidate.group)));
    let (testable, hidden): (Vec<_>, Vec<_>) = scored.partition(|(_, score)| score.is_some());
    let testable: Vec<(&Candidate, Score)> =
        testable.into_iter().filter_map(|(c, score)| Some((c, score?))).collect();
    let groups = testable.iter().map(|(candidate, score)| (&candidate.group, score)).collect::<Vec<_>>();
    let probabilities = draws.adjusted(projected, &groups);
    let most = testable.iter().map(|(_, score)| -2.0 * score.log_p).fold(0.0, f64::max);
    let all = testable.iter().zip(&probabilities);
    let mut found: Vec<Absent> = all.map(|((c, score), p)| absent(c, score, *p, most)).collect();
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    (found, hidden.into_iter().map(|(candidate, _)| called(&candidate.name, candidate.place())).collect())
}

/// The test of `candidate`, where `most` is the evidence of the likeliest.
fn absent(candidate: &Candidate, score: &Score, p_value: f64, most: f64) -> Absent {
    let evidence = -2.0 * score.log_p;
    Absent {
        name: candidate.name.clone(),
        degree: candidate.place().map(str::to_owned),
        unit: candidate.unit.clone(),
        value: score.values.clone(),
        standard_error: score.standard_errors.clone(),
        visible_from: SEEN * score.standard_errors.iter().copied().fold(0.0, f64::max),
        p_value,
        evidence,
        candidate: most - evidence <= CLOSE,
    }
}
