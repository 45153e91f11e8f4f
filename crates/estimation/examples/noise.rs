//! How reliable verdicts and intervals are on runs whose noise is not stated: two ships under many disturbances,
//! simulated repeatedly.
//!
//! `cargo run --release -p seatrial-estimation --example noise -- <what> <runs> <seed> [<ship or disturbance> …]` with
//! `size`: how often the exact model is rejected, and how often intervals contain the truth, for `prediction-error`
//! and `output-error`; `power`: how often a model that lacks two terms is rejected, and whether one of them is named
//! first; `yaw`: the same for `r |r|` alone; `inverted`: how often each input is named that is logged with the other sign, and
//! any that is logged right; `stated`: the same with stated noise; `short`: `size` for runs of a quarter of the length; `right` and
//! `right-short`: both without intervals; `pooled`: size of eight runs together.

use std::collections::BTreeMap;
use std::time::Instant;

use estimation::Estimator;
use estimation::criticism::{Criticism, Subject, Verdict, criticise, criticise_each};
use estimation::pooled::{Judgement, Pool, Resampling, estimate};
use estimation::predictor::{Drift, Flow, ForceNoise, InitialState, NoiseModel};
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use maneuver::{DictionaryFile, Generator};
use numerics::statistics::{clustered_share, wilson};
use rayon::prelude::*;
use regression::MeanRemoval;
use regression::pooled::PooledRuns;
use ship::engine::{Compiled, Run, RunView, Segment, Streams};
use ship::model::{Model, Source, Term, Vessel};

const PAPER: &str = include_str!("../../../pipelines/paper/vessel.toml");
const DICTIONARY: &str = include_str!("../../../pipelines/paper/dictionary.toml");
const TWIN: &str = include_str!("twin.toml");
/// The paper's optimized experiment: maneuver and samples.
const OPTIMIZED: [(usize, usize); 6] = [(0, 193), (4, 43), (5, 229), (6, 101), (7, 85), (10, 349)];
/// Runs that are judged together.
const POOLED: usize = 8;

fn main() -> Result<(), Box<dyn std::error::Error>> {
    let arguments: Vec<String> = std::env::args().skip(1).collect();
    let at = |i: usize| arguments.get(i).map(String::as_str);
    let what = at(0).unwrap_or("size").to_owned();
    let (runs, seed): (u32, u64) = (at(1).unwrap_or("40").parse()?, at(2).unwrap_or("1").parse()?);
    let wanted: Vec<&String> = arguments.iter().skip(3).collect();
    println!("{what}: {runs} runs of each, seed {seed}");
    // Short runs contain the same maneuvers in a quarter of the time.
    let share = if what.ends_with("short") { 4 } else { 1 };
    for ship in [paper(share)?, twin(share)?] {
        let chosen = |name: &str| wanted.iter().any(|own| own.as_str() == name);
        let ships = ["paper", "twin"].into_iter().any(chosen);
        if ships && !chosen(ship.name) {
            continue;
        }
        for (name, sea) in ship.seas() {
            let some = wanted.iter().any(|own| !["paper", "twin"].contains(&own.as_str()));
            if some && !chosen(name) {
                continue;
            }
            let begun = Instant::now();
            for line in ship.lines(&what, &sea, runs, seed) {
                println!("{:<6}{name:<18}{line}", ship.name);
            }
            println!("{:<6}{name:<18}{:.1} s", ship.name, begun.elapsed().as_secs_f64());
        }
    }
    Ok(())
}

/// The disturbances of runs.
#[derive(Clone, Copy, Default)]
struct Sea {
    /// The name that seeds its draws.
    name: &'static str,
    noise: [f64; 3],
    /// Standard deviation, and the time over which the current drifts [s]: 0 if it is new at every sample, infinite
    /// if it is constant.
    current: Option<(f64, f64)>,
    /// Accelerations, and the time over which each drifts.
    force: Option<([f64; 3], [f64; 3])>,
    /// Drift of the sensors.
    sensors: Option<([f64; 3], f64)>,
    /// Accelerations that oscillate, and their period.
    waves: Option<([f64; 3], f64)>,
}

