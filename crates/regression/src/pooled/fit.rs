use numerics::{product, times, transposed};

use super::Diagnosis;
use crate::MeanRemoval;
use crate::solve::Normal;

/// How parts are pooled into one estimate.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// No intercept, one per part (*batch*), or one for all (*complete*).
    pub removal: MeanRemoval,
    /// Regularisation towards a nominal model.
    pub prior: Option<Prior<'a>>,
    /// Largest condition index (see [`Diagnosis`]) that is accepted; infinite: any that can be solved. A prior
    /// determines every direction.
    pub most: f64,
}

/// Tikhonov regularisation: the estimate minimises ‖Âx − b̂‖² + s² ‖x − x₀‖², Â being the normal matrix with each row and
/// column divided by the root sum of squares of its centred instrument and regressor (its entries are correlations), x the
/// parameters times those of their regressors, x₀ the nominal ones.
#[derive(Clone, Copy, Debug)]
pub struct Prior<'a> {
    /// s: 0 is none, 0.03 mild; at infinity the estimate is the nominal model.
    pub strength: f64,
    /// The nominal parameters: surge, sway, yaw.
    pub nominal: &'a [f64],
}

/// The outcome for one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct DegreeFit {
    /// Whether there is an estimate, and if not, why.
    pub status: Status,
    /// The estimate.
    pub solution: Option<Solution>,
}

/// Whether a degree of freedom is identified.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// It is.
    Identified,
    /// No more samples than unknowns.
    TooShort,
    /// This parameter's regressor or instrument is constant, or the matrix singular to rounding.
    NotExcited(usize),
    /// Collinear beyond [`Options::most`].
    Collinear(Diagnosis),
    /// Every parameter is at a bound.
    Bounded,
    /// A search was requested and found no model.
    Unfound,
}

/// An estimate of one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// θ̂.
    pub theta: Vec<f64>,
    /// G with θ̂ = θ₀ + G (b − A θ₀), p × p row-major: A⁻¹ without a prior.
    pub gain: Vec<f64>,
    /// The intercept over all parts; 0 without one, the mean over the samples of all with one per part.
    pub intercept: f64,
}

/// θ̂ of surge, sway and yaw together, and their intercepts; `None` unless all have an estimate.
pub fn joined(solutions: [Option<&Solution>; 3]) -> Option<(Vec<f64>, [f64; 3])> {
    let [Some(surge), Some(sway), Some(yaw)] = solutions else { return None };
    let all = [surge, sway, yaw];
    Some((all.map(|s| s.theta.as_slice()).concat(), all.map(|s| s.intercept)))
}

/// θ̂ and G, or the parameter that is not excited.
pub(super) fn solve(normal: &Normal, prior: Option<(f64, &[f64])>) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let Some((strength, nominal)) = prior.filter(|(strength, _)| *strength > 0.0) else {
        return normal.solve();
    };
    let p = normal.b.len();
    let scaled = normal.regular_scaled();
    // (ÂᵀÂ + s² I) X = Âᵀ, then the scales are undone.
    let mut gain = transposed(p, &scaled);
    let mut square = product(p, &gain, &scaled);
    (0..p).for_each(|i| square[i * p + i] += strength * strength);
    numerics::solve(p, &mut square, &mut gain).ok_or(0_usize)?;
    for (k, entry) in gain.iter_mut().enumerate() {
        let size = normal.phi[k / p] * normal.zeta[k % p];
        *entry = if size > 0.0 { *entry / size } else { 0.0 };
    }
    let predicted = times(&normal.a, nominal);
    let missing: Vec<f64> = normal.b.iter().zip(predicted).map(|(b, predicted)| b - predicted).collect();
    let moved = times(&gain, &missing);
    Ok((nominal.iter().zip(moved).map(|(nominal, moved)| nominal + moved).collect(), gain))
}
