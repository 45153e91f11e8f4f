use regression::pooled::whiteness;

use super::agreement::apart;
use super::chance::Draws;
use super::feedback::feedback;
use super::found::{Criticism, FoundNoise, Verdict};
use super::gate::{LAGS, is_white, white_once_named};
use super::library::Lifted;
use super::noise::{Guess, LASTING};
use super::problems::{Problems, Series, State, Subject};
use super::refinement::Refinement;
use super::score::Projected;
use super::tested::{LEVEL, tested};
use super::waves::waves;
use super::white_noise::{reject_under_white, under_white};
use super::with_noise::each_with_noise;
use super::words::statements;
use crate::sensitivity::Flow;

/// Tests what the model lacks by score tests of whitened errors, see [`super`]. `parameters`: θ̂ of all runs, in the
/// order of the model. `None` if the model diverges, or the runs determine nothing.
pub fn criticise(subject: &Subject, parameters: &[f64]) -> Option<Criticism> {
    criticise_after(subject, parameters, &[])
}

/// The same, given kinds of noise that were found before for these runs.
pub(crate) fn criticise_after(
    subject: &Subject,
    parameters: &[f64],
    before: &[(Guess, f64)],
) -> Option<Criticism> {
    judge(subject, &Problems::new(subject, true), &[parameters.to_vec()], before).pop().flatten()
}

/// The same for every run by itself, each with its own estimate.
pub fn criticise_each(subject: &Subject, parameters: &[Vec<f64>]) -> Vec<Option<Criticism>> {
    judge(subject, &Problems::new(subject, false), parameters, &[])
}

fn judge(
    subject: &Subject,
    problems: &Problems,
    starts: &[Vec<f64>],
    before: &[(Guess, f64)],
) -> Vec<Option<Criticism>> {
    let states = match subject.levels {
        Some(_) => Refinement::new(problems, starts).run(),
        None => each_with_noise(problems, starts, before),
    };
    verdicts(subject, problems, states)
}

/// The verdict of the runs on every estimate.
pub(super) fn verdicts(subject: &Subject, problems: &Problems, states: Vec<State>) -> Vec<Option<Criticism>> {
    let lifted = Lifted::new(subject.model);
    let draws = Draws::new(lifted.candidates.iter().map(|c| c.group.unknowns.len()).sum());
    let (sums, series) = problems.look(&lifted, &states);
    let under_white = under_white(problems, &lifted, &draws, &states);
    let each = states.into_iter().zip(sums).zip(series).zip(under_white).enumerate();
    each.map(|(problem, (((state, sums), series), under_white))| {
        let projected = Projected::new(&sums?, state.parameters.len())?;
        let mut found = judged(subject, &lifted, &draws, &state, &projected, &series);
        let white = found.whiteness.iter().all(is_white);
        let under_white = white && reject_under_white(&mut found, under_white);
        if subject.levels.is_none() && !white {
            let rejected = found.rejected && white_once_named(problems, problem, &state, &lifted, &found);
            found.verdict = if rejected { Verdict::Rejected } else { Verdict::None };
            found.rejected = rejected;
            if !rejected {
                found.waves_s = waves(subject, &series);
            }
        }
        let known = found.verdict != Verdict::None;
        if known && !subject.names.is_empty() {
            found.apart = apart(problems, &state);
        }
        if !found.apart.is_empty() {
            (found.rejected, found.verdict) = (true, Verdict::Rejected);
        }
        found.statements = statements(&found, under_white);
        Some(found).filter(Criticism::is_finite)
    })
    .collect()
}

fn judged(
    subject: &Subject,
    lifted: &Lifted,
    draws: &Draws,
    state: &State,
    projected: &Projected,
    series: &Series,
) -> Criticism {
    let (found, hidden) = tested(lifted, draws, projected);
    let p_value = found.iter().map(|a| a.p_value).reduce(f64::min);
    let whiteness = [0, 1, 2].map(|d: usize| {
        let own: Vec<Vec<f64>> = series.iter().map(|(_, white)| white[d].clone()).collect();
        whiteness(&own, LAGS)
    });
    let ([noise_u, noise_v, noise_r], (current_std, current_time_s)) = noise(subject, state);
    let rejected = p_value.is_some_and(|p| p < LEVEL);
    Criticism {
        rejected,
        verdict: if rejected { Verdict::Rejected } else { Verdict::NotRejected },
        p_value,
        stated_noise: subject.levels.is_some(),
        noise_u,
        noise_v,
        noise_r,
        current_std,
        current_time_s,
        noise: state.noise.as_ref().map(FoundNoise::from),
        error_ratio: projected.variance().sqrt(),
        whiteness: whiteness.to_vec(),
        apart: Vec::new(),
        feedback: feedback(subject.model, subject.runs, series),
        waves_s: None,
        absent: found,
        hidden,
        statements: Vec::new(),
    }
}

/// Standard deviations of the noise; that of the current, and the time over which it drifts.
fn noise(subject: &Subject, state: &State) -> ([f64; 3], (f64, Option<f64>)) {
    match (subject.levels, &state.noise) {
        (Some(levels), _) => {
            let current = match levels.current {
                Flow::Still => (0.0, None),
                Flow::White { std } => (std, None),
                Flow::Markov { std, factor, .. } => {
                    let decay = (subject.rate_hz * libm::log(factor)).abs();
                    (std, decay.is_finite().then(|| (1.0 / decay).min(LASTING)))
                }
            };
            (levels.measurement, current)
        }
        (None, Some(found)) => (found.guess.measurement(), found.guess.current()),
        (None, None) => ([f64::NAN; 3], (f64::NAN, None)),
    }
}
