use maneuver::{Motion, Steady};
use refusal::Invalid;
use ship::engine::Compiled;
use ship::model::Vessel;

/// Most steps of Newton's method per sample; a model that is linear in its inputs needs one.
const STEPS: usize = 5;
/// Residuals below this fraction of a metre per second (or radian) in a sample count as zero.
const SMALL: f64 = 1e-9;
/// Largest fraction of an observed model error that is learnt within a sample.
const MOST_BELIEVED: f64 = 0.3;

/// Inputs for commanded accelerations, by a model of the vessel and its observed errors: dynamic inversion
/// with a disturbance observer. Errors of parameters and unknown currents are not distinguished: both appear
/// as increments of u, v and r that the model does not explain.
#[derive(Clone, Debug)]
pub(crate) struct Inversion<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    steady: Steady<'a>,
    /// Inputs, then measured disturbances and derived channels.
    exogenous: Vec<f64>,
    gradients: Vec<[f64; 3]>,
    /// The last command to the actuators; empty before the first one.
    last: Vec<f64>,
    /// State and current of the model's current point.
    looked: Option<([f64; 3], [f64; 2])>,
    /// Increments of u, v, r in a sample that the model does not explain.
    pub unexplained: [f64; 3],
    /// Fraction of a new observation of u, v, r that is learnt.
    believed: [f64; 3],
}

/// Commanded increments in a sample; sway may be left to the drift of the turn.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Gains {
    pub u: f64,
    pub v: f64,
    /// Whether sway is commanded even if inputs have to leave their couplings for it.
    pub sway: bool,
    pub r: f64,
}

