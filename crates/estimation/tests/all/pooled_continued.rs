//! Searches whose start diverges, and estimates that do not simulate.

use std::collections::BTreeMap;

use estimation::pooled::{Judgement, Pool, Resampling, estimate};
use estimation::{EstimateStatus, Estimator};
use regression::pooled::{Part, PooledRuns};
use ship::model::Vessel;

use crate::support::craft::{craft_file, part, runs};
use crate::support::noise::Normals;

fn craft() -> Vessel {
    Vessel::from_file(craft_file()).unwrap()
}

/// An unstable craft: its damping has the wrong sign.
fn runaway() -> Vessel {
    let mut file = craft_file();
    for spec in [&mut file.surge, &mut file.sway, &mut file.yaw].into_iter().flatten() {
        if ["u", "v", "r"].contains(&spec.term.as_str()) {
            spec.nominal = Some(0.6);
        }
    }
    Vessel::from_file(file).unwrap()
}

/// Two hundred samples each.
fn parts(noise: bool) -> Vec<Part> {
    let (vessel, mut normals) = (craft(), Normals::new(33));
    (0..4).map(|i| part(&vessel, 200, i, &mut normals, noise)).collect()
}

const JUDGEMENT: Judgement = Judgement { replicates: 0, seed: 1 };

#[test]
fn law_a_search_whose_start_diverges_finds_the_minimum_that_it_finds_from_elsewhere() {
    let (near, far, parts) = (craft(), runaway(), parts(true));
    let found = |pool: &Pool| {
        let found = pool.estimate(&parts, Estimator::OutputError).unwrap_or_else(|_| panic!("no estimate"));
        assert_eq!((found.used, &found.unfound), ([Estimator::OutputError; 3], &None));
        found.parameters(&pool.model).unwrap()
    };
    // A dominating prior keeps the start of the search at an unstable craft.
    let (expected, continued) = (found(&Pool::new(&near)), found(&Pool { strength: 1e9, ..Pool::new(&far) }));
    for (a, b) in expected.iter().zip(&continued) {
        assert!((a - b).abs() <= 1e-3 * a.abs().max(1e-3), "{a} {b}");
    }
}

#[test]
fn what_does_not_simulate_is_not_identified_and_no_model_is_delivered() {
    let (far, runs) = (runaway(), PooledRuns::new(runs(&parts(true)), &BTreeMap::new()));
    let of = |strength: f64| {
        estimate(
            &Pool { strength, ..Pool::new(&far) },
            &runs,
            Estimator::Ls,
            &JUDGEMENT,
            Resampling::Given(&[]),
        )
        .unwrap()
    };
    let held = of(1e9);
    assert!(held.delivered.is_none() && held.sources.iter().all(|source| source.diverged > 0));
    assert_eq!(held.as_run(Estimator::Ls).status, EstimateStatus::Diverges);
    assert!(held.degrees.iter().all(|degree| degree.status == EstimateStatus::Diverges));
    let said = &held.statements[0];
    assert!(
        said.contains("no model is delivered") && said.contains("4 of 4") && said.contains("`2`"),
        "{said}"
    );
    let free = of(0.0);
    assert!(free.delivered.is_some());
    assert_ne!(free.as_run(Estimator::Ls).status, EstimateStatus::Diverges);
}
