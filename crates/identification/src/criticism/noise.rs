use numerics::{dot, solve};
use vessel::lanes::{SideBySide, lane};
use vessel::{LANES, Lane, Model, RunView};

use crate::sensitivity::{Flow, Levels, Recordings, filter_each};

/// What is looked for: noise of u, v, r; the current; over which time it changes.
const LEVELS: usize = 5;
/// By how much a logarithm is changed to see what its level does.
const CHANGE: f64 = 1e-4;
/// Most steps of a search, and those after which only the most promising go on.
const STEPS: [usize; 2] = [30, 5];
/// How many go on.
const PROMISING: usize = 2;
/// Rise of twice the log-likelihood from which a further step is worth it.
const RISE: f64 = 0.01;
/// Most that a logarithm changes by in a step.
const LONGEST: f64 = 1.5;
/// Damping of the first step and beyond which none helps.
const DAMPING: [f64; 2] = [1e-2, 1e6];
/// Samples that are enough to know the noise.
pub(crate) const ENOUGH: usize = 12_000;
/// Times over which a drifting current is first thought to change \[s\].
const TIMES: [f64; 3] = [3.0, 20.0, 150.0];
/// Shares of the time between two samples below which a current is new at every sample, and of which it is first thought so.
const NEW: [f64; 2] = [0.7, 0.2];
/// Share of the speed that a current is first thought to have that stays.
const SMALL: f64 = 0.1;
/// Least time of a drift over that between two samples.
const LEAST: f64 = 1e-3;
/// Time of a drift from which a current stays as it is \[s\].
pub(super) const LASTING: f64 = 1e5;

/// Logarithms of the levels: noise of u, v, r, current, time of its drift \[s\].
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Guess {
    logs: [f64; LEVELS],
}

impl Guess {
    /// By level: standard deviations of noise and current, and the time \[s\].
    fn level(&self, i: usize) -> f64 {
        libm::exp(self.logs[i])
    }

    /// Standard deviations of the noise in u, v, r.
    pub fn measurement(&self) -> [f64; 3] {
        [0, 1, 2].map(|d| self.level(d))
    }

    /// Standard deviation of the current, and the time over which it drifts \[s\] unless it is new at every sample.
    pub fn current(&self, rate_hz: f64) -> (f64, Option<f64>) {
        (self.level(3), Some(self.level(4)).filter(|time| time * rate_hz > NEW[0]))
    }

    fn changed(mut self, by: impl Fn(usize) -> f64, rate_hz: f64) -> Self {
        (0..LEVELS).for_each(|i| self.logs[i] += by(i));
        self.logs[4] = self.logs[4].clamp(libm::log(LEAST / rate_hz), libm::log(LASTING));
        self
    }

    /// Where searches begin: where `errors` say, the standard deviations of the errors of free simulations, once with all of
    /// them noise, else with more and more of them from a current.
    pub fn first(errors: [f64; 3], rate_hz: f64) -> Vec<Self> {
        let noise = |less: f64| errors.map(|error| libm::log(error.max(1e-9)) - less);
        let flow = libm::log(libm::hypot(errors[0], errors[1]).max(1e-9));
        let guess = |less: f64, current: f64, time: f64| {
            let [u, v, r] = noise(less);
            Self { logs: [u, v, r, flow + current, libm::log(time)] }
        };
        let new = NEW[1] / rate_hz;
        let drifts = TIMES.iter().map(|time| guess(1.0, 0.0, *time));
        [guess(0.0, -3.0, new), guess(2.0, 1.0, new)].into_iter().chain(drifts).collect()
    }
}

/// What disturbs runs side by side, of each its own; a current that is new at every sample is one that drifts within none.
pub(super) fn side_by_side(guesses: &[Guess; LANES], rate_hz: f64) -> Levels<Lane> {
    let level = |i: usize| lane(LANES, |run| guesses[run].level(i));
    let factor = lane(LANES, |run| libm::exp(-1.0 / (rate_hz * guesses[run].level(4))));
    let turning = Lane::splat(1.0 / rate_hz);
    let current = Flow::Markov { std: level(3), factor, turning };
    Levels { measurement: [0, 1, 2].map(level), current, force: None }
}

/// What makes the first of some runs most likely under a model.
pub(super) struct Search<'a> {
    model: &'a Model,
    rate_hz: f64,
    known_start: bool,
    /// Each in all lanes, one guess in each.
    runs: Vec<SideBySide>,
}

/// Twice the log-likelihood but for a constant, its slopes by the logarithms, and its curvature by those of every sample.
struct Worth {
    worth: f64,
    slopes: [f64; LEVELS],
    curvature: [f64; LEVELS * LEVELS],
}

