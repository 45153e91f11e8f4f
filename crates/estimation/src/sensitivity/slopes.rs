use numerics::{LANES, Lane};

use super::dynamics::Dynamics;
use super::recordings::Recordings;

/// Squared errors of a free simulation, and their gradient by the unknowns.
#[derive(Clone, Debug, PartialEq)]
pub struct Slopes {
    /// Σ e² of u, v, r.
    pub squares: [f64; 3],
    /// Σ_d w_d Σ s_d e_d, an entry per free unknown.
    pub gradient: Vec<f64>,
}

/// The gradient for `recordings` simulated with `unknowns`, per lane, by the unknowns in `free`. `weights` is called
/// with lane and squared errors, `path` is a buffer for the states. Sample 0 counts where `from_start`. One adjoint, λ(k) = Aᵀλ(k+1) + W e(k), replaces
/// all sensitivities: a parameter's entry is Σ φ(k) λ(k+1).
pub fn slopes(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    from_start: bool,
    weights: impl Fn(usize, [f64; 3]) -> [f64; 3],
    path: &mut Vec<[Lane; 3]>,
) -> Vec<Slopes> {
    let (model, first) = (recordings.model, usize::from(!from_start));
    let theta = &unknowns[..model.parameters()];
    let dynamics = Dynamics::new(model, theta, None);
    let (squares, gradient) =
        numerics::vectorized!(narrow: there_and_back(dynamics, recordings, unknowns, first, weights, path));
    let own = |lane: usize| Slopes {
        squares: squares.map(|sum| sum[lane]),
        gradient: free.iter().map(|i| gradient[*i][lane]).collect(),
    };
    (0..LANES).map(own).collect()
}

/// Squared errors and their gradient by every unknown, by a forward and a backward pass. Samples count from `first`
/// on.
#[inline(always)]
fn there_and_back(
    mut dynamics: Dynamics<Lane, 3>,
    recordings: &Recordings,
    unknowns: &[Lane],
    first: usize,
    weights: impl Fn(usize, [f64; 3]) -> [f64; 3],
    path: &mut Vec<[Lane; 3]>,
) -> ([Lane; 3], Vec<Lane>) {
    let (layout, last) = (recordings.model.layout(), recordings.longest());
    let (all, degrees) = (layout.parameters(), [0, 1, 2].map(|d| layout.degree(d)));
    let even = recordings.samples.iter().all(|samples| *samples == last);
    let counted = |k: usize, z: [Lane; 3]| {
        let error = recordings.error(k, z);
        if even { error } else { error.map(|e| e * recordings.lasting(k)) }
    };
    let mut z = [0, 1, 2].map(|d: usize| recordings.initial[d] + unknowns[all + d]);
    path.clear();
    path.reserve(last + 1);
    let mut squares = [Lane::ZERO; 3];
    for k in 0..=last {
        path.push(z);
        if k >= first {
            let error = counted(k, z);
            for d in 0..3 {
                squares[d] = error[d].fused(error[d], squares[d]);
            }
        }
        if k < last {
            z = dynamics.step(z, recordings.exogenous(k));
        }
    }
    let by_lane: [[f64; 3]; LANES] = std::array::from_fn(|lane| weights(lane, squares.map(|sum| sum[lane])));
    let weights = [0, 1, 2].map(|d: usize| Lane(by_lane.map(|own| own[d])));
    let mut gradient = vec![Lane::ZERO; all + 3];
    let mut adjoint = [Lane::ZERO; 3];
    for (k, z) in path.iter().enumerate().rev() {
        if k < last {
            let local = dynamics.at(z, recordings.exogenous(k));
            for d in 0..3 {
                for i in degrees[d].clone() {
                    gradient[i] = dynamics.term(i).fused(adjoint[d], gradient[i]);
                }
            }
            adjoint = dynamics.backward(&local, &adjoint);
        }
        if k >= first {
            let error = counted(k, *z);
            for d in 0..3 {
                adjoint[d] += weights[d] * error[d];
            }
        }
    }
    gradient[all..].copy_from_slice(&adjoint);
    (squares, gradient)
}
