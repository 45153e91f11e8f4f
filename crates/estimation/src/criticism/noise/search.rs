use numerics::{LANES, Lane, Watch, dot, iterate, solve};
use ship::model::ParameterLayout;

use super::likelihood::{LikelihoodSums, Likelihoods, Line, Samples, add_run};
use super::{Guess, MOST, NoiseKind, side_by_side};
use crate::sensitivity::with_states;

/// Change of a logarithm for difference quotients by its level.
const CHANGE: f64 = 1e-4;
const FIRST: usize = 3;
pub(super) const STEPS: usize = 30;
const LONGEST: f64 = 1.5;
/// Damping of the first step, and the largest one that is tried.
const DAMPING: [f64; 2] = [1e-2, 1e6];
/// Levels that are changed in one pass; one more lane is unchanged.
const AT_ONCE: usize = LANES - 1;

/// Maximises the restricted likelihood of runs, with the model linearised about their paths.
pub(super) struct LikelihoodSearch<'a> {
    pub layout: ParameterLayout,
    pub lines: Vec<(&'a Line<'a>, usize)>,
    pub rate_hz: f64,
    pub known_start: bool,
    pub floor: [f64; 3],
    /// The search ends at a smaller rise of twice the log-likelihood.
    pub rise: f64,
}

#[derive(Clone, Debug)]
pub(super) struct Best {
    pub guess: Guess,
    pub likelihood: f64,
    pub change: Vec<f64>,
}

/// A point of a search, with its gradient by the logarithms, and its curvature from the gradients of the samples.
struct ClimbPoint {
    at: Best,
    slopes: [f64; MOST],
    curvature: [f64; MOST * MOST],
}

impl LikelihoodSearch<'_> {
    /// The most likely levels of a kind: the two best of `starts` climb a few steps, and the better one is continued.
    pub fn best(&self, starts: &[Guess]) -> Option<Best> {
        let mut likelihoods: Vec<(Guess, f64)> = Vec::with_capacity(starts.len());
        for some in starts.chunks(LANES) {
            let guesses = std::array::from_fn(|lane| some[lane.min(some.len() - 1)]);
            let likelihood = self.sums(&guesses, None).likelihood;
            likelihoods.extend(some.iter().enumerate().map(|(lane, start)| (*start, likelihood[lane])));
        }
        likelihoods.retain(|(_, likelihood)| likelihood.is_finite());
        likelihoods.sort_by(|a, b| b.1.total_cmp(&a.1));
        let begun = likelihoods.iter().take(2).filter_map(|(start, _)| self.climb(*start, FIRST));
        let better = begun.reduce(|a, b| if b.likelihood > a.likelihood { b } else { a })?;
        self.climb_on(better.guess, &better.change, STEPS)
    }

    /// Ascends from `start` in at most `most` steps.
    pub fn climb(&self, start: Guess, most: usize) -> Option<Best> {
        self.climb_on(start, &vec![0.0; self.layout.parameters()], most)
    }

    /// Damped steps with the curvature from the samples' gradients (Berndt, Hall, Hall and Hausman).
    fn climb_on(&self, start: Guess, change: &[f64], most: usize) -> Option<Best> {
        let mut here = self.slopes(&start, change)?;
        let mut damping = DAMPING[0];
        iterate("Berndt, Hall, Hall and Hausman", most, &Watch::default(), || {
            let step = here.step(damping);
            let trial = here.at.guess.changed(|i| step[i], self.rate_hz, self.floor);
            match self
                .slopes(&trial, &here.at.change)
                .filter(|there| there.at.likelihood > here.at.likelihood)
            {
                Some(there) => {
                    let rise = there.at.likelihood - here.at.likelihood;
                    here = there;
                    damping *= 0.2;
                    if rise < self.rise && damping < 1.0 {
                        return None;
                    }
                }
                None => damping *= 10.0,
            }
            let ends = damping > DAMPING[1] || dot(&here.slopes, &here.step(0.0)) < self.rise;
            (!ends).then_some(())
        });
        Some(here.at)
    }

    /// Sums of all runs under the levels of every lane.
    pub fn sums(&self, guesses: &[Guess; LANES], mut stored: Option<(&[f64], &mut Samples)>) -> Likelihoods {
        let levels = side_by_side(guesses, self.rate_hz);
        let mut sums = LikelihoodSums::new(self.layout.parameters());
        let (states, layout, known) = (guesses[0].kind.states(), self.layout, self.known_start);
        for (line, samples) in &self.lines {
            let store = stored.as_mut().map(|(change, kept)| (*change, &mut **kept));
            with_states!(states, add_run(&mut sums, layout, line, *samples, &levels, known, store));
        }
        sums.finish()
    }

    /// `None` if the filter's numbers are not finite, or the parameters cannot be distinguished.
    fn slopes(&self, at: &Guess, change: &[f64]) -> Option<ClimbPoint> {
        let levels = at.kind.levels();
        let mut point = ClimbPoint {
            at: Best { guess: *at, likelihood: 0.0, change: Vec::new() },
            slopes: [0.0; MOST],
            curvature: [0.0; MOST * MOST],
        };
        let count: usize = self.lines.iter().map(|(_, samples)| samples).sum();
        let mut by_sample = vec![[0.0; MOST]; count];
        for first in (0..levels).step_by(AT_ONCE) {
            let guesses: [Guess; LANES] = std::array::from_fn(|lane| {
                let changed = |i: usize| if lane > 0 && i + 1 == first + lane { CHANGE } else { 0.0 };
                at.changed(changed, self.rate_hz, self.floor)
            });
            let mut samples = Vec::with_capacity(count);
            let sums = self.sums(&guesses, Some((change, &mut samples)));
            let changed = first..levels.min(first + AT_ONCE);
            for i in changed.clone() {
                point.slopes[i] = (sums.likelihood[1 + i - first] - sums.likelihood[0]) / CHANGE;
            }
            for (slopes, [scale, squares]) in by_sample.iter_mut().zip(&samples) {
                for i in changed.clone() {
                    slopes[i] = slope(scale, squares, 1 + i - first);
                }
            }
            if first == 0 {
                point.at.likelihood = sums.likelihood[0];
                point.at.change = sums.change()?.0;
            }
        }
        for slopes in &by_sample {
            for (i, a) in slopes[..levels].iter().enumerate() {
                // For twice the log-likelihood: half the squared gradients.
                let row = point.curvature[i * MOST..].iter_mut().zip(&slopes[..levels]);
                row.for_each(|(sum, b)| *sum += 0.5 * a * b);
            }
        }
        let finite = point.at.likelihood.is_finite() && point.slopes.iter().all(|s| s.is_finite());
        finite.then_some(point)
    }
}

