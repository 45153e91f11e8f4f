use std::ops::Range;

use numerics::{add_rows, dot, product, transposed};
use thiserror::Error;

/// Candidate information matrices that do not define a design problem.
#[derive(Clone, Debug, Error, PartialEq)]
pub enum Error {
    /// A candidate whose number of entries differs from that of the blocks.
    #[error("a candidate with {found} entries, expected {expected}")]
    Shape {
        /// Entries given.
        found: usize,
        /// Entries that the blocks have together.
        expected: usize,
    },
    /// An entry that is not finite.
    #[error("candidate {candidate} has an entry that is not finite")]
    NotFinite {
        /// Its index.
        candidate: usize,
    },
    /// There is no candidate.
    #[error("no candidate")]
    Empty,
    /// No mixture of the candidates excites a direction.
    #[error("no candidate excites a direction of block {block}: {direction:?}")]
    Unexcited {
        /// Index of the block.
        block: usize,
        /// The direction, in rows scaled to size one.
        direction: Vec<f64>,
    },
    /// A singular covariance, so that its criterion is not defined.
    #[error("row {row} of block {block} has no variance of its own")]
    SingularCovariance {
        /// Index of the block.
        block: usize,
        /// Dominant row of the block in the direction without variance.
        row: usize,
    },
    /// A weight that is negative or not finite.
    #[error("weight {found} of row {row}")]
    Weight {
        /// Index of the row over all blocks.
        row: usize,
        /// The weight.
        found: f64,
    },
    /// An upper bound that is negative or not a number.
    #[error("bound {found} of candidate {candidate}")]
    Bound {
        /// Index of the candidate.
        candidate: usize,
        /// The bound.
        found: f64,
    },
    /// Upper bounds without shares that sum to 1.
    #[error("the bounds sum to {total}")]
    Infeasible {
        /// Their sum.
        total: f64,
    },
    /// The solver failed.
    #[error("the solver failed: {0}")]
    Solver(String),
}

/// Information matrices of all candidates, one row-major matrix per block, side by side.
#[derive(Clone, Debug)]
pub struct Candidates {
    dimensions: Vec<usize>,
    entries: Vec<f64>,
}

/// Candidates with rows and columns divided by factors.
pub(crate) struct Balanced {
    pub candidates: Candidates,
    /// log|det| of the original less that of the balanced ones.
    pub offset: f64,
    /// One factor per row over all blocks.
    pub rows: Vec<f64>,
    /// One factor per column over all blocks.
    pub columns: Vec<f64>,
}

/// Buffers for evaluating the criterion, reused over evaluations.
#[derive(Clone, Debug, Default)]
pub struct Evaluation {
    /// Σ_b log|det M_b(w)|.
    pub log_det: f64,
    /// (M_b(w)⁻¹)ᵀ per block, so that g_q is a dot product.
    pub inverse_transposed: Vec<f64>,
    pub(crate) sum: Vec<f64>,
    pub(crate) inverse: Vec<f64>,
}

impl Candidates {
    /// No candidates yet; `dimensions` are the rows of each block.
    pub fn new(dimensions: Vec<usize>) -> Self {
        Self { dimensions, entries: Vec::new() }
    }

    /// Appends a candidate: all blocks' entries, row-major, one block after the other.
    ///
    /// # Errors
    /// [`Error::Shape`], [`Error::NotFinite`].
    pub fn push(&mut self, entries: &[f64]) -> Result<(), Error> {
        if entries.len() != self.size() {
            return Err(Error::Shape { found: entries.len(), expected: self.size() });
        }
        if !entries.iter().all(|x| x.is_finite()) {
            return Err(Error::NotFinite { candidate: self.len() });
        }
        self.entries.extend_from_slice(entries);
        Ok(())
    }

    /// No candidates, with the same dimensions.
    pub(crate) fn none(&self) -> Self {
        Self::new(self.dimensions.clone())
    }

    /// Appends a candidate with the same dimensions and finite entries.
    pub(crate) fn append(&mut self, entries: &[f64]) {
        self.entries.extend_from_slice(entries);
    }

    /// Number of candidates Q.
    pub fn len(&self) -> usize {
        self.entries.len() / self.size().max(1)
    }

    /// Whether there is no candidate.
    pub fn is_empty(&self) -> bool {
        self.entries.is_empty()
    }

    /// Total dimension p: the sum of the blocks' rows.
    pub fn dimension(&self) -> usize {
        self.dimensions.iter().sum()
    }

