use numerics::lanes::{by_lane, lane};
use numerics::{LANES, Lane, times};
use rayon::prelude::*;
use ship::engine::{RunView, SideBySide};
use ship::model::Model;

use super::Absent;
use super::library::{Lifted, with_effects};
use super::noise::{Earlier, Guess, Noise, NoiseKind, Turns, side_by_side};
use crate::predictor::{Linear, linearize_each, scaled_inverse};
use crate::sensitivity::{Flow, ForceNoise, Gain, NoiseModel, Recordings, filter_along, groups, with_states};

/// A model, and runs to test it on.
#[derive(Clone, Copy, Debug)]
pub struct Subject<'a> {
    /// The structure, with intercepts if they were estimated.
    pub model: &'a Model,
    /// The runs.
    pub runs: &'a [RunView<'a>],
    /// The sampling rate \[Hz\].
    pub rate_hz: f64,
    /// Whether simulations start from the true state; else from the measured one.
    pub known_start: bool,
    /// The disturbances of the runs, if stated; else they are found.
    pub levels: Option<NoiseModel>,
    /// The recording of every run, to test whether recordings agree; empty to skip that test.
    pub names: &'a [&'a str],
    /// Tests of the signs of channels that were made before.
    pub signs: &'a [Absent],
}

#[derive(Clone, Debug)]
pub(super) struct TestedEstimate {
    pub parameters: Vec<f64>,
    pub noise: Option<Noise>,
}

/// Ratio of forces to noise at which every prediction starts at the last measurement.
const FORCE: f64 = 1e3;

/// White errors by degree of freedom from sample 1 on, with the index of their run.
pub(super) type Series = Vec<(usize, [Vec<f64>; 3])>;

/// Estimates of one model, each from its own runs, in lanes.
pub(super) struct Problems<'a> {
    pub subject: &'a Subject<'a>,
    groups: Vec<(Vec<usize>, SideBySide)>,
    of_run: Vec<usize>,
}

impl<'a> Problems<'a> {
    /// One estimate for all runs, or one for every run.
    pub fn new(subject: &'a Subject, pooled: bool) -> Self {
        let runs = 0..subject.runs.len();
        let of_run = runs.clone().map(|run| if pooled { 0 } else { run }).collect();
        Self { subject, groups: groups(subject.runs, runs).collect(), of_run }
    }

    pub fn count(&self) -> usize {
        self.of_run.last().map_or(0, |last| last + 1)
    }

    fn states(&self) -> usize {
        self.subject.levels.map_or(3, |levels| levels.states())
    }

    /// The runs of one problem, with their indices.
    pub fn runs_of(&self, problem: usize) -> impl Iterator<Item = (usize, RunView<'a>)> + '_ {
        let runs = self.subject.runs.iter().copied().enumerate().zip(&self.of_run);
        runs.filter(move |(_, of)| **of == problem).map(|(run, _)| run)
    }

    /// The search for the noise of one problem.
    pub fn turns(&self, problem: usize) -> Turns<'a> {
        let Subject { model, rate_hz, known_start, .. } = *self.subject;
        Turns { model, runs: self.runs_of(problem).map(|(_, run)| run).collect(), rate_hz, known_start }
    }

    fn any(&self, group: &[usize], wanted: &[usize]) -> bool {
        group.iter().any(|run| wanted.contains(&self.of_run[*run]))
    }

    /// White errors of the `wanted` problems and their derivatives by the parameters; `None` if they are not finite.
    pub fn white(&self, wanted: &[usize], states: &[TestedEstimate]) -> Vec<Option<Linear>> {
        let free: Vec<usize> = (0..self.subject.model.parameters()).collect();
        let mut sums = vec![None; self.count()];
        for (group, runs) in self.groups.iter().filter(|(group, _)| self.any(group, wanted)) {
            let linears = with_states!(self.states(), white(self, group, runs, states, &free));
            self.add(&mut sums, group, linears);
        }
        finite(sums)
    }

    /// The same for every run by itself, for one estimate from all, under the stated or found noise.
    pub fn by_run(&self, state: &TestedEstimate) -> Vec<(usize, Linear)> {
        let free: Vec<usize> = (0..self.subject.model.parameters()).collect();
        let kind = state.noise.as_ref().map(|noise| noise.guess.kind);
        let count = kind.map_or(self.states(), NoiseKind::states);
        let states = vec![state.clone(); self.count()];
        let each = self.groups.iter().flat_map(|(group, runs)| {
            let linears = with_states!(count, white(self, group, runs, &states, &free));
            group.iter().copied().zip(linears)
        });
        each.collect()
    }

