use crate::solve::Normal;
use crate::{MeanRemoval, Sums};

/// What is subtracted from instruments and regressors of each part: means over all parts, over the part, or nothing.
#[derive(Clone, Debug)]
pub struct Centring {
    removal: MeanRemoval,
    parts: Vec<[Means; 3]>,
}

/// Means of one degree of freedom.
#[derive(Clone, Debug, Default)]
struct Means {
    zeta: Vec<f64>,
    phi: Vec<f64>,
    target: f64,
}

impl Centring {
    /// Of parts with these sums.
    pub fn new(parts: &[&Sums], removal: MeanRemoval) -> Self {
        let means = match removal {
            MeanRemoval::Batch => parts.iter().map(|sums| means(sums, true)).collect(),
            _ => {
                let whole = Sums::total(parts.iter().copied());
                vec![means(&whole, removal == MeanRemoval::Complete); usize::from(!parts.is_empty())]
            }
        };
        Self { removal, parts: means }
    }

    /// Number of intercepts of a degree of freedom.
    pub fn intercepts(&self) -> usize {
        if self.removal == MeanRemoval::None { 0 } else { self.parts.len() }
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

fn means(sums: &Sums, removed: bool) -> [Means; 3] {
    let share = if removed && sums.samples > 0 { 1.0 / sums.samples as f64 } else { 0.0 };
    [0, 1, 2].map(|d| {
        let degree = &sums.degrees[d];
        let (p, lifted) = (degree.parameters(), degree.parameters() + 1);
        Means {
            zeta: (0..p).map(|i| share * degree.a[i * lifted + p]).collect(),
            phi: (0..p).map(|i| share * degree.a[p * lifted + i]).collect(),
            target: share * degree.b[p],
        }
    })
}

/// The normal equations of degree of freedom `d`. One intercept for all parts needs the sums of all together.
pub(super) fn pooled(parts: &[&Sums], removal: MeanRemoval, d: usize) -> Normal {
    if removal == MeanRemoval::Batch {
        return Normal::new(parts.iter().map(|sums| &sums.degrees[d]), true);
    }
    let whole = Sums::total(parts.iter().copied());
    Normal::new([&whole.degrees[d]].into_iter(), removal == MeanRemoval::Complete)
}
