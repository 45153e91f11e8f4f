use std::sync::Arc;

use super::fit::{diagnosed, unknown};
use super::{DegreeFit, Diagnosis, Options, Solution, Status, joined};
use crate::solve::{Normal, NormalSums, estimated};
use crate::{MeanRemoval, Sums};

/// The sums of many parts that an estimate needs; little is stored per part.
#[derive(Clone, Debug)]
pub struct PooledSums {
    removal: MeanRemoval,
    /// Of all parts.
    total: Sums,
    /// Number of parts.
    parts: usize,
    /// Per part, surge, sway and yaw: Σ φ and Σ Δy, from which residuals are summed.
    ends: Vec<f64>,
    /// With an intercept per part: the means of each part, and the normal equations of all.
    batch: Option<(AllMeans, [NormalSums; 3])>,
}

impl PooledSums {
    /// Sums of no parts; `removal` says which parts share an intercept.
    pub fn new(removal: MeanRemoval) -> Self {
        let batch = (removal == MeanRemoval::Batch).then(Default::default);
        Self { removal, total: Sums::default(), parts: 0, ends: Vec::new(), batch }
    }

    /// The sums of all `parts`.
    pub fn of<'a>(parts: impl IntoIterator<Item = &'a Sums>, removal: MeanRemoval) -> Self {
        let mut pooled = Self::new(removal);
        parts.into_iter().for_each(|part| pooled.add(part));
        pooled
    }

    /// Adds a part.
    pub fn add(&mut self, part: &Sums) {
        self.total.merge(part);
        self.parts += 1;
        if self.removal != MeanRemoval::None {
            self.ends.extend(part.degrees.iter().flat_map(|degree| degree.end()));
        }
        if let Some((means, normals)) = &mut self.batch {
            Arc::make_mut(means).push(Means::of(part, true));
            normals.iter_mut().zip(&part.degrees).for_each(|(normal, degree)| normal.add(degree, true));
        }
    }

    /// The sums of all parts together.
    pub fn total(&self) -> &Sums {
        &self.total
    }

    /// Number of parts.
    pub fn parts(&self) -> usize {
        self.parts
    }

    /// The means that are subtracted from instruments and regressors.
    pub fn centring(&self) -> Centring {
        let means = match &self.batch {
            Some((means, _)) => Arc::clone(means),
            None if self.parts == 0 => Arc::default(),
            None => Arc::new(vec![Means::of(&self.total, self.removal == MeanRemoval::Complete)]),
        };
        Centring::of(self.removal, means)
    }

    /// Number of intercepts of degree of freedom `d`.
    fn intercepts(&self, d: usize) -> usize {
        match self.removal {
            _ if self.has_constant(d) => 0,
            MeanRemoval::None => 0,
            MeanRemoval::Batch => self.parts,
            MeanRemoval::Complete => self.parts.min(1),
        }
    }

    /// Whether the intercept of degree of freedom `d` is the parameter of a term 1.
    fn has_constant(&self, d: usize) -> bool {
        self.total.degrees.get(d).is_some_and(|degree| degree.known.constant)
    }

    /// The normal equations of degree of freedom `d`.
    fn normal(&self, d: usize) -> Normal {
        match &self.batch {
            Some((_, normals)) => normals[d].clone().finish(),
            None => {
                let degrees = [&self.total.degrees[d]];
                Normal::new(degrees.into_iter(), self.removal == MeanRemoval::Complete)
            }
        }
    }

    /// How means are removed.
    pub fn removal(&self) -> MeanRemoval {
        self.removal
    }

    /// Estimates surge, sway and yaw.
    pub fn fit(&self, options: &Options) -> [DegreeFit; 3] {
        let mut first = 0;
        [0, 1, 2].map(|d| {
            let p = self.total.degrees.get(d).map_or(0, |degree| degree.parameters());
            let range = first..first + p;
            first += p;
            if self.total.samples <= (p + self.intercepts(d)) as u64 {
                return DegreeFit { status: Status::TooShort, solution: None };
            }
            let prior = options.prior.map(|prior| (prior.strength, &prior.nominal[range]));
            match super::fit::solve(&self.normal(d), prior) {
                Err(parameter) => DegreeFit { status: Status::NotExcited(parameter), solution: None },
                Ok((theta, gain)) => self.judged(options, d, theta, gain),
            }
        })
    }

    fn judged(&self, options: &Options, d: usize, theta: Vec<f64>, gain: Vec<f64>) -> DegreeFit {
        if options.most.is_finite() && options.prior.is_none() {
            let diagnosis = self.diagnose(d);
            if diagnosis.index > options.most {
                return DegreeFit { status: Status::Collinear(diagnosis), solution: None };
            }
        }
        let bounded = !self.total.degrees[d].known.bounds.is_empty();
        if bounded && estimated(theta.len(), |k| gain[k]) == 0 {
            return DegreeFit { status: Status::Bounded, solution: None };
        }
        let intercept = self.mean_residual(d, &theta);
        DegreeFit { status: Status::Identified, solution: Some(Solution { theta, gain, intercept }) }
    }

    /// Diagnoses degree of freedom `d`.
    pub fn diagnose(&self, d: usize) -> Diagnosis {
        if self.parts == 0 {
            return unknown(0);
        }
        diagnosed(&self.total, &self.normal(d), self.removal, d)
    }

    /// Mean of Δy − φᵀθ over all samples, summed part by part; 0 without intercepts.
    fn mean_residual(&self, d: usize, theta: &[f64]) -> f64 {
        if self.removal == MeanRemoval::None || self.total.samples == 0 || self.has_constant(d) {
            return 0.0;
        }
        let lengths: Vec<usize> = self.total.degrees.iter().map(|degree| degree.b.len()).collect();
        let (first, whole) = (lengths[..d].iter().sum::<usize>(), lengths.iter().sum::<usize>());
        let mut total = 0.0;
        for end in self.ends.chunks_exact(whole) {
            let (phi, target) = end[first..first + lengths[d]].split_at(lengths[d] - 1);
            total += target[0] - theta.iter().zip(phi).map(|(t, f)| t * f).sum::<f64>();
        }
        total / self.total.samples as f64
    }
}