    /// Least squares of the `wanted` problems: under forces far above the noise predictions are linear in the parameters.
    pub fn least_squares(&self, wanted: &[usize]) -> Vec<(usize, Vec<f64>)> {
        let std = self.subject.levels.map_or([1.0; 3], |levels| levels.measurement).map(|std| FORCE * std);
        let gusts = ForceNoise { std, factor: [0.0; 3] };
        let measurement = std.map(|std| std / FORCE);
        let levels = NoiseModel { measurement, current: Flow::Still, force: Some(gusts), drift: None };
        let forced = Subject { levels: Some(levels), ..*self.subject };
        let same = Problems { subject: &forced, groups: self.groups.clone(), of_run: self.of_run.clone() };
        let zero = TestedEstimate { parameters: vec![0.0; self.subject.model.parameters()], noise: None };
        let sums = same.white(wanted, &vec![zero; self.count()]);
        let step = |problem: &usize| Some((*problem, newton_step(sums[*problem].as_ref()?)?.0));
        wanted.iter().filter_map(step).collect()
    }

    /// White errors and all sensitivities, those by the model's own parameters first, and the errors themselves.
    pub fn look(&self, lifted: &Lifted, states: &[TestedEstimate]) -> (Vec<Option<Linear>>, Vec<Series>) {
        let mut sums = vec![None; self.count()];
        let mut series: Vec<Series> = vec![Vec::new(); self.count()];
        let mut look = |group: &[usize], runs: &SideBySide, count: usize| {
            let (linears, white) = with_states!(count, look_at(self, lifted, group, runs, states));
            self.add(&mut sums, group, linears);
            group.iter().zip(white).for_each(|(run, white)| series[self.of_run[*run]].push((*run, white)));
        };
        if self.subject.levels.is_some() {
            self.groups.iter().for_each(|(group, runs)| look(group, runs, self.states()));
        } else {
            for kind in NoiseKind::ALL {
                let of = |run: &usize| states[self.of_run[*run]].noise.as_ref().map(|noise| noise.guess.kind);
                let chosen = (0..self.subject.runs.len()).filter(|run| of(run) == Some(kind));
                groups(self.subject.runs, chosen)
                    .for_each(|(group, runs)| look(&group, &runs, kind.states()));
            }
        }
        (finite(sums), series)
    }

    fn add(&self, sums: &mut [Option<Linear>], group: &[usize], linears: Vec<Linear>) {
        for (run, linear) in group.iter().zip(linears) {
            match &mut sums[self.of_run[*run]] {
                Some(total) => total.add(&linear),
                none => *none = Some(linear),
            }
        }
    }

    fn parameters(&self, group: &[usize], states: &[TestedEstimate]) -> Vec<Lane> {
        let of = |run: usize| &states[self.of_run[group[run]]].parameters;
        (0..self.subject.model.parameters()).map(|i| lane(group.len(), |run| of(run)[i])).collect()
    }

    fn levels(&self, group: &[usize], states: &[TestedEstimate]) -> NoiseModel<Lane> {
        let guess_of = |run: usize| states[self.of_run[group[run]]].noise.as_ref().map(|noise| noise.guess);
        match (self.subject.levels, guess_of(0)) {
            (None, Some(first)) => {
                let each = by_lane(group.len(), |run| guess_of(run).unwrap_or(first));
                side_by_side(&each, self.subject.rate_hz)
            }
            (stated, _) => stated.unwrap_or(WHITE).spread(),
        }
    }
}

/// A placeholder for problems without noise, which are not evaluated.
const WHITE: NoiseModel =
    NoiseModel { measurement: [1.0; 3], current: Flow::Still, force: None, drift: None };

fn finite(sums: Vec<Option<Linear>>) -> Vec<Option<Linear>> {
    sums.into_iter().map(|sum| sum.filter(Linear::finite)).collect()
}

fn white<const N: usize>(
    problems: &Problems,
    group: &[usize],
    runs: &SideBySide,
    states: &[TestedEstimate],
    free: &[usize],
) -> Vec<Linear> {
    let (subject, levels) = (problems.subject, problems.levels(group, states));
    let recordings = Recordings::of(subject.model, runs);
    let unknowns = with_start(problems.parameters(group, states));
    let (gains, _) = filter_along::<N>(&recordings, &unknowns, &levels, subject.known_start, |_| ());
    linearize_each(&recordings, &unknowns, free, Some(&levels), &gains, false)
}

