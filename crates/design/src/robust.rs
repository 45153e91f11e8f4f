use crate::{Covariance, CovariancePoint, Error, Objective};

/// How criteria of several models become one.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Over {
    /// The mean of the logarithms.
    Mean,
    /// The worst model's, approached by −log(mean exp(−s Φ))/s: within log(models)/s of it.
    Worst(f64),
}

/// A criterion of the covariance over several models of the same candidates: concave where every model's is.
#[derive(Clone, Debug)]
pub struct Robust {
    models: Vec<Covariance>,
    over: Over,
}

/// What an evaluation leaves for the derivatives: every model's, and the weight of each.
#[derive(Clone, Debug, Default)]
pub struct RobustPoint {
    models: Vec<CovariancePoint>,
    weights: Vec<f64>,
}

impl Robust {
    /// `models`: of the same candidates, with the same norm.
    ///
    /// # Errors
    /// [`Error::Empty`] without a model; [`Error::Shape`] where they have different numbers of candidates.
    pub fn new(models: Vec<Covariance>, over: Over) -> Result<Self, Error> {
        let first = models.first().ok_or(Error::Empty)?;
        match models.iter().find(|m| m.len() != first.len() || m.degree() != first.degree()) {
            Some(other) => Err(Error::Shape { found: other.len(), expected: first.len() }),
            None => Ok(Self { models, over }),
        }
    }

    /// Whether it is proved concave.
    pub fn is_concave(&self) -> bool {
        self.models.iter().all(Covariance::is_concave)
    }

    /// The models' criteria at `shares`, each as [`Objective::value`]; minus infinity where one is not defined.
    pub fn values(&self, shares: &[f64]) -> Vec<f64> {
        let of =
            |m: &Covariance| m.value(shares, &mut CovariancePoint::default()).unwrap_or(f64::NEG_INFINITY);
        self.models.iter().map(of).collect()
    }

    /// By how much its value may be above what it stands for.
    pub fn excess(&self) -> f64 {
        match self.over {
            Over::Mean => 0.0,
            Over::Worst(sharpness) => (self.models.len() as f64).ln() / sharpness,
        }
    }

    /// Smoother ones that lead to this one.
    pub(crate) fn approach(&self) -> Vec<Self> {
        let Over::Worst(sharpness) = self.over else { return Vec::new() };
        let steps = [1.0, 10.0, 100.0, 1e3, 1e4, 1e5].into_iter().filter(|s| *s < sharpness);
        steps.map(|s| Self { models: self.models.clone(), over: Over::Worst(s) }).collect()
    }

    /// The value over all models, and the weight of each in the gradient.
    fn combine(&self, values: &[f64]) -> (f64, Vec<f64>) {
        let count = values.len() as f64;
        match self.over {
            Over::Mean => (values.iter().sum::<f64>() / count, vec![1.0 / count; values.len()]),
            Over::Worst(sharpness) => {
                let least = values.iter().copied().fold(f64::INFINITY, f64::min);
                let parts: Vec<f64> = values.iter().map(|v| (-sharpness * (v - least)).exp()).collect();
                let sum: f64 = parts.iter().sum();
                (least - (sum / count).ln() / sharpness, parts.iter().map(|p| p / sum).collect())
            }
        }
    }

    fn each(
        &self,
        at: &mut RobustPoint,
        mut value: impl FnMut(&Covariance, &mut CovariancePoint) -> Option<f64>,
    ) -> Option<f64> {
        at.models.resize_with(self.models.len(), CovariancePoint::default);
        let values: Option<Vec<f64>> =
            self.models.iter().zip(&mut at.models).map(|(model, at)| value(model, at)).collect();
        let (value, weights) = self.combine(&values?);
        at.weights = weights;
        Some(value)
    }
}

impl Objective for Robust {
    type Point = RobustPoint;

    fn len(&self) -> usize {
        self.models[0].len()
    }

    fn degree(&self) -> f64 {
        self.models[0].degree()
    }

    fn size(&self) -> usize {
        self.models[0].size() * self.models.len()
    }

    fn exponent(&self) -> f64 {
        self.models[0].exponent()
    }

    fn evaluate(&self, shares: &[f64], at: &mut RobustPoint) -> Option<f64> {
        self.each(at, |model, at| model.evaluate(shares, at))
    }

    fn value(&self, shares: &[f64], at: &mut RobustPoint) -> Option<f64> {
        self.each(at, |model, at| model.value(shares, at))
    }

    fn sensitivity(&self, q: usize, at: &RobustPoint) -> f64 {
        let of = |(m, (at, weight)): (&Covariance, (&CovariancePoint, &f64))| weight * m.sensitivity(q, at);
        self.models.iter().zip(at.models.iter().zip(&at.weights)).map(of).sum()
    }

    fn curvature(&self, members: &[usize], at: &RobustPoint) -> Vec<f64> {
        let k = members.len();
        let mut curvature = vec![0.0; k * k];
        let mut gradients = Vec::with_capacity(self.models.len());
        for (model, (at, weight)) in self.models.iter().zip(at.models.iter().zip(&at.weights)) {
            let own = model.curvature(members, at);
            curvature.iter_mut().zip(&own).for_each(|(c, o)| *c += weight * o);
            gradients.push(members.iter().map(|q| model.sensitivity(*q, at)).collect::<Vec<f64>>());
        }
        let Over::Worst(sharpness) = self.over else { return curvature };
        let mean = |i: usize| gradients.iter().zip(&at.weights).map(|(g, w)| w * g[i]).sum::<f64>();
        let means: Vec<f64> = (0..k).map(mean).collect();
        for (gradient, weight) in gradients.iter().zip(&at.weights) {
            let apart = |i: usize| gradient[i] - means[i];
            for (e, entry) in curvature.iter_mut().enumerate() {
                *entry += sharpness * weight * apart(e / k) * apart(e % k);
            }
        }
        curvature
    }
}
