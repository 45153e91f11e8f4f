use std::f64::consts::{FRAC_PI_2, PI, TAU};

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

/// The setting of an azimuth thruster: speed n \[1/s\] and direction of its push, from forward to starboard
/// \[rad\], not wrapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setting {
    /// Speed; negative when reversed.
    pub n: f64,
    /// Direction.
    pub alpha: f64,
}

/// A thruster's force from its speed n.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "lowercase")]
pub enum Law {
    /// c n |n|.
    #[default]
    Quadratic,
    /// c n, as in the paper's static model.
    Linear,
}

/// A thruster: body axes x forward, y starboard, z down.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Thruster {
    /// Force from speed.
    pub law: Law,
    /// c: force per speed, or per speed squared.
    pub coefficient: f64,
    /// Its position relative to the reference point: forward and to starboard \[m\].
    pub position_m: [f64; 2],
}

impl Thruster {
    /// τ1 (forward), τ2 (to starboard), τ3 (moment, bow to starboard) at speed `n`, pushing in direction `alpha` \[rad\],
    /// counted from forward towards starboard. With F = c n|n| (or c n):
    ///
    /// τ1 = F cos α,  τ2 = F sin α,  τ3 = l_x F sin α − l_y F cos α.
    ///
    /// τ3 is the z component of l × F. The paper prints + l_y n cos α; with these axes the sign is minus: a thruster on
    /// the starboard side (l_y > 0) that pushes forward turns the bow to port.
    pub fn forces(&self, n: f64, alpha: f64) -> [f64; 3] {
        let force = match self.law {
            Law::Quadratic => self.coefficient * n * n.abs(),
            Law::Linear => self.coefficient * n,
        };
        let (sin, cos) = libm::sincos(alpha);
        let (forward, starboard) = (force * cos, force * sin);
        let [x, y] = self.position_m;
        [forward, starboard, x * starboard - y * forward]
    }

    /// The setting that pushes with `force` (forward, to starboard) \[N\]: of the two, ahead and reversed, the one whose
    /// direction is nearer to `alpha` \[rad\], within a quarter turn of it. Without force `alpha` stays.
    pub fn setting(&self, [forward, starboard]: [f64; 2], alpha: f64) -> Setting {
        let force = libm::hypot(forward, starboard);
        if force == 0.0 {
            return Setting { n: 0.0, alpha };
        }
        let turn = (libm::atan2(starboard, forward) - alpha + PI).rem_euclid(TAU) - PI;
        let is_reversed = turn.abs() > FRAC_PI_2;
        let (sign, turn) = if is_reversed { (-1.0, turn - PI.copysign(turn)) } else { (1.0, turn) };
        let speed = match self.law {
            Law::Quadratic => (force / self.coefficient).sqrt(),
            Law::Linear => force / self.coefficient,
        };
        Setting { n: sign * speed, alpha: alpha + turn }
    }
}

/// Forces that no settings of the thrusters produce together.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unreachable {
    /// Which of τ1, τ2, τ3, from 0.
    pub force: usize,
    /// The demanded value \[N or N m\].
    pub wanted: f64,
    /// The value that follows from the forces before it.
    pub made: f64,
}

/// Least-norm thrust allocation: the inverse of [`Thruster::forces`] summed over azimuth thrusters.
///
/// With the thrusters' force components f = (X₁, Y₁, X₂, Y₂, …) the forces are τ = B f, with the rows (1, 0,
/// …), (0, 1, …), (−l_y, l_x, …). Of all f that produce τ the one of least norm is f = Bᵀ(BBᵀ)⁻¹τ (Fossen,
/// Handbook of Marine Craft Hydrodynamics and Motion Control, 12.3, with equal weights). It is computed from
/// B = L Q with orthonormal rows of Q, which also shows which forces a rank-deficient B cannot produce.
#[derive(Clone, Debug, PartialEq)]
pub struct Allocation {
    thrusters: Vec<Thruster>,
    /// Orthonormal rows, 2 per thruster.
    q: Vec<Vec<f64>>,
    /// Per force, its coefficients on the rows of `q`; the last coefficient belongs to a row of its own if the flag is set.
    l: Vec<(Vec<f64>, bool)>,
}

