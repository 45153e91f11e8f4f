use numerics::times;
use vessel::lanes::SideBySide;
use vessel::{Lane, Model, RunView};

use super::channels::with_effects;
use super::found::{Absent, Criticism, called};
use super::library::{Candidate, Lifted};
use super::noise::{Guess, noise_of, unknowns, white};
use super::score::{Projected, Score, holm};
use super::words::statements;
use crate::pooled::whiteness;
use crate::predictor::{Linear, linearize, scaled_inverse};
use crate::sensitivity::{Flow, Levels, Recordings, filter, groups, with_states};

/// A model is rejected where something absent is found with a smaller probability than this under the model, after Holm.
pub const LEVEL: f64 = 0.05;
/// Standard errors that something absent must be large for a trial to find it nearly always.
const SEEN: f64 = 3.9;
/// How far in −2 log p the next candidates may lie behind the first and still be what is missing.
const CLOSE: f64 = 6.0;
/// Most often that the estimate is refined under the noise.
const ROUNDS: usize = 12;
/// Most often that the noise is looked for.
const SEARCHES: usize = 4;
/// Fall of the squared white errors below which the estimate is that of least errors.
const SETTLED: f64 = 1e-2;
/// Most lengths that are tried of a step.
const STEPS: i32 = 6;
/// Lags of the test of whiteness.
const LAGS: usize = 20;

/// A model with its estimate, and the runs that are to be explained by it.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The structure, with intercepts where they were estimated.
    pub model: &'a Model,
    /// θ̂, in the order of `model`.
    pub parameters: &'a [f64],
    /// The runs.
    pub runs: &'a [RunView<'a>],
    /// The sampling rate \[Hz\].
    pub rate_hz: f64,
    /// Whether simulations start from the true state; else from the measured one.
    pub known_start: bool,
    /// What disturbs the runs, where it is stated; else it is looked for.
    pub levels: Option<Levels>,
}

/// Looks for what the model lacks: score tests of whitened errors, see [`super`]. None where the model diverges, or the runs
/// determine nothing.
pub fn criticise(subject: &Subject) -> Option<Criticism> {
    let groups: Vec<SideBySide> =
        groups(subject.runs, 0..subject.runs.len()).map(|(_, group)| group).collect();
    let lifted = Lifted::new(subject.model);
    let (parameters, levels) = refined(subject, &groups)?;
    let (sums, series) = look(subject, &lifted, &groups, &parameters, &levels)?;
    let projected = Projected::new(&sums, parameters.len())?;
    Some(judged(subject, &lifted, &levels, &projected, &series))
}

/// The estimate of least white errors, and the noise under which it is that: one follows from the other, in turns.
fn refined(subject: &Subject, groups: &[SideBySide]) -> Option<(Vec<f64>, Levels)> {
    let mut parameters = subject.parameters.to_vec();
    let (model, rate, known) = (subject.model, subject.rate_hz, subject.known_start);
    let looked_for = |parameters: &[f64], before: Option<&Guess>| {
        let errors = free_errors(subject, groups, parameters)?;
        noise_of(model, groups, parameters, errors, rate, known, before)
    };
    let mut noise = match subject.levels {
        Some(_) => None,
        None => Some(looked_for(&parameters, None)?),
    };
    let mut levels = subject.levels.or(noise.as_ref().map(|noise| noise.levels(rate)))?;
    let mut errors = white_sums(subject, groups, &parameters, &levels)?;
    for round in 1..=ROUNDS {
        let (step, decrement) = newton_step(&errors)?;
        if decrement < SETTLED {
            break;
        }
        // Half a step, and half of that, where the whole one leads out of sight.
        let shorter = (0..STEPS).map(|halved| 0.5_f64.powi(halved));
        let mut tried = shorter.filter_map(|share| {
            let trial: Vec<f64> = parameters.iter().zip(&step).map(|(p, s)| p + share * s).collect();
            let sums = white_sums(subject, groups, &trial, &levels)?;
            Some((trial, sums))
        });
        let before: f64 = errors.squares.iter().sum();
        let Some((trial, sums)) = tried.find(|(_, sums)| sums.squares.iter().sum::<f64>() < before) else {
            break;
        };
        (parameters, errors) = (trial, sums);
        if let (Some(before), true) = (&noise, round < SEARCHES)
            && let Some(found) = looked_for(&parameters, Some(before))
        {
            levels = found.levels(rate);
            noise = Some(found);
            errors = white_sums(subject, groups, &parameters, &levels)?;
        }
    }
    Some((parameters, levels))
}

/// White errors and their slopes by the model's parameters.
fn white_sums(
    subject: &Subject,
    groups: &[SideBySide],
    parameters: &[f64],
    levels: &Levels,
) -> Option<Linear> {
    let free: Vec<usize> = (0..parameters.len()).collect();
    let each = groups
        .iter()
        .flat_map(|group| with_states!(levels, white_group(subject, group, parameters, levels, &free)));
    let total = each.reduce(|mut total, own| {
        total.add(&own);
        total
    });
    total.filter(Linear::finite)
}

fn white_group<const N: usize>(
    subject: &Subject,
    group: &SideBySide,
    parameters: &[f64],
    levels: &Levels,
    free: &[usize],
) -> Vec<Linear> {
    let own = Recordings::of(subject.model, group);
    let all = unknowns(parameters);
    let (gains, _) = filter::<N>(&own, &all, levels, subject.known_start);
    let mut sums = linearize(&own, &all, free, Some(levels), &gains, false);
    sums.truncate(group.runs);
    sums
}

