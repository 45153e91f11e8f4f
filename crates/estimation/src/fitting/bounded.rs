//! What priors and bounds do to a search for θ.

use ship::forces::Forces;

use crate::fitting::Prior;

/// Squares of the distances of θ from its priors, in their deviations.
pub(crate) fn distance(theta: &[f64], priors: &[Option<Prior>]) -> f64 {
    let square = |(own, prior): (&f64, &Option<Prior>)| {
        prior.map_or(0.0, |prior| ((own - prior.mean) / prior.deviation).powi(2))
    };
    theta.iter().zip(priors).map(square).sum()
}

/// What the prior of each of θ adds to the second and to the first derivative of half the cost, where the squares of distances
/// are multiplied by `weight`.
pub(crate) fn pulls(theta: &[f64], priors: &[Option<Prior>], weight: f64) -> Vec<[f64; 2]> {
    let pull = |(own, prior): (&f64, &Option<Prior>)| {
        let Some(prior) = prior else { return [0.0; 2] };
        let pull = weight / (prior.deviation * prior.deviation);
        [pull, pull * (own - prior.mean)]
    };
    theta.iter().zip(priors).map(pull).collect()
}

/// Which of θ lie at a bound that the cost pushes them to.
pub(crate) fn held(forces: &Forces, theta: &[f64], gradient: &[f64]) -> Vec<bool> {
    let own = |((own, gradient), parameter): ((&f64, &f64), &ship::forces::Parameter)| {
        let [low, high] = parameter.bounds;
        (*own <= low && *gradient > 0.0) || (*own >= high && *gradient < 0.0)
    };
    theta.iter().zip(gradient).zip(forces.parameters()).map(own).collect()
}

/// θ after `steps` of those at the places `free`, within their bounds.
pub(crate) fn moved(
    forces: &Forces,
    theta: &[f64],
    free: &[usize],
    steps: impl Iterator<Item = f64>,
) -> Vec<f64> {
    let mut next = theta.to_vec();
    for (i, step) in free.iter().zip(steps) {
        let [low, high] = forces.parameters()[*i].bounds;
        next[*i] = (next[*i] + step).clamp(low, high);
    }
    next
}
