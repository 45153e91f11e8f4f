use numerics::LANES;
use rayon::prelude::*;
use ship::engine::RunView;
use ship::model::Model;

use super::likelihood::{Likelihoods, Line};
use super::search::{Best, LikelihoodSearch, STEPS, Seen, after};
use super::{Guess, NoiseKind};

const TURNS: usize = 8;
/// All kinds are compared before these turns.
const COMPARED: [usize; 3] = [0, 1, 4];
const AGAIN: usize = 10;
/// Parameters have converged if they change by less than this many standard errors.
const REST: f64 = 0.2;
/// Penalty of a level in twice the log-likelihood.
const A_LEVEL: f64 = 2.0;
const SHORTER: i32 = 6;
/// Share of the motion that is the least noise.
const FLOOR: f64 = 1e-6;
/// Samples that suffice to find the noise, and the least rise of twice the log-likelihood for a further step.
pub(crate) const ENOUGH: usize = 8_000;
const RISE: f64 = 0.05;
/// The same before the first alternation.
const FIRST: (usize, f64) = (3_000, 1.0);
/// Kinds that are less likely by no more than this are plausible.
const NEAR: f64 = 6.0;
/// Kinds that were less likely by more than this are not searched again.
const FAR: f64 = 15.0;

pub(crate) struct Turns<'a> {
    pub model: &'a Model,
    pub runs: Vec<RunView<'a>>,
    pub rate_hz: f64,
    pub known_start: bool,
}

/// Kinds of noise, the likeliest first, with twice their restricted log-likelihood less the penalty of their levels.
pub(crate) type Kinds = Vec<(Guess, f64)>;
/// Kinds that were found for nearly the same model.
pub(crate) type Earlier = [(Guess, f64)];

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Noise {
    pub guess: Guess,
    pub kinds: Kinds,
    pub turns: usize,
    pub at_rest: bool,
    /// Standard errors of the parameters, and the largest among all plausible kinds.
    pub errors: Vec<f64>,
    pub widest: Vec<f64>,
}

impl Noise {
    /// The plausible kinds.
    pub fn near(&self) -> impl Iterator<Item = &Guess> {
        self.within(NEAR)
    }

    /// The kinds that are less likely than the best by no more than this in twice the log-likelihood.
    pub fn within(&self, below: f64) -> impl Iterator<Item = &Guess> {
        let best = self.kinds.first().map_or(0.0, |(_, likelihood)| *likelihood);
        self.kinds.iter().filter(move |(_, likelihood)| *likelihood >= best - below).map(|(guess, _)| guess)
    }
}

struct State<'a> {
    theta: Vec<f64>,
    lines: Vec<Line<'a>>,
    kinds: Vec<Best>,
    best: Best,
}

impl<'a> Turns<'a> {
    /// Noise and parameters, found alternately from `theta`; `None` if the filter's numbers are not finite, or the
    /// parameters cannot be distinguished.
    pub fn alternate(&self, theta: &[f64], before: &Earlier) -> Option<(Vec<f64>, Noise)> {
        let lines: Vec<Line> = self.runs.iter().map(|run| Line::free(self.model, theta, *run)).collect();
        let (kinds, best) = self.compared(&lines, before)?;
        let mut state = State { theta: theta.to_vec(), lines, kinds, best };
        for turn in 0..TURNS {
            if turn > 0 && COMPARED.contains(&turn) {
                let before: Kinds = state.kinds.iter().map(|best| (best.guess, value(best))).collect();
                (state.kinds, state.best) = self.compared(&state.lines, &before)?;
            } else if turn > 0 {
                let search = self.search(&state.lines, (ENOUGH, RISE));
                let again = search.climb(state.best.guess, AGAIN)?;
                let kind = again.guess.kind;
                state.kinds.iter_mut().filter(|best| best.guess.kind == kind).for_each(|best| {
                    *best = again.clone();
                });
                state.best = again;
            }
            let (change, moved) = self.step(&state)?;
            let rests = turn > 0 && moved < REST;
            self.follow(&mut state, &change, rests)?;
            if rests || turn + 1 == TURNS {
                return self.ended(state, turn + 1, rests);
            }
        }
        None
    }

    /// Twice the restricted log-likelihood of all runs, with the model linearised about free simulations with `theta`.
    pub fn likelihood(&self, theta: &[f64], guess: Guess) -> f64 {
        let lines: Vec<Line> = self.runs.iter().map(|run| Line::free(self.model, theta, *run)).collect();
        self.search(&lines, (usize::MAX, RISE)).sums(&[guess; LANES], None).likelihood[0]
    }

