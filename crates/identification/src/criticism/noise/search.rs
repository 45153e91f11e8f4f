use model::ParameterLayout;
use numerics::{LANES, Lane, Watch, dot, iterate, solve};

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

#[cfg(test)]
mod tests {
    use engine::RunView;
    use model::{Model, Source, Vessel};

    use super::*;

    const RATE_HZ: f64 = 8.0;
    const SAMPLES: usize = 14;

    /// A short run that the path of a free simulation does not follow exactly.
    fn run(model: &Model, theta: &[f64]) -> (Vec<f64>, Vec<f64>) {
        let wave = |k: usize, by: f64| (by * k as f64).sin();
        let inputs = |k: usize| [2000.0, 900.0, 400.0].map(|size: f64| size * wave(k + 1, 0.2 + 1e-4 * size));
        let exogenous: Vec<f64> = (0..SAMPLES).flat_map(inputs).collect();
        let states = engine::simulate_one(model, theta, [0.6, 0.05, 0.1], &exogenous);
        let off = |(i, x): (usize, f64)| x + 0.05 * wave(i * i + 3, 1.7);
        (states.into_iter().enumerate().map(off).collect(), exogenous)
    }

    /// A random draw, in units of its standard deviation.
    #[derive(Clone, Copy, PartialEq)]
    enum Draw {
        Noise(usize, usize),
        Start(usize),
        /// Of the current, of forces or of sensors, before a sample.
        Water(usize, usize),
        Push(usize, usize),
        Sensor(usize, usize),
    }

    fn draws(kind: NoiseKind) -> Vec<Draw> {
        use NoiseKind::{Current, Forces, ForcesAndCurrent, ForcesEach, Sensors, White};
        let steps = |count: usize| (0..=SAMPLES).flat_map(move |k| (0..count).map(move |d| (k, d)));
        let mut all: Vec<Draw> = steps(3).map(|(k, d)| Draw::Noise(k, d)).collect();
        all.extend((0..3).map(Draw::Start));
        if matches!(kind, White | Current | ForcesAndCurrent) {
            all.extend(steps(2).map(|(k, d)| Draw::Water(k, d)));
        }
        if matches!(kind, Forces | ForcesEach | ForcesAndCurrent) {
            all.extend(steps(3).map(|(k, d)| Draw::Push(k, d)));
        }
        if kind == Sensors {
            all.extend(steps(3).map(|(k, d)| Draw::Sensor(k, d)));
        }
        all
    }

    /// The response of all measurements to a draw, or to a unit of a parameter, by propagation through all samples.
    #[allow(clippy::needless_range_loop)] // Several arrays at once.
    fn response(line: &Line, guess: &Guess, drawn: Option<Draw>, parameter: Option<usize>) -> Vec<f64> {
        let p = line.terms.len() / SAMPLES;
        let layout = Vessel::preset("ljungberg-model-ship").unwrap().model.with_intercepts().layout();
        let noise = guess.measurement();
        let (flow, time) = guess.current();
        let unit = |own: Draw| if drawn == Some(own) { 1.0 } else { 0.0 };
        let keep = |time: f64| (-1.0 / (RATE_HZ * time)).exp();
        let next = |before: f64, k: usize, std: f64, keep: f64, drawn: f64| {
            keep * before + std * if k == 0 { drawn } else { (1.0 - keep * keep).sqrt() * drawn }
        };
        let mut x: [f64; 3] = [0, 1, 2].map(|d| 1e3 * noise[d] * unit(Draw::Start(d)));
        let (mut water, mut push, mut sensor, mut heading) = ([0.0; 2], [0.0; 3], [0.0; 3], 0.0_f64);
        let mut out = Vec::new();
        for k in 0..=SAMPLES {
            for d in 0..3 {
                if let Some((std, times)) = guess.forces() {
                    push[d] = next(push[d], k, std[d], keep(times[d]), unit(Draw::Push(k, d)));
                }
                if let Some((std, time)) = guess.sensors() {
                    sensor[d] = next(sensor[d], k, std[d], keep(time), unit(Draw::Sensor(k, d)));
                }
                out.push(x[d] + sensor[d] + noise[d] * unit(Draw::Noise(k, d)));
            }
            if k == SAMPLES {
                break;
            }
            for d in 0..2 {
                water[d] = next(water[d], k, flow, time.map_or(0.0, keep), unit(Draw::Water(k, d)));
            }
            let (sin, cos) = if time.is_some() { heading.sin_cos() } else { (0.0, 1.0) };
            let body = [cos * water[0] + sin * water[1], cos * water[1] - sin * water[0]];
            let point = &line.points[k];
            let mut moved = x;
            for d in 0..3 {
                let j = point.slopes[d];
                moved[d] += j[0] * (x[0] - body[0]) + j[1] * (x[1] - body[1]) + j[2] * x[2] + push[d];
            }
            if let Some(i) = parameter {
                moved[layout.degrees().nth(i).unwrap()] += line.terms[k * p + i];
            }
            heading += point.state[2] / RATE_HZ;
            x = moved;
        }
        out
    }