/// Pools `parts` and estimates surge, sway and yaw.
pub fn fit(parts: &[&Sums], options: &Options) -> [DegreeFit; 3] {
    PooledSums::of(parts.iter().copied(), options.removal).fit(options)
}

/// Diagnoses degree of freedom `d` of pooled `parts`.
pub fn diagnose(parts: &[&Sums], removal: MeanRemoval, d: usize) -> Diagnosis {
    PooledSums::of(parts.iter().copied(), removal).diagnose(d)
}

impl Centring {
    /// Of parts with these sums.
    pub fn new(parts: &[&Sums], removal: MeanRemoval) -> Self {
        PooledSums::of(parts.iter().copied(), removal).centring()
    }
}

/// The means that are subtracted from instruments and regressors of each part: over all parts, over the part, or none.
#[derive(Clone, Debug)]
pub struct Centring {
    removal: MeanRemoval,
    parts: AllMeans,
}

/// The means of every part, or of all together.
pub(super) type AllMeans = Arc<Vec<[Means; 3]>>;

/// Means of one degree of freedom.
#[derive(Clone, Debug, Default)]
pub(super) struct Means {
    zeta: Vec<f64>,
    phi: Vec<f64>,
    target: f64,
    /// Whether a term 1 is the intercept.
    constant: bool,
    /// Whether some parameters are bounded.
    bounded: bool,
}

impl Centring {
    /// From the means of every part, or of all together.
    pub(super) fn of(removal: MeanRemoval, parts: AllMeans) -> Self {
        Self { removal, parts }
    }

    /// Number of unknowns of degree of freedom `d`: intercepts, and those of `p` parameters that are not at a bound,
    /// by the `gain` of their estimate.
    pub(super) fn unknowns(&self, d: usize, gain: &[f64], p: usize) -> usize {
        let is = |of: fn(&Means) -> bool| self.parts.first().is_some_and(|means| of(&means[d]));
        let parameters = if is(|means| means.bounded) { estimated(p, |k| gain[k]) } else { p };
        let none = self.removal == MeanRemoval::None || is(|means| means.constant);
        parameters + if none { 0 } else { self.parts.len() }
    }

    fn at(&self, part: usize, d: usize) -> &Means {
        let group = if self.removal == MeanRemoval::Batch { part } else { 0 };
        &self.parts[group][d]
    }

    /// `row` of the instruments of part `part` without their means.
    pub fn zeta(&self, part: usize, d: usize, row: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(row.iter().zip(&self.at(part, d).zeta).map(|(z, mean)| z - mean));
    }

    /// `row` of the regressors of part `part` without their means.
    pub fn phi(&self, part: usize, d: usize, row: &[f64], out: &mut Vec<f64>) {
        out.clear();
        out.extend(row.iter().zip(&self.at(part, d).phi).map(|(f, mean)| f - mean));
    }

    /// The intercept that goes with `theta` in part `part`: mean of Δy − φᵀθ.
    pub fn intercept(&self, part: usize, d: usize, theta: &[f64]) -> f64 {
        let means = self.at(part, d);
        means.target - means.phi.iter().zip(theta).map(|(f, t)| f * t).sum::<f64>()
    }
}

impl Means {
    /// Of surge, sway and yaw in `sums`; of instruments and regressors 0 where they are not `removed`.
    pub(super) fn of(sums: &Sums, removed: bool) -> [Self; 3] {
        [0, 1, 2].map(|d| {
            let degree = &sums.degrees[d];
            let removed = removed && sums.samples > 0 && !degree.known.constant;
            let share = if removed { 1.0 / sums.samples as f64 } else { 0.0 };
            let (p, lifted) = (degree.parameters(), degree.parameters() + 1);
            Self {
                zeta: (0..p).map(|i| share * degree.a[i * lifted + p]).collect(),
                phi: (0..p).map(|i| share * degree.a[p * lifted + i]).collect(),
                target: share * degree.b[p],
                constant: degree.known.constant,
                bounded: !degree.known.bounds.is_empty(),
            }
        })
    }
}

refusal::choices! {
    /// Where the model comes from that instruments are simulated with.
    pub enum NominalSource {
        /// The nominal values of the vessel.
        Given = "given",
        /// The least-squares fit of the same data.
        LeastSquares = "least-squares",
        /// A previous estimate.
        Estimate = "estimate",
    }
}

/// The model that instruments are simulated with: known, or to be fitted to the data that is used.
#[derive(Clone, Debug, PartialEq)]
pub enum NominalModel {
    /// θ: surge, sway, yaw; the model has its own intercepts.
    Known(Vec<f64>),
    /// The least-squares fit.
    Fitted,
}

impl NominalModel {
    /// θ and intercepts, with the least-squares `sums` of the data that is used. `None` if those identify no model.
    pub fn parameters(&self, sums: &PooledSums) -> Option<(Vec<f64>, [f64; 3])> {
        match self {
            Self::Known(theta) => Some((theta.clone(), [0.0; 3])),
            Self::Fitted => {
                let options = Options { removal: sums.removal(), prior: None, most: f64::INFINITY };
                joined(sums.fit(&options).each_ref().map(|degree| degree.solution.as_ref()))
            }
        }
    }
}