    fn search<'l>(&self, lines: &'l [Line<'l>], (most, rise): (usize, f64)) -> LikelihoodSearch<'l> {
        let mut left = most;
        let mut chosen = Vec::new();
        for line in lines {
            let samples = line.points.len().min(left);
            left -= samples;
            if samples > 0 {
                chosen.push((line, samples));
            }
        }
        let floor = Seen::of(lines).motion.map(|size| (FLOOR * size).max(1e-12));
        LikelihoodSearch {
            layout: self.model.layout(),
            lines: chosen,
            rate_hz: self.rate_hz,
            known_start: self.known_start,
            floor,
            rise,
        }
    }

    /// The most likely levels of every kind, and of the best. Kinds `before` continue; far less likely ones keep their
    /// distance.
    fn compared(&self, lines: &[Line], before: &Earlier) -> Option<(Vec<Best>, Best)> {
        let search = self.search(lines, if before.is_empty() { FIRST } else { (ENOUGH, RISE) });
        let seen = Seen::of(lines);
        let earlier = |kind: NoiseKind| before.iter().filter(move |(guess, _)| guess.kind == kind);
        let highest = before.iter().map(|(_, value)| *value).fold(f64::NEG_INFINITY, f64::max);
        let far = |kind: NoiseKind| earlier(kind).any(|(_, value)| *value < highest - FAR);
        let (first, later) = NoiseKind::ALL.split_at(4);
        let begun = |kind: &NoiseKind, others: Vec<Guess>| match earlier(*kind).next() {
            Some(_) if far(*kind) => None,
            Some((guess, _)) => search.climb(*guess, STEPS).or_else(|| search.best(&others)),
            None => search.best(&others),
        };
        let each = |kind: &NoiseKind| begun(kind, seen.starts(*kind, self.rate_hz));
        let mut bests: Vec<Best> = first.par_iter().filter_map(each).collect();
        let mut simple: Vec<Guess> = bests.iter().map(|best| best.guess).collect();
        simple.extend(before.iter().map(|(guess, _)| *guess).filter(|guess| far(guess.kind)));
        let each = |kind: &NoiseKind| begun(kind, after(*kind, &simple));
        bests.extend(later.par_iter().filter_map(each).collect::<Vec<_>>());
        let best = bests.iter().max_by(|a, b| value(a).total_cmp(&value(b)))?.clone();
        bests.extend(before.iter().filter(|(guess, _)| far(guess.kind)).map(|(guess, likelihood)| Best {
            guess: *guess,
            likelihood: best.likelihood - cost(&best.guess) + cost(guess) + likelihood - highest,
            change: vec![0.0; best.change.len()],
        }));
        Some((bests, best))
    }

    /// The change of the parameters to the least white errors of all runs, and its maximum in standard errors.
    fn step(&self, state: &State) -> Option<(Vec<f64>, f64)> {
        let (change, errors) = self.all(state, &state.best.guess).change()?;
        let moved = change.iter().zip(&errors).map(|(c, e)| (c / e).abs()).fold(0.0, f64::max);
        moved.is_finite().then_some((change, moved))
    }

    fn all(&self, state: &State, guess: &Guess) -> Likelihoods {
        self.search(&state.lines, (usize::MAX, RISE)).sums(&[*guess; LANES], None)
    }

    /// Changes the parameters and filters the runs with them; by less if the filter's numbers are not finite.
    fn follow(&self, state: &mut State<'a>, change: &[f64], rests: bool) -> Option<()> {
        let bounds = self.model.bounds().unwrap_or_default();
        for share in (0..SHORTER).map(|halved| 0.5_f64.powi(halved)) {
            let mut theta: Vec<f64> = state.theta.iter().zip(change).map(|(p, s)| p + share * s).collect();
            theta.iter_mut().zip(&bounds).for_each(|(p, [low, high])| *p = p.max(*low).min(*high));
            if rests {
                state.theta = theta;
                return Some(());
            }
            let setting = (self.rate_hz, self.known_start);
            let line =
                |run: &RunView<'a>| Line::filtered(self.model, &theta, *run, &state.best.guess, setting);
            if let Some(lines) = self.runs.iter().map(line).collect() {
                (state.theta, state.lines) = (theta, lines);
                return Some(());
            }
        }
        None
    }

    fn ended(&self, state: State, turns: usize, at_rest: bool) -> Option<(Vec<f64>, Noise)> {
        let errors = |guess: &Guess| {
            let sums = self.all(&state, guess);
            let freedom = self.runs.iter().map(RunView::samples).sum::<usize>() * 3;
            let (change, errors) = sums.change()?;
            let explained: f64 = change.iter().zip(&sums.gradient).map(|(a, b)| a * b).sum();
            let freedom = (freedom as f64 - change.len() as f64).max(1.0);
            let variance = ((sums.squares - explained) / freedom).max(0.0);
            Some(errors.into_iter().map(|error| error * variance.sqrt()).collect::<Vec<f64>>())
        };
        let standard_errors = errors(&state.best.guess)?;
        let near = state.kinds.iter().filter(|best| value(best) >= value(&state.best) - NEAR);
        let mut widest = standard_errors.clone();
        for errors in near.filter_map(|best| errors(&best.guess)) {
            widest.iter_mut().zip(errors).for_each(|(most, error)| *most = most.max(error));
        }
        let mut kinds: Kinds = state.kinds.iter().map(|best| (best.guess, value(best))).collect();
        kinds.sort_by(|a, b| b.1.total_cmp(&a.1));
        let noise = Noise { guess: state.best.guess, kinds, turns, at_rest, errors: standard_errors, widest };
        Some((state.theta, noise))
    }
}

fn value(best: &Best) -> f64 {
    best.likelihood - cost(&best.guess)
}

fn cost(guess: &Guess) -> f64 {
    A_LEVEL * guess.kind.levels() as f64
}
