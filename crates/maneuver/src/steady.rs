//! Inputs that hold a wanted motion steady, or lead from one to the next: the inverse of the model.

use refusal::Invalid;
use ship::engine::Compiled;
use ship::model::{Actuator, Vessel};

/// A motion through the water to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Surge speed \[m/s\].
    pub u: f64,
    /// Sway speed \[m/s\]; `None`: the drift of the turn.
    pub v: Option<f64>,
    /// Yaw rate \[rad/s\].
    pub r: f64,
}

/// A vessel's steady inputs for wanted motions.
#[derive(Clone, Debug)]
pub struct Steady<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    /// Inputs, then measured disturbances and derived channels as in simulated trials.
    exogenous: Vec<f64>,
    gradients: Vec<[f64; 3]>,
    /// The last solution: consecutive motions have similar inputs.
    last: Vec<f64>,
    workspace: Workspace,
    /// The current point of a search.
    at: Vec<f64>,
}

impl<'a> Steady<'a> {
    /// For `vessel` with `parameters`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64]) -> Self {
        Self {
            vessel,
            model: Compiled::new(&vessel.model, parameters),
            exogenous: vec![0.0; vessel.model.exogenous()],
            gradients: vec![[0.0; 3]; vessel.model.variables.len()],
            last: Vec::new(),
            workspace: Workspace::default(),
            at: Vec::new(),
        }
    }

    /// The inputs that hold `motion`, by Newton's method from `unknowns` (inputs, then sway speed), which
    /// become the solution. If that fails or exceeds the range of the inputs, zero is tried and then, damped,
    /// starts all over the inputs' ranges: forces such as `n |n|` have no slope at zero.
    ///
    /// The unknowns are the inputs and, where the vessel has too few independent inputs to command it, the sway speed.
    /// The equations are zero increments and the couplings between inputs; a commanded sway speed releases the couplings.
    ///
    /// # Errors
    /// A vessel without the inputs to command the motion; a motion for which no inputs were found.
    pub fn solve(&mut self, motion: Motion, unknowns: &mut [f64]) -> Result<(), Invalid> {
        self.follow(motion, [0.0; 3], unknowns)
    }

    /// [`Self::solve`] for inputs by which u, v and r change by `gain` until the next sample \[m/s, m/s, rad/s\].
    ///
    /// # Errors
    /// As [`Steady::solve`].
    pub fn follow(&mut self, motion: Motion, gain: [f64; 3], unknowns: &mut [f64]) -> Result<(), Invalid> {
        let wanted = WantedMotion { gain, ..WantedMotion::of(motion, self.vessel)? };
        let used = self.vessel.model.inputs + usize::from(wanted.sway_free);
        let mut beyond = None;
        for from_zero in [false, true] {
            if from_zero {
                unknowns[..used].fill(0.0);
            }
            let (mut at, mut workspace) = (std::mem::take(&mut self.at), std::mem::take(&mut self.workspace));
            at.clear();
            at.extend_from_slice(&unknowns[..used]);
            let has_converged =
                plain(&mut at, &mut workspace, |unknowns, rows| self.linearised(&wanted, unknowns, rows));
            (self.at, self.workspace) = (at, workspace);
            if has_converged {
                if self.within(&self.at) {
                    unknowns[..used].copy_from_slice(&self.at);
                    return Ok(());
                }
                beyond.get_or_insert_with(|| self.at.clone());
            }
        }
        let solution = self.search(&wanted, beyond).ok_or_else(|| unreachable_motion(&wanted))?;
        unknowns[..used].copy_from_slice(&solution);
        self.last = solution;
        Ok(())
    }

    /// The first solution from any start that is within the inputs' ranges, else any; `beyond` is a known one.
    fn search(&mut self, wanted: &WantedMotion, mut beyond: Option<Vec<f64>>) -> Option<Vec<f64>> {
        let used = self.vessel.model.inputs + usize::from(wanted.sway_free);
        let last = (self.last.len() == used).then(|| self.last.clone());
        let search = Starts::new(self.vessel, wanted);
        let rest = (vec![0.0; used], search.scales(0));
        let starts = last.map(|last| (last, search.scales(0))).into_iter().chain([rest]);
        for (mut at, scales) in starts.chain(search.starts()) {
            if damped(&mut at, &scales, |unknowns, rows| self.linearised(wanted, unknowns, rows)) {
                if self.within(&at) {
                    return Some(at);
                }
                beyond.get_or_insert(at);
            }
        }
        beyond
    }

    /// Whether `unknowns` are within the ranges of the vessel's inputs.
    fn within(&self, unknowns: &[f64]) -> bool {
        self.vessel.beyond_range(unknowns).is_none()
    }

    /// Fills in rows \[Jacobian | −residual\] at `unknowns`.
    fn linearised(&mut self, wanted: &WantedMotion, unknowns: &[f64], rows: &mut NewtonRows) {
        let inputs = self.vessel.model.inputs;
        let n = inputs + usize::from(wanted.sway_free);
        let Motion { u, v, r } = wanted.motion;
        self.exogenous[..inputs].copy_from_slice(&unknowns[..inputs]);
        self.vessel.model.complete(&mut self.exogenous);
        self.model.look([u, v.unwrap_or_else(|| unknowns[inputs]), r], &self.exogenous, None);
        if wanted.sway_free {
            self.model.gradients(&mut self.gradients);
        } else {
            self.model.exogenous_gradients(&mut self.gradients);
        }
        self.vessel.model.by_sources(&self.exogenous, &mut self.gradients);
        rows.clear(n);
        for (d, increment) in self.model.increments().into_iter().enumerate() {
            let row = rows.push();
            row[..n].iter_mut().enumerate().for_each(|(j, entry)| {
                *entry = self.gradients[if j < inputs { 3 + j } else { 1 }][d];
            });
            row[n] = -(increment - wanted.gain[d]);
        }
        if wanted.coupled {
            for (i, coupling) in self.vessel.couplings.iter().enumerate() {
                if let Some((leader, factor)) = coupling {
                    let row = rows.push();
                    row[i] = 1.0;
                    row[*leader] = -factor;
                    row[n] = factor * unknowns[*leader] - unknowns[i];
                }
            }
        }
    }
}

