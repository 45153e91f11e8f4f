//! Which inputs hold a wanted motion steady: the inverse of the model at equilibrium.

use crate::{Compiled, Invalid, Vessel};

/// A motion through the water to hold.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Motion {
    /// Surge speed \[m/s\].
    pub u: f64,
    /// Sway speed \[m/s\]; `None`: whatever comes with the turn.
    pub v: Option<f64>,
    /// Yaw rate \[rad/s\].
    pub r: f64,
}

/// A vessel's steady inputs for wanted motions.
#[derive(Clone, Debug)]
pub struct Steady<'a> {
    vessel: &'a Vessel,
    model: Compiled<'a, f64>,
    /// Inputs, then measured disturbances, which are zero.
    exogenous: Vec<f64>,
    gradients: Vec<[f64; 3]>,
}

impl<'a> Steady<'a> {
    /// Of `vessel` with `parameters`.
    pub fn new(vessel: &'a Vessel, parameters: &[f64]) -> Self {
        let gradients = vec![[0.0; 3]; vessel.model.variables.len()];
        let exogenous = vec![0.0; vessel.model.exogenous()];
        Self { vessel, model: Compiled::new(&vessel.model, parameters), exogenous, gradients }
    }

    /// The inputs that hold `motion`, by Newton's method from `unknowns` (inputs, then sway speed), which become the solution.
    ///
    /// The unknowns are the inputs and, where the vessel has too few independent inputs to command it, the sway speed.
    /// The equations are zero increments and the couplings between inputs; a commanded sway speed releases the couplings.
    ///
    /// # Errors
    /// A vessel without the inputs to command the motion; a motion that no inputs hold.
    pub fn solve(&mut self, motion: Motion, unknowns: &mut [f64]) -> Result<(), Invalid> {
        let wanted = Wanted::of(motion, self.vessel)?;
        for _ in 0..50 {
            let Some(step) = self.newton_step(&wanted, unknowns) else {
                break;
            };
            let mut change: f64 = 0.0;
            for (x, dx) in unknowns.iter_mut().zip(&step) {
                change = change.max(dx.abs() / (x.abs() + 1e-9));
                *x += dx;
            }
            if !unknowns.iter().all(|x| x.is_finite()) {
                break;
            }
            if change < 1e-13 {
                return Ok(());
            }
        }
        Err(unreachable_motion(wanted.motion))
    }

    /// Solves Jacobian · step = −residual; `None` where the Jacobian is singular.
    fn newton_step(&mut self, wanted: &Wanted, unknowns: &[f64]) -> Option<Vec<f64>> {
        let inputs = self.vessel.model.inputs;
        let n = inputs + usize::from(wanted.sway_free);
        let Motion { u, v, r } = wanted.motion;
        self.exogenous[..inputs].copy_from_slice(&unknowns[..inputs]);
        self.model.look([u, v.unwrap_or(unknowns[inputs]), r], &self.exogenous, None);
        self.model.gradients(&mut self.gradients);
        let increments = self.model.increments();
        let row = |d: usize| {
            let mut row = vec![-increments[d]; n + 1];
            row[..n].iter_mut().enumerate().for_each(|(j, entry)| {
                *entry = self.gradients[if j < inputs { 3 + j } else { 1 }][d];
            });
            row
        };
        let mut rows: Vec<Vec<f64>> = (0..3).map(row).collect();
        if wanted.coupled {
            for (i, coupling) in self.vessel.couplings.iter().enumerate() {
                if let Some((leader, factor)) = coupling {
                    let mut row = vec![0.0; n + 1];
                    row[i] = 1.0;
                    row[*leader] = -factor;
                    row[n] = factor * unknowns[*leader] - unknowns[i];
                    rows.push(row);
                }
            }
        }
        solve(&rows)
    }
}

/// A motion, and which unknowns and equations it leaves.
struct Wanted {
    motion: Motion,
    sway_free: bool,
    coupled: bool,
}

impl Wanted {
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
        Ok(Self { motion, sway_free, coupled })
    }
}

/// Solves rows \[a | b\], each scaled to a largest coefficient of 1.
fn solve(rows: &[Vec<f64>]) -> Option<Vec<f64>> {
    let n = rows.len();
    let mut a = Vec::with_capacity(n * n);
    let mut b = Vec::with_capacity(n);
    for row in rows {
        let scale = row[..n].iter().fold(0.0_f64, |m, x| m.max(x.abs()));
        a.extend(row[..n].iter().map(|x| x / scale));
        b.push(row[n] / scale);
    }
    numerics::solve(n, &mut a, &mut b).map(|_| b)
}

fn unreachable_motion(motion: Motion) -> Invalid {
    let sway = motion.v.map_or(String::new(), |v| format!(", v = {v} m/s"));
    Invalid::new(
        "wanted motion",
        format!("u = {} m/s{sway}, r = {} rad/s, which no inputs hold steady", motion.u, motion.r),
        "a motion that the model can hold",
        "lower the speeds, or turn the maneuver into inputs with the other parameters (`inputs_from`)",
    )
}
