//! Whether errors follow a known kind of noise once missing terms are added to the model.

use numerics::Lane;
use regression::pooled::{Whiteness, whiteness};
use ship::engine::{RunView, SideBySide};
use ship::model::Model;

use super::chance::Draws;
use super::channels::with_effects;
use super::found::{Absent, Criticism};
use super::library::{Candidate, Lifted};
use super::problems::{Problems, State, Subject};
use super::score::Projected;
use super::tested::{LEVEL, tested};
use super::with_noise::with_noise;
use crate::sensitivity::{Recordings, filter, with_states};

/// Errors are not white below this probability of the test of whiteness, for each of u, v and r.
const GATE: f64 = 0.01 / 3.0;
/// Maximum number of terms that are added to the model.
const MOST: usize = 4;
/// Lags of the test of whiteness.
pub(super) const LAGS: usize = 20;

pub(super) fn is_white(test: &Whiteness) -> bool {
    test.p_value >= GATE
}

/// Whether the errors of an estimate become white when the terms that `found` names are added to the model one by
/// one.
pub(super) fn white_once_named(
    problems: &Problems,
    problem: usize,
    state: &State,
    lifted: &Lifted,
    found: &Criticism,
) -> bool {
    let Some(first) = found.absent.first() else { return false };
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
        let own = runs.iter().zip(&exogenous);
        let views: Vec<RunView> = own
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
            let own: Vec<Vec<f64>> = series.iter().map(|(_, white)| white[d].clone()).collect();
            is_white(&whiteness(&own, LAGS))
        });
        if white {
            return true;
        }
        let Some(projected) = Projected::new(&sums, state.parameters.len()) else { return false };
        let draws = Draws::new(lifted.candidates.iter().map(|c| c.group.unknowns.len()).sum());
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
    state: State,
}

impl Richer {
    /// Adds what is `absent` from the model of `subject`; returns whether that was possible.
    fn add(&mut self, subject: &Subject, runs: &[RunView], lifted: &Lifted, absent: &Absent) -> bool {
        let is = |c: &&Candidate| c.name == absent.name && c.place() == absent.degree.as_deref();
        let Some(candidate) = lifted.candidates.iter().find(is) else { return false };
        if candidate.degree.is_none() {
            self.exogenous = runs.iter().map(|run| self.with_effects(subject, run)).collect();
            self.model.variables.clone_from(&lifted.model.variables);
        }
        let places: Vec<usize> =
            candidate.group.unknowns.iter().flatten().map(|column| lifted.others[*column]).collect();
        let (mut first, mut parameters) = (0, Vec::new());
        let mut known = self.state.parameters.iter();
        for (degree, own) in self.model.degrees.iter_mut().zip(&lifted.model.degrees) {
            parameters.extend(known.by_ref().take(degree.terms.len()));
            for place in places.iter().filter(|place| (first..first + own.terms.len()).contains(place)) {
                degree.terms.push(own.terms[place - first].clone());
                degree.parameters.push(own.parameters[place - first].clone());
                parameters.push(0.0);
            }
            first += own.terms.len();
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
            with_states!(levels, filter(&recordings, &unknowns, &levels, subject.known_start).1);
        let states: Vec<Lane> = side.measured.iter().zip(&innovations).map(|(y, e)| *y - *e).collect();
        let rows = with_effects(subject.model, &parameters, &states, &side.exogenous, subject.rate_hz);
        rows.into_iter().map(|row| row[0]).collect()
    }
}
