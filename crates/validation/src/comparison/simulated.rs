use std::borrow::Cow;

use estimation::pooled::deviations;
use numerics::statistics::MeanTrajectory;
use regression::pooled::Part;
use ship::engine::{check_diverged, replay};
use ship::model::Model;

use super::errors::{ComparedRecording, Sums};
use super::standing::{ComparedModel, Standing};

/// A participant of a comparison.
#[derive(Clone, Debug)]
pub struct Contestant<'a> {
    /// Its standing.
    pub standing: Standing,
    /// Its place among the models that are averaged, from 1, if it is one of them.
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
        for (_, own) in sources {
            let found: Vec<Option<Trajectory>> = own.iter().map(|window| simulate(own, window)).collect();
            let sum = |(window, found): (&Part, &Option<Trajectory>)| {
                let mut sum = Sums::default();
                sum.add(window, found.as_ref().map(|found| found.states.as_slice()));
                sum
            };
            sums.push(own.iter().zip(&found).map(sum).collect());
            windows.push(found);
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
            let mut own = Sums::default();
            sums.iter().for_each(|sum| own.merge(sum));
            whole.merge(&own);
            let varies = deviations(windows.iter().map(|w| w.measured.as_slice()));
            ComparedRecording { source: source.clone(), errors: own.errors(varies, std) }
        };
        let recordings = sources.iter().zip(&self.sums).map(recording).collect();
        let (name, place) = (self.standing, self.place);
        ComparedModel { name, place, errors: whole.errors(std, std), recordings }
    }
}
