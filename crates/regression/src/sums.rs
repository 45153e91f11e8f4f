use std::collections::BTreeMap;
use std::ops::Range;

use numerics::{LANES, Lane, Number, Numbers};
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
        for (degree, other) in self.degrees.iter_mut().zip(&other.degrees) {
            add(&mut degree.a, &other.a);
            add(&mut degree.b, &other.b);
            add(&mut degree.instrument_squares, &other.instrument_squares);
            add(&mut degree.regressor_squares, &other.regressor_squares);
        }
    }
}

fn add(sum: &mut [f64], other: &[f64]) {
    sum.iter_mut().zip(other).for_each(|(a, b)| *a += b);
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

/// [`LANES`] runs of N samples side by side. All row-major. Data shared by the runs (`X` = `f64`) is one number per
/// entry instead of a lane; the results have the same bits.
#[derive(Clone, Copy, Debug)]
pub struct Batch<'a, X = Lane> {
    /// The model structure.
    pub model: &'a Model,
    /// Measured states u, v \[m/s\], r \[rad/s\]: (N+1) × 3.
    pub measured: &'a [Lane],
    /// The states that the instruments are evaluated at: (N+1) × 3. For instrumental variables those of a nominal
    /// simulation, for least squares the measured ones.
    pub instrument_states: &'a [X],
    /// Inputs and measured disturbances: N × exogenous.
    pub exogenous: &'a [X],
    /// Those that the instruments are evaluated with: N × exogenous. For least squares the above.
    pub instrument_exogenous: &'a [X],
    /// Per run, the first sample of each segment, ascending from 0.
    pub segments: [&'a [usize]; LANES],
}

/// A batch with its number type erased, so that passes are compiled here and not in every crate and test that calls them.
#[derive(Clone, Copy, Debug)]
pub(crate) enum AnyBatch<'a> {
    Lanes(Batch<'a, Lane>),
    Shared(Batch<'a, f64>),
}

/// The result of a pass over a batch of either kind, [`numerics::vectorized!`].
macro_rules! over_batch {
    ($any:expr, |$batch:ident| $pass:expr) => {
        match $any {
            $crate::sums::AnyBatch::Lanes($batch) => numerics::vectorized!($pass),
            $crate::sums::AnyBatch::Shared($batch) => numerics::vectorized!($pass),
        }
    };
}
pub(crate) use over_batch;

impl<'a> AnyBatch<'a> {
    /// The model structure.
    pub(crate) fn model(&self) -> &'a Model {
        match self {
            Self::Lanes(batch) => batch.model,
            Self::Shared(batch) => batch.model,
        }
    }
}

impl<'a, X: Number> Batch<'a, X> {
    /// This batch with its number type erased.
    pub(crate) fn any(&self) -> AnyBatch<'a> {
        let numbers =
            [self.instrument_states, self.exogenous, self.instrument_exogenous].map(|rows| X::numbers(rows));
        match numbers {
            [Numbers::Lanes(states), Numbers::Lanes(inputs), Numbers::Lanes(instruments)] => {
                AnyBatch::Lanes(self.of([states, inputs, instruments]))
            }
            [Numbers::Shared(states), Numbers::Shared(inputs), Numbers::Shared(instruments)] => {
                AnyBatch::Shared(self.of([states, inputs, instruments]))
            }
            _ => unreachable!("all are made of X"),
        }
    }

    /// This batch with its data as numbers of another type.
    fn of<Y>(&self, [instrument_states, exogenous, instrument_exogenous]: [&'a [Y]; 3]) -> Batch<'a, Y> {
        let Self { model, measured, segments, .. } = *self;
        Batch { model, measured, instrument_states, exogenous, instrument_exogenous, segments }
    }
}

impl<X> Batch<'_, X> {
    /// Number of regression pairs N.
    pub fn samples(&self) -> usize {
        self.measured.len() / 3 - 1
    }
}

/// Splits `range` into blocks of `N` samples: (first, count).
pub(crate) fn parts<const N: usize>(range: Range<usize>) -> impl Iterator<Item = (usize, usize)> {
    let end = range.end;
    range.step_by(N).map(move |k| (k, N.min(end - k)))
}

/// A group of samples that shares its intercepts: its first sample, and a constant per signal.
#[derive(Clone, Debug)]
pub(crate) struct Group {
    pub start: usize,
    pub constants: Vec<f64>,
}

/// The groups of every run.
pub(crate) type Groups<'a> = [&'a [Group]; LANES];

/// The groups' constants that hold at each of `N` samples, lane by lane.
pub(crate) struct Constants<'a, const N: usize> {
    groups: Groups<'a>,
    signals: Vec<[Lane; N]>,
    next: [usize; LANES],
    /// The next sample at which a constant changes.
    changes: usize,
}

impl<'a, const N: usize> Constants<'a, N> {
    pub(crate) fn new(groups: Groups<'a>, signals: usize) -> Self {
        Self { groups, signals: vec![[Lane::ZERO; N]; signals], next: [0; LANES], changes: 0 }
    }

    /// The constants of the samples from `k` on; called with ascending `k`.
    pub(crate) fn at(&mut self, k: usize) -> &[[Lane; N]] {
        if self.changes < k + N {
            self.changes = usize::MAX;
            (0..LANES).for_each(|lane| self.enter(k, lane));
        }
        &self.signals
    }

    /// The constants at the first of the samples `range`, and the end of their validity: after a multiple of `N`
    /// samples, or at the end of `range`, and zero beyond.
    pub(crate) fn over(&mut self, range: Range<usize>) -> (usize, &[[Lane; N]]) {
        self.at(range.start);
        if range.len() < N {
            self.signals.iter_mut().for_each(|signal| signal[range.len()..].fill(Lane::ZERO));
            return (range.end, &self.signals);
        }
        let whole = |samples: usize| samples / N * N;
        let same = whole(self.changes - range.start).max(N);
        (range.start + same.min(whole(range.len())), &self.signals)
    }

    fn enter(&mut self, k: usize, lane: usize) {
        let groups = self.groups[lane];
        // A group that began among the last samples applies to all of these.
        if let Some(i) = self.next[lane].checked_sub(1) {
            self.hold(lane, 0, &groups[i]);
        }
        while let Some(group) = groups.get(self.next[lane]).filter(|g| g.start < k + N) {
            self.hold(lane, group.start - k, group);
            self.next[lane] += 1;
            if group.start > k {
                self.changes = self.changes.min(k + N);
            }
        }
        if let Some(group) = groups.get(self.next[lane]) {
            self.changes = self.changes.min(group.start);
        }
    }

    /// Applies `group` to `lane` from sample `from` of these on.
    fn hold(&mut self, lane: usize, from: usize, group: &Group) {
        for (signal, value) in self.signals.iter_mut().zip(&group.constants) {
            signal[from..].iter_mut().for_each(|at| at[lane] = *value);
        }
    }
}
