//! Models from sub-experiments that are picked at random.

use std::collections::BTreeMap;

use estimation::Estimator;
use estimation::pooled::Pool;
use regression::pooled::PooledRuns;
use serde_json::json;
use ship::engine::{Run, Segment};
use validation::selection::{Realization, SelectionOptions, Selector};

use crate::average::vessel;

const LABELS: [&str; 6] = ["a", "b", "a", "a", "b", "c"];

/// A sub-experiment of maneuver `label`.
fn run((i, label): (usize, &&str)) -> Run {
    let wave = |k: usize, by: f64| (by * (k + 10 * i) as f64).sin();
    Run {
        design: "test".to_owned(),
        run: i as i32,
        initial: [0.0; 3],
        instrument_exogenous: Vec::new(),
        exogenous: (0..20).flat_map(|k| [wave(k, 0.9), wave(k, 1.7)]).collect(),
        measured: (0..=20).flat_map(|k| [wave(k, 0.7), wave(k, 1.1), wave(k, 1.3)]).collect(),
        segments: vec![Segment { maneuver: (*label).to_owned(), start: 0 }],
    }
}

/// The parts that each of 200 realizations picks: by the design, and at random.
fn picked(counts: &BTreeMap<String, u64>) -> [Vec<Vec<usize>>; 2] {
    let vessel = vessel(&json!({"surge": {"u": -0.1}, "sway": {"v": -0.2}, "yaw": {"r": -0.3}}));
    let (pool, runs) = (Pool::new(&vessel), LABELS.iter().enumerate().map(run).collect());
    let runs = PooledRuns::new(runs, &BTreeMap::new());
    let options = SelectionOptions {
        estimator: Estimator::Ls,
        counts: counts.clone(),
        realizations: 200,
        seed: 7,
        published_limits: None,
    };
    let selector = Selector::new(&pool, &runs, &options).unwrap();
    let all: Vec<Realization> = (0..selector.groups()).flat_map(|group| selector.group(group)).collect();
    ["optimized", "random"].map(|design| {
        let own = all.iter().filter(|own| own.design == design);
        own.map(|own| own.picked.split(' ').map(|i| i.parse().unwrap()).collect()).collect()
    })
}

#[test]
fn law_picks_are_those_counted_and_none_comes_twice() {
    let counts: BTreeMap<String, u64> = [("a".to_owned(), 2), ("b".to_owned(), 1)].into();
    let [designed, random] = picked(&counts);
    let (mut seen, mut seen_at_random) = ([0; 6], [0; 6]);
    assert_eq!((designed.len(), random.len()), (200, 200));
    for (own, random) in designed.iter().zip(&random) {
        let of = |label: &str| own.iter().filter(|i| LABELS[**i] == label).count();
        assert_eq!((own.len(), of("a"), of("b"), random.len()), (3, 2, 1, 3));
        for picked in [own, random] {
            assert!(picked.windows(2).all(|pair| pair[0] < pair[1]), "{picked:?}");
        }
        own.iter().for_each(|i| seen[*i] += 1);
        random.iter().for_each(|i| seen_at_random[*i] += 1);
    }
    assert!(seen[..5].iter().all(|n| *n > 60) && seen[5] == 0, "{seen:?}");
    assert!(seen_at_random.iter().all(|n| *n > 60), "{seen_at_random:?}");
    assert_eq!(picked(&counts), [designed, random]);
    let all: BTreeMap<String, u64> = [("a".to_owned(), 3), ("b".to_owned(), 2), ("c".to_owned(), 1)].into();
    assert_eq!(picked(&all)[1][0], [0, 1, 2, 3, 4, 5]);
}
