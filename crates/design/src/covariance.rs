use std::ops::Range;

use numerics::{congruence, dot, product, symmetric, transposed};

use crate::candidates::Balanced;
use crate::spectrum::{Block, Spectrum, is_proportional, row_without_variance};
use crate::{Candidates, Error, Norm, Objective};

/// A criterion of the sandwich covariance A(w)⁻¹ B(w) A(w)⁻ᵀ, A(w) = Σ w_q M_qᵀ, B(w) = Σ w_q B_q, block by block of
/// parameters. As an [`Objective`] it is minus the [`Norm`] of the weighted covariance.
#[derive(Clone, Debug)]
pub struct Covariance {
    information: Candidates,
    meat: Candidates,
    /// Per block the square root V of its weights in balanced units, k × n: V C Vᵀ is minimised. Nuisance parameters
    /// such as intercepts have columns of zeros.
    roots: Vec<Vec<f64>>,
    /// Balanced units per unit of every row.
    rows: Vec<f64>,
    norm: Norm,
    /// The offset to add to the balanced norm.
    offset: f64,
    /// Whether the criterion is proved concave.
    concave: bool,
}

/// Balanced information is singular if its inverse has an entry above this.
const SINGULAR: f64 = 1e13;

fn largest(entries: &[f64]) -> f64 {
    entries.iter().fold(0.0, |largest, x| x.abs().max(largest))
}

/// The workspace of an evaluation, for the derivatives.
#[derive(Clone, Debug, Default)]
pub struct CovariancePoint {
    /// Cov of the parameters and nuisances in balanced units, block by block.
    covariance: Vec<f64>,
    /// A⁻¹.
    inverse: Vec<f64>,
    /// ∂Φ/∂M and ∂Φ/∂B.
    slopes: [Vec<f64>; 2],
    spectrum: Spectrum,
    sums: [Vec<f64>; 2],
}

