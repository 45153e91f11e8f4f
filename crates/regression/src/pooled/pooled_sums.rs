use std::sync::Arc;

use super::centre::{AllMeans, Means};
use super::diagnosis::{diagnosed, unknown};
use super::{Centring, DegreeFit, Diagnosis, Options, Solution, Status};
use crate::bounded::estimated;
use crate::solve::{Normal, NormalSums};
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
                let own = [&self.total.degrees[d]];
                Normal::new(own.into_iter(), self.removal == MeanRemoval::Complete)
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
            let own = first..first + p;
            first += p;
            if self.total.samples <= (p + self.intercepts(d)) as u64 {
                return DegreeFit { status: Status::TooShort, solution: None };
            }
            let prior = options.prior.map(|prior| (prior.strength, &prior.nominal[own]));
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
