//! Score tests of all that a model may lack.

use super::chance::Draws;
use super::found::{Absent, called};
use super::library::{Candidate, Lifted};
use super::score::{Projected, Score};

/// A model is rejected where the likeliest of all that is looked for has a smaller probability than this under the model.
pub const LEVEL: f64 = 0.05;
/// Standard errors that something absent must be large for a trial to find it nearly always.
const SEEN: f64 = 3.9;
/// How far in −2 log p the next candidates may lie behind the first and still be what is missing.
const CLOSE: f64 = 6.0;

/// What the tests say of all candidates, the likeliest first, and what cannot be tested.
pub(super) fn tested(lifted: &Lifted, draws: &Draws, projected: &Projected) -> (Vec<Absent>, Vec<String>) {
    let scored = lifted.candidates.iter().map(|candidate| (candidate, projected.score(&candidate.group)));
    let (told, hidden): (Vec<_>, Vec<_>) = scored.partition(|(_, score)| score.is_some());
    let told: Vec<(&Candidate, Score)> =
        told.into_iter().filter_map(|(c, score)| Some((c, score?))).collect();
    let groups = told.iter().map(|(candidate, score)| (&candidate.group, score)).collect::<Vec<_>>();
    let probabilities = draws.adjusted(projected, &groups);
    let most = told.iter().map(|(_, score)| -2.0 * score.log_p).fold(0.0, f64::max);
    let all = told.iter().zip(&probabilities);
    let mut found: Vec<Absent> = all.map(|((c, score), p)| absent(c, score, *p, most)).collect();
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    (found, hidden.into_iter().map(|(candidate, _)| called(&candidate.name, candidate.place())).collect())
}

/// What a test says of `candidate`, the evidence of the likeliest being `most`.
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