impl Covariance {
    /// `moments`: M_q = mean of φζᵀ, rows by parameter, columns by instrument. `meat`: B_q per candidate, with
    /// the same blocks, rows and columns by instrument, symmetric. `weights`: of every row's variance, 0 for a
    /// nuisance; for a [`Norm::LogDet`] it only matters which are zero.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::Empty`]; [`Error::Unexcited`] if equal shares do not excite a
    /// direction; [`Error::SingularCovariance`] if a weighted direction has no variance at equal shares.
    pub fn new(moments: &Candidates, meat: &Candidates, weights: &[f64], norm: Norm) -> Result<Self, Error> {
        if weights.len() != moments.dimension() {
            return Err(Error::Shape { found: weights.len(), expected: moments.dimension() });
        }
        if let Some(row) = weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
            return Err(Error::Weight { row, found: weights[row] });
        }
        Self::built(moments, meat, norm, |n, rows| {
            let root = |i: usize| match norm {
                Norm::LogDet => 1.0,
                Norm::Trace => weights[rows.start + i].sqrt(),
            };
            let kept: Vec<usize> = (0..n).filter(|i| weights[rows.start + i] > 0.0).collect();
            kept.iter().flat_map(|i| (0..n).map(move |j| if *i == j { root(j) } else { 0.0 })).collect()
        })
    }

    /// The trace of G C with one symmetric positive semidefinite matrix G per block, the mean square effect of
    /// parameter errors on a function of the parameters: V-optimality.
    ///
    /// # Errors
    /// As [`Covariance::new`].
    pub fn of_matrices(moments: &Candidates, meat: &Candidates, weights: &[Vec<f64>]) -> Result<Self, Error> {
        let sizes: Vec<usize> = moments.blocks().map(|(n, _)| n * n).collect();
        let given: Vec<usize> = weights.iter().map(Vec::len).collect();
        if given != sizes {
            return Err(Error::Shape { found: given.iter().sum(), expected: sizes.iter().sum() });
        }
        let mut block = 0;
        Self::built(moments, meat, Norm::Trace, |n, _| {
            block += 1;
            // Weights that are not finite are refused.
            let (values, vectors) = symmetric(n, &weights[block - 1]).unwrap_or_default();
            let least = 1e-14 * values.iter().copied().fold(0.0, f64::max);
            let kept: Vec<usize> = (0..values.len()).filter(|e| values[*e] > least).collect();
            let root = |e: usize, i: usize| values[e].sqrt() * vectors[i * n + e];
            kept.iter().flat_map(|e| (0..n).map(move |i| root(*e, i))).collect()
        })
    }

    /// The sum of the variances of linear functions of the parameters. `slopes`: the derivatives of each by every
    /// row. Rows of different blocks count as uncorrelated.
    ///
    /// # Errors
    /// As [`Covariance::new`]; [`Error::Weight`] for a derivative that is not finite.
    pub fn of_functions(moments: &Candidates, meat: &Candidates, slopes: &[Vec<f64>]) -> Result<Self, Error> {
        let expected = moments.dimension();
        for function in slopes {
            if function.len() != expected {
                return Err(Error::Shape { found: function.len(), expected });
            }
            if let Some(row) = function.iter().position(|slope| !slope.is_finite()) {
                return Err(Error::Weight { row, found: function[row] });
            }
        }
        Self::built(moments, meat, Norm::Trace, |_, rows| {
            slopes.iter().flat_map(|function| function[rows.clone()].iter().copied()).collect()
        })
    }

    /// `root`: V of a block of n rows, with indices `rows`, in units of the candidates.
    fn built(
        information: &Candidates,
        meat: &Candidates,
        norm: Norm,
        mut root: impl FnMut(usize, Range<usize>) -> Vec<f64>,
    ) -> Result<Self, Error> {
        if meat.len() != information.len() || meat.size() != information.size() {
            return Err(Error::Shape { found: meat.size(), expected: information.size() });
        }
        let Balanced { candidates: information, rows, columns, .. } = information.balanced()?;
        information.check_excitation()?;
        let meat = meat.congruent(&columns);
        let (mut roots, mut offset, mut first) = (Vec::new(), 0.0, 0);
        for (n, _) in information.blocks() {
            let mut rooted = root(n, first..first + n);
            for row in rooted.chunks_exact_mut(n) {
                for (entry, unit) in row.iter_mut().zip(&rows[first..]).filter(|(e, _)| **e != 0.0) {
                    match norm {
                        Norm::LogDet => offset -= 2.0 * libm::log(*unit),
                        Norm::Trace => *entry /= unit,
                    }
                }
            }
            roots.push(rooted);
            first += n;
        }
        let concave = is_proportional(&information, &meat);
        let built = Self { information, meat, roots, rows, norm, offset, concave };
        built.check_covariance()?;
        Ok(built)
    }

    /// Whether the criterion is concave up to a monotone function: B_q is proportional to the information, which is
    /// symmetric positive semidefinite up to row factors. Then a small gap bounds the distance to the global optimum.
    pub fn is_concave(&self) -> bool {
        self.concave
    }

    /// The norm.
    pub fn norm(&self) -> Norm {
        self.norm
    }

    /// Refuses a dictionary whose equal mixture gives a weighted direction (or, for the trace, all directions) no variance.
    fn check_covariance(&self) -> Result<(), Error> {
        let count = self.information.len();
        let mut at = CovariancePoint::default();
        self.invert(&vec![1.0 / count as f64; count], &mut at)
            .ok_or_else(|| Error::Solver("equal shares are singular".into()))?;
        let weighted = self.weighted_blocks(&at);
        let nothing = weighted.iter().flatten().all(|c| *c == 0.0);
        if self.norm != Norm::LogDet && !nothing {
            return Ok(());
        }
        let row = |(index, (block, matrix)): (usize, (Block<'_>, &Vec<f64>))| {
            row_without_variance(&block, matrix).map(|row| Error::SingularCovariance { block: index, row })
        };
        self.blocks().zip(&weighted).enumerate().find_map(row).map_or(Ok(()), Err)
    }

    /// Number of eigenvalues of the weighted covariance.
    fn eigenvalues(&self) -> usize {
        self.blocks().map(|block| block.kept()).sum()
    }

    fn blocks(&self) -> impl Iterator<Item = Block<'_>> + '_ {
        let mut first = 0;
        self.information.blocks().zip(&self.roots).map(move |((n, range), root)| {
            first += n;
            Block { n, range, rows: first - n..first, root }
        })
    }

    /// Computes covariance and inverse. `None` if the information is singular.
    fn invert(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<()> {
        self.information.sum(shares, &mut at.sums[0]);
        self.meat.sum(shares, &mut at.sums[1]);
        at.covariance.clear();
        at.inverse.clear();
        for (n, range) in self.information.blocks() {
            let mut inverse = vec![0.0; n * n];
            numerics::inverse(n, &mut at.sums[0][range.clone()], &mut inverse)?;
            if largest(&inverse) > SINGULAR {
                return None;
            }
            // M is Aᵀ.
            let inverse = transposed(n, &inverse);
            let covariance = congruence(n, &inverse, &at.sums[1][range]);
            // Symmetrised, since asymmetric rounding would dominate the eigenvalues of nearly singular information.
            let entry = |e: usize| 0.5 * (covariance[e] + covariance[e % n * n + e / n]);
            at.covariance.extend((0..n * n).map(entry));
            at.inverse.extend(inverse);
        }
        Some(())
    }

    fn weighted_blocks(&self, at: &CovariancePoint) -> Vec<Vec<f64>> {
        self.blocks().map(|b| b.weighted(&at.covariance[b.range.clone()])).collect()
    }

    /// The variances of all rows at `shares`, nuisances included, per unit of experiment and without weights. `None`
    /// if the information is singular.
    pub fn variances(&self, shares: &[f64]) -> Option<Vec<f64>> {
        let mut at = CovariancePoint::default();
        self.invert(shares, &mut at)?;
        let of = |block: Block<'_>| {
            let unit = |i: usize| self.rows[block.rows.start + i].powi(2);
            let diagonal = |i: usize| at.covariance[block.range.start + i * block.n + i] / unit(i);
            (0..block.n).map(diagonal).collect::<Vec<_>>()
        };
        Some(self.blocks().flat_map(of).collect())
    }

    /// gᵀ C g of linear functions of the parameters at `shares`, per unit of experiment; g has a derivative by every
    /// row, in `functions`. `None` if the information is singular.
    pub fn variances_of(&self, shares: &[f64], functions: &[Vec<f64>]) -> Option<Vec<f64>> {
        let mut at = CovariancePoint::default();
        self.invert(shares, &mut at)?;
        let of = |function: &Vec<f64>| {
            let variance = |block: Block<'_>| {
                let rows = function[block.rows.clone()].iter().zip(&self.rows[block.rows.clone()]);
                let root: Vec<f64> = rows.map(|(slope, unit)| slope / unit).collect();
                let block = Block { root: &root, ..block };
                block.weighted(&at.covariance[block.range.clone()]).iter().sum::<f64>()
            };
            self.blocks().map(variance).sum()
        };
        Some(functions.iter().map(of).collect())
    }
}