fn look_at<const N: usize>(
    problems: &Problems,
    lifted: &Lifted,
    group: &[usize],
    runs: &SideBySide,
    states: &[TestedEstimate],
) -> (Vec<Linear>, Vec<[Vec<f64>; 3]>) {
    let (subject, levels) = (problems.subject, problems.levels(group, states));
    let parameters = problems.parameters(group, states);
    let own_recordings = Recordings::of(subject.model, runs);
    let (gains, innovations) = filter_along::<N>(
        &own_recordings,
        &with_start(parameters.clone()),
        &levels,
        subject.known_start,
        |_| (),
    );
    let predicted: Vec<Lane> = runs.measured.iter().zip(&innovations).map(|(y, e)| *y - *e).collect();
    let exogenous = with_effects(subject.model, &parameters, &predicted, &runs.exogenous, subject.rate_hz);
    let wider = SideBySide { exogenous, instrument_exogenous: Vec::new(), ..runs.clone() };
    let recordings = Recordings::of(&lifted.model, &wider);
    let free: Vec<usize> = lifted.known.iter().chain(&lifted.others).copied().collect();
    let all = with_start(lifted.parameters(&parameters, Lane::ZERO));
    let sums = linearize_each(&recordings, &all, &free, Some(&levels), &gains, false);
    (sums, errors(runs, &gains, &innovations))
}

fn with_start(parameters: Vec<Lane>) -> Vec<Lane> {
    parameters.into_iter().chain([Lane::ZERO; 3]).collect()
}

/// Innovations made white at each sample after the first, by lane: u, v, r.
fn errors<const N: usize>(run: &SideBySide, gains: &[Gain<Lane, N>], raw: &[Lane]) -> Vec<[Vec<f64>; 3]> {
    let all: Vec<[Lane; 3]> =
        gains.iter().zip(raw.as_chunks().0).map(|(gain, error)| gain.white(error)).collect();
    let by_lane = |lane: usize| {
        let rows = &all[1..=run.samples[lane].min(all.len() - 1)];
        [0, 1, 2].map(|d: usize| rows.iter().map(|white| white[d][lane]).collect())
    };
    (0..run.runs.min(LANES)).map(by_lane).collect()
}

/// The change of the unknowns to the least errors of white `sums`, and the decrease of the errors.
fn newton_step(sums: &Linear) -> Option<(Vec<f64>, f64)> {
    let (normal, gradient) = sums.weighted([1.0; 3]);
    let inverse = scaled_inverse(&normal, gradient.len()).ok()?;
    let step = times(&inverse, &gradient);
    let decrement = step.iter().zip(&gradient).map(|(x, g)| x * g).sum();
    step.iter().all(|x| x.is_finite()).then_some((step, decrement))
}

const ROUNDS: usize = 12;
/// Above this variance of the white errors another start is tried.
const FAR: f64 = 1.3;
const SETTLED: f64 = 1e-2;
const SHORTER: i32 = 6;

/// Estimates while they are refined to the least white errors under stated noise.
pub(super) struct Refinement<'a> {
    problems: &'a Problems<'a>,
    states: Vec<TestedEstimate>,
    errors: Vec<Option<Linear>>,
}

impl<'a> Refinement<'a> {
    /// The estimates that are reached from `starts`.
    pub fn run(problems: &'a Problems<'a>, starts: &[Vec<f64>]) -> Vec<TestedEstimate> {
        let state = |start: &Vec<f64>| TestedEstimate { parameters: start.clone(), noise: None };
        let states = starts.iter().map(state).collect();
        let mut refinement = Self { problems, states, errors: Vec::new() };
        refinement.settle((0..starts.len()).collect());
        refinement.elsewhere();
        refinement.states
    }

    /// If errors are far above the noise, restarts from least squares and keeps the better result.
    fn elsewhere(&mut self) {
        let far = |errors: &Option<Linear>| {
            errors.as_ref().is_none_or(|errors| squares(errors) > FAR * 3.0 * errors.samples)
        };
        let open: Vec<usize> = (0..self.errors.len()).filter(|problem| far(&self.errors[*problem])).collect();
        if open.is_empty() {
            return;
        }
        let (states, errors) = (self.states.clone(), self.errors.clone());
        for (problem, parameters) in self.problems.least_squares(&open) {
            self.states[problem] = TestedEstimate { parameters, noise: None };
        }
        self.settle(open.clone());
        let err = |errors: &Option<Linear>| errors.as_ref().map_or(f64::INFINITY, squares);
        for problem in open {
            if err(&self.errors[problem]) >= err(&errors[problem]) {
                self.states[problem] = states[problem].clone();
                self.errors[problem].clone_from(&errors[problem]);
            }
        }
    }

