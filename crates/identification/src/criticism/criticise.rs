use super::chance::Draws;
use super::feedback::feedback;
use super::found::{Absent, Criticism, called};
use super::library::{Candidate, Lifted};
use super::noise::{Guess, LASTING, Search};
use super::problems::{Problems, Series, State, Subject, newton_step};
use super::score::{Projected, Score};
use super::words::statements;
use crate::pooled::whiteness;
use crate::predictor::Linear;
use crate::sensitivity::Flow;

/// A model is rejected where the likeliest of all that is looked for has a smaller probability than this under the model.
pub const LEVEL: f64 = 0.05;
/// Standard errors that something absent must be large for a trial to find it nearly always.
const SEEN: f64 = 3.9;
/// How far in −2 log p the next candidates may lie behind the first and still be what is missing.
const CLOSE: f64 = 6.0;
/// Most often that the estimates are refined under the noise.
const ROUNDS: usize = 12;
/// Most often that the noise is looked for.
const SEARCHES: usize = 6;
/// Rise of twice the log-likelihood that makes noise another one.
const OTHER: f64 = 1.0;
/// White errors beyond this variance are tried from another start.
const FAR: f64 = 1.3;
/// Fall of the squared white errors below which the estimate is that of least errors.
const SETTLED: f64 = 1e-2;
/// Most lengths that are tried of a step.
const SHORTER: i32 = 6;
/// Lags of the test of whiteness.
const LAGS: usize = 20;

/// Looks for what the model lacks: score tests of whitened errors, see [`super`]. `parameters`: θ̂ of all runs, in the order of
/// the model. None where the model diverges, or the runs determine nothing.
pub fn criticise(subject: &Subject, parameters: &[f64]) -> Option<Criticism> {
    judge(subject, &Problems::new(subject, true), &[parameters.to_vec()]).pop().flatten()
}

/// The same of every run by itself, of which each has its estimate.
pub fn criticise_each(subject: &Subject, parameters: &[Vec<f64>]) -> Vec<Option<Criticism>> {
    judge(subject, &Problems::new(subject, false), parameters)
}

fn judge(subject: &Subject, problems: &Problems, starts: &[Vec<f64>]) -> Vec<Option<Criticism>> {
    let states = Refinement::new(subject, problems, starts).run();
    let lifted = Lifted::new(subject.model);
    let draws = Draws::new(lifted.candidates.iter().map(|c| c.group.unknowns.len()).sum());
    let (sums, series) = problems.look(&lifted, &states);
    let each = states.into_iter().zip(sums).zip(series);
    each.map(|((state, sums), series)| {
        let projected = Projected::new(&sums?, state.parameters.len())?;
        Some(judged(subject, &lifted, &draws, &state, &projected, &series)).filter(Criticism::is_finite)
    })
    .collect()
}

/// Estimates on their way to the least white errors, and the noise under which they are that: one follows from the other, in
/// turns.
struct Refinement<'a> {
    problems: &'a Problems<'a>,
    states: Vec<State>,
    /// Searches for the noise, with what was thought of first, where none is stated.
    searches: Vec<Option<(Search<'a>, Vec<Guess>)>>,
    errors: Vec<Option<Linear>>,
}

impl<'a> Refinement<'a> {
    fn new(subject: &Subject, problems: &'a Problems, starts: &[Vec<f64>]) -> Self {
        let mut states: Vec<State> =
            starts.iter().map(|start| State { parameters: start.clone(), noise: None }).collect();
        let search = |(problem, state): (usize, &mut State)| {
            let search = problems.search(problem);
            let errors = problems.free_errors(problem, &state.parameters);
            let first = errors.map_or(Vec::new(), |errors| Guess::first(errors, subject.rate_hz));
            state.noise = search.brief(&first, &state.parameters).first().map(|(found, _)| *found);
            (search, first)
        };
        let searches = match subject.levels {
            Some(_) => states.iter().map(|_| None).collect(),
            None => states.iter_mut().enumerate().map(search).map(Some).collect(),
        };
        Self { problems, states, searches, errors: Vec::new() }
    }

    fn run(mut self) -> Vec<State> {
        self.settle((0..self.states.len()).collect());
        self.elsewhere();
        let open = self.again();
        if !open.is_empty() {
            self.settle(open);
        }
        self.states
    }

    /// Begins once more at least squares, and keeps what is likelier: where noise is looked for, since the errors of an estimate
    /// that is far off look like a current that drifts; where it is stated and errors are far beyond it.
    fn elsewhere(&mut self) {
        let far = |errors: &Option<Linear>| {
            errors.as_ref().is_none_or(|errors| squares(errors) > FAR * 3.0 * errors.samples)
        };
        let again = |problem: &usize| self.searches[*problem].is_some() || far(&self.errors[*problem]);
        let open: Vec<usize> = (0..self.errors.len()).filter(again).collect();
        if open.is_empty() {
            return;
        }
        let before: Vec<f64> = open.iter().map(|problem| self.worth(*problem)).collect();
        let (states, errors) = (self.states.clone(), self.errors.clone());
        for (problem, found) in self.problems.least_squares(&open) {
            let noise = self.searches[problem].as_ref().map(|(search, _)| search.lasting());
            self.states[problem] = State { parameters: found, noise };
        }
        self.settle(open.clone());
        for (problem, before) in open.into_iter().zip(before) {
            if self.worth(problem) <= before {
                self.states[problem] = states[problem].clone();
                self.errors[problem].clone_from(&errors[problem]);
            }
        }
    }