impl Sea {
    /// The disturbances as stated to the filter. Constant ones are left to the intercepts.
    fn levels(&self, rate: f64) -> NoiseModel {
        let factor = |time: f64| correlation(rate, time);
        let flow = |(std, time): (f64, f64)| match time > 0.0 {
            true => Flow::Markov { std, factor: factor(time), turning: 1.0 / rate },
            false => Flow::White { std },
        };
        let gusts = |(std, times): ([f64; 3], [f64; 3])| {
            times[0].is_finite().then(|| ForceNoise { std: std.map(|s| s / rate), factor: times.map(factor) })
        };
        NoiseModel {
            measurement: self.noise,
            current: self.current.map_or(Flow::Still, flow),
            force: self.force.and_then(gusts),
            drift: self.sensors.map(|(std, time)| Drift { std, factor: factor(time) }),
        }
    }
}

/// Correlation of neighbouring samples of a process that drifts over `time` \[s\].
fn correlation(rate: f64, time: f64) -> f64 {
    (-1.0 / (rate * time)).exp()
}

struct Ship {
    name: &'static str,
    vessel: Vessel,
    /// The true model when the fitted one lacks two terms.
    richer: (Model, Vec<f64>),
    /// The same with `r |r|` alone.
    quadratic: (Model, Vec<f64>),
    initial: [f64; 3],
    inputs: Vec<f64>,
    known_start: bool,
    /// Noise, current, accelerations, drift of sensors.
    scales: ([f64; 3], f64, [f64; 3], [f64; 3]),
    white: ([f64; 3], f64),
}

fn paper(share: usize) -> Result<Ship, Box<dyn std::error::Error>> {
    let vessel = Vessel::from_file(PAPER.parse()?)?;
    let file: DictionaryFile = DICTIONARY.parse()?;
    let generator = Generator::without_tables(&vessel, &file)?;
    let (mut inputs, mut initial) = (Vec::new(), None);
    for (maneuver, samples) in OPTIMIZED {
        let own = generator.realize(maneuver, samples / share)?;
        initial = initial.or(Some(own.initial));
        inputs.extend(own.inputs);
    }
    Ok(Ship {
        name: "paper",
        richer: richer(&vessel, &[(1, "v |v|", -0.4), (2, "r |r|", -0.3)])?,
        quadratic: richer(&vessel, &[(2, "r |r|", -0.3)])?,
        vessel,
        initial: initial.unwrap_or_default(),
        inputs,
        known_start: true,
        scales: ([0.0158; 3], 0.1, [0.02; 3], [0.03, 0.03, 0.02]),
        white: ([0.1581; 3], 0.1581),
    })
}

fn twin(share: usize) -> Result<Ship, Box<dyn std::error::Error>> {
    let vessel = Vessel::from_file(TWIN.parse()?)?;
    let mut levels = vec![0.0; 64];
    Streams::new(7, "twin").normals(0, 0, &mut levels);
    let (mut inputs, mut pair) = (Vec::new(), [0.5, 0.5]);
    for k in 0..480 / share {
        if k % (24 / share) == 0 {
            let own = &levels[2 * (k / (24 / share))..];
            let (both, turn) = ((0.45 + 0.4 * own[0]).clamp(-0.6, 0.9), (0.5 * own[1]).clamp(-0.8, 0.8));
            pair = [both + turn, both - turn].map(|x: f64| x.clamp(-1.0, 1.0));
        }
        inputs.extend(pair);
    }
    Ok(Ship {
        name: "twin",
        richer: richer(&vessel, &[(1, "v |v|", -0.35), (2, "r |r|", -1.1)])?,
        quadratic: richer(&vessel, &[(2, "r |r|", -1.1)])?,
        vessel,
        initial: [2.0, 0.0, 0.0],
        inputs,
        known_start: false,
        scales: ([0.03, 0.03, 0.005], 0.2, [0.03, 0.03, 0.006], [0.06, 0.06, 0.01]),
        white: ([0.1, 0.1, 0.02], 0.2),
    })
}

/// The vessel with `more` terms: degree, text and value.
fn richer(
    vessel: &Vessel,
    more: &[(usize, &str, f64)],
) -> Result<(Model, Vec<f64>), Box<dyn std::error::Error>> {
    let names: Vec<&str> = vessel.model.variables.iter().map(|v| v.name.as_str()).collect();
    let (mut model, layout) = (vessel.model.clone(), vessel.model.layout());
    let theta = vessel.parameters(Source::Value)?;
    let mut values: [Vec<f64>; 3] = [0, 1, 2].map(|d| theta[layout.terms(d)].to_vec());
    for (d, text, value) in more {
        model.degrees[*d].parameters.push((*text).to_owned());
        model.degrees[*d].terms.push(Term::parse(text, &names)?);
        values[*d].push(*value);
    }
    Ok((model, values.concat()))
}