    fn settle(&mut self, mut open: Vec<usize>) {
        let errors = self.problems.white(&open, &self.states);
        self.errors.resize(errors.len(), None);
        for (problem, linear) in errors.into_iter().enumerate().filter(|(problem, _)| open.contains(problem))
        {
            self.errors[problem] = linear;
        }
        for _ in 0..ROUNDS {
            open = self.step(&open);
            if open.is_empty() {
                break;
            }
        }
    }

    /// Makes a step of each of the `open` ones; returns those that improved.
    fn step(&mut self, open: &[usize]) -> Vec<usize> {
        let newton = |problem: &usize| {
            let (step, decrement) = newton_step(self.errors[*problem].as_ref()?)?;
            (decrement >= SETTLED).then_some((*problem, step))
        };
        let mut left: Vec<(usize, Vec<f64>)> = open.iter().filter_map(newton).collect();
        let mut helped = Vec::new();
        // Halved steps if the whole one diverges.
        for share in (0..SHORTER).map(|halved| 0.5_f64.powi(halved)) {
            if left.is_empty() {
                break;
            }
            let mut trials = self.states.clone();
            for (problem, step) in &left {
                let steps = trials[*problem].parameters.iter_mut().zip(step);
                steps.for_each(|(p, s)| *p += share * s);
            }
            let tried: Vec<usize> = left.iter().map(|(problem, _)| *problem).collect();
            let mut errors = self.problems.white(&tried, &trials);
            left.retain(|(problem, _)| {
                let better = errors[*problem].as_ref().is_some_and(|error| {
                    self.errors[*problem].as_ref().is_none_or(|before| nearer(error, before))
                });
                if better {
                    self.states[*problem] = trials[*problem].clone();
                    self.errors[*problem] = errors[*problem].take();
                    helped.push(*problem);
                }
                !better
            });
        }
        helped.sort_unstable();
        helped
    }
}

/// Whether white errors are smaller, or closer to a stationary point: sums of squares may rise on the way.
fn nearer(linear: &Linear, before: &Linear) -> bool {
    let left = |sums: &Linear| newton_step(sums).map_or(f64::INFINITY, |(_, decrement)| decrement);
    squares(linear) < squares(before) || left(linear) < left(before)
}

fn squares(sums: &Linear) -> f64 {
    sums.squares.iter().sum()
}

/// Estimates alternating with the noise of each: from `starts`, else from least squares; see [`with_noise`].
pub(super) fn each_with_noise(all: &Problems, starts: &[Vec<f64>], before: &Earlier) -> Vec<TestedEstimate> {
    let each = starts.par_iter().enumerate().map(|(problem, start)| {
        let state = with_noise(all, problem, std::slice::from_ref(start), before);
        state.unwrap_or(TestedEstimate { parameters: start.clone(), noise: None })
    });
    each.collect()
}

/// The same for one, from the first of `starts` that succeeds, else from least squares.
pub(super) fn with_noise(
    problems: &Problems,
    problem: usize,
    starts: &[Vec<f64>],
    before: &Earlier,
) -> Option<TestedEstimate> {
    let turns = problems.turns(problem);
    let elsewhere = || {
        let simple = problems.least_squares(&[problem]).pop();
        simple.and_then(|(_, parameters)| turns.alternate(&parameters, before))
    };
    let noisy = starts.iter().find_map(|start| turns.alternate(start, before)).or_else(elsewhere);
    noisy.map(|(parameters, noise)| TestedEstimate { parameters, noise: Some(noise) })
}

/// Twice the restricted log-likelihood of all runs of `subject`, up to a constant, by which kinds of noise are compared. The
/// model is linearised about free simulations with `parameters`; what they explain counts for nothing.
///
/// `levels`, [`NoiseKind::levels`] of them: standard deviations of the noise of u, v \[m/s\], r \[rad/s\]; those of forces
/// or sensors, and their times \[s\]; that of the current \[m/s\], and its time \[s\].
pub fn restricted_likelihood(subject: &Subject, parameters: &[f64], kind: NoiseKind, levels: &[f64]) -> f64 {
    Problems::new(subject, true).turns(0).likelihood(parameters, Guess::new(kind, levels))
}
