//! Tests under white noise when another kind seems likelier: a missing term may look like drifting noise.

use super::chance::Draws;
use super::found::{Absent, Criticism, Verdict};
use super::library::Lifted;
use super::noise::{Noise, NoiseKind};
use super::problems::{Problems, State};
use super::score::Projected;
use super::tested::{LEVEL, tested};

/// Twice the log-likelihood by which another kind may be ahead due to a missing term.
const TAKEN: f64 = 30.0;
/// Factor on probabilities under white noise: two tests are made.
const TESTS: f64 = 2.0;

/// The tests of every estimate under white noise if that is not the likeliest kind but plausible.
pub(super) fn under_white(
    problems: &Problems,
    lifted: &Lifted,
    draws: &Draws,
    states: &[State],
) -> Vec<Option<Vec<Absent>>> {
    let white = |state: &State| {
        let likeliest = state.noise.as_ref().filter(|noise| noise.guess.kind != NoiseKind::White)?;
        let guess = *likeliest.within(TAKEN).find(|own| own.kind == NoiseKind::White)?;
        Some(Noise { guess, ..likeliest.clone() })
    };
    let under = |state: &State| State { parameters: state.parameters.clone(), noise: white(state) };
    let own: Vec<State> = states.iter().map(under).collect();
    if own.iter().all(|state| state.noise.is_none()) {
        return vec![None; states.len()];
    }
    let (sums, _) = problems.look(lifted, &own);
    let each = sums.into_iter().zip(&own);
    each.map(|(sums, own)| Some(tested(lifted, draws, &Projected::new(&sums?, own.parameters.len())?).0))
        .collect()
}

/// Rejects a model by the tests under white noise if these are the stronger evidence against it; returns whether they
/// are.
pub(super) fn reject_under_white(found: &mut Criticism, white: Option<Vec<Absent>>) -> bool {
    let Some(white) = white.and_then(|white| clearer_under_white(&found.absent, white)) else { return false };
    (found.rejected, found.verdict) = (true, Verdict::Rejected);
    (found.p_value, found.absent) = (Some(least(&white)), white);
    true
}

/// The tests under white noise of a model whose `likeliest` noise is another, if they reject it and are the stronger
/// evidence. Their probabilities are doubled, since two tests are made; `None` if they are not.
pub fn clearer_under_white(likeliest: &[Absent], mut white: Vec<Absent>) -> Option<Vec<Absent>> {
    white.iter_mut().for_each(|own| own.p_value = (TESTS * own.p_value).min(1.0));
    Some(white).filter(|white| least(white) < least(likeliest).min(LEVEL))
}

fn least(found: &[Absent]) -> f64 {
    found.iter().map(|own| own.p_value).fold(1.0, f64::min)
}
