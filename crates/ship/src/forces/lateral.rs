//! Sums of derivatives along what was sailed: what a free run knows of sway and yaw.

use crate::forces::Forces;

/// A sum of terms of one order in sway or yaw, where v is the same multiple of r L throughout. It is linear in θ.
#[derive(Clone, Debug, PartialEq)]
pub struct LateralSum {
    /// 1 for sway, 2 for yaw.
    pub degree: usize,
    /// 1 for linear terms, 3 for cubic ones.
    pub order: u32,
    /// By what each of θ counts in it, in the prime system.
    pub weights: Vec<f64>,
    /// What known numbers add.
    pub known: f64,
}

impl LateralSum {
    /// The sum with parameters `theta`.
    pub fn of(&self, theta: &[f64]) -> f64 {
        self.known + numerics::dot(&self.weights, theta)
    }
}

impl Forces {
    /// The sums of linear, quadratic and cubic terms in sway and yaw where v is `drift` r L, with a yaw rate of 1 in the prime
    /// system. Those of fewer than two free numbers are left out.
    pub fn lateral_sums(&self, drift: f64) -> Vec<LateralSum> {
        let orders = [1, 2].into_iter().flat_map(|degree| (1..=3).map(move |order| (degree, order)));
        let all = orders.map(|(degree, order)| self.lateral_sum(degree, order, drift));
        all.filter(|own| own.weights.iter().filter(|weight| **weight != 0.0).count() > 1).collect()
    }

    fn lateral_sum(&self, degree: usize, order: u32, drift: f64) -> LateralSum {
        let of = |theta: &[f64]| -> f64 {
            let numbers = self.numbers.with(theta);
            let terms = self.terms[degree].iter().filter_map(|own| own.lateral(&numbers, drift));
            terms.filter(|own| own.0 == order).map(|own| own.1).sum()
        };
        let count = self.parameters().len();
        let known = of(&vec![0.0; count]);
        let weight = |i: usize| {
            let unit: Vec<f64> = (0..count).map(|k| f64::from(u8::from(k == i))).collect();
            of(&unit) - known
        };
        LateralSum { degree, order, weights: (0..count).map(weight).collect(), known }
    }
}