impl Ship {
    fn seas(&self) -> Vec<(&'static str, Sea)> {
        let (noise, current, force, sensors) = self.scales;
        let (much, white) = self.white;
        let still = Sea { noise, ..Sea::default() };
        let pushed = |time: [f64; 3]| Sea { force: Some((force, time)), ..still };
        [
            ("white", Sea { noise: much, current: Some((white, 0.0)), ..still }),
            ("quiet", Sea { current: Some((white, 0.0)), ..still }),
            ("current", Sea { current: Some((current, 30.0)), ..still }),
            ("constant-current", Sea { current: Some((current, f64::INFINITY)), ..still }),
            ("constant-wind", pushed([f64::INFINITY; 3])),
            ("gusts-8", pushed([8.0; 3])),
            ("gusts-30", pushed([30.0; 3])),
            ("gusts-current", Sea { current: Some((current, 30.0)), ..pushed([8.0; 3]) }),
            ("sensors", Sea { sensors: Some((sensors, 60.0)), ..still }),
            ("unlike-gusts", pushed([3.0, 8.0, 25.0])),
            ("waves", Sea { waves: Some((force.map(|f| 4.0 * f), 3.0)), ..still }),
            ("waves-8", Sea { waves: Some((force.map(|f| 4.0 * f), 8.0)), ..still }),
        ]
        .into_iter()
        .map(|(name, sea)| (name, Sea { name, ..sea }))
        .collect()
    }

    fn recorded(&self, model: &Model, theta: &[f64], sea: &Sea, seed: u64, run: u32) -> Run {
        let width = model.exogenous();
        let (samples, rate) = (self.inputs.len() / width, self.vessel.sample_rate_hz);
        let streams = Streams::new(seed, &format!("{} {}", self.name, sea.name));
        let draws = |channel: u32| {
            let mut all = vec![0.0; samples + 2];
            streams.normals(run, channel, &mut all);
            all
        };
        let process = |channel: u32, std: f64, time: f64| {
            let keep = correlation(rate, time);
            let mut all = draws(channel);
            for k in 0..all.len() {
                let fresh = (1.0 - keep * keep).sqrt() * all[k];
                all[k] = if k == 0 { all[k] } else { keep * all[k - 1] + fresh };
            }
            all.into_iter().map(|x| std * x).collect::<Vec<f64>>()
        };
        let flow = sea.current.map(|(std, time)| [3, 4].map(|channel| process(channel, std, time)));
        let forces =
            sea.force.map(|(std, times)| [0, 1, 2].map(|d| process(5 + d as u32, std[d] / rate, times[d])));
        let drift = sea.sensors.map(|(std, time)| [0, 1, 2].map(|d| process(8 + d as u32, std[d], time)));
        let waves = sea.waves.map(|(std, period)| {
            [0, 1, 2].map(|d| oscillating(&draws(11 + d as u32), std[d] / rate, rate * period))
        });
        let noise = [0, 1, 2].map(draws);
        let mut compiled = Compiled::<f64>::new(model, theta);
        let (mut state, mut heading, mut measured) = (self.initial, 0.0_f64, Vec::new());
        for k in 0..=samples {
            for d in 0..3 {
                let own = drift.as_ref().map_or(0.0, |drift| drift[d][k]);
                measured.push(state[d] + sea.noise[d] * noise[d][k] + own);
            }
            if k == samples {
                break;
            }
            let white = sea.current.is_some_and(|(_, time)| time == 0.0);
            let (sin, cos) = if white { (0.0, 1.0) } else { heading.sin_cos() };
            let water = flow
                .as_ref()
                .map(|[north, east]| [cos * north[k] + sin * east[k], cos * east[k] - sin * north[k]]);
            compiled.look(state, &self.inputs[width * k..width * (k + 1)], water);
            let pushed = |all: &Option<[Vec<f64>; 3]>, d: usize| all.as_ref().map_or(0.0, |own| own[d][k]);
            heading += state[2] / rate;
            state = compiled.next(state, Some([0, 1, 2].map(|d| pushed(&forces, d) + pushed(&waves, d))));
        }
        Run {
            design: "noise".to_owned(),
            run: run as i32,
            initial: if self.known_start { self.initial } else { [measured[0], measured[1], measured[2]] },
            instrument_exogenous: Vec::new(),
            exogenous: self.inputs.clone(),
            measured,
            segments: vec![Segment { maneuver: "all".to_owned(), start: 0 }],
        }
    }