/// The contribution of a sample to the derivative of twice the log-likelihood by the level that is changed in a lane.
fn slope(scale: &Lane, squares: &Lane, lane: usize) -> f64 {
    (2.0 * (scale[lane] / scale[0] - 1.0) - (squares[lane] - squares[0])) / CHANGE
}

impl ClimbPoint {
    fn step(&self, damping: f64) -> [f64; MOST] {
        let (mut matrix, mut step) = (self.curvature, self.slopes);
        for i in 0..MOST {
            matrix[i * MOST + i] += damping * matrix[i * MOST + i] + 1e-3;
        }
        if solve(MOST, &mut matrix, &mut step).is_none() {
            return [0.0; MOST];
        }
        let most = step.iter().fold(LONGEST, |most: f64, x| most.max(x.abs()));
        step.map(|x| x * LONGEST / most)
    }
}

pub(super) struct Seen {
    /// Differences of neighbouring samples beyond steady change: u, v, r.
    pub rough: [f64; 3],
    pub errors: [f64; 3],
    pub motion: [f64; 3],
}

const TIMES: [f64; 4] = [3.0, 12.0, 50.0, 300.0];

impl Seen {
    pub fn of(lines: &[Line]) -> Self {
        let (mut rough, mut errors, mut motion) = ([0.0; 3], [0.0; 3], [0.0; 3]);
        let (mut windows, mut samples) = (0.0, 0.0);
        for line in lines {
            let rows = line.run.measured.as_chunks::<3>().0;
            for row in rows.windows(3) {
                (0..3).for_each(|d| rough[d] += (row[2][d] - 2.0 * row[1][d] + row[0][d]).powi(2) / 6.0);
                windows += 1.0;
            }
            let rms = line.errors();
            (0..3).for_each(|d| errors[d] += rms[d] * rms[d] * line.points.len() as f64);
            rows.iter().for_each(|row| (0..3).for_each(|d| motion[d] += row[d] * row[d]));
            samples += line.points.len() as f64;
        }
        let root = |sums: [f64; 3], count: f64| sums.map(|sum| (sum / f64::max(count, 1.0)).sqrt());
        Self { rough: root(rough, windows), errors: root(errors, samples), motion: root(motion, samples) }
    }