    /// Entries per candidate.
    pub fn size(&self) -> usize {
        self.dimensions.iter().map(|n| n * n).sum()
    }

    /// Entries of candidate `q`.
    pub fn candidate(&self, q: usize) -> &[f64] {
        &self.entries[q * self.size()..(q + 1) * self.size()]
    }

    /// Per block: its rows n and the range of its entries.
    pub fn blocks(&self) -> impl Iterator<Item = (usize, Range<usize>)> + '_ {
        let mut start = 0;
        self.dimensions.iter().map(move |n| {
            start += n * n;
            (*n, start - n * n..start)
        })
    }

    /// M(w) = Σ_q w_q M_q into `out`.
    pub fn sum(&self, shares: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.resize(self.size(), 0.0);
        add_rows(out, &self.entries, shares);
    }

    /// Scales rows and columns so that the mean candidate has rows and columns of size one, and returns log|det| of
    /// the original less that of the scaled ones. Shares and sensitivities do not change.
    ///
    /// # Errors
    /// [`Error::Empty`]; [`Error::Unexcited`] for a row that is zero in every candidate.
    pub fn scaled(&self) -> Result<(Self, f64), Error> {
        self.balanced().map(|balanced| (balanced.candidates, balanced.offset))
    }

    /// [`Candidates::scaled`] with the factors of rows and columns.
    pub(crate) fn balanced(&self) -> Result<Balanced, Error> {
        if self.is_empty() {
            return Err(Error::Empty);
        }
        let ones = vec![1.0; self.dimension()];
        let mut out = Balanced { candidates: self.clone(), offset: 0.0, rows: ones.clone(), columns: ones };
        for by_row in [true, false, true] {
            let mut first = 0;
            for (block, (n, range)) in self.blocks().enumerate() {
                let norms = out.candidates.root_mean_squares(n, range.clone(), by_row);
                if let Some(zero) = norms.iter().position(|norm| *norm == 0.0) {
                    let direction = (0..n).map(|j| f64::from(u8::from(zero == j))).collect();
                    return Err(Error::Unexcited { block, direction });
                }
                let factors = if by_row { &mut out.rows } else { &mut out.columns };
                for (factor, norm) in factors[first..].iter_mut().zip(&norms) {
                    out.offset += libm::log(*norm);
                    *factor *= norm;
                }
                let of = |e: usize| norms[if by_row { e / n } else { e % n }];
                out.candidates.divide(range, &(0..n * n).map(of).collect::<Vec<_>>());
                first += n;
            }
        }
        Ok(out)
    }

    /// Every entry divided by the factors of its row and of its column.
    pub(crate) fn congruent(&self, factors: &[f64]) -> Self {
        let mut out = self.clone();
        let mut first = 0;
        for (n, range) in self.blocks() {
            let of = |e: usize| factors[first + e / n] * factors[first + e % n];
            out.divide(range, &(0..n * n).map(of).collect::<Vec<_>>());
            first += n;
        }
        out
    }

    /// Refuses balanced candidates whose equal mixture does not excite a direction.
    pub(crate) fn check_excitation(&self) -> Result<(), Error> {
        let mut sum = Vec::new();
        self.sum(&vec![1.0 / self.len() as f64; self.len()], &mut sum);
        for (block, (n, range)) in self.blocks().enumerate() {
            // Rows belong to regressors: an unexcited combination of them is a left singular direction.
            let mixture = &sum[range];
            if numerics::condition(n, mixture) < 1e9 {
                continue;
            }
            let direction = match numerics::weakest(n, &transposed(n, mixture)) {
                Some(weakest) if weakest.ratio > 1e-12 => continue,
                Some(weakest) => weakest.direction,
                None => vec![1.0; n],
            };
            return Err(Error::Unexcited { block, direction });
        }
        Ok(())
    }

    /// Root mean squares over all candidates of every row or every column of the block of n rows in `range`.
    fn root_mean_squares(&self, n: usize, range: Range<usize>, by_row: bool) -> Vec<f64> {
        let mut squares = vec![0.0; n];
        let mut sums = vec![0.0; n];
        for entries in self.entries.chunks_exact(self.size()) {
            sums.fill(0.0);
            for (i, row) in entries[range.clone()].chunks_exact(n).enumerate() {
                for (j, entry) in row.iter().enumerate() {
                    sums[if by_row { i } else { j }] += entry * entry;
                }
            }
            squares.iter_mut().zip(&sums).for_each(|(all, sum)| *all += sum);
        }
        squares.iter().map(|square| (square / self.len() as f64).sqrt()).collect()
    }

    /// Divides the entries in `range` of every candidate by those of `by`.
    fn divide(&mut self, range: Range<usize>, by: &[f64]) {
        let size = self.size();
        for entries in self.entries.chunks_exact_mut(size) {
            entries[range.clone()].iter_mut().zip(by).for_each(|(entry, by)| *entry /= by);
        }
    }
}