impl<'a> Inversion<'a> {
    /// With `parameters`; model errors are learnt with time constant `memory_s`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64], memory_s: f64) -> Self {
        Self {
            vessel,
            model: Compiled::new(&vessel.model, parameters),
            steady: Steady::new(vessel, parameters),
            exogenous: vec![0.0; vessel.model.exogenous()],
            gradients: vec![[0.0; 3]; vessel.model.variables.len()],
            last: Vec::new(),
            looked: None,
            unexplained: [0.0; 3],
            believed: [(1.0 / (memory_s * vessel.sample_rate_hz)).min(MOST_BELIEVED); 3],
        }
    }

    /// Limits what is learnt of each of u, v, r from an observation.
    pub fn limit_belief(&mut self, most: [f64; 3]) {
        self.believed.iter_mut().zip(most).for_each(|(own, most)| *own = own.min(most));
    }

    /// The inputs that produce `wanted` at `state`, in a known current of body components `current`.
    ///
    /// # Errors
    /// A vessel without the inputs to command surge, yaw and, where wanted, sway.
    pub fn inputs(&mut self, state: [f64; 3], current: [f64; 2], wanted: &Gains) -> Result<&[f64], Invalid> {
        if self.last.is_empty() {
            self.begin(state, current, wanted.sway)?;
        }
        let (free, count) = self.free(wanted.sway);
        let free = &free[..count];
        for _ in 0..STEPS {
            let missing = self.missing(state, current, wanted, free);
            if missing.iter().all(|missing| missing.abs() <= SMALL) {
                break;
            }
            let rows = self.linearised(missing, wanted.sway, free);
            if !self.corrected(free, solved(rows)) {
                break;
            }
        }
        Ok(&self.last)
    }

    /// Begins with inputs that hold the present motion; fails if the inputs do not command it.
    fn begin(&mut self, state: [f64; 3], current: [f64; 2], sway: bool) -> Result<(), Invalid> {
        let inputs = self.vessel.model.inputs;
        let mut unknowns = vec![0.0; inputs + 1];
        let motion = Motion { u: state[0] - current[0], v: sway.then_some(0.0), r: 0.0 };
        self.steady.solve(motion, &mut unknowns)?;
        unknowns.truncate(inputs);
        self.last = unknowns;
        Ok(())
    }

    /// The free inputs, and their number: at most three.
    fn free(&self, sway: bool) -> ([usize; 3], usize) {
        let leads = |i: &usize| sway || self.vessel.couplings[*i].is_none();
        let mut free = [0; 3];
        let places = free.iter_mut().zip((0..self.vessel.model.inputs).filter(leads));
        let count = places.map(|(place, input)| *place = input).count();
        (free, count)
    }

    /// Increments of u, v and r that the inputs do not produce yet; sway is left out where two inputs command
    /// the vessel.
    fn missing(&mut self, state: [f64; 3], current: [f64; 2], wanted: &Gains, free: &[usize]) -> [f64; 3] {
        self.look(state, current, None);
        let increments = self.model.increments();
        let gains = [wanted.u, wanted.v, wanted.r];
        let missing = [0, 1, 2].map(|d| gains[d] - increments[d] - self.unexplained[d]);
        [missing[0], if free.len() == 3 { missing[1] } else { 0.0 }, missing[2]]
    }

    /// Rows \[slopes by the free inputs | missing increments\] of surge, sway and yaw at the current point.
    fn linearised(&mut self, missing: [f64; 3], alone: bool, free: &[usize]) -> [[f64; 4]; 3] {
        self.model.exogenous_gradients(&mut self.gradients);
        self.vessel.model.by_sources(&self.exogenous, &mut self.gradients);
        let mut rows = [[0.0; 4]; 3];
        for d in (0..3).filter(|d| *d != 1 || free.len() == 3) {
            for (slope, leader) in rows[d].iter_mut().zip(free) {
                *slope = self.slope(d, *leader, alone);
            }
            rows[d][3] = missing[d];
        }
        rows
    }

    /// Slope of degree of freedom `d` by input `leader`, with the inputs that follow it.
    fn slope(&self, d: usize, leader: usize, alone: bool) -> f64 {
        let own = self.gradients[3 + leader][d];
        let follows = |(i, coupling): (usize, &Option<(usize, f64)>)| match coupling {
            Some((of, factor)) if *of == leader && !alone => Some(factor * self.gradients[3 + i][d]),
            _ => None,
        };
        own + self.vessel.couplings.iter().enumerate().filter_map(follows).sum::<f64>()
    }

    /// Changes the inputs as far as their ranges allow; returns whether anything changed.
    fn corrected(&mut self, free: &[usize], changes: [f64; 3]) -> bool {
        let mut changed = false;
        for (i, change) in free.iter().zip(changes) {
            let before = self.last[*i];
            let after = self.vessel.actuators[*i]
                .range
                .map_or(before + change, |[low, high]| (before + change).clamp(low, high));
            changed |= (after - before).abs() > 1e-12 * after.abs();
            self.last[*i] = after;
        }
        if free.len() < self.last.len() {
            for (i, coupling) in self.vessel.couplings.iter().enumerate() {
                if let Some((leader, factor)) = coupling {
                    self.last[i] = factor * self.last[*leader];
                }
            }
        }
        changed
    }

    /// Sets the point of the model, unless it is there already.
    fn look(&mut self, state: [f64; 3], current: [f64; 2], inputs: Option<&[f64]>) {
        let inputs = inputs.unwrap_or(&self.last);
        if self.looked == Some((state, current)) && self.exogenous[..inputs.len()] == *inputs {
            return;
        }
        self.looked = Some((state, current));
        self.exogenous.iter_mut().zip(inputs).for_each(|(to, from)| *to = *from);
        self.vessel.model.complete(&mut self.exogenous);
        self.model.look(state, &self.exogenous, Some(current));
    }

    /// The motion a sample after `before`, under `inputs`, with what was learnt so far.
    pub fn predicted(&mut self, before: [f64; 3], inputs: &[f64], current: [f64; 2]) -> [f64; 3] {
        self.look(before, current, Some(inputs));
        let increments = self.model.increments();
        [0, 1, 2].map(|d| before[d] + increments[d] + self.unexplained[d])
    }

    /// Learns from a sample: `before` became `after` under `inputs`.
    pub fn observe(&mut self, before: [f64; 3], inputs: &[f64], current: [f64; 2], after: [f64; 3]) {
        self.look(before, current, Some(inputs));
        let increments = self.model.increments();
        for d in 0..3 {
            let lacking = after[d] - before[d] - increments[d] - self.unexplained[d];
            self.unexplained[d] += self.believed[d] * lacking;
        }
    }
}

/// Solves rows \[A | b\] by elimination; unknowns without a slope are not changed.
fn solved(mut rows: [[f64; 4]; 3]) -> [f64; 3] {
    let mut used = [false; 3];
    let mut pivots = [None; 3];
    for column in 0..3 {
        let open = (0..3).filter(|row| !used[*row]);
        let best = open.max_by(|a, b| rows[*a][column].abs().total_cmp(&rows[*b][column].abs()));
        let Some(row) = best.filter(|row| rows[*row][column].abs() > 1e-15) else { continue };
        used[row] = true;
        pivots[column] = Some(row);
        let own = rows[row];
        for other in (0..3).filter(|other| *other != row) {
            let factor = rows[other][column] / own[column];
            rows[other].iter_mut().zip(own).for_each(|(to, from)| *to -= factor * from);
        }
    }
    [0, 1, 2].map(|column| pivots[column].map_or(0.0, |row: usize| rows[row][3] / rows[row][column]))
}
