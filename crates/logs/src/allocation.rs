use crate::Thruster;

/// What an azimuth thruster is set to: speed n \[1/s\] and direction of its push, from forward to starboard \[rad\], not
/// wrapped.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Setting {
    /// Speed; negative where it is reversed.
    pub n: f64,
    /// Direction.
    pub alpha: f64,
}

/// Forces that the thrusters cannot make together, whatever their settings.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unreachable {
    /// Which of τ1, τ2, τ3, from 0.
    pub force: usize,
    /// What is wanted of it \[N or N m\].
    pub wanted: f64,
    /// What follows from those before it.
    pub made: f64,
}

/// Least-norm thrust allocation: the inverse of [`Thruster::forces`] summed over azimuth thrusters.
///
/// With the thrusters' force components f = (X₁, Y₁, X₂, Y₂, …) the forces are τ = B f, with the rows
/// (1, 0, …), (0, 1, …), (−l_y, l_x, …). Of all f that make τ the one of least norm is f = Bᵀ(BBᵀ)⁻¹τ (Fossen, Handbook of
/// Marine Craft Hydrodynamics and Motion Control, 12.3, with equal weights); here by B = L Q with orthonormal rows of Q,
/// which also tells what cannot be made where B lacks rank.
#[derive(Clone, Debug, PartialEq)]
pub struct Allocation {
    thrusters: Vec<Thruster>,
    /// Orthonormal rows, 2 per thruster.
    q: Vec<Vec<f64>>,
    /// Per force: its coefficients on the rows of `q`; the last belongs to a row of its own if `own`.
    l: Vec<(Vec<f64>, bool)>,
}

/// A row of B counts as dependent on those before it if less than this part of it is left.
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

    /// The thrusters.
    pub fn thrusters(&self) -> &[Thruster] {
        &self.thrusters
    }

    /// Forward and starboard force of each thruster \[N\] for `tau` = τ1, τ2 \[N\], τ3 \[N m\].
    ///
    /// # Errors
    /// Forces that no settings make.
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

    /// Settings that make `tau`, each turned as little as can be from `near`: a thruster is reversed rather than turned by
    /// more than a quarter, and one without force stays as it points.
    ///
    /// # Errors
    /// Forces that no settings make.
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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Law;

    fn thruster(law: Law, position_m: [f64; 2]) -> Thruster {
        Thruster { law, coefficient: 1.7, position_m }
    }

    fn made(allocation: &Allocation, settings: &[Setting]) -> [f64; 3] {
        let mut sum = [0.0; 3];
        for (thruster, setting) in allocation.thrusters().iter().zip(settings) {
            let forces = thruster.forces(setting.n, setting.alpha);
            sum.iter_mut().zip(forces).for_each(|(sum, force)| *sum += force);
        }
        sum
    }

    #[test]
    fn law_allocated_settings_make_the_forces_through_the_azimuth_map() {
        for (law, places) in [
            (Law::Quadratic, vec![[-0.4, -0.1], [-0.4, 0.1]]),
            (Law::Linear, vec![[11.0, 0.0], [-11.0, 0.0]]),
            (Law::Quadratic, vec![[11.0, 0.3], [-9.0, 2.0], [-9.0, -2.5]]),
        ] {
            let allocation = Allocation::new(places.iter().map(|p| thruster(law, *p)).collect());
            let mut near = vec![Setting::default(); places.len()];
            for k in 0..60 {
                let k = f64::from(k);
                let tau = [30.0 * (0.3 * k).cos(), 20.0 * (0.7 * k).sin(), 9.0 * (1.1 * k).sin()];
                let next = allocation.settings(tau, &near).unwrap();
                for (found, wanted) in made(&allocation, &next).into_iter().zip(tau) {
                    approx::assert_abs_diff_eq!(found, wanted, epsilon = 1e-11);
                }
                for (next, near) in next.iter().zip(&near) {
                    assert!((next.alpha - near.alpha).abs() <= std::f64::consts::FRAC_PI_2 + 1e-12);
                }
                near = next;
            }
        }
    }

    #[test]
    fn law_no_other_components_with_the_same_forces_are_smaller() {
        let places = [[11.0, 0.3], [-9.0, 2.0], [-9.0, -2.5]];
        let allocation = Allocation::new(places.iter().map(|p| thruster(Law::Linear, *p)).collect());
        let f = allocation.components([3.0, -2.0, 5.0]).unwrap();
        // Steps that change no force: thrusters pull on each other along the lines between them.
        for (i, j) in [(0, 1), (1, 2), (0, 2)] {
            let line = [places[j][0] - places[i][0], places[j][1] - places[i][1]];
            let along: f64 = (0..2).map(|d| (f[j][d] - f[i][d]) * line[d]).sum();
            approx::assert_abs_diff_eq!(along, 0.0, epsilon = 1e-12);
        }
    }

    #[test]
    fn what_a_single_thruster_cannot_make_is_told() {
        let allocation = Allocation::new(vec![thruster(Law::Quadratic, [-2.0, 0.0])]);
        assert!(allocation.components([5.0, 3.0, -6.0]).is_ok());
        let refused = allocation.components([5.0, 3.0, 1.0]).unwrap_err();
        assert_eq!((refused.force, refused.wanted, refused.made), (2, 1.0, -6.0));
        assert!(Allocation::new(Vec::new()).components([1.0, 0.0, 0.0]).is_err());
    }

    #[test]
    fn a_thruster_is_reversed_rather_than_turned_about() {
        let allocation = Allocation::new(vec![thruster(Law::Quadratic, [-2.0, 0.0])]);
        let found = allocation.settings([-1.7 * 4.0, 0.0, 0.0], &[Setting { n: 1.0, alpha: 0.0 }]).unwrap();
        approx::assert_abs_diff_eq!(found[0].n, -2.0, epsilon = 1e-14);
        approx::assert_abs_diff_eq!(found[0].alpha, 0.0, epsilon = 1e-14);
        let still = allocation.settings([0.0; 3], &[Setting { n: 1.0, alpha: 0.6 }]).unwrap();
        assert_eq!(still[0], Setting { n: 0.0, alpha: 0.6 });
    }
}
