//! Tests what a model lacks or has wrong, by score tests of whitened errors.
//!
//! Candidates are added to the model with a parameter of zero: terms, logged channels that no term has, a lag or delay of
//! the inputs, a current. The signs of channels are tested by those of nominal values. For a ship with forces
//! [`crate::fitting`] makes the same [`Criticism`] by scores of windows. The errors of the estimate and all sensitivities pass through the same Kalman filter, which whitens the errors, at the
//! states that it predicts, never at measured ones. Both are projected onto the complement of the estimated
//! parameters. Then T = sᵀV⁻¹s is χ² under the model, s being the products of the projected sensitivities and errors,
//! V those of the sensitivities; sums add over runs. Joint draws of all scores correct for the number of candidates.
//! If no noise is stated, it is found by its likelihood.

mod library;
mod noise;
mod problems;
mod residuals;
mod score;
mod verdict;

use numerics::Lane;
use numerics::statistics::student_half_width;
use regression::pooled::{Whiteness, whiteness};
use ship::engine::{RunView, SideBySide};
use ship::model::Model;

use crate::sensitivity::{Flow, NoiseModel, Recordings, filter, with_states};
use library::{CandidateEffect, Lifted, with_effects};
use noise::{Earlier, LASTING};
use problems::{Problems, Refinement, Series, TestedEstimate, each_with_noise, with_noise};
use residuals::{apart, feedback, waves};
use score::{Draws, Projected, reject_under_white, tested, under_white};

pub use library::against_nominal;
pub(crate) use library::signs;
pub use noise::NoiseKind;
pub(crate) use noise::{ENOUGH, Kinds};
pub use problems::{Subject, restricted_likelihood};
pub use residuals::oscillation;
pub use score::clearer_under_white;
pub use verdict::{
    Absent, Apart, Criticism, Feedback, FoundDrift, FoundNoise, LEVEL, OtherNoise, Suspect, Verdict, number,
};
pub(crate) use verdict::{change, sign_remedy, statements};

/// Tests what the model lacks by score tests of whitened errors, see [`self`]. `parameters`: θ̂ of all runs, in the
/// order of the model. `None` if the model diverges, or the runs determine nothing.
pub fn criticise(subject: &Subject, parameters: &[f64]) -> Option<Criticism> {
    criticise_after(subject, parameters, &[])
}

/// The same, given kinds of noise that were found before for these runs.
pub(crate) fn criticise_after(subject: &Subject, theta: &[f64], known: &Earlier) -> Option<Criticism> {
    judge(subject, &Problems::new(subject, true), &[theta.to_vec()], known).pop().flatten()
}

/// The same for every run by itself, each with its own estimate.
pub fn criticise_each(subject: &Subject, parameters: &[Vec<f64>]) -> Vec<Option<Criticism>> {
    judge(subject, &Problems::new(subject, false), parameters, &[])
}

fn judge(subject: &Subject, all: &Problems, from: &[Vec<f64>], before: &Earlier) -> Vec<Option<Criticism>> {
    let states = match subject.levels {
        Some(_) => Refinement::run(all, from),
        None => each_with_noise(all, from, before),
    };
    verdicts(subject, all, states)
}

fn verdicts(subject: &Subject, problems: &Problems, states: Vec<TestedEstimate>) -> Vec<Option<Criticism>> {
    let lifted = Lifted::new(subject.model);
    let draws = Draws::new(lifted.candidates.iter().map(|c| c.unknowns.len()).sum());
    let (sums, series) = problems.look(&lifted, &states);
    let under_white = under_white(problems, &lifted, &draws, &states);
    let each = states.into_iter().zip(sums).zip(series).zip(under_white).enumerate();
    each.map(|(problem, (((state, sums), series), under_white))| {
        let projected = Projected::new(&sums?, state.parameters.len())?;
        let mut criticism = judged(subject, &lifted, &draws, &state, &projected, &series);
        let white = criticism.whiteness.iter().all(is_white);
        let under_white = white && reject_under_white(&mut criticism, under_white);
        if subject.levels.is_none() && !white {
            let rejected =
                criticism.rejected && white_once_named(problems, problem, &state, &lifted, &criticism);
            criticism.verdict = if rejected { Verdict::Rejected } else { Verdict::None };
            criticism.rejected = rejected;
            if !rejected {
                criticism.waves_s = waves(subject, &series);
            }
        }
        let known = criticism.verdict != Verdict::None;
        if known && !subject.names.is_empty() {
            criticism.apart = apart(problems, &state);
        }
        criticism.absent.extend_from_slice(subject.signs);
        let wrong = |absent: &Absent| absent.kind == Suspect::Sign && absent.candidate;
        criticism.absent.sort_by_key(|absent| !wrong(absent));
        if !criticism.apart.is_empty() || known && subject.signs.iter().any(wrong) {
            (criticism.rejected, criticism.verdict) = (true, Verdict::Rejected);
        }
        criticism.statements = statements(&criticism, under_white);
        Some(criticism).filter(Criticism::is_finite)
    })
    .collect()
}

