use std::ops::Range;

use crate::eigen::symmetric;
use crate::product::{congruence, dot, transposed};
use crate::spectrum::Spectrum;
use crate::{Candidates, Design, Error, Objective};

mod check;
mod objective;

use check::is_proportional;

/// What of a covariance matrix is made small.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub enum Norm {
    /// log det: D-optimality.
    #[default]
    LogDet,
    /// log of the trace: A-optimality.
    Trace,
}

/// A criterion of the covariance A(w)⁻¹ B(w) A(w)⁻ᵀ, A(w) = Σ w_q M_qᵀ, B(w) = Σ w_q B_q, one block of parameters after
/// the other. As an [`Objective`] it is minus the [`Norm`] of the weighted covariance.
#[derive(Clone, Debug)]
pub struct Covariance {
    information: Candidates,
    middle: Candidates,
    /// Per block the square root V of its weights in balanced units, k × n: what is made small is V C Vᵀ. Nuisances such
    /// as intercepts have columns of zeros.
    roots: Vec<Vec<f64>>,
    /// Balanced units per unit of every row.
    rows: Vec<f64>,
    norm: Norm,
    /// What the balanced norm has to be raised by.
    offset: f64,
    /// Whether the criterion is proved concave.
    concave: bool,
}

/// An inverse of balanced information with an entry above this is that of a singular matrix.
const SINGULAR: f64 = 1e13;

fn largest(entries: &[f64]) -> f64 {
    entries.iter().fold(0.0, |largest, x| x.abs().max(largest))
}

/// What an evaluation leaves for the derivatives.
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
    /// `information`: M_q = mean of φζᵀ, rows by parameter, columns by instrument. `middle`: B_q per candidate, the blocks
    /// as there, rows and columns by instrument, symmetric. `weights`: of every row's variance, 0 for a nuisance; a
    /// [`Norm::LogDet`] asks only which are zero.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`], [`Error::Empty`]; [`Error::Unexcited`] where equal shares leave a direction
    /// without excitation; [`Error::SingularCovariance`] where they leave a weighted direction without any variance.
    pub fn new(
        information: &Candidates,
        middle: &Candidates,
        weights: &[f64],
        norm: Norm,
    ) -> Result<Self, Error> {
        if weights.len() != information.dimension() {
            return Err(Error::Shape { found: weights.len(), expected: information.dimension() });
        }
        if let Some(row) = weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
            return Err(Error::Weight { row, found: weights[row] });
        }
        Self::built(information, middle, norm, |n, rows| {
            let root = |i: usize| match norm {
                Norm::LogDet => 1.0,
                Norm::Trace => weights[rows.start + i].sqrt(),
            };
            let kept: Vec<usize> = (0..n).filter(|i| weights[rows.start + i] > 0.0).collect();
            kept.iter().flat_map(|i| (0..n).map(move |j| if *i == j { root(j) } else { 0.0 })).collect()
        })
    }

    /// The trace of G C with one symmetric positive semidefinite matrix G per block, as the mean square of what errors of
    /// the parameters do to something that depends on them: V-optimality.
    ///
    /// # Errors
    /// As [`Covariance::new`].
    pub fn of_matrices(
        information: &Candidates,
        middle: &Candidates,
        weights: &[Vec<f64>],
    ) -> Result<Self, Error> {
        let sizes: Vec<usize> = information.blocks().map(|(n, _)| n * n).collect();
        let found: Vec<usize> = weights.iter().map(Vec::len).collect();
        if found != sizes {
            let (found, expected) = (found.iter().sum(), sizes.iter().sum());
            return Err(Error::Shape { found, expected });
        }
        let mut block = 0;
        Self::built(information, middle, Norm::Trace, |n, _| {
            block += 1;
            let (values, vectors) = symmetric(n, &weights[block - 1]);
            let least = 1e-14 * values.iter().copied().fold(0.0, f64::max);
            let kept: Vec<usize> = (0..n).filter(|e| values[*e] > least).collect();
            let root = |e: usize, i: usize| values[e].sqrt() * vectors[i * n + e];
            kept.iter().flat_map(|e| (0..n).map(move |i| root(*e, i))).collect()
        })
    }

    /// `root`: V of a block of n rows, which are `rows` of all, in units of the candidates.
    fn built(
        information: &Candidates,
        middle: &Candidates,
        norm: Norm,
        mut root: impl FnMut(usize, Range<usize>) -> Vec<f64>,
    ) -> Result<Self, Error> {
        if middle.len() != information.len() || middle.size() != information.size() {
            return Err(Error::Shape { found: middle.size(), expected: information.size() });
        }
        let balanced = information.balanced()?;
        balanced.candidates.check_excitation()?;
        let middle = middle.congruent(&balanced.columns);
        let (mut roots, mut offset, mut first) = (Vec::new(), 0.0, 0);
        for (n, _) in information.blocks() {
            let mut own = root(n, first..first + n);
            for row in own.chunks_exact_mut(n) {
                for (entry, unit) in row.iter_mut().zip(&balanced.rows[first..]).filter(|(e, _)| **e != 0.0) {
                    match norm {
                        Norm::LogDet => offset -= 2.0 * unit.ln(),
                        Norm::Trace => *entry /= unit,
                    }
                }
            }
            roots.push(own);
            first += n;
        }
        let concave = is_proportional(&balanced.candidates, &middle);
        let built = Self {
            information: balanced.candidates,
            middle,
            roots,
            rows: balanced.rows,
            norm,
            offset,
            concave,
        };
        built.check_covariance()?;
        Ok(built)
    }

    /// Whether the criterion is concave up to a monotone function: B_q is proportional to the information, and that is
    /// symmetric positive semidefinite up to row factors. Then a small gap bounds the distance to the global optimum.
    pub fn is_concave(&self) -> bool {
        self.concave
    }

    /// The norm.
    pub fn norm(&self) -> Norm {
        self.norm
    }

    /// Number of eigenvalues of the weighted covariance.
    fn eigenvalues(&self) -> usize {
        self.blocks().map(|block| block.kept()).sum()
    }

    /// What fraction of the experiment's time the shares of `design`, solved for this criterion, need for what `shares`
    /// give; 0 where these leave a direction without excitation.
    pub fn efficiency(&self, design: &Design, shares: &[f64]) -> f64 {
        let value = self.value(shares, &mut CovariancePoint::default());
        value.map_or(0.0, |value| ((value - design.log_det) / self.degree()).exp())
    }

    fn blocks(&self) -> impl Iterator<Item = Block<'_>> + '_ {
        let mut first = 0;
        self.information.blocks().zip(&self.roots).map(move |((n, range), root)| {
            first += n;
            Block { n, range, rows: first - n..first, root }
        })
    }

    /// Fills in covariance and inverse. `None` where the information is singular.
    fn invert(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<()> {
        self.information.sum(shares, &mut at.sums[0]);
        self.middle.sum(shares, &mut at.sums[1]);
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
            at.covariance.extend(congruence(n, &inverse, &at.sums[1][range]));
            at.inverse.extend(inverse);
        }
        Some(())
    }

    fn weighted_blocks(&self, at: &CovariancePoint) -> Vec<Vec<f64>> {
        self.blocks().map(|b| b.weighted(&at.covariance[b.range.clone()])).collect()
    }

    /// The variances of all rows at `shares`, nuisances included, per unit of experiment and without weights. `None` where
    /// the information is singular.
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
}

