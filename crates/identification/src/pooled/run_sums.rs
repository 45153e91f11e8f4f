use super::delivered::Ranges;
use super::{Covered, DegreeRegression, Expansion, LostInstruments, NoEstimate, NominalModel, Parts, Pool};
use crate::{DegreeSums, Estimator, Known, Sums};

/// Sums over the sub-experiments of some runs that add to those of others without rounding: an estimate from them does not
/// depend on how the runs were dealt, nor on the order.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct RunSums {
    /// Number of sub-experiments.
    pub parts: u64,
    /// Regression pairs.
    pub samples: u64,
    /// Surge, sway, yaw.
    pub degrees: [Products; 3],
    /// What the data covered: states, inputs, measured disturbances.
    pub covered: Vec<Covered>,
}

/// Σ w wᵀ of one degree of freedom with p parameters, w = (ζ, φ, Δy, 1) of 2p + 2 entries: the upper triangle, row by row. The
/// products of a sub-experiment are added up as they come, sub-experiments without rounding.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Products(pub Vec<Expansion>);

impl Products {
    /// How many there are with `p` parameters.
    pub fn count(p: usize) -> usize {
        (p + 1) * (2 * p + 3)
    }

    /// Adds a sub-experiment.
    fn add(&mut self, part: &DegreeRegression) {
        let mut own = vec![0.0; Self::count(part.parameters)];
        let mut row = Vec::with_capacity(2 * part.parameters + 2);
        for (k, target) in part.target.iter().enumerate() {
            row.clear();
            row.extend_from_slice(part.zeta(k));
            row.extend_from_slice(part.phi(k));
            row.extend([*target, 1.0]);
            let pairs = row.iter().enumerate().flat_map(|(i, a)| row[i..].iter().map(move |b| a * b));
            own.iter_mut().zip(pairs).for_each(|(sum, product)| *sum += product);
        }
        self.0.resize_with(own.len(), Expansion::default);
        self.0.iter_mut().zip(own).for_each(|(sum, own)| sum.add(own));
    }

    /// The sums, each rounded once; none where one is too large for a number.
    pub(super) fn rounded(&self, p: usize) -> Option<Rounded> {
        let sums: Vec<f64> = self.0.iter().map(Expansion::value).collect();
        (sums.len() == Self::count(p) && sums.iter().all(|sum| sum.is_finite()))
            .then_some(Rounded { p, sums })
    }
}

impl RunSums {
    /// Adds the sums of other runs.
    pub fn merge(&mut self, other: &Self) {
        self.parts = self.parts.saturating_add(other.parts);
        self.samples = self.samples.saturating_add(other.samples);
        for (own, other) in self.degrees.iter_mut().zip(&other.degrees) {
            own.0.resize_with(other.0.len(), Expansion::default);
            own.0.iter_mut().zip(&other.0).for_each(|(own, other)| own.merge(other));
        }
        if self.covered.is_empty() {
            self.covered.clone_from(&other.covered);
        }
        for (own, other) in self.covered.iter_mut().zip(&other.covered) {
            (own.low, own.high) = (own.low.min(other.low), own.high.max(other.high));
        }
    }
}

/// [`Products`], rounded.
pub(super) struct Rounded {
    p: usize,
    sums: Vec<f64>,
}

/// Where instruments, regressors and, from the end, Δy and 1 stand in w.
#[derive(Clone, Copy)]
pub(super) enum Entry {
    Zeta(usize),
    Phi(usize),
    Increment,
    One,
}

impl Rounded {
    /// The sum of products of two entries.
    pub fn at(&self, a: Entry, b: Entry) -> f64 {
        let place = |entry: Entry| match entry {
            Entry::Zeta(i) => i,
            Entry::Phi(i) => self.p + i,
            Entry::Increment => 2 * self.p,
            Entry::One => 2 * self.p + 1,
        };
        let (i, j) = (place(a).min(place(b)), place(a).max(place(b)));
        let width = 2 * self.p + 2;
        self.sums[i * width - i * (i + 1) / 2 + j]
    }

    /// The sums of estimates with these entries as instruments.
    pub fn sums(&self, instrument: fn(usize) -> Entry, known: Known) -> DegreeSums {
        let p = self.p;
        let lifted = |i: usize, of: fn(usize) -> Entry| if i < p { of(i) } else { Entry::One };
        let square = |of: fn(usize) -> Entry| (0..p).map(|i| self.at(of(i), of(i))).collect();
        let pair = |k: usize| self.at(lifted(k / (p + 1), instrument), lifted(k % (p + 1), Entry::Phi));
        DegreeSums {
            a: (0..(p + 1) * (p + 1)).map(pair).collect(),
            b: (0..=p).map(|i| self.at(lifted(i, instrument), Entry::Increment)).collect(),
            instrument_squares: square(instrument),
            regressor_squares: square(Entry::Phi),
            known,
        }
    }
}

impl Pool<'_> {
    /// The sums of `parts`, for [`Estimator::Ls`] with the regressors as instruments, else with those of the nominal model,
    /// which must be known: parts are gone through once.
    ///
    /// # Errors
    /// The nominal simulation diverges; parts that cannot be read.
    pub fn run_sums<P: Parts>(
        &self,
        parts: &P,
        estimator: Estimator,
    ) -> Result<RunSums, NoEstimate<P::Error>> {
        let simulated = match &self.nominal {
            NominalModel::Known(theta) if estimator.by_instruments() => {
                Some(self.model.layout().woven(theta, [0.0; 3]))
            }
            _ => None,
        };
        let (mut sums, mut ranges) = (RunSums::default(), Ranges::new(&self.vessel.model));
        let mut lost: Option<LostInstruments> = None;
        parts
            .each(|part| match self.regression(&part, simulated.as_deref()) {
                _ if lost.is_some() => {}
                Err(diverged) => lost = Some(diverged),
                Ok((regression, _)) => {
                    sums.parts += 1;
                    sums.samples += regression.samples as u64;
                    sums.degrees.iter_mut().zip(&regression.degrees).for_each(|(own, part)| own.add(part));
                    ranges.add(&part.run);
                }
            })
            .map_err(NoEstimate::Unread)?;
        sums.covered = ranges.covered();
        lost.map_or(Ok(sums), |lost| Err(NoEstimate::Lost(lost)))
    }
}

/// The sums of all degrees of freedom.
pub(super) fn whole(degrees: impl Iterator<Item = DegreeSums>, samples: u64) -> Sums {
    Sums { samples, degrees: degrees.collect() }
}