/// The objective, maximised over shares: a function Φ of the mixture of candidates with Φ(tw) = Φ(w) + degree · log
/// t, so that Σ_q w_q g_q is the degree.
pub trait Objective {
    /// The value and the workspace of the derivatives, reused over evaluations.
    type Point: Default;

    /// Number of candidates Q.
    fn len(&self) -> usize;

    /// Whether there is no candidate.
    fn is_empty(&self) -> bool {
        self.len() == 0
    }

    /// Σ_q w_q g_q at any shares.
    fn degree(&self) -> f64;

    /// Numbers per candidate: no optimal support needs more shares between their bounds.
    fn size(&self) -> usize;

    /// Exponent of multiplicative steps w_q ← w_q g_q^κ.
    fn exponent(&self) -> f64;

    /// Φ(w), and the workspace of the derivatives. `None` if it is not defined.
    fn evaluate(&self, shares: &[f64], at: &mut Self::Point) -> Option<f64>;

    /// Φ(w) alone. `None` if it is not defined.
    fn value(&self, shares: &[f64], at: &mut Self::Point) -> Option<f64>;

    /// g_q = ∂Φ/∂w_q at an evaluated point.
    fn sensitivity(&self, q: usize, at: &Self::Point) -> f64;

    /// g_q of all candidates.
    fn sensitivities(&self, at: &Self::Point) -> Vec<f64> {
        (0..self.len()).map(|q| self.sensitivity(q, at)).collect()
    }

    /// −∂²Φ/∂w_q∂w_r at an evaluated point, members × members, row-major.
    fn curvature(&self, members: &[usize], at: &Self::Point) -> Vec<f64>;
}

/// The D-criterion of the information matrix, Σ_b log|det M_b(w)|.
impl Objective for Candidates {
    type Point = Evaluation;

    fn len(&self) -> usize {
        Self::len(self)
    }

    fn degree(&self) -> f64 {
        self.dimension() as f64
    }

    fn size(&self) -> usize {
        Self::size(self)
    }

    fn exponent(&self) -> f64 {
        1.0
    }

    fn evaluate(&self, shares: &[f64], at: &mut Evaluation) -> Option<f64> {
        self.sum(shares, &mut at.sum);
        at.inverse.resize(self.size(), 0.0);
        at.inverse_transposed.clear();
        at.log_det = 0.0;
        let mut regular = true;
        for (n, range) in self.blocks() {
            match numerics::inverse_and_log_det(n, &mut at.sum[range.clone()], &mut at.inverse[range.clone()])
            {
                Some(det) => at.log_det += det.log_abs,
                None => regular = false,
            }
            at.inverse_transposed.extend(transposed(n, &at.inverse[range]));
        }
        regular.then_some(at.log_det)
    }

    fn value(&self, shares: &[f64], at: &mut Evaluation) -> Option<f64> {
        self.sum(shares, &mut at.sum);
        let mut sum = 0.0;
        for (n, range) in self.blocks() {
            sum += numerics::log_det(n, &mut at.sum[range])?.log_abs;
        }
        Some(sum)
    }

    /// g_q = Σ_b tr(M_b(w)⁻¹ M_q,b).
    fn sensitivity(&self, q: usize, at: &Evaluation) -> f64 {
        dot(&at.inverse_transposed, self.candidate(q))
    }

    /// Σ_b tr(M⁻¹ M_q M⁻¹ M_r).
    fn curvature(&self, members: &[usize], at: &Evaluation) -> Vec<f64> {
        let (mut products, mut turned) = (Vec::new(), Vec::new());
        for q in members {
            let entries = self.candidate(*q);
            for (n, range) in self.blocks() {
                let inverse = transposed(n, &at.inverse_transposed[range.clone()]);
                let relative = product(n, &inverse, &entries[range]);
                turned.extend(transposed(n, &relative));
                products.extend(relative);
            }
        }
        let rows = || products.chunks_exact(self.size());
        let columns = || turned.chunks_exact(self.size());
        rows().flat_map(|row| columns().map(|column| dot(row, column))).collect()
    }
}
