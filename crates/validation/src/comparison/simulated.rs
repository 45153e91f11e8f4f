use std::borrow::Cow;

use estimation::pooled::deviations;
use numerics::statistics::MeanTrajectory;
use regression::pooled::Part;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{check_diverged, replay};
use ship::model::Model;

/// A participant of a comparison.
#[derive(Clone, Debug)]
pub struct Contestant<'a> {
    /// Its standing.
    pub standing: Standing,
    /// Its place among the models that are averaged or compared, from 1, if it is one of several.
    pub place: Option<u64>,
    /// The model; several of the same channels are averaged.
    pub ships: Vec<Ship<'a>>,
}

impl<'a> Contestant<'a> {
    /// The first of its models that has the most channels: ranges of the data that it was fitted to are those of this one.
    pub(super) fn widest(&self) -> Option<&Ship<'a>> {
        self.ships.iter().rev().max_by_key(|ship| ship.model.exogenous())
    }
}

/// A model.
#[derive(Clone, Copy, Debug)]
pub struct Ship<'a> {
    /// Its structure.
    pub model: &'a Model,
    /// Its parameters: surge, sway, yaw.
    pub theta: &'a [f64],
    /// Where its inputs and measured disturbances stand in the rows of the windows; `None`: they are these rows.
    pub columns: Option<&'a [usize]>,
}

impl Ship<'_> {
    /// Its rows of inputs and measured disturbances, of those of `window`, which have so many.
    pub(super) fn exogenous<'w>(&self, window: &'w Part) -> Cow<'w, [f64]> {
        let Some(columns) = self.columns else { return Cow::Borrowed(&window.exogenous) };
        let width = window.exogenous.len() / window.samples().max(1);
        let rows = window.exogenous.chunks_exact(width.max(1));
        Cow::Owned(rows.flat_map(|row| columns.iter().map(|column| row[*column])).collect())
    }

    /// Its simulation of `window` from the first measured state: u, v, r row by row.
    fn simulate(&self, window: &Part, are_inputs_held: bool) -> Vec<f64> {
        replay(self.model, self.theta, window.view().initial, &self.exogenous(window), are_inputs_held)
    }
}

/// The simulation over a window.
pub(super) struct Trajectory {
    /// u, v, r row by row.
    pub states: Vec<f64>,
    /// Standard deviations of the models that are averaged, row by row; empty for a single model.
    pub spread: Vec<f64>,
}

/// Every window of every source, simulated by one contestant.
pub(super) struct Simulated {
    standing: Standing,
    place: Option<u64>,
    pub windows: Vec<Vec<Option<Trajectory>>>,
    /// Sums by source and window.
    pub sums: Vec<Vec<Sums>>,
}

impl Simulated {
    fn new(
        (standing, place): (Standing, Option<u64>),
        sources: &[(String, Vec<Part>)],
        simulate: impl Fn(&[Part], &Part) -> Option<Trajectory>,
    ) -> Self {
        let (mut windows, mut sums) = (Vec::new(), Vec::new());
        for (_, parts) in sources {
            let trajectories: Vec<Option<Trajectory>> =
                parts.iter().map(|window| simulate(parts, window)).collect();
            let sum = |(window, trajectory): (&Part, &Option<Trajectory>)| {
                Sums::of(window, trajectory.as_ref().map(|trajectory| trajectory.states.as_slice()))
            };
            sums.push(parts.iter().zip(&trajectories).map(sum).collect());
            windows.push(trajectories);
        }
        Self { standing, place, windows, sums }
    }

    pub fn of(one: &Contestant, sources: &[(String, Vec<Part>)], are_inputs_held: bool) -> Self {
        Self::new((one.standing, one.place), sources, |_, window| {
            let mut mean = MeanTrajectory::default();
            for ship in &one.ships {
                let states = ship.simulate(window, are_inputs_held);
                if check_diverged(states.iter().copied()).is_some() {
                    return None;
                }
                mean.add(&states);
            }
            let spread = if one.ships.len() > 1 { mean.spread() } else { Vec::new() };
            (!one.ships.is_empty()).then(|| Trajectory { states: mean.mean().to_vec(), spread })
        })
    }

    /// The baseline: the mean of each source's windows.
    pub fn mean(sources: &[(String, Vec<Part>)]) -> Self {
        Self::new((Standing::Mean, None), sources, |all, window| {
            let rows = || all.iter().flat_map(|w| w.measured.as_chunks::<3>().0.iter().skip(1));
            let n = rows().count().max(1) as f64;
            let mean = [0, 1, 2].map(|d: usize| rows().map(|row| row[d]).sum::<f64>() / n);
            Some(Trajectory { states: mean.repeat(window.samples() + 1), spread: Vec::new() })
        })
    }

    pub fn compared(&self, sources: &[(String, Vec<Part>)], std: [f64; 3]) -> ComparedModel {
        let mut whole = Sums::default();
        let recording = |((source, windows), sums): (&(String, Vec<Part>), &Vec<Sums>)| {
            let mut recording = Sums::default();
            sums.iter().for_each(|sum| recording.merge(sum));
            whole.merge(&recording);
            let varies = deviations(windows.iter().map(|w| w.measured.as_slice()));
            ComparedRecording { source: source.clone(), errors: recording.errors(varies, std) }
        };
        let recordings = sources.iter().zip(&self.sums).map(recording).collect();
        let (name, place) = (self.standing, self.place);
        ComparedModel { name, place, errors: whole.errors(std, std), recordings }
    }
}

