use numerics::{LANES, Lane, Watch, dot, iterate, solve};
use ship::model::ParameterLayout;

use super::kind::{Guess, MOST, NoiseKind, side_by_side};
use super::line::Line;
use super::pass::{Found, Samples, Sums};

/// Change of a logarithm for difference quotients by its level.
const CHANGE: f64 = 1e-4;
/// Steps after which the better of two climbs is continued.
const FIRST: usize = 3;
/// Maximum number of steps of a climb.
pub(super) const STEPS: usize = 30;
/// Maximum change of a logarithm in a step.
const LONGEST: f64 = 1.5;
/// Damping of the first step, and the largest one that is tried.
const DAMPING: [f64; 2] = [1e-2, 1e6];
/// Levels that are changed in one pass; one more lane is unchanged.
const AT_ONCE: usize = LANES - 1;

/// Maximises the restricted likelihood of runs, with the model linearised about their paths.
pub(super) struct Search<'a> {
    pub layout: ParameterLayout,
    /// Runs, and the number of samples used of each.
    pub lines: Vec<(&'a Line<'a>, usize)>,
    pub rate_hz: f64,
    pub known_start: bool,
    /// Least noise of u, v, r.
    pub floor: [f64; 3],
    /// The search ends at a smaller rise of twice the log-likelihood.
    pub rise: f64,
}

/// The best point of a search.
#[derive(Clone, Debug)]
pub(super) struct Best {
    pub guess: Guess,
    /// Twice the restricted log-likelihood up to a constant.
    pub likelihood: f64,
    /// The change of the parameters to the least white errors.
    pub change: Vec<f64>,
}

/// A point of a search, with its gradient by the logarithms, and its curvature from the gradients of the samples.
struct Slopes {
    at: Best,
    slopes: [f64; MOST],
    curvature: [f64; MOST * MOST],
}

impl Search<'_> {
    /// The most likely levels of a kind: the two best of `starts` climb a few steps, and the better one is continued.
    pub fn best(&self, starts: &[Guess]) -> Option<Best> {
        let mut found: Vec<(Guess, f64)> = Vec::with_capacity(starts.len());
        for some in starts.chunks(LANES) {
            let guesses = std::array::from_fn(|lane| some[lane.min(some.len() - 1)]);
            let likelihood = self.sums(&guesses, None).likelihood;
            found.extend(some.iter().enumerate().map(|(lane, start)| (*start, likelihood[lane])));
        }
        found.retain(|(_, likelihood)| likelihood.is_finite());
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        let begun = found.iter().take(2).filter_map(|(start, _)| self.climb(*start, FIRST));
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
    pub fn sums(&self, guesses: &[Guess; LANES], mut own: Option<(&[f64], &mut Samples)>) -> Found {
        let levels = side_by_side(guesses, self.rate_hz);
        let mut sums = Sums::new(self.layout.parameters());
        let known = self.known_start;
        for (line, samples) in &self.lines {
            let own = own.as_mut().map(|(change, kept)| (*change, &mut **kept));
            match guesses[0].kind {
                NoiseKind::White => sums.add::<3>(self.layout, line, *samples, &levels, known, own),
                NoiseKind::Current => sums.add::<5>(self.layout, line, *samples, &levels, known, own),
                NoiseKind::Forces | NoiseKind::ForcesEach => {
                    sums.add::<6>(self.layout, line, *samples, &levels, known, own)
                }
                NoiseKind::Sensors => sums.add::<7>(self.layout, line, *samples, &levels, known, own),
                NoiseKind::ForcesAndCurrent => {
                    sums.add::<8>(self.layout, line, *samples, &levels, known, own)
                }
            }
        }
        sums.finish()
    }

    /// `None` if the filter's numbers are not finite, or the parameters cannot be distinguished.
    fn slopes(&self, at: &Guess, change: &[f64]) -> Option<Slopes> {
        let levels = at.kind.levels();
        let mut found = Slopes {
            at: Best { guess: *at, likelihood: 0.0, change: Vec::new() },
            slopes: [0.0; MOST],
            curvature: [0.0; MOST * MOST],
        };
        let count: usize = self.lines.iter().map(|(_, samples)| samples).sum();
        let mut by_sample = vec![[0.0; MOST]; count];
        for first in (0..levels).step_by(AT_ONCE) {
            let guesses: [Guess; LANES] = std::array::from_fn(|lane| {
                let own = |i: usize| if lane > 0 && i + 1 == first + lane { CHANGE } else { 0.0 };
                at.changed(own, self.rate_hz, self.floor)
            });
            let mut samples = Vec::with_capacity(count);
            let sums = self.sums(&guesses, Some((change, &mut samples)));
            let changed = first..levels.min(first + AT_ONCE);
            for i in changed.clone() {
                found.slopes[i] = (sums.likelihood[1 + i - first] - sums.likelihood[0]) / CHANGE;
            }
            for (slopes, [scale, squares]) in by_sample.iter_mut().zip(&samples) {
                for i in changed.clone() {
                    slopes[i] = slope(scale, squares, 1 + i - first);
                }
            }
            if first == 0 {
                found.at.likelihood = sums.likelihood[0];
                found.at.change = sums.change()?.0;
            }
        }
        for slopes in &by_sample {
            for (i, a) in slopes[..levels].iter().enumerate() {
                // For twice the log-likelihood: half the squared gradients.
                let row = found.curvature[i * MOST..].iter_mut().zip(&slopes[..levels]);
                row.for_each(|(sum, b)| *sum += 0.5 * a * b);
            }
        }
        let finite = found.at.likelihood.is_finite() && found.slopes.iter().all(|s| s.is_finite());
        finite.then_some(found)
    }
}

/// The contribution of a sample to the derivative of twice the log-likelihood by the level that is changed in a lane.
fn slope(scale: &Lane, squares: &Lane, lane: usize) -> f64 {
    (2.0 * (scale[lane] / scale[0] - 1.0) - (squares[lane] - squares[0])) / CHANGE
}

impl Slopes {
    /// A damped ascent step; levels without effect stay.
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