    /// Starts of a kind that does not begin at another one.
    pub fn starts(&self, kind: NoiseKind, rate_hz: f64) -> Vec<Guess> {
        let flow = libm::hypot(self.errors[0], self.errors[1]);
        let less = |share: f64| self.errors.map(|e| share * e);
        let pairs = |shares: [f64; 2], times: &[f64]| -> Vec<[f64; 2]> {
            times.iter().flat_map(|time| shares.map(|share| [share, *time])).collect()
        };
        let (second, shares) = match kind {
            NoiseKind::White => (less(0.9), [0.03, 0.3, 1.0, 3.0].map(|share| [share, 0.0]).to_vec()),
            NoiseKind::Current => (less(0.4), pairs([0.3, 1.2], &TIMES)),
            NoiseKind::Forces | NoiseKind::ForcesEach => {
                // Errors that grow over a time are due to forces of about that time.
                let times = [0.5 / rate_hz, 2.0 / rate_hz, 2.0, 8.0, 30.0, 120.0];
                (less(0.4), pairs([0.02, 0.1], &times))
            }
            NoiseKind::Sensors => {
                (self.rough.map(|r| 0.3 * r), pairs([0.3, 1.0], &[1.0, 5.0, 20.0, 60.0, 200.0]))
            }
            NoiseKind::ForcesAndCurrent => return Vec::new(),
        };
        let guess = |noise: [f64; 3], [share, time]: [f64; 2]| match kind {
            NoiseKind::White => Guess::new(kind, &[&noise[..], &[share * flow]].concat()),
            NoiseKind::Current => Guess::new(kind, &[&noise[..], &[share * flow, time]].concat()),
            _ => Guess::new(kind, &[&noise[..], &less(share), &[time]].concat()),
        };
        let of = |noise: [f64; 3]| shares.iter().map(move |other| guess(noise, *other)).collect::<Vec<_>>();
        [self.rough, second].into_iter().flat_map(of).collect()
    }
}

/// Starts of a kind that begins at others, which were found before it.
pub(super) fn after(kind: NoiseKind, earlier: &[Guess]) -> Vec<Guess> {
    let of = |kind: NoiseKind| earlier.iter().find(|guess| guess.kind == kind);
    let forces = of(NoiseKind::Forces);
    let all = |guess: &Guess| (0..guess.kind.levels()).map(|i| guess.level(i)).collect::<Vec<f64>>();
    match (kind, forces, of(NoiseKind::Current)) {
        (NoiseKind::ForcesEach, Some(forces), _) => {
            let levels = all(forces);
            let shares = [
                [1.0, 1.0, 1.0],
                [3.0, 1.0, 1.0],
                [1.0, 3.0, 1.0],
                [1.0, 1.0, 3.0],
                [0.3, 1.0, 1.0],
                [1.0, 0.3, 1.0],
                [1.0, 1.0, 0.3],
                [0.3, 1.0, 3.0],
            ];
            shares
                .map(|times| Guess::new(kind, &[&levels[..6], &times.map(|t| t * levels[6])].concat()))
                .to_vec()
        }
        (NoiseKind::ForcesAndCurrent, Some(forces), Some(current)) => {
            let (f, c) = (all(forces), all(current));
            let noise = |i: usize| f[i].min(c[i]);
            let mixed = |force: f64, flow: f64, noise: [f64; 3]| {
                let pushed = [3, 4, 5].map(|i| force * f[i]);
                Guess::new(kind, &[&noise[..], &pushed, &[f[6], flow * c[3], c[4]]].concat())
            };
            let least = [0, 1, 2].map(noise);
            let [of_f, of_c] = [&f, &c].map(|level| [level[0], level[1], level[2]]);
            [
                mixed(1.0, 1.0, least),
                mixed(0.7, 0.7, least),
                mixed(1.0, 0.1, of_f),
                mixed(0.1, 1.0, of_c),
                mixed(0.5, 1.0, of_c),
                mixed(1.0, 0.5, of_f),
                mixed(0.3, 0.3, least),
                mixed(0.3, 0.7, least),
            ]
            .to_vec()
        }
        _ => Vec::new(),
    }
}