/// A motion, and its unknowns and equations.
struct WantedMotion {
    motion: Motion,
    /// Increments of u, v and r until the next sample.
    gain: [f64; 3],
    sway_free: bool,
    coupled: bool,
}

impl WantedMotion {
    fn of(motion: Motion, vessel: &Vessel) -> Result<Self, Invalid> {
        let couplings = vessel.couplings.iter().flatten().count();
        let coupled = motion.v.is_none();
        let free = vessel.model.inputs - if coupled { couplings } else { 0 };
        let sway_free = motion.v.is_none() && free == 2;
        if free + usize::from(sway_free) != 3 {
            return Err(Invalid::new(
                "inputs",
                format!("{free} independent ones"),
                "3 to command surge, sway and yaw, or 2 for surge and yaw",
                "couple inputs with `follows`, leave the sway speed out, or give the inputs in a file (kind = \"inputs\")",
            ));
        }
        let motion = Motion { v: if sway_free { None } else { Some(motion.v.unwrap_or(0.0)) }, ..motion };
        Ok(Self { motion, gain: [0.0; 3], sway_free, coupled })
    }
}

/// Starting points of a search.
struct Starts<'a> {
    vessel: &'a Vessel,
    wanted: &'a WantedMotion,
}

/// Distance of an input's start from the centre of its range, in halves of the range …
const SHARES: [f64; 6] = [0.5, 0.9, 0.1, 0.7, 0.3, 1.0];

/// … and from zero, where no range is known.
const MAGNITUDES: [f64; 6] = [1.0, 1e2, 1e-2, 1e4, 1e6, 1e-4];

/// Inputs that start on either side; any more start at the centre.
const MOST_SIDES: usize = 4;

impl<'a> Starts<'a> {
    fn new(vessel: &'a Vessel, wanted: &'a WantedMotion) -> Self {
        Self { vessel, wanted }
    }