    fn lines(&self, what: &str, sea: &Sea, runs: u32, seed: u64) -> Vec<String> {
        let truth: Vec<f64> = self.vessel.value.iter().copied().flatten().collect();
        let (model, theta) = match what {
            "power" | "stated" => (&self.richer.0, &self.richer.1),
            "yaw" => (&self.quadratic.0, &self.quadratic.1),
            _ => (&self.vessel.model, &truth),
        };
        let runs: Vec<Run> =
            (0..runs).into_par_iter().map(|run| self.recorded(model, theta, sea, seed, run)).collect();
        match what {
            "pooled" => self.pooled(&runs, &truth),
            "inverted" => self.inverted(&runs),
            _ => {
                let stated = (what == "stated").then(|| sea.levels(self.vessel.sample_rate_hz));
                let mut lines = self.verdicts(&runs, &truth, stated);
                if ["size", "short"].contains(&what) {
                    lines.extend(self.coverage(&runs, &truth, Estimator::PredictionError));
                    lines.extend(self.coverage(&runs, &truth, Estimator::OutputError));
                }
                lines
            }
        }
    }

    fn subject<'a>(
        &self,
        model: &'a Model,
        runs: &'a [RunView<'a>],
        levels: Option<NoiseModel>,
    ) -> Subject<'a> {
        let rate_hz = self.vessel.sample_rate_hz;
        Subject { model, runs, rate_hz, known_start: self.known_start, levels, names: &[], signs: &[] }
    }

    fn verdicts(&self, runs: &[Run], truth: &[f64], stated: Option<NoiseModel>) -> Vec<String> {
        let model = self.vessel.model.with_intercepts();
        let start = model.layout().woven(truth, [0.0; 3]);
        let found: Vec<Criticism> = runs
            .par_iter()
            .filter_map(|run| {
                let views = [run.view()];
                criticise_each(&self.subject(&model, &views, stated), std::slice::from_ref(&start))
                    .pop()
                    .flatten()
            })
            .collect();
        summary(&found)
    }

    /// How often each input is named by the estimate of all of a run, and nothing else.
    fn inverted(&self, runs: &[Run]) -> Vec<String> {
        let (width, names) = (self.vessel.model.exogenous(), self.vessel.model.input_names());
        let judgement = Judgement { replicates: 0, seed: 1 };
        let named = |run: &Run, negated: Option<usize>| -> Vec<String> {
            let mut run = run.clone();
            let negate = |input| run.exogenous.iter_mut().skip(input).step_by(width).for_each(|x| *x = -*x);
            negated.into_iter().for_each(negate);
            let (pool, runs) = (Pool::new(&self.vessel), PooledRuns::new(vec![run], &BTreeMap::new()));
            let found =
                estimate(&pool, &runs, Estimator::PredictionError, &judgement, Resampling::Given(&[])).ok();
            let criticism = found.and_then(|found| found.criticism);
            criticism.iter().flat_map(Criticism::wrong_signs).map(|sign| sign.name.clone()).collect()
        };
        let count = |negated: Option<usize>| {
            let expected: Vec<String> =
                negated.iter().map(|i| format!("`{}` acts with the opposite sign", names[*i])).collect();
            let right = runs.par_iter().filter(|run| named(run, negated) == expected).count();
            let what = negated.map_or("none", |i| names[i]);
            format!("{what} inverted: so named {}", share(right, runs.len()))
        };
        std::iter::once(None).chain((0..names.len()).map(Some)).map(count).collect()
    }

    fn pooled(&self, runs: &[Run], truth: &[f64]) -> Vec<String> {
        let model = self.vessel.model.with_intercepts();
        let start = model.layout().woven(truth, [0.0; 3]);
        let found: Vec<Criticism> = runs
            .par_chunks_exact(POOLED)
            .filter_map(|runs| {
                let views: Vec<RunView> = runs.iter().map(Run::view).collect();
                criticise(&self.subject(&model, &views, None), &start)
            })
            .collect();
        summary(&found)
    }

    fn coverage(&self, runs: &[Run], truth: &[f64], estimator: Estimator) -> Vec<String> {
        let estimators = RunEstimators {
            vessel: &self.vessel,
            estimators: vec![estimator],
            removal: MeanRemoval::Complete,
            initial: if self.known_start { InitialState::Known } else { InitialState::Estimated },
            additional: AdditionalUnknowns::default(),
            levels: None,
        };
        let rows: Vec<(Vec<f64>, Vec<f64>)> = runs
            .par_chunks(4)
            .filter_map(|runs| estimators.estimates(runs).ok())
            .flatten_iter()
            .filter_map(|row| row.estimate)
            .collect();
        let found = rows.len();
        let rows: Vec<_> = rows.into_iter().filter(|(_, errors)| !errors[0].is_nan()).collect();
        let none = share(found - rows.len(), found);
        let holds =
            |(theta, error): &(Vec<f64>, Vec<f64>), i: usize| (theta[i] - truth[i]).abs() <= 1.96 * error[i];
        let held = |i: usize| rows.iter().filter(|row| holds(row, i)).count();
        let worst = (0..truth.len()).map(held).min().unwrap_or(0);
        // The parameters of a run err together.
        let of_run = |row| (0..truth.len()).filter(|i| holds(row, *i)).count() as f64 / truth.len() as f64;
        let shares: Vec<f64> = rows.iter().map(of_run).collect();
        let [low, high] = clustered_share(&shares).unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
        let mean = 100.0 * shares.iter().sum::<f64>() / shares.len() as f64;
        vec![format!(
            "{estimator}: held {mean:.1} ({low:.1}–{high:.1}) of {} runs, no standard errors {none}, worst parameter {}",
            rows.len(),
            share(worst, rows.len())
        )]
    }
}

