//! Which inputs hold a wanted motion steady: the inverse of the model at equilibrium.

use crate::{Invalid, Vessel};

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

/// Steady inputs of `vessel` with `parameters`, by Newton's method from `start` (inputs, then sway speed).
///
/// The unknowns are the inputs and, where the vessel has too few independent inputs to command it, the sway speed.
/// The equations are zero increments and the couplings between inputs; a commanded sway speed releases the couplings.
///
/// # Errors
/// A vessel without the inputs to command the motion; a motion that no inputs hold.
pub fn steady_inputs(
    vessel: &Vessel,
    parameters: &[f64],
    motion: Motion,
    start: &mut [f64],
) -> Result<(), Invalid> {
    let problem = Problem::new(vessel, parameters, motion)?;
    for _ in 0..50 {
        let Some(step) = problem.newton_step(start) else {
            break;
        };
        let mut change: f64 = 0.0;
        for (x, dx) in start.iter_mut().zip(&step) {
            change = change.max(dx.abs() / (x.abs() + 1e-9));
            *x += dx;
        }
        if !start.iter().all(|x| x.is_finite()) {
            break;
        }
        if change < 1e-13 {
            return Ok(());
        }
    }
    Err(unreachable_motion(motion))
}

struct Problem<'a> {
    vessel: &'a Vessel,
    parameters: &'a [f64],
    motion: Motion,
    sway_free: bool,
    coupled: bool,
}

impl<'a> Problem<'a> {
    fn new(vessel: &'a Vessel, parameters: &'a [f64], motion: Motion) -> Result<Self, Invalid> {
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
        Ok(Self { vessel, parameters, motion, sway_free, coupled })
    }

    fn values(&self, unknowns: &[f64]) -> Vec<f64> {
        let inputs = self.vessel.model.inputs;
        let mut values = vec![self.motion.u, self.motion.v.unwrap_or(unknowns[inputs]), self.motion.r];
        values.extend_from_slice(&unknowns[..inputs]);
        values.resize(self.vessel.model.variables.len(), 0.0);
        values
    }

    /// Solves Jacobian · step = −residual; `None` where the Jacobian is singular.
    fn newton_step(&self, unknowns: &[f64]) -> Option<Vec<f64>> {
        let inputs = self.vessel.model.inputs;
        let n = inputs + usize::from(self.sway_free);
        let values = self.values(unknowns);
        let mut rows: Vec<Vec<f64>> = Vec::with_capacity(n);
        let mut next = 0;
        for degree in &self.vessel.model.degrees {
            let mut row = vec![0.0; n + 1];
            for term in &degree.terms {
                let parameter = self.parameters[next];
                next += 1;
                row[n] -= parameter * term.evaluate(&values);
                for (j, entry) in row[..n].iter_mut().enumerate() {
                    *entry += parameter * term.derivative(&values, if j < inputs { 3 + j } else { 1 });
                }
            }
            rows.push(row);
        }
        if self.coupled {
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