    /// By what states are compared: twice the log-likelihood where noise is looked for, else minus the squared white errors.
    fn worth(&self, problem: usize) -> f64 {
        let state = &self.states[problem];
        let found = match (&self.searches[problem], &state.noise) {
            (Some((search, _)), Some(noise)) => search.likelihood(noise, &state.parameters),
            (Some(_), None) => None,
            (None, _) => self.errors[problem].as_ref().map(|errors| -squares(errors)),
        };
        found.unwrap_or(f64::NEG_INFINITY)
    }

    fn settle(&mut self, mut open: Vec<usize>) {
        let found = self.problems.white(&open, &self.states);
        self.errors.resize(found.len(), None);
        for (problem, found) in found.into_iter().enumerate().filter(|(problem, _)| open.contains(problem)) {
            self.errors[problem] = found;
        }
        for round in 1..=ROUNDS {
            open = self.step(&open);
            if open.is_empty() {
                break;
            }
            if round < SEARCHES && self.searches.iter().any(Option::is_some) {
                self.listen(&open);
            }
        }
    }

    /// Looks for the noise once more from the beginning: those for which it is another than what was found with the estimate
    /// that came in.
    fn again(&mut self) -> Vec<usize> {
        let mut changed = Vec::new();
        for (problem, search) in self.searches.iter_mut().enumerate() {
            let Some((search, first)) = search.take() else { continue };
            let state = &mut self.states[problem];
            let here = state.noise.and_then(|noise| search.from(&[noise], &state.parameters));
            let other = search.from(&first, &state.parameters);
            if let Some((found, worth)) = other
                && here.is_none_or(|(_, here)| worth > here + OTHER)
            {
                state.noise = Some(found);
                changed.push(problem);
            }
        }
        changed
    }

    /// A step of each of the `open` ones; those that it helped are left.
    fn step(&mut self, open: &[usize]) -> Vec<usize> {
        let newton = |problem: &usize| {
            let (step, decrement) = newton_step(self.errors[*problem].as_ref()?)?;
            (decrement >= SETTLED).then_some((*problem, step))
        };
        let mut left: Vec<(usize, Vec<f64>)> = open.iter().filter_map(newton).collect();
        let mut helped = Vec::new();
        // Half a step, and half of that, where the whole one leads out of sight.
        for share in (0..SHORTER).map(|halved| 0.5_f64.powi(halved)) {
            if left.is_empty() {
                break;
            }
            let mut trials = self.states.clone();
            for (problem, step) in &left {
                let own = trials[*problem].parameters.iter_mut().zip(step);
                own.for_each(|(p, s)| *p += share * s);
            }
            let tried: Vec<usize> = left.iter().map(|(problem, _)| *problem).collect();
            let mut found = self.problems.white(&tried, &trials);
            left.retain(|(problem, _)| {
                let better = found[*problem].as_ref().is_some_and(|found| {
                    self.errors[*problem].as_ref().is_none_or(|before| nearer(found, before))
                });
                if better {
                    self.states[*problem] = trials[*problem].clone();
                    self.errors[*problem] = found[*problem].take();
                    helped.push(*problem);
                }
                !better
            });
        }
        helped.sort_unstable();
        helped
    }

    /// The noise again, from where it was.
    fn listen(&mut self, open: &[usize]) {
        for problem in open {
            let state = &mut self.states[*problem];
            let Some((search, _)) = &self.searches[*problem] else { continue };
            let Some(before) = state.noise else { continue };
            let found = search.brief(&[before], &state.parameters);
            state.noise = Some(found.first().map_or(before, |(found, _)| *found));
        }
        let again = self.problems.white(open, &self.states);
        for (problem, found) in again.into_iter().enumerate() {
            if open.contains(&problem) {
                self.errors[problem] = found;
            }
        }
    }
}

/// Whether white errors are smaller, or nearer to where no step makes them so: the filter follows the estimate, so that sums
/// of squares alone may rise on the way there.
fn nearer(found: &Linear, before: &Linear) -> bool {
    let left = |sums: &Linear| newton_step(sums).map_or(f64::INFINITY, |(_, decrement)| decrement);
    squares(found) < squares(before) || left(found) < left(before)
}

fn squares(sums: &Linear) -> f64 {
    sums.squares.iter().sum()
}

fn judged(
    subject: &Subject,
    lifted: &Lifted,
    draws: &Draws,
    state: &State,
    projected: &Projected,
    series: &Series,
) -> Criticism {
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
    let p_value = found.iter().map(|a| a.p_value).reduce(f64::min);
    let whiteness = [0, 1, 2].map(|d: usize| {
        let own: Vec<Vec<f64>> = series.iter().map(|(_, white)| white[d].clone()).collect();
        whiteness(&own, LAGS)
    });
    let ([noise_u, noise_v, noise_r], (current_std, current_time_s)) = noise(subject, state);
    let mut all = Criticism {
        rejected: p_value.is_some_and(|p| p < LEVEL),
        p_value,
        stated_noise: subject.levels.is_some(),
        noise_u,
        noise_v,
        noise_r,
        current_std,
        current_time_s,
        error_ratio: projected.variance().sqrt(),
        whiteness: whiteness.to_vec(),
        feedback: feedback(subject.model, subject.runs, series),
        absent: found,
        hidden: hidden.into_iter().map(|(candidate, _)| called(&candidate.name, candidate.place())).collect(),
        statements: Vec::new(),
    };
    all.statements = statements(&all);
    all
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
        (None, Some(found)) => (found.measurement(), found.current(subject.rate_hz)),
        (None, None) => ([f64::NAN; 3], (f64::NAN, None)),
    }
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
