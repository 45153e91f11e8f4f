use numerics::{LANES, Lane};
use ship::engine::{Compiled, DIVERGED, RunView, SideBySide};
use ship::model::Model;

use super::kind::{Guess, side_by_side};
use crate::sensitivity::{Recordings, current_of, filter_along, vessel_state, with_states};

/// A run, with the model linearised about a causal path.
pub(super) struct Line<'a> {
    pub run: RunView<'a>,
    /// By sample; the last one has no successor.
    pub points: Vec<Point>,
    /// φ of every parameter, by sample.
    pub terms: Vec<f64>,
}

/// A point of the path.
#[derive(Clone, Copy)]
pub(super) struct Point {
    pub state: [f64; 3],
    pub current: [f64; 2],
    /// The state after it.
    pub next: [f64; 3],
    /// Derivatives by the state.
    pub slopes: [[f64; 3]; 3],
}

impl<'a> Line<'a> {
    /// Linearises about the free simulation with `theta`; about the measured states if that diverges.
    pub fn free(model: &Model, theta: &[f64], run: RunView<'a>) -> Self {
        let (width, mut state) = (model.exogenous().max(1), run.initial);
        let mut compiled = Compiled::<f64>::new(model, theta);
        let mut path = vec![(state, [0.0; 2])];
        for row in run.exogenous.chunks_exact(width) {
            compiled.look(state, row, None);
            state = compiled.next(state, None);
            path.push((state, [0.0; 2]));
        }
        let near = |x: &f64| x.is_finite() && x.abs() <= DIVERGED;
        if !path.iter().all(|(state, _)| state.iter().all(near)) {
            path = run.measured.as_chunks::<3>().0.iter().map(|y| (*y, [0.0; 2])).collect();
        }
        Self::about(model, theta, run, path)
    }

    /// Linearises about the states and currents that a filter for `guess` has at every sample; `None` if they are not
    /// finite.
    pub fn filtered(
        model: &Model,
        theta: &[f64],
        run: RunView<'a>,
        guess: &Guess,
        (rate_hz, known_start): (f64, bool),
    ) -> Option<Self> {
        let alike = SideBySide::of(&[run]);
        let recordings = Recordings::of(model, &alike);
        let unknowns: Vec<Lane> = theta.iter().copied().chain([0.0; 3]).map(Lane::splat).collect();
        let levels = guess.levels(rate_hz);
        let path = with_states!(levels, path(&recordings, &unknowns, guess, rate_hz, known_start));
        let near = |x: &f64| x.is_finite() && x.abs() <= DIVERGED;
        let all = path.iter().all(|(state, current)| state.iter().chain(current).all(near));
        all.then(|| Self::about(model, theta, run, path))
    }

    fn about(model: &Model, theta: &[f64], run: RunView<'a>, path: Vec<([f64; 3], [f64; 2])>) -> Self {
        let (width, mut compiled) = (model.exogenous().max(1), Compiled::<f64>::new(model, theta));
        let mut terms = Vec::with_capacity(theta.len() * path.len());
        let rows = run.exogenous.chunks_exact(width);
        let point = |((state, current), row): (([f64; 3], [f64; 2]), &[f64])| {
            compiled.look(state, row, Some(current));
            terms.extend((0..theta.len()).map(|i| compiled.term(i)));
            Point { state, current, next: compiled.next(state, None), slopes: compiled.slopes() }
        };
        let points = path.into_iter().zip(rows).map(point).collect();
        Self { run, points, terms }
    }

    /// Root mean square of the measured states less the path.
    pub fn errors(&self) -> [f64; 3] {
        let rows = || self.points.iter().zip(self.run.measured.as_chunks::<3>().0);
        let square = |d: usize| rows().map(|(point, y)| (y[d] - point.state[d]).powi(2)).sum::<f64>();
        [0, 1, 2].map(|d| (square(d) / self.points.len().max(1) as f64).sqrt())
    }
}

fn path<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    guess: &Guess,
    rate_hz: f64,
    known_start: bool,
) -> Vec<([f64; 3], [f64; 2])> {
    let levels = side_by_side(&[*guess; LANES], rate_hz);
    let mut path = Vec::with_capacity(recordings.longest() + 1);
    filter_along::<N>(
        recordings,
        unknowns,
        &levels,
        known_start,
        #[inline(always)]
        |z| {
            let current = current_of(z).map_or([0.0; 2], |own| own.map(|c| c[0]));
            path.push((vessel_state(z).map(|x| x[0]), current));
        },
    );
    path
}