fn judged(
    subject: &Subject,
    lifted: &Lifted,
    draws: &Draws,
    state: &TestedEstimate,
    projected: &Projected,
    series: &Series,
) -> Criticism {
    let (absent, hidden) = tested(lifted, draws, projected);
    let p_value = absent.iter().map(|a| a.p_value).reduce(f64::min);
    let whiteness = [0, 1, 2].map(|d: usize| {
        let errors: Vec<Vec<f64>> = series.iter().map(|(_, white)| white[d].clone()).collect();
        whiteness(&errors, LAGS)
    });
    let ([noise_u, noise_v, noise_r], (current_std, current_time_s)) = noise(subject, state);
    let rejected = p_value.is_some_and(|p| p < LEVEL);
    Criticism {
        rejected,
        verdict: if rejected { Verdict::Rejected } else { Verdict::NotRejected },
        p_value,
        stated_noise: subject.levels.is_some(),
        noise_u: Some(noise_u),
        noise_v: Some(noise_v),
        noise_r: Some(noise_r),
        current_std: Some(current_std),
        current_time_s,
        units: None,
        noise: state.noise.as_ref().map(FoundNoise::from),
        error_ratio: Some(projected.variance().sqrt()),
        whiteness: whiteness.to_vec(),
        apart: Vec::new(),
        feedback: feedback(subject.model, subject.runs, series),
        waves_s: None,
        absent,
        hidden,
        statements: Vec::new(),
    }
}

/// Standard deviations of the noise; that of the current, and the time over which it drifts.
fn noise(subject: &Subject, state: &TestedEstimate) -> ([f64; 3], (f64, Option<f64>)) {
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
        (None, Some(noise)) => (noise.guess.measurement(), noise.guess.current()),
        (None, None) => ([f64::NAN; 3], (f64::NAN, None)),
    }
}

/// Errors are not white below this probability of the test of whiteness, for each of u, v and r.
const GATE: f64 = 0.01 / 3.0;
const MOST: usize = 4;
const LAGS: usize = 20;

fn is_white(test: &Whiteness) -> bool {
    test.p_value >= GATE
}

/// Whether the errors of an estimate become white when the terms that `criticism` names are added one by one.
fn white_once_named(
    problems: &Problems,
    problem: usize,
    state: &TestedEstimate,
    lifted: &Lifted,
    criticism: &Criticism,
) -> bool {
    let Some(first) = criticism.absent.first() else { return false };
    let (places, runs): (Vec<usize>, Vec<RunView>) = problems.runs_of(problem).unzip();
    let mut richer = Richer {
        model: problems.subject.model.clone(),
        exogenous: places.iter().map(|place| problems.subject.runs[*place].exogenous.to_vec()).collect(),
        state: state.clone(),
    };
    if !richer.add(problems.subject, &runs, lifted, first) {
        return false;
    }
    for _ in 1..MOST {
        let exogenous = std::mem::take(&mut richer.exogenous);
        let model = richer.model.clone();
        let pairs = runs.iter().zip(&exogenous);
        let views: Vec<RunView> = pairs
            .map(|(run, exogenous)| RunView { exogenous, instrument_exogenous: exogenous, ..*run })
            .collect();
        let subject = Subject { model: &model, runs: &views, ..*problems.subject };
        let problems = Problems::new(&subject, true);
        let before = richer.state.noise.as_ref().map_or(&[][..], |noise| &noise.kinds);
        let starts = [richer.state.parameters.clone()];
        let Some(state) = with_noise(&problems, 0, &starts, before) else { return false };
        let lifted = Lifted::new(&model);
        let (mut sums, mut series) = problems.look(&lifted, std::slice::from_ref(&state));
        let (Some(Some(sums)), Some(series)) = (sums.pop(), series.pop()) else { return false };
        let white = (0..3).all(|d| {
            let errors: Vec<Vec<f64>> = series.iter().map(|(_, white)| white[d].clone()).collect();
            is_white(&whiteness(&errors, LAGS))
        });
        if white {
            return true;
        }
        let Some(projected) = Projected::new(&sums, state.parameters.len()) else { return false };
        let draws = Draws::new(lifted.candidates.iter().map(|c| c.unknowns.len()).sum());
        let (absent, _) = tested(&lifted, &draws, &projected);
        let p_value = absent.iter().map(|a| a.p_value).fold(1.0, f64::min);
        let next = absent.first().filter(|_| p_value < LEVEL);
        richer = Richer { model: model.clone(), exogenous: exogenous.clone(), state };
        if !next.is_some_and(|next| richer.add(&subject, &views, &lifted, next)) {
            return false;
        }
    }
    false
}

/// A model with the terms that it was found to lack; channels of other effects follow those of its runs.
struct Richer {
    model: Model,
    exogenous: Vec<Vec<f64>>,
    state: TestedEstimate,
}