    /// Starts with the scales of their unknowns: all inputs at the centre or on either side, combined with each sway.
    fn starts(&self) -> impl Iterator<Item = (Vec<f64>, Vec<f64>)> {
        let sides = 3_usize.pow(self.vessel.model.inputs.min(MOST_SIDES) as u32);
        let ways = if self.wanted.sway_free { 3 } else { 1 };
        (0..SHARES.len()).flat_map(move |level| {
            (0..sides).flat_map(move |side| {
                (0..ways).map(move |way| (self.start(level, side, way), self.scales(level)))
            })
        })
    }

    /// The digits of `side` to base 3 select where the inputs start.
    fn start(&self, level: usize, side: usize, way: usize) -> Vec<f64> {
        let Motion { u, r, .. } = self.wanted.motion;
        let sign = |place: usize| [0.0, 1.0, -1.0][side / 3_usize.pow(place.min(19) as u32) % 3];
        let inputs = self.vessel.actuators.iter().enumerate();
        let mut start: Vec<f64> = inputs
            .map(|(i, actuator)| match actuator.range {
                Some([low, high]) => 0.5 * (low + high) + sign(i) * SHARES[level] * 0.5 * (high - low),
                None => sign(i) * MAGNITUDES[level],
            })
            .collect();
        for (i, coupling) in self.vessel.couplings.iter().enumerate() {
            if let Some((leader, factor)) = coupling.filter(|_| self.wanted.coupled) {
                start[i] = factor * start[leader];
            }
        }
        if self.wanted.sway_free {
            // A turn to starboard drifts to port.
            let outwards = -0.1 * u.abs().max(0.1) * if r < 0.0 { -1.0 } else { 1.0 };
            start.push([0.0, outwards, -outwards][way]);
        }
        start
    }

    fn scales(&self, level: usize) -> Vec<f64> {
        let input =
            |actuator: &Actuator| actuator.range.map_or(MAGNITUDES[level], |[low, high]| 0.5 * (high - low));
        let sway = self.wanted.sway_free.then(|| self.wanted.motion.u.abs().max(0.1));
        self.vessel.actuators.iter().map(input).chain(sway).collect()
    }
}

fn unreachable_motion(wanted: &WantedMotion) -> Invalid {
    let WantedMotion { motion, gain, .. } = wanted;
    let (how, what) = if *gain == [0.0; 3] { ("hold steady", "hold") } else { ("follow", "follow") };
    let sway = motion.v.map_or(String::new(), |v| format!(", v = {v} m/s"));
    Invalid::new(
        "wanted motion",
        format!("u = {} m/s{sway}, r = {} rad/s, which no inputs were found to {how}", motion.u, motion.r),
        format!("a motion that the model can {what}"),
        "lower the speeds, or turn the maneuver into inputs with the other parameters (`inputs_from`)",
    )
}

/// Most steps; damped ones may be short.
const STEPS: usize = 50;
const DAMPED_STEPS: usize = 200;

/// Relative change of the unknowns at which they count as solved.
const SOLVED: f64 = 1e-13;

/// Solves the equations from `unknowns` by full steps; returns whether they converge. `linearised` fills in
/// rows \[Jacobian | −residual\].
fn plain(
    unknowns: &mut [f64],
    Workspace { rows, solver }: &mut Workspace,
    mut linearised: impl FnMut(&[f64], &mut NewtonRows),
) -> bool {
    for _ in 0..STEPS {
        linearised(unknowns, rows);
        let Some(step) = solver.solve(rows) else {
            return false;
        };
        let mut change: f64 = 0.0;
        for (x, dx) in unknowns.iter_mut().zip(step) {
            change = change.max(dx.abs() / (x.abs() + 1e-9));
            *x += dx;
        }
        if !unknowns.iter().all(|x| x.is_finite()) {
            return false;
        }
        if change < SOLVED {
            return true;
        }
    }
    false
}

/// Buffers that searches reuse.
#[derive(Clone, Debug, Default)]
struct Workspace {
    rows: NewtonRows,
    solver: Solver,
}

/// Rows \[Jacobian | −residual\] of as many equations as unknowns.
#[derive(Clone, Debug, Default)]
struct NewtonRows {
    entries: Vec<f64>,
    width: usize,
}

impl NewtonRows {
    /// Prepares for the rows of `unknowns`, without any yet.
    pub(crate) fn clear(&mut self, unknowns: usize) {
        self.entries.clear();
        self.width = unknowns + 1;
    }

