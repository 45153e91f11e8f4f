use numerics::{add_outer, product, transposed};

use super::{Centring, DegreeRegression, Regression};

/// How much of each regressor its instruments explain, beyond what they explain of the others: Shea's partial R²
/// (*Review of Economics and Statistics* 79, 1997), (S_φφ⁻¹)_ii / ((S_φζ S_ζζ⁻¹ S_ζφ)⁻¹)_ii of centred sums. 1 for
/// least squares, near 0 for instruments that do not follow the motion. `None` if a matrix is singular.
pub fn strength(parts: &[&Regression], centring: &Centring, d: usize) -> Option<Vec<f64>> {
    let mut strength = Strength::default();
    parts.iter().enumerate().for_each(|(i, part)| strength.add(i, &part.degrees[d], centring, d));
    strength.partial()
}

/// The sums for the strength of instruments.
#[derive(Clone, Debug, Default)]
pub struct Strength {
    /// p, and S_φφ, S_ζζ, S_ζφ.
    found: Option<(usize, [Vec<f64>; 3])>,
}

impl Strength {
    /// Adds degree of freedom `d` of part number `i`.
    pub fn add(&mut self, i: usize, part: &DegreeRegression, centring: &Centring, d: usize) {
        let p = part.parameters;
        let (_, sums) = self.found.get_or_insert_with(|| (p, [0; 3].map(|_| vec![0.0; p * p])));
        let (mut zeta, mut phi) = (Vec::new(), Vec::new());
        for k in 0..part.target.len() {
            centring.zeta(i, d, part.zeta(k), &mut zeta);
            centring.phi(i, d, part.phi(k), &mut phi);
            for (sum, (left, right)) in sums.iter_mut().zip([(&phi, &phi), (&zeta, &zeta), (&zeta, &phi)]) {
                add_outer(sum, left, right);
            }
        }
    }

    /// See [`strength`].
    pub fn partial(self) -> Option<Vec<f64>> {
        let (p, sums) = self.found?;
        let scale: Vec<[f64; 2]> = (0..p).map(|i| [0, 1].map(|s: usize| sums[s][i * p + i].sqrt())).collect();
        let scaled = |which: usize, rows: usize, columns: usize| -> Vec<f64> {
            (0..p * p).map(|k| sums[which][k] / (scale[k / p][rows] * scale[k % p][columns])).collect()
        };
        let (regressors, instruments, mixed) = (scaled(0, 0, 0), scaled(1, 1, 1), scaled(2, 1, 0));
        let mut projected = mixed.clone();
        numerics::solve(p, &mut instruments.clone(), &mut projected)?;
        let explained = product(p, &transposed(p, &mixed), &projected);
        let (own, explained) = (inverse_diagonal(p, &regressors)?, inverse_diagonal(p, &explained)?);
        let partial: Vec<f64> =
            own.iter().zip(&explained).map(|(own, explained)| (own / explained).clamp(0.0, 1.0)).collect();
        partial.iter().all(|x| x.is_finite()).then_some(partial)
    }
}

fn inverse_diagonal(p: usize, a: &[f64]) -> Option<Vec<f64>> {
    let (mut destroyed, mut inverse) = (a.to_vec(), vec![0.0; p * p]);
    numerics::inverse(p, &mut destroyed, &mut inverse)?;
    Some((0..p).map(|i| inverse[i * p + i]).collect())
}