/// Errors of one model over some windows. Null where a window diverged, or there is none.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedErrors {
    /// Windows.
    pub windows: u64,
    /// Windows that diverged.
    pub diverged: u64,
    /// Samples that were simulated.
    pub samples: u64,
    /// Root mean square error of u.
    pub rmse_u: Option<f64>,
    /// Of v.
    pub rmse_v: Option<f64>,
    /// Of r.
    pub rmse_r: Option<f64>,
    /// 100 (1 − RMSE/std), 0 as good as the mean of the data; null where u does not vary.
    pub fit_u: Option<f64>,
    /// Of v.
    pub fit_v: Option<f64>,
    /// Of r.
    pub fit_r: Option<f64>,
    /// Mean of measured less simulated u.
    pub bias_u: Option<f64>,
    /// Of v.
    pub bias_v: Option<f64>,
    /// Of r.
    pub bias_r: Option<f64>,
    /// Norm of RMSE over the standard deviations of u, v, r in all recordings.
    pub error_norm: Option<f64>,
}

/// Those over one run or recording, against the standard deviations of its own states.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedRecording {
    /// Its name.
    pub source: String,
    /// Its errors.
    pub errors: ComparedErrors,
}

impl ComparedErrors {
    /// Fits of u, v, r.
    pub fn fits(&self) -> [Option<f64>; 3] {
        [self.fit_u, self.fit_v, self.fit_r]
    }

    /// RMSE of u, v, r.
    pub fn rmse(&self) -> [Option<f64>; 3] {
        [self.rmse_u, self.rmse_v, self.rmse_r]
    }
}

/// Sums of errors over windows.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct Sums {
    windows: u64,
    diverged: u64,
    samples: u64,
    errors: [f64; 3],
    squares: [f64; 3],
}

impl Sums {
    /// Of a window with its simulated `states`, (N+1) × 3; `None`: it diverged.
    fn of(window: &Part, states: Option<&[f64]>) -> Self {
        let Some(states) = states else { return Self { windows: 1, diverged: 1, ..Self::default() } };
        let mut sums = Self { windows: 1, samples: window.samples() as u64, ..Self::default() };
        let pairs = window.measured.as_chunks::<3>().0.iter().zip(states.as_chunks::<3>().0);
        for (measured, simulated) in pairs.skip(1) {
            for d in 0..3 {
                let error = measured[d] - simulated[d];
                sums.errors[d] += error;
                sums.squares[d] += error * error;
            }
        }
        sums
    }

    pub fn merge(&mut self, other: &Self) {
        self.windows += other.windows;
        self.diverged += other.diverged;
        self.samples += other.samples;
        (0..3).for_each(|d| {
            self.errors[d] += other.errors[d];
            self.squares[d] += other.squares[d];
        });
    }

    /// The errors relative to the standard deviations `still` of these windows and `all` of all windows.
    pub fn errors(&self, still: [f64; 3], all: [f64; 3]) -> ComparedErrors {
        let Self { windows, diverged, samples, .. } = *self;
        let mut errors = ComparedErrors { windows, diverged, samples, ..ComparedErrors::default() };
        if diverged > 0 || samples == 0 {
            return errors;
        }
        let n = samples as f64;
        let rmse = self.squares.map(|sum| (sum / n).sqrt());
        let fit = |d: usize| (still[d] > 0.0).then(|| 100.0 * (1.0 - rmse[d] / still[d]));
        let norm = (0..3).map(|d| (rmse[d] / all[d]).powi(2)).sum::<f64>().sqrt();
        [errors.rmse_u, errors.rmse_v, errors.rmse_r] = rmse.map(Some);
        [errors.fit_u, errors.fit_v, errors.fit_r] = [0, 1, 2].map(fit);
        [errors.bias_u, errors.bias_v, errors.bias_r] = self.errors.map(|sum| Some(sum / n));
        errors.error_norm = Some(norm).filter(|norm| norm.is_finite());
        errors
    }
}

refusal::choices! {
    /// Who takes part in a comparison.
    pub enum Standing {
        /// The model.
        Model = "model",
        /// Several models, whose trajectories are averaged.
        Average = "average of models",
        /// One of the models that are averaged, alone.
        Averaged = "model of the average",
        /// Another model.
        Other = "other model",
        /// The same structure by least squares of the same data.
        LeastSquares = "least squares",
        /// The mean of each recording.
        Mean = "mean of the data",
    }
}

/// One model over all windows.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct ComparedModel {
    /// Which.
    pub name: Standing,
    /// Its place among the models that are averaged or compared, from 1, if it is one of several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<u64>,
    /// Over all windows.
    pub errors: ComparedErrors,
    /// One entry per run or recording.
    pub recordings: Vec<ComparedRecording>,
}

/// How far the error norm of another lies above the first model's, recording by recording, or window by window of one recording.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Difference {
    /// The other.
    pub name: Standing,
    /// Its place among the models that are averaged or compared, from 1, if it is one of several.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub place: Option<u64>,
    /// Pairs that were compared.
    pub pairs: u64,
    /// The median difference; null where it is infinite.
    pub median: Option<f64>,
    /// 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    pub interval: [Option<f64>; 2],
}