impl Objective for Covariance {
    type Point = CovariancePoint;

    fn len(&self) -> usize {
        self.information.len()
    }

    fn degree(&self) -> f64 {
        match self.norm {
            Norm::LogDet => self.eigenvalues() as f64,
            Norm::Trace => 1.0,
        }
    }

    fn size(&self) -> usize {
        self.information.size()
    }

    fn exponent(&self) -> f64 {
        match self.norm {
            Norm::LogDet => 1.0,
            Norm::Trace => 0.5,
        }
    }

    fn value(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<f64> {
        self.invert(shares, at)?;
        let weighted = self.weighted_blocks(at);
        Some(-self.offset - crate::spectrum::value(self.norm, &weighted)?)
    }

    fn evaluate(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<f64> {
        self.invert(shares, at)?;
        let spectrum = Spectrum::of(self.norm, &self.weighted_blocks(at))?;
        at.slopes.iter_mut().for_each(Vec::clear);
        for (block, slope) in self.blocks().zip(&spectrum.slopes) {
            let n = block.n;
            let inverse = &at.inverse[block.range.clone()];
            let weight = block.unweighted(slope);
            // dΦ = 2 tr(S A⁻¹ dA C) − tr(A⁻ᵀ S A⁻¹ dB), S = ∂norm/∂C.
            let left = product(n, &weight, inverse);
            let of_m = product(n, &at.covariance[block.range.clone()], &left);
            let of_b = product(n, &transposed(n, inverse), &left);
            at.slopes[0].extend(of_m.iter().map(|x| 2.0 * x));
            at.slopes[1].extend(of_b.iter().map(|x| -x));
        }
        let value = -self.offset - spectrum.value;
        at.spectrum = spectrum;
        Some(value)
    }

    fn sensitivity(&self, q: usize, at: &CovariancePoint) -> f64 {
        dot(&at.slopes[0], self.information.candidate(q)) + dot(&at.slopes[1], self.meat.candidate(q))
    }

    fn curvature(&self, members: &[usize], at: &CovariancePoint) -> Vec<f64> {
        let first: Vec<f64> = members.iter().map(|q| -self.sensitivity(*q, at)).collect();
        let mut moved: Vec<Vec<Vec<f64>>> = Vec::new();
        let k = members.len();
        let mut curvature = vec![0.0; k * k];
        for (block, slope) in self.blocks().zip(&at.spectrum.slopes) {
            let weight = block.unweighted(slope);
            let changes: Vec<Change> = members.iter().map(|q| self.change(&block, &weight, *q, at)).collect();
            for (q, a) in changes.iter().enumerate() {
                // Symmetric: tr S U C U'ᵀ too, since S and C are.
                for (r, b) in changes.iter().enumerate().skip(q) {
                    let mixed = dot(&b.weighted, &a.pulled)
                        + dot(&a.weighted, &b.pulled)
                        + dot(&a.twisted, &b.relative);
                    curvature[q * k + r] += 2.0 * mixed;
                    if r > q {
                        curvature[r * k + q] += 2.0 * mixed;
                    }
                }
            }
            moved.push(changes.into_iter().map(|c| c.covariance).collect());
        }
        at.spectrum.add_curvature(&moved, &first, &mut curvature);
        curvature
    }
}

/// The change of the covariance of a block with one candidate's share: U = A⁻¹ A_q, V = A⁻¹ B_q A⁻ᵀ.
struct Change {
    /// U.
    relative: Vec<f64>,
    /// S U.
    weighted: Vec<f64>,
    /// S U C.
    twisted: Vec<f64>,
    /// (U C)ᵀ − V.
    pulled: Vec<f64>,
    /// The weighted covariance's derivative −U C − C Uᵀ + V.
    covariance: Vec<f64>,
}

impl Covariance {
    fn change(&self, block: &Block<'_>, weight: &[f64], q: usize, at: &CovariancePoint) -> Change {
        let n = block.n;
        let inverse = &at.inverse[block.range.clone()];
        let covariance = &at.covariance[block.range.clone()];
        let information = transposed(n, &self.information.candidate(q)[block.range.clone()]);
        let relative = product(n, inverse, &information);
        let meat = congruence(n, inverse, &self.meat.candidate(q)[block.range.clone()]);
        let weighted = product(n, weight, &relative);
        let twisted = product(n, &weighted, covariance);
        let turned = product(n, &relative, covariance);
        let pulled = (0..n * n).map(|e| turned[(e % n) * n + e / n] - meat[e]).collect();
        let whole: Vec<f64> = (0..n * n).map(|e| meat[e] - turned[e] - turned[(e % n) * n + e / n]).collect();
        Change { relative, weighted, twisted, pulled, covariance: block.weighted(&whole) }
    }
}
