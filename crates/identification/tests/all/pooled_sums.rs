//! Estimates from sums of runs that were dealt in any way.

use std::collections::BTreeMap;

use crate::pooled_again::runs;
use crate::pooled_laws::craft;
use approx::assert_relative_eq;
use identification::pooled::{
    Judgement, NominalModel, Part, Pool, Pooled, PooledRuns, Resampling, RunSums, estimate, estimate_merged,
};
use identification::runs::Beside;
use identification::{Estimator, MeanRemoval};
use numerics::congruence;
use vessel::Vessel;

fn pool(vessel: &Vessel, removal: MeanRemoval) -> Pool<'_> {
    Pool {
        vessel,
        model: vessel.model.with_intercepts(),
        removal,
        strength: 0.0,
        nominal: NominalModel::Known(vessel.nominal.clone()),
        part_samples: Some(40),
        beside: Beside::default(),
        constant: Vec::new(),
    }
}

/// The estimate from the sums of these runs, group by group.
fn merged(pool: &Pool, estimator: Estimator, groups: &[&[usize]]) -> Pooled {
    let all = runs(pool.vessel);
    let mut whole = RunSums::default();
    for group in groups {
        let some = PooledRuns::new(group.iter().map(|i| all[*i].clone()).collect(), &BTreeMap::new());
        whole.merge(&pool.run_sums(&some.cut(pool.part_samples), estimator).unwrap());
    }
    estimate_merged(pool, estimator, &whole, "measured").unwrap()
}

/// ζ, φ and Δy of a pair.
type Row<'a> = (&'a [f64], &'a [f64], f64);

const FORTH: &[&[usize]] = &[&[0, 1, 2, 3, 4, 5, 6, 7]];

#[test]
fn law_sums_of_runs_give_the_estimate_of_all_in_any_order() {
    let vessel = craft();
    let all = PooledRuns::new(runs(&vessel), &BTreeMap::new());
    let judgement = Judgement { bandwidth: None, replicates: 0, seed: 1 };
    for removal in [MeanRemoval::Complete, MeanRemoval::None] {
        for estimator in [Estimator::Ls, Estimator::Iv] {
            let pool = pool(&vessel, removal);
            let expected = estimate(&pool, &all, estimator, &judgement, Resampling::Given(&[])).unwrap();
            let found = merged(&pool, estimator, FORTH);
            for groups in [&[&[7, 3, 5][..], &[0], &[6, 2, 1, 4]][..], &[&[4, 2], &[1, 0, 7], &[3, 6, 5]]] {
                // Written out, so that every digit counts.
                assert_eq!(format!("{:?}", merged(&pool, estimator, groups)), format!("{found:?}"));
            }
            // Instruments that are simulated leave the first pair of each part out.
            let first = if estimator == Estimator::Iv { expected.parts } else { 0 };
            let pairs = expected.samples - first as u64;
            assert_eq!((found.parts, found.samples), (expected.parts, pairs));
            for (own, other) in found.degrees.iter().zip(&expected.degrees) {
                assert_relative_eq!(own.condition.unwrap(), other.condition.unwrap(), max_relative = 1e-8);
                assert_eq!((&own.weakest, own.estimator), (&other.weakest, other.estimator));
                for (a, b) in own.parameters.iter().zip(&other.parameters) {
                    assert_relative_eq!(a.estimate.unwrap(), b.estimate.unwrap(), max_relative = 1e-9);
                    assert_relative_eq!(a.variation, b.variation, max_relative = 1e-9);
                    let strength = [a, b].map(|p| p.instrument_strength.unwrap());
                    assert_relative_eq!(strength[0], strength[1], max_relative = 1e-6);
                }
            }
            let (own, other) = (found.delivered.unwrap(), expected.delivered.unwrap());
            (0..3).for_each(|d| assert_relative_eq!(own.constant[d], other.constant[d], epsilon = 1e-9));
            assert_eq!(format!("{:?}", own.covered), format!("{:?}", other.covered));
            assert!(found.statements[0].contains("white residuals"));
        }
    }
}

/// A C Aᵀ = σ̂² Σζᶜζᶜᵀ with residuals taken one by one, so that nothing is inverted.
#[test]
fn law_covariances_of_merged_sums_are_those_of_white_residuals() {
    let vessel = craft();
    let all: Vec<Part> = PooledRuns::new(runs(&vessel), &BTreeMap::new()).parts(Some(40));
    for (removal, intercepts) in [(MeanRemoval::Complete, 1), (MeanRemoval::None, 0)] {
        let pool = pool(&vessel, removal);
        let found = merged(&pool, Estimator::Iv, FORTH).delivered.unwrap();
        let model = pool.model.layout().woven(&vessel.nominal, [0.0; 3]);
        let regressions: Vec<_> =
            all.iter().map(|part| pool.regression(&part.whole(), Some(&model)).unwrap().0).collect();
        let (covariance, layout) = (found.covariance.unwrap().entries, vessel.model.layout());
        let count = vessel.model.parameters();
        for d in 0..3 {
            let (own, p) = (layout.terms(d), layout.terms(d).len());
            let rows = || {
                let degrees = regressions.iter().map(move |r| &r.degrees[d]);
                degrees.flat_map(|r| (0..r.target.len()).map(move |k| (r.zeta(k), r.phi(k), r.target[k])))
            };
            let n = rows().count() as f64;
            let mean = |of: &dyn Fn(&Row) -> f64| {
                if intercepts == 1 { rows().map(|row| of(&row)).sum::<f64>() / n } else { 0.0 }
            };
            let zeta: Vec<f64> = (0..p).map(|i| mean(&|row| row.0[i])).collect();
            let (mut a, mut middle, mut squares) = (vec![0.0; p * p], vec![0.0; p * p], 0.0);
            for (z, phi, target) in rows() {
                let gained = phi.iter().zip(&found.theta[own.clone()]).map(|(f, t)| f * t).sum::<f64>();
                squares += (target - gained - (found.constant[d] - vessel.model.constant[d])).powi(2);
                for k in 0..p * p {
                    a[k] += (z[k / p] - zeta[k / p]) * phi[k % p];
                    middle[k] += (z[k / p] - zeta[k / p]) * (z[k % p] - zeta[k % p]);
                }
            }
            let variance = squares / (n - (p + intercepts) as f64);
            let entry = |k: usize| covariance[(own.start + k / p) * count + own.start + k % p];
            let told = congruence(p, &a, &(0..p * p).map(entry).collect::<Vec<_>>());
            for k in 0..p * p {
                let size = variance * (middle[k / p * (p + 1)] * middle[k % p * (p + 1)]).sqrt();
                assert_relative_eq!(told[k], variance * middle[k], epsilon = 1e-7 * size);
            }
            assert_relative_eq!(found.increment_std[d], (squares / n).sqrt(), max_relative = 1e-7);
        }
    }
}