/// A row of B counts as dependent on the rows before it if less than this share of it remains.
const DEPENDENT: f64 = 1e-9;

impl Allocation {
    /// Factors B.
    pub fn new(thrusters: Vec<Thruster>) -> Self {
        let row = |of: &dyn Fn(&Thruster) -> [f64; 2]| thrusters.iter().flat_map(of).collect::<Vec<f64>>();
        let rows =
            [row(&|_| [1.0, 0.0]), row(&|_| [0.0, 1.0]), row(&|t| [-t.position_m[1], t.position_m[0]])];
        let (mut q, mut l) = (Vec::<Vec<f64>>::new(), Vec::new());
        for mut row in rows {
            let size = dot(&row, &row).sqrt();
            let mut coefficients: Vec<f64> = Vec::new();
            for unit in &q {
                let along = dot(&row, unit);
                row.iter_mut().zip(unit).for_each(|(x, u)| *x -= along * u);
                coefficients.push(along);
            }
            let left = dot(&row, &row).sqrt();
            let is_independent = left > DEPENDENT * size.max(f64::MIN_POSITIVE);
            if is_independent {
                row.iter_mut().for_each(|x| *x /= left);
                q.push(row);
                coefficients.push(left);
            }
            l.push((coefficients, is_independent));
        }
        Self { thrusters, q, l }
    }

    /// τ1, τ2 \[N\] and τ3 \[N m\] that all thrusters produce together.
    pub fn forces(&self, settings: &[Setting]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (thruster, setting) in self.thrusters.iter().zip(settings) {
            let forces = thruster.forces(setting.n, setting.alpha);
            sum.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        }
        sum
    }

    /// Forward and starboard force of each thruster \[N\] for `tau` = τ1, τ2 \[N\], τ3 \[N m\].
    ///
    /// # Errors
    /// Forces that no settings produce.
    pub fn components(&self, tau: [f64; 3]) -> Result<Vec<[f64; 2]>, Unreachable> {
        let largest = tau.iter().fold(0.0_f64, |most, t| most.max(t.abs()));
        let mut y: Vec<f64> = Vec::new();
        for (force, ((coefficients, is_independent), wanted)) in self.l.iter().zip(tau).enumerate() {
            let made: f64 = coefficients.iter().zip(&y).map(|(c, y)| c * y).sum();
            match coefficients.last().filter(|_| *is_independent) {
                Some(pivot) => y.push((wanted - made) / pivot),
                None if (wanted - made).abs() > 1e-6 * largest => {
                    return Err(Unreachable { force, wanted, made });
                }
                None => {}
            }
        }
        let mut f = vec![0.0; 2 * self.thrusters.len()];
        for (row, y) in self.q.iter().zip(&y) {
            f.iter_mut().zip(row).for_each(|(f, q)| *f += q * y);
        }
        Ok(f.chunks_exact(2).map(|pair| [pair[0], pair[1]]).collect())
    }

    /// Settings that produce `tau`, each turned as little as possible from `near`: a thruster is reversed
    /// rather than turned by more than a quarter turn, and one without force keeps its direction.
    ///
    /// # Errors
    /// Forces that no settings produce.
    pub fn settings(&self, tau: [f64; 3], near: &[Setting]) -> Result<Vec<Setting>, Unreachable> {
        let components = self.components(tau)?;
        let of = |((thruster, force), near): ((&Thruster, [f64; 2]), &Setting)| {
            thruster.setting(force, near.alpha)
        };
        Ok(self.thrusters.iter().zip(components).zip(near).map(of).collect())
    }
}

fn dot(a: &[f64], b: &[f64]) -> f64 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