impl<'a> Search<'a> {
    /// By the first of `runs` until there are [`ENOUGH`] samples.
    pub fn new<'r>(
        model: &'a Model,
        runs: impl Iterator<Item = RunView<'r>>,
        rate_hz: f64,
        known_start: bool,
    ) -> Self {
        let (mut left, mut chosen) = (ENOUGH, Vec::new());
        for run in runs {
            let samples = run.samples().min(left);
            left -= samples;
            let part = match samples == run.samples() {
                true => run,
                false => RunView { initial: run.initial, ..run.part(0..samples) },
            };
            chosen.push(SideBySide::of(&[part; LANES]));
            if left == 0 {
                break;
            }
        }
        Self { model, rate_hz, known_start, runs: chosen }
    }

    /// The most likely of what a few steps from each of `starts` lead to under `parameters`, and twice its log-likelihood.
    pub fn brief(&self, starts: &[Guess], parameters: &[f64]) -> Vec<(Guess, f64)> {
        let each = starts.iter().filter_map(|start| self.climb(*start, parameters, STEPS[1]));
        let mut found: Vec<(Guess, f64)> = each.collect();
        found.sort_by(|a, b| b.1.total_cmp(&a.1));
        found.truncate(PROMISING);
        found
    }

    /// The same after all steps from the most promising of them.
    pub fn from(&self, starts: &[Guess], parameters: &[f64]) -> Option<(Guess, f64)> {
        let promising = self.brief(starts, parameters);
        let found = promising.iter().filter_map(|(start, _)| self.climb(*start, parameters, STEPS[0]));
        found.max_by(|a, b| a.1.total_cmp(&b.1))
    }

    /// Twice the log-likelihood.
    pub fn likelihood(&self, at: &Guess, parameters: &[f64]) -> Option<f64> {
        self.worth(at, parameters).map(|found| found.worth)
    }

    /// Where a search begins that knows nothing of errors: noise by what neighbouring samples differ by beyond steady change,
    /// and a current that stays, small beside the speed.
    pub fn lasting(&self) -> Guess {
        let (mut rough, mut speed, mut samples) = ([0.0; 3], 0.0, 0.0);
        for run in &self.runs {
            for row in run.measured.as_chunks::<3>().0.windows(3) {
                for (d, sum) in rough.iter_mut().enumerate() {
                    let change = row[2][d][0] - 2.0 * row[1][d][0] + row[0][d][0];
                    *sum += change * change / 6.0;
                }
                speed += row[1][0][0] * row[1][0][0] + row[1][1][0] * row[1][1][0];
                samples += 1.0;
            }
        }
        let log = |sum: f64| libm::log((sum / samples).sqrt().max(1e-9));
        let [u, v, r] = rough.map(log);
        Guess { logs: [u, v, r, log(speed) + libm::log(SMALL), libm::log(LASTING)] }
    }

    /// Goes uphill by damped steps, whose curvature is that of the samples' own slopes (Berndt, Hall, Hall and Hausman).
    fn climb(&self, start: Guess, parameters: &[f64], most: usize) -> Option<(Guess, f64)> {
        let (mut at, mut here) = (start, self.worth(&start, parameters)?);
        let mut damping = DAMPING[0];
        for _ in 0..most {
            let step = here.step(damping);
            let trial = at.changed(|i| step[i], self.rate_hz);
            match self.worth(&trial, parameters).filter(|there| there.worth > here.worth) {
                Some(there) => {
                    let rise = there.worth - here.worth;
                    (at, here) = (trial, there);
                    damping *= 0.2;
                    if rise < RISE && damping < 1.0 {
                        break;
                    }
                }
                None => damping *= 10.0,
            }
            if damping > DAMPING[1] || dot(&here.slopes, &here.step(0.0)) < RISE {
                break;
            }
        }
        Some((at, here.worth))
    }

    /// None where the filter's numbers end.
    fn worth(&self, at: &Guess, parameters: &[f64]) -> Option<Worth> {
        let guesses: [Guess; LANES] = std::array::from_fn(|lane| {
            at.changed(|i| if lane == i + 1 { CHANGE } else { 0.0 }, self.rate_hz)
        });
        let levels = side_by_side(&guesses, self.rate_hz);
        let mut sum = Worth { worth: 0.0, slopes: [0.0; LEVELS], curvature: [0.0; LEVELS * LEVELS] };
        let unknowns: Vec<Lane> = parameters.iter().copied().chain([0.0; 3]).map(Lane::splat).collect();
        for run in &self.runs {
            let recordings = Recordings::of(self.model, run);
            let (gains, innovations) =
                filter_each::<LEVELS>(&recordings, &unknowns, &levels, self.known_start);
            for (gain, error) in gains.iter().zip(innovations.as_chunks().0).skip(1) {
                sum.add(gain.scales(), gain.white(error));
            }
        }
        sum.worth.is_finite().then_some(sum)
    }
}

impl Worth {
    /// Adds a sample.
    fn add(&mut self, scales: [Lane; 3], white: [Lane; 3]) {
        let own = |lane: usize| {
            let det: f64 = scales.iter().map(|s| s[lane]).product();
            2.0 * libm::log(det) - white.iter().map(|w| w[lane] * w[lane]).sum::<f64>()
        };
        let here = own(0);
        let slopes: [f64; LEVELS] = std::array::from_fn(|i| (own(i + 1) - here) / CHANGE);
        self.worth += here;
        for (i, a) in slopes.iter().enumerate() {
            self.slopes[i] += a;
            // Of twice the log-likelihood: half the squared slopes.
            slopes.iter().enumerate().for_each(|(j, b)| self.curvature[i * LEVELS + j] += 0.5 * a * b);
        }
    }

    /// Uphill; what makes no difference stays.
    fn step(&self, damping: f64) -> [f64; LEVELS] {
        let (mut matrix, mut step) = (self.curvature, self.slopes);
        for i in 0..LEVELS {
            matrix[i * LEVELS + i] += damping * matrix[i * LEVELS + i] + 1e-3;
        }
        if solve(LEVELS, &mut matrix, &mut step).is_none() {
            return [0.0; LEVELS];
        }
        let most = step.iter().fold(LONGEST, |most: f64, x| most.max(x.abs()));
        step.map(|x| x * LONGEST / most)
    }
}
