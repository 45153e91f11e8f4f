use crate::{Setting, Thruster};

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
    /// Per force, its coefficients on the rows of `q`; the last coefficient belongs to a row of its own if
    /// the flag is set.
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
            let own = left > DEPENDENT * size.max(f64::MIN_POSITIVE);
            if own {
                row.iter_mut().for_each(|x| *x /= left);
                q.push(row);
                coefficients.push(left);
            }
            l.push((coefficients, own));
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
        for (force, ((coefficients, own), wanted)) in self.l.iter().zip(tau).enumerate() {
            let made: f64 = coefficients.iter().zip(&y).map(|(c, y)| c * y).sum();
            match coefficients.last().filter(|_| *own) {
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
