use std::ops::Range;

use crate::certificate::{is_concave, row_scaling};
use crate::product::{congruence, dot, product, transposed};
use crate::spectrum::Spectrum;
use crate::{Candidates, Design, Error, Objective};

/// What of a covariance matrix is made small.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Norm {
    /// log det: D-optimality.
    LogDet,
    /// log (Σ λ_i^s)^(1/s) over the eigenvalues of all blocks: s = 1 is A-optimality, E-optimality is approached as s
    /// grows and lies between this and this less log(number of eigenvalues)/s.
    PowerMean(f64),
}

/// A criterion of the covariance A(w)⁻¹ B(w) A(w)⁻ᵀ, A(w) = Σ w_q M_qᵀ, B(w) = Σ w_q B_q, one block of parameters after
/// the other. As an [`Objective`] it is minus the [`Norm`] of the weighted covariance.
#[derive(Clone, Debug)]
pub struct Covariance {
    information: Candidates,
    middle: Candidates,
    /// √weight of every row in balanced units; 0 for a nuisance such as an intercept.
    scale: Vec<f64>,
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
        if weights.len() != information.dimension() || middle.len() != information.len() {
            return Err(Error::Shape { found: weights.len(), expected: information.dimension() });
        }
        if let Some(row) = weights.iter().position(|w| !(w.is_finite() && *w >= 0.0)) {
            return Err(Error::Weight { row, found: weights[row] });
        }
        let balanced = information.balanced()?;
        balanced.candidates.check_excitation()?;
        let middle = middle.congruent(&balanced.columns);
        let root = |(w, row): (&f64, &f64)| match norm {
            Norm::LogDet => f64::from(u8::from(*w > 0.0)),
            Norm::PowerMean(_) => w.sqrt() / row,
        };
        let scale: Vec<f64> = weights.iter().zip(&balanced.rows).map(root).collect();
        let offset = match norm {
            Norm::LogDet => weights
                .iter()
                .zip(&balanced.rows)
                .map(|(w, r)| if *w > 0.0 { -2.0 * r.ln() } else { 0.0 })
                .sum(),
            Norm::PowerMean(_) => 0.0,
        };
        let concave = is_proportional(&balanced.candidates, &middle);
        let built = Self {
            information: balanced.candidates,
            middle,
            scale,
            rows: balanced.rows,
            norm,
            offset,
            concave,
        };
        built.check_covariance()?;
        Ok(built)
    }

    /// The same with another norm of the same kind of weights.
    pub(crate) fn with_power(&self, power: f64) -> Self {
        Self { norm: Norm::PowerMean(power), ..self.clone() }
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

    /// Number of weighted rows: eigenvalues of the weighted covariance.
    pub fn eigenvalues(&self) -> usize {
        self.scale.iter().filter(|s| **s > 0.0).count()
    }

    /// What fraction of the experiment's time the shares of `design`, solved for this criterion, need for what `shares`
    /// give; 0 where these leave a direction without excitation.
    pub fn efficiency(&self, design: &Design, shares: &[f64]) -> f64 {
        let value = self.value(shares, &mut CovariancePoint::default());
        value.map_or(0.0, |value| ((value - design.log_det) / self.degree()).exp())
    }

    fn blocks(&self) -> impl Iterator<Item = Block> + '_ {
        let mut first = 0;
        self.information.blocks().map(move |(n, range)| {
            first += n;
            let rows = first - n..first;
            let kept = (0..n).filter(|i| self.scale[rows.start + i] > 0.0).collect();
            Block { n, range, rows, kept }
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
            small_matrix::inverse(n, &mut at.sums[0][range.clone()], &mut inverse)?;
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

    /// The weighted covariance of a block's kept rows.
    fn weighted(&self, block: &Block, matrix: &[f64]) -> Vec<f64> {
        let scale = |i: usize| self.scale[block.rows.start + i];
        let pairs = block.kept.iter().flat_map(|i| block.kept.iter().map(move |j| (*i, *j)));
        pairs.map(|(i, j)| scale(i) * scale(j) * matrix[block.range.start + i * block.n + j]).collect()
    }

    /// The transpose of [`Covariance::weighted`]: back to all rows of a block.
    fn unweighted(&self, block: &Block, kept: &[f64]) -> Vec<f64> {
        let scale = |i: usize| self.scale[block.rows.start + i];
        let mut out = vec![0.0; block.n * block.n];
        for (a, i) in block.kept.iter().enumerate() {
            for (b, j) in block.kept.iter().enumerate() {
                out[i * block.n + j] = scale(*i) * scale(*j) * kept[a * block.kept.len() + b];
            }
        }
        out
    }

    fn weighted_blocks(&self, at: &CovariancePoint) -> Vec<Vec<f64>> {
        self.blocks().map(|b| self.weighted(&b, &at.covariance)).collect()
    }

    /// Refuses a dictionary whose equal mixture gives a weighted direction no variance (or, for a mean of eigenvalues, none
    /// at all).
    fn check_covariance(&self) -> Result<(), Error> {
        let count = self.information.len();
        let mut at = CovariancePoint::default();
        self.invert(&vec![1.0 / count as f64; count], &mut at)
            .ok_or_else(|| Error::Solver("equal shares are singular".into()))?;
        let weighted = self.weighted_blocks(&at);
        let nothing = weighted.iter().flatten().all(|c| *c == 0.0);
        for (index, (block, matrix)) in self.blocks().zip(&weighted).enumerate() {
            let k = block.kept.len();
            if k == 0 || (self.norm != Norm::LogDet && !nothing) {
                continue;
            }
            // In correlations, so that units do not count.
            let size = |i: usize| matrix[i * k + i].max(0.0).sqrt();
            let zero = (0..k).find(|i| size(*i) == 0.0);
            let direction = match zero {
                Some(i) => (0..k).map(|j| f64::from(u8::from(i == j))).collect(),
                None => {
                    let correlation: Vec<f64> =
                        (0..k * k).map(|e| matrix[e] / (size(e / k) * size(e % k))).collect();
                    match small_matrix::weakest(k, &correlation) {
                        Some(found) if found.ratio > 1e-12 => continue,
                        Some(found) => found.direction,
                        None => vec![1.0; k],
                    }
                }
            };
            let strongest =
                (0..k).max_by(|a: &usize, b| f64::abs(direction[*a]).total_cmp(&f64::abs(direction[*b])));
            return Err(Error::SingularCovariance { block: index, row: block.kept[strongest.unwrap_or(0)] });
        }
        Ok(())
    }

    /// The variances of all rows at `shares`, nuisances included, per unit of experiment and without weights. `None` where
    /// the information is singular.
    pub fn variances(&self, shares: &[f64]) -> Option<Vec<f64>> {
        let mut at = CovariancePoint::default();
        self.invert(shares, &mut at)?;
        let of = |block: Block| {
            let unit = |i: usize| self.rows[block.rows.start + i].powi(2);
            let diagonal = |i: usize| at.covariance[block.range.start + i * block.n + i] / unit(i);
            (0..block.n).map(diagonal).collect::<Vec<_>>()
        };
        Some(self.blocks().flat_map(of).collect())
    }
}

struct Block {
    n: usize,
    range: Range<usize>,
    rows: Range<usize>,
    kept: Vec<usize>,
}

impl Objective for Covariance {
    type Point = CovariancePoint;

    fn len(&self) -> usize {
        self.information.len()
    }

    fn degree(&self) -> f64 {
        match self.norm {
            Norm::LogDet => self.eigenvalues() as f64,
            Norm::PowerMean(_) => 1.0,
        }
    }

    fn size(&self) -> usize {
        self.information.size()
    }

    fn exponent(&self) -> f64 {
        match self.norm {
            Norm::LogDet => 1.0,
            Norm::PowerMean(_) => 0.5,
        }
    }

    fn value(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<f64> {
        self.invert(shares, at)?;
        let weighted = self.weighted_blocks(at);
        Some(-self.offset - crate::spectrum::value(self.norm, &weighted)?)
    }

    fn evaluate(&self, shares: &[f64], at: &mut CovariancePoint) -> Option<f64> {
        self.invert(shares, at)?;
        let spectrum = Spectrum::of(self.norm, self.weighted_blocks(at))?;
        at.slopes.iter_mut().for_each(Vec::clear);
        for (block, slope) in self.blocks().zip(spectrum.slopes()) {
            let n = block.n;
            let inverse = &at.inverse[block.range.clone()];
            let weight = self.unweighted(&block, &slope);
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
        dot(&at.slopes[0], self.information.candidate(q)) + dot(&at.slopes[1], self.middle.candidate(q))
    }

    fn curvature(&self, members: &[usize], at: &CovariancePoint) -> Vec<f64> {
        let first: Vec<f64> = members.iter().map(|q| -self.sensitivity(*q, at)).collect();
        let mut moved: Vec<Vec<Vec<f64>>> = Vec::new();
        let k = members.len();
        let mut curvature = vec![0.0; k * k];
        for (block, slope) in self.blocks().zip(at.spectrum.slopes()) {
            let weight = self.unweighted(&block, &slope);
            let changes: Vec<Change> = members.iter().map(|q| self.change(&block, &weight, *q, at)).collect();
            for (q, a) in changes.iter().enumerate() {
                for (r, b) in changes.iter().enumerate() {
                    let mixed = dot(&b.weighted, &a.pulled)
                        + dot(&a.weighted, &b.pulled)
                        + dot(&a.twisted, &b.relative);
                    curvature[q * k + r] += 2.0 * mixed;
                }
            }
            moved.push(changes.into_iter().map(|c| c.covariance).collect());
        }
        at.spectrum.add_curvature(&moved, &first, &mut curvature);
        curvature
    }
}

/// How the covariance of a block changes with one candidate's share: U = A⁻¹ A_q, V = A⁻¹ B_q A⁻ᵀ.
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
    fn change(&self, block: &Block, weight: &[f64], q: usize, at: &CovariancePoint) -> Change {
        let n = block.n;
        let inverse = &at.inverse[block.range.clone()];
        let covariance = &at.covariance[block.range.clone()];
        let information = transposed(n, &self.information.candidate(q)[block.range.clone()]);
        let relative = product(n, inverse, &information);
        let middle = congruence(n, inverse, &self.middle.candidate(q)[block.range.clone()]);
        let weighted = product(n, weight, &relative);
        let twisted = product(n, &weighted, covariance);
        let turned = product(n, &relative, covariance);
        let pulled = (0..n * n).map(|e| turned[(e % n) * n + e / n] - middle[e]).collect();
        let mut whole = vec![0.0; block.range.end];
        for e in 0..n * n {
            whole[block.range.start + e] = middle[e] - turned[e] - turned[(e % n) * n + e / n];
        }
        Change { relative, weighted, twisted, pulled, covariance: self.weighted(block, &whole) }
    }
}

/// Whether every B_q is one multiple, per block, of the information in symmetric form.
fn is_proportional(information: &Candidates, middle: &Candidates) -> bool {
    if !is_concave(information) {
        return false;
    }
    information.blocks().all(|(n, range)| {
        let matrices = (0..information.len()).map(|q| &information.candidate(q)[range.clone()]);
        let Some(factors) = row_scaling(n, matrices) else { return false };
        // A D with A = Mᵀ: instrument i is d_i times regressor i.
        let symmetric = |q: usize| -> Vec<f64> {
            let m = &information.candidate(q)[range.clone()];
            (0..n * n).map(|e| factors[e / n] * m[e]).collect()
        };
        let (mut own, mut cross, mut total) = (0.0, 0.0, 0.0);
        for q in 0..information.len() {
            let (s, b) = (symmetric(q), &middle.candidate(q)[range.clone()]);
            own += dot(&s, &s);
            cross += dot(&s, b);
            total += dot(b, b);
        }
        let factor = cross / own;
        let left: f64 = (0..information.len())
            .map(|q| {
                let (s, b) = (symmetric(q), &middle.candidate(q)[range.clone()]);
                s.iter().zip(b).map(|(s, b)| (b - factor * s).powi(2)).sum::<f64>()
            })
            .sum();
        factor > 0.0 && left <= 1e-18 * total
    })
}