    /// Twice the restricted log-likelihood of all samples after the first, from their covariance.
    #[allow(clippy::needless_range_loop)] // Cholesky's, of rows and columns.
    fn dense(line: &Line, guess: &Guess) -> f64 {
        let p = line.terms.len() / SAMPLES;
        let n = 3 * (SAMPLES + 1);
        let columns: Vec<Vec<f64>> =
            draws(guess.kind).into_iter().map(|draw| response(line, guess, Some(draw), None)).collect();
        let mut lower = vec![0.0; n * n];
        for i in 0..n {
            for j in 0..=i {
                let covariance: f64 = columns.iter().map(|own| own[i] * own[j]).sum();
                let left = covariance - (0..j).map(|k| lower[i * n + k] * lower[j * n + k]).sum::<f64>();
                lower[i * n + j] = if i == j { left.sqrt() } else { left / lower[j * n + j] };
            }
        }
        let white = |mut own: Vec<f64>| {
            for i in 0..n {
                let before: f64 = (0..i).map(|k| lower[i * n + k] * own[k]).sum();
                own[i] = (own[i] - before) / lower[i * n + i];
            }
            own.split_off(3)
        };
        let path = line.points.iter().map(|point| point.state);
        let last = line.points[SAMPLES - 1].next;
        let path: Vec<f64> = path.chain([last]).flatten().collect();
        let errors = white(line.run.measured.iter().zip(path).map(|(y, x)| y - x).collect());
        let slopes: Vec<Vec<f64>> = (0..p).map(|i| white(response(line, guess, None, Some(i)))).collect();
        let mut normal: Vec<f64> = (0..p * p).map(|k| dot(&slopes[k / p], &slopes[k % p])).collect();
        let gradient: Vec<f64> = slopes.iter().map(|own| dot(own, &errors)).collect();
        let volume = numerics::log_det(p, &mut normal.clone()).unwrap().log_abs;
        let mut solved = gradient.clone();
        solve(p, &mut normal, &mut solved).unwrap();
        let logs: f64 = (3..n).map(|i| lower[i * n + i].ln()).sum();
        -2.0 * logs - (dot(&errors, &errors) - dot(&gradient, &solved)) - volume
    }

    #[test]
    fn oracle_the_restricted_likelihood_is_that_of_the_whole_covariance() {
        let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
        let model = vessel.model.with_intercepts();
        let theta = model.layout().woven(&vessel.parameters(Source::Value).unwrap(), [1e-3, 0.0, -1e-3]);
        let (measured, exogenous) = run(&model, &theta);
        let view = RunView {
            measured: &measured,
            instrument_exogenous: &exogenous,
            exogenous: &exogenous,
            initial: [0.6, 0.05, 0.1],
        };
        let line = Line::free(&model, &theta, view);
        let search = Search {
            layout: model.layout(),
            lines: vec![(&line, SAMPLES)],
            rate_hz: RATE_HZ,
            known_start: false,
            floor: [1e-9; 3],
            rise: 0.05,
        };
        let noise = [0.03, 0.05, 0.04];
        for (kind, more) in [
            (NoiseKind::White, &[0.2][..]),
            (NoiseKind::Current, &[0.1, 0.7]),
            (NoiseKind::Forces, &[0.02, 0.01, 0.03, 0.4]),
            (NoiseKind::ForcesEach, &[0.02, 0.01, 0.03, 0.4, 2.0, 0.2]),
            (NoiseKind::Sensors, &[0.05, 0.02, 0.03, 0.6]),
            (NoiseKind::ForcesAndCurrent, &[0.02, 0.01, 0.03, 0.4, 0.1, 0.7]),
        ] {
            let guess = Guess::new(kind, &[&noise, more].concat());
            let (found, wanted) = (search.sums(&[guess; LANES], None).likelihood[3], dense(&line, &guess));
            assert!((found - wanted).abs() < 2e-5 * wanted.abs(), "{kind:?}: {found} {wanted}");
        }
    }
}