/// Standard deviations of the errors of free simulations.
fn free_errors(subject: &Subject, groups: &[SideBySide], parameters: &[f64]) -> Option<[f64; 3]> {
    let (mut squares, mut samples) = ([0.0; 3], 0.0);
    for group in groups {
        let recordings = Recordings::of(subject.model, group);
        let sums = linearize::<3>(&recordings, &unknowns(parameters), &[], None, &[], false);
        for own in &sums[..group.runs] {
            samples += own.samples;
            (0..3).for_each(|d| squares[d] += own.squares[d]);
        }
    }
    let errors = squares.map(|sum| (sum / samples).sqrt());
    errors.iter().all(|e| e.is_finite()).then_some(errors)
}

/// White errors by run and degree of freedom.
type Series = Vec<[Vec<f64>; 3]>;

/// White errors and sensitivities of all runs, the model's own parameters first.
fn look(
    subject: &Subject,
    lifted: &Lifted,
    groups: &[SideBySide],
    parameters: &[f64],
    levels: &Levels,
) -> Option<(Linear, Series)> {
    let (mut total, mut series) = (None::<Linear>, Vec::new());
    for group in groups {
        let (sums, white) = with_states!(levels, look_at(subject, lifted, group, parameters, levels));
        series.extend(white);
        for own in sums {
            match &mut total {
                Some(total) => total.add(&own),
                None => total = Some(own),
            }
        }
    }
    total.filter(Linear::finite).map(|total| (total, series))
}

fn look_at<const N: usize>(
    subject: &Subject,
    lifted: &Lifted,
    group: &SideBySide,
    parameters: &[f64],
    levels: &Levels,
) -> (Vec<Linear>, Series) {
    let own = Recordings::of(subject.model, group);
    let (gains, innovations) = filter::<N>(&own, &unknowns(parameters), levels, subject.known_start);
    let predicted: Vec<Lane> = group.measured.iter().zip(&innovations).map(|(y, e)| *y - *e).collect();
    let lanes: Vec<Lane> = parameters.iter().copied().map(Lane::splat).collect();
    let exogenous = with_effects(subject.model, &lanes, &predicted, &group.exogenous, subject.rate_hz);
    let group = SideBySide { exogenous, ..group.clone() };
    let recordings = Recordings::of(&lifted.model, &group);
    let free: Vec<usize> = lifted.known.iter().chain(&lifted.others).copied().collect();
    let all = unknowns(&lifted.parameters(parameters, 0.0));
    let mut sums = linearize(&recordings, &all, &free, Some(levels), &gains, false);
    sums.truncate(group.runs);
    (sums, white(&group, &gains, &innovations))
}

/// What the unknowns of white `sums` change by for the least errors, and by how much these fall then.
fn newton_step(sums: &Linear) -> Option<(Vec<f64>, f64)> {
    let (normal, gradient) = sums.weighted([1.0; 3]);
    let inverse = scaled_inverse(&normal, gradient.len()).ok()?;
    let step = times(&inverse, &gradient);
    let decrement = step.iter().zip(&gradient).map(|(x, g)| x * g).sum();
    step.iter().all(|x| x.is_finite()).then_some((step, decrement))
}

fn judged(
    subject: &Subject,
    lifted: &Lifted,
    levels: &Levels,
    projected: &Projected,
    series: &Series,
) -> Criticism {
    let scored = lifted.candidates.iter().map(|candidate| (candidate, projected.score(&candidate.group)));
    let (told, hidden): (Vec<_>, Vec<_>) = scored.partition(|(_, score)| score.is_some());
    let told: Vec<(&Candidate, Score)> =
        told.into_iter().filter_map(|(c, score)| Some((c, score?))).collect();
    let adjusted = holm(&told.iter().map(|(_, score)| score.log_p).collect::<Vec<_>>());
    let most = told.iter().map(|(_, score)| -2.0 * score.log_p).fold(0.0, f64::max);
    let all = told.iter().zip(&adjusted);
    let mut found: Vec<Absent> = all.map(|((c, score), p)| absent(c, score, *p, most)).collect();
    found.sort_by(|a, b| b.evidence.total_cmp(&a.evidence));
    let p_value = found.iter().map(|a| a.p_value).reduce(f64::min);
    let rejected = p_value.is_some_and(|p| p < LEVEL);
    let whiteness = [0, 1, 2].map(|d: usize| {
        let own: Vec<Vec<f64>> = series.iter().map(|run| run[d].clone()).collect();
        whiteness(&own, LAGS)
    });
    let [noise_u, noise_v, noise_r] = levels.measurement;
    let (current_std, current_time_s) = match levels.current {
        Flow::Still => (0.0, None),
        Flow::White { std } => (std, None),
        Flow::Markov { std, factor, .. } => {
            (std, Some(-1.0 / (subject.rate_hz * libm::log(factor))).filter(|t| t.is_finite()))
        }
    };
    let mut all = Criticism {
        rejected,
        p_value,
        stated_noise: subject.levels.is_some(),
        noise_u,
        noise_v,
        noise_r,
        current_std,
        current_time_s,
        error_ratio: projected.variance().sqrt(),
        whiteness: whiteness.to_vec(),
        absent: found,
        hidden: hidden.into_iter().map(|(candidate, _)| called(&candidate.name, candidate.place())).collect(),
        statements: Vec::new(),
    };
    all.statements = statements(&all);
    all
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