impl Richer {
    /// Adds what is `absent` from the model of `subject`; returns whether that was possible.
    fn add(&mut self, subject: &Subject, runs: &[RunView], lifted: &Lifted, absent: &Absent) -> bool {
        let is = |c: &&CandidateEffect| c.name == absent.name && c.place() == absent.degree.as_deref();
        let Some(candidate) = lifted.candidates.iter().find(is) else { return false };
        if candidate.degree.is_none() {
            self.exogenous = runs.iter().map(|run| self.with_effects(subject, run)).collect();
            self.model.variables.clone_from(&lifted.model.variables);
        }
        let places: Vec<usize> = candidate.unknowns.iter().flatten().map(|c| lifted.others[*c]).collect();
        let (mut first, mut parameters) = (0, Vec::new());
        let mut known = self.state.parameters.iter();
        for (degree, richer) in self.model.degrees.iter_mut().zip(&lifted.model.degrees) {
            parameters.extend(known.by_ref().take(degree.terms.len()));
            for place in places.iter().filter(|place| (first..first + richer.terms.len()).contains(place)) {
                degree.terms.push(richer.terms[place - first].clone());
                degree.parameters.push(richer.parameters[place - first].clone());
                parameters.push(0.0);
            }
            first += richer.terms.len();
        }
        self.state.parameters = parameters;
        true
    }

    /// The rows of a run with the channels of effects, along the states that a filter predicts.
    fn with_effects(&self, subject: &Subject, run: &RunView) -> Vec<f64> {
        let side = SideBySide::of(&[*run]);
        let recordings = Recordings::of(subject.model, &side);
        let parameters: Vec<Lane> = self.state.parameters.iter().copied().map(Lane::splat).collect();
        let unknowns: Vec<Lane> = parameters.iter().copied().chain([Lane::ZERO; 3]).collect();
        let Some(noise) = &self.state.noise else { return run.exogenous.to_vec() };
        let levels = noise.guess.levels(subject.rate_hz);
        let innovations =
            with_states!(levels.states(), filter(&recordings, &unknowns, &levels, subject.known_start).1);
        let states: Vec<Lane> = side.measured.iter().zip(&innovations).map(|(y, e)| *y - *e).collect();
        let rows = with_effects(subject.model, &parameters, &states, &side.exogenous, subject.rate_hz);
        rows.into_iter().map(|row| row[0]).collect()
    }
}

/// With fewer samples, the noise is not known well enough to choose one kind.
const SHORT: usize = 500;
/// Samples per degree of freedom of Student's t, and the least number of these: levels are found from the run too.
const FREEDOM: [f64; 2] = [18.5, 13.0];

/// Factor on standard errors of runs of `samples` samples, for 95 % intervals by the normal distribution's 1.96.
fn student(samples: usize) -> f64 {
    student_half_width((samples as f64 / FREEDOM[0]).max(FREEDOM[1])) / 1.959_964
}

#[derive(Clone, Debug)]
pub(crate) struct Calibrated {
    pub levels: NoiseModel,
    pub parameters: Vec<f64>,
    /// Their standard errors if runs are short: the largest among all plausible kinds of noise.
    pub widest: Option<Vec<f64>>,
    /// The levels of these kinds; of the best one alone if runs are long enough.
    pub near: Vec<NoiseModel>,
    pub factor: f64,
    pub white: bool,
    /// Whether waves move the ship, so that no standard errors hold.
    pub waves: bool,
    pub kinds: Kinds,
}

/// Noise and parameters of `runs` under `model`, from the first of `starts` that succeeds.
pub(crate) fn calibrated(
    model: &Model,
    runs: &[RunView],
    rate_hz: f64,
    known_start: bool,
    starts: &[Vec<f64>],
) -> Option<Calibrated> {
    let subject = Subject { model, runs, rate_hz, known_start, levels: None, names: &[], signs: &[] };
    let problems = Problems::new(&subject, true);
    let state = with_noise(&problems, 0, starts, &[])?;
    let noise = state.noise.clone()?;
    let (parameters, kinds) = (state.parameters.clone(), noise.kinds.clone());
    let verdict = verdicts(&subject, &problems, vec![state]).pop().flatten();
    let samples = runs.iter().map(RunView::samples).sum();
    let (short, factor) = (samples < SHORT, student(samples));
    let levels = noise.guess.levels(rate_hz);
    let near = match short {
        true => noise.near().map(|guess| guess.levels(rate_hz)).collect(),
        false => vec![levels],
    };
    Some(Calibrated {
        levels,
        parameters,
        widest: short.then(|| noise.widest.clone()),
        near,
        factor,
        white: verdict.as_ref().is_some_and(|criticism| criticism.verdict != Verdict::None),
        waves: verdict.is_some_and(|criticism| criticism.waves_s.is_some()),
        kinds,
    })
}