/// The rows of one block: `range` in the matrices, `rows` over all blocks; the root V of its weights, k × n.
struct Block<'a> {
    n: usize,
    range: Range<usize>,
    rows: Range<usize>,
    root: &'a [f64],
}

impl Block<'_> {
    /// Rows of the root.
    fn kept(&self) -> usize {
        self.root.len() / self.n.max(1)
    }

    /// V C Vᵀ, k × k.
    fn weighted(&self, matrix: &[f64]) -> Vec<f64> {
        let (n, k) = (self.n, self.kept());
        let mut half = vec![0.0; k * n];
        multiply(k, n, self.root, matrix, &mut half);
        let rows = |i: usize| &half[i * n..(i + 1) * n];
        let root = |j: usize| &self.root[j * n..(j + 1) * n];
        (0..k * k).map(|e| dot(rows(e / k), root(e % k))).collect()
    }

    /// Vᵀ K V, n × n.
    fn unweighted(&self, kept: &[f64]) -> Vec<f64> {
        let (n, k) = (self.n, self.kept());
        let mut half = vec![0.0; k * n];
        multiply(k, k, kept, self.root, &mut half);
        let mut out = vec![0.0; n * n];
        for (row, root) in half.chunks_exact(n).zip(self.root.chunks_exact(n)) {
            for (line, r) in out.chunks_exact_mut(n).zip(root).filter(|(_, r)| **r != 0.0) {
                line.iter_mut().zip(row).for_each(|(o, x)| *o += r * x);
            }
        }
        out
    }
}

/// A B of a rows × m and an m × n matrix; zeros in A cost nothing.
fn multiply(rows: usize, m: usize, a: &[f64], b: &[f64], out: &mut [f64]) {
    let n = out.len() / rows.max(1);
    for (line, left) in out.chunks_exact_mut(n.max(1)).zip(a.chunks_exact(m.max(1))) {
        for (factor, right) in left.iter().zip(b.chunks_exact(n.max(1))).filter(|(f, _)| **f != 0.0) {
            line.iter_mut().zip(right).for_each(|(o, r)| *o += factor * r);
        }
    }
}
