use std::collections::BTreeMap;

use numerics::Number;
use refusal::Invalid;
use ship::model::{Degree, DegreeOfFreedom, Model};

/// Sums over regression pairs of all degrees of freedom. The sums of two data sets add to those of both.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Sums {
    /// Number of pairs N.
    pub samples: u64,
    /// Surge, sway, yaw.
    pub degrees: Vec<DegreeSums>,
}

/// Sums of one degree of freedom with p parameters; p̃ = p + 1.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct DegreeSums<X = f64> {
    /// A = Σ ζ̃ φ̃ᵀ, p̃ × p̃, row-major. The last row holds Σ φ, the last column Σ ζ, the corner N.
    pub a: Vec<X>,
    /// b = Σ ζ̃ Δy, p̃.
    pub b: Vec<X>,
    /// Σ ζ_i², p.
    pub instrument_squares: Vec<X>,
    /// Σ φ_i², p.
    pub regressor_squares: Vec<X>,
    /// The constraints on the parameters.
    pub known: Known,
}

/// The constraints on the parameters of a degree of freedom.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Known {
    /// Whether one of the terms is 1: then its parameter is the intercept, and no mean is removed.
    pub constant: bool,
    /// The bounds of estimates, by index; see [`ship::model::Degree::bounds`].
    pub bounds: BTreeMap<usize, [f64; 2]>,
}

impl Known {
    /// Of `degree`.
    pub fn of(degree: &Degree) -> Self {
        Self { constant: degree.constant().is_some(), bounds: degree.bounds.clone() }
    }
}

impl Sums {
    /// The sums of all `parts` together.
    pub fn total<'a>(parts: impl IntoIterator<Item = &'a Self>) -> Self {
        let mut whole = Self::default();
        parts.into_iter().for_each(|part| whole.merge(part));
        whole
    }

    /// Adds the sums of further data.
    pub fn merge(&mut self, other: &Self) {
        if self.degrees.is_empty() {
            self.clone_from(other);
            return;
        }
        self.samples += other.samples;
        for (own, other) in self.degrees.iter_mut().zip(&other.degrees) {
            add(&mut own.a, &other.a);
            add(&mut own.b, &other.b);
            add(&mut own.instrument_squares, &other.instrument_squares);
            add(&mut own.regressor_squares, &other.regressor_squares);
        }
    }
}

fn add(own: &mut [f64], other: &[f64]) {
    own.iter_mut().zip(other).for_each(|(a, b)| *a += b);
}

impl<X: Number> DegreeSums<X> {
    /// Sums over no samples, of `p` parameters.
    pub(crate) fn zero(p: usize) -> Self {
        let zeros = |count: usize| vec![X::ZERO; count];
        Self {
            a: zeros((p + 1) * (p + 1)),
            b: zeros(p + 1),
            instrument_squares: zeros(p),
            regressor_squares: zeros(p),
            known: Known::default(),
        }
    }

    /// Sums over no samples, of the parameters of `degree`.
    pub(crate) fn of(degree: &Degree) -> Self {
        Self { known: Known::of(degree), ..Self::zero(degree.terms.len()) }
    }

    /// Number of parameters p.
    pub fn parameters(&self) -> usize {
        self.instrument_squares.len()
    }

    /// Adds a sample: ζ and φ of p entries, the 1 that augments both, and Δy.
    #[inline(always)]
    pub(crate) fn add_sample(&mut self, zeta: &[X], phi: &[X], one: X, increment: X) {
        let p = zeta.len();
        for (i, z) in zeta.iter().enumerate() {
            self.add_row(i, *z, phi, one, increment);
        }
        self.add_row(p, one, phi, one, increment);
        for i in 0..p {
            self.instrument_squares[i] += zeta[i] * zeta[i];
            self.regressor_squares[i] += phi[i] * phi[i];
        }
    }

    /// Adds entry `i` of ζ̃ times φ̃ and Δy.
    #[inline(always)]
    fn add_row(&mut self, i: usize, z: X, phi: &[X], one: X, increment: X) {
        let p = phi.len();
        let row = &mut self.a[i * (p + 1)..(i + 1) * (p + 1)];
        for (sum, f) in row.iter_mut().zip(phi) {
            *sum += z * *f;
        }
        row[p] += z * one;
        self.b[i] += z * increment;
    }
}

impl<X: Number> DegreeSums<X> {
    /// Σζ/N; zero without an intercept.
    pub(crate) fn instrument_means(&self, centred: bool) -> impl Iterator<Item = X> {
        let (p, share) = (self.parameters(), self.share(centred));
        (0..p).map(move |i| share * self.a[i * (p + 1) + p])
    }

    /// (ΣΔy − Σφᵀθ)/N; zero without an intercept.
    pub(crate) fn intercept(&self, theta: &[X], centred: bool) -> X {
        self.share(centred) * self.residual(theta)
    }

    /// ΣΔy − Σφᵀθ.
    pub(crate) fn residual(&self, theta: &[X]) -> X {
        let p = self.parameters();
        let mut predicted = X::ZERO;
        theta.iter().zip(&self.a[p * (p + 1)..]).for_each(|(t, f)| predicted += *t * *f);
        self.b[p] - predicted
    }

    /// 1/N, or zero if no mean is removed.
    pub(crate) fn share(&self, centred: bool) -> X {
        let n = self.a.last().copied().unwrap_or(X::ZERO);
        if !centred || self.known.constant {
            return X::ZERO;
        }
        X::ONE.each(n, |one, n| if n > 0.0 { one / n } else { 0.0 })
    }
}

impl DegreeSums {
    /// Σφ and, last, ΣΔy.
    pub(crate) fn end(&self) -> impl Iterator<Item = f64> {
        let p = self.parameters();
        self.a[p * (p + 1)..].iter().take(p).chain(&self.b[p..]).copied()
    }
}

refusal::choices! {
    /// How the instruments' mean is removed: how many intercepts a degree of freedom has, none, one per segment or
    /// one.
    pub enum MeanRemoval {
        /// Not at all.
        None = "none",
        /// Segment by segment.
        Batch = "batch",
        /// Over the whole experiment.
        Complete = "complete",
    }
}

impl MeanRemoval {
    /// Refuses an intercept per segment if `model` has a term 1: the constant cannot be distinguished from them.
    ///
    /// # Errors
    /// Names the parameter.
    pub fn check(self, model: &Model) -> Result<(), Invalid> {
        let constant = DegreeOfFreedom::ALL.into_iter().find_map(|d| {
            let degree = &model.degrees[d as usize];
            degree.constant().map(|i| (d, &degree.parameters[i]))
        });
        match constant.filter(|_| self == Self::Batch) {
            None => Ok(()),
            Some((d, name)) => Err(Invalid::new(
                format!("parameter `{name}`"),
                format!("the term `1` in {} beside an intercept for every segment", d.name()),
                "one intercept: instruments without their mean over each segment see no constant",
                "take --mean-removal complete or none, or remove the term",
            )),
        }
    }
}