/// A damped oscillation of this period in samples, driven by `draws`, with standard deviation `std`.
fn oscillating(draws: &[f64], std: f64, period: f64) -> Vec<f64> {
    let (keep, turn) = ((-1.0 / (3.0 * period)).exp(), std::f64::consts::TAU / period);
    let (a, b) = (2.0 * keep * turn.cos(), -keep * keep);
    let mut all: Vec<f64> = Vec::with_capacity(draws.len());
    for (k, draw) in draws.iter().enumerate() {
        let before = |lag: usize| if k >= lag { all[k - lag] } else { 0.0 };
        all.push(a * before(1) + b * before(2) + draw);
    }
    let size = (all.iter().map(|x| x * x).sum::<f64>() / all.len() as f64).sqrt();
    all.into_iter().map(|x| std * x / size).collect()
}

fn summary(found: &[Criticism]) -> Vec<String> {
    let count = |holds: &dyn Fn(&Criticism) -> bool| found.iter().filter(|c| holds(c)).count();
    let mut kinds: BTreeMap<String, usize> = BTreeMap::new();
    let mut turns = 0;
    for noise in found.iter().filter_map(|c| c.noise.as_ref()) {
        *kinds.entry(format!("{:?}", noise.kind)).or_default() += 1;
        turns += noise.turns;
    }
    let named = |c: &Criticism| {
        let first = c.absent.first().map(|a| (a.name.as_str(), a.degree.as_deref()));
        c.rejected && matches!(first, Some(("v |v|", Some("sway")) | ("r |r|", Some("yaw"))))
    };
    vec![
        format!(
            "rejected {}, named first {}, no verdict {}",
            share(count(&|c| c.rejected), found.len()),
            share(count(&named), found.len()),
            share(count(&|c| c.verdict == Verdict::None), found.len())
        ),
        format!("kinds {kinds:?}, turns {:.1}", turns as f64 / found.len().max(1) as f64),
    ]
}

/// With its 95 % interval (Wilson's).
fn share(count: usize, total: usize) -> String {
    let [low, high] = wilson(count as u64, total as u64).unwrap_or([0.0, 1.0]).map(|end| 100.0 * end);
    format!("{:.1} % ({low:.1} to {high:.1}) of {total}", 100.0 * count as f64 / total.max(1) as f64)
}