    /// Appends a row of zeros.
    pub(crate) fn push(&mut self) -> &mut [f64] {
        let before = self.entries.len();
        self.entries.resize(before + self.width, 0.0);
        &mut self.entries[before..]
    }

    fn iter(&self) -> impl ExactSizeIterator<Item = &[f64]> {
        self.entries.chunks_exact(self.width.max(1))
    }
}

/// [`plain`] with steps that are halved until the next one, with the same Jacobian, is shorter, so that the
/// units of the equations do not matter. `scales`: magnitudes of the unknowns.
///
/// The test is the natural one of Deuflhard, Newton Methods for Nonlinear Problems, 2011, section 3.3.
fn damped(unknowns: &mut [f64], scales: &[f64], mut linearised: impl FnMut(&[f64], &mut NewtonRows)) -> bool {
    let (mut rows, mut solver) = (NewtonRows::default(), Solver::default());
    linearised(unknowns, &mut rows);
    // At rest the equations hold, and the step is undetermined.
    if rows.iter().all(|row| row.last() == Some(&0.0)) {
        return true;
    }
    let mut before = f64::INFINITY;
    for _ in 0..DAMPED_STEPS {
        let Some(step) = solver.solve(&rows).map(<[f64]>::to_vec) else { return false };
        let length = length(&step, unknowns, scales);
        // Only rounding remains: the equations cannot be solved more accurately.
        let rounding = length < 1e-8 && length >= 0.5 * before;
        if length < SOLVED || rounding {
            unknowns.iter_mut().zip(&step).for_each(|(x, dx)| *x += dx);
            return true;
        }
        let Some((next, after)) = shortened(unknowns, scales, (&step, length), &rows, &mut linearised) else {
            return false;
        };
        unknowns.copy_from_slice(&next);
        (rows, before) = (after, length);
    }
    false
}

/// Advances along `step`, whose length is given, as far as the next step with the same Jacobian becomes
/// shorter: returns the unknowns there, with their rows.
fn shortened(
    unknowns: &[f64],
    scales: &[f64],
    (step, whole): (&[f64], f64),
    rows: &NewtonRows,
    linearised: &mut impl FnMut(&[f64], &mut NewtonRows),
) -> Option<(Vec<f64>, NewtonRows)> {
    let (mut share, mut solver) = (1.0, Solver::default());
    while share > 1e-6 {
        let next: Vec<f64> = unknowns.iter().zip(step).map(|(x, dx)| x + share * dx).collect();
        let mut after = NewtonRows::default();
        linearised(&next, &mut after);
        let mut mixed = rows.clone();
        for (row, after) in mixed.entries.chunks_exact_mut(rows.width).zip(after.iter()) {
            row[rows.width - 1] = after[rows.width - 1];
        }
        let left = solver.solve(&mixed);
        let shorter = left.is_some_and(|left| length(left, unknowns, scales) <= (1.0 - share / 4.0) * whole);
        if shorter || whole < 1e-8 {
            return Some((next, after));
        }
        share *= 0.5;
    }
    None
}

/// The largest relative change by `step`.
fn length(step: &[f64], unknowns: &[f64], scales: &[f64]) -> f64 {
    let all = step.iter().zip(unknowns).zip(scales);
    all.fold(0.0, |most: f64, ((dx, x), scale)| most.max(dx.abs() / (x.abs() + 1e-3 * scale)))
}

/// Buffers of the linear solver.
#[derive(Clone, Debug, Default)]
struct Solver {
    a: Vec<f64>,
    b: Vec<f64>,
}

impl Solver {
    /// Solves rows \[a | b\], each scaled to a largest coefficient of 1; `None` where they are singular.
    fn solve(&mut self, rows: &NewtonRows) -> Option<&[f64]> {
        let n = rows.iter().len();
        self.a.clear();
        self.b.clear();
        for row in rows.iter() {
            let scale = row[..n].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
            self.a.extend(row[..n].iter().map(|x| x / scale));
            self.b.push(row[n] / scale);
        }
        numerics::solve(n, &mut self.a, &mut self.b)?;
        self.b.iter().all(|x| x.is_finite()).then_some(&self.b)
    }
}
