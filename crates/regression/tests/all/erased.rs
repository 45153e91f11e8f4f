//! Parts and runs with their error type erased.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::sync::atomic::{AtomicUsize, Ordering};

use regression::pooled::{AnyParts, AnyRuns, Faults, PartView, Parts, PooledRuns, Recorded};
use ship::engine::{Run, Segment};

/// Parts of which none can be read.
struct Unreadable;

impl Parts for Unreadable {
    type Error = String;

    fn count(&self) -> usize {
        7
    }

    fn samples(&self, _: usize) -> usize {
        10
    }

    fn at(&self, places: &[usize], _: &mut dyn FnMut(PartView)) -> Result<(), String> {
        Err(format!("no part {places:?}"))
    }
}

/// A run that can be read so many times.
struct Fading(AtomicUsize);

impl Recorded for Fading {
    type Error = String;

    fn blocks(&self) -> usize {
        1
    }

    fn block(&self, i: usize) -> Result<Cow<'_, [Run]>, String> {
        let left = self.0.load(Ordering::Relaxed);
        self.0.store(left.saturating_sub(1), Ordering::Relaxed);
        if left > 0 { Ok(Cow::Owned(vec![run()])) } else { Err(format!("no block {i}")) }
    }
}

fn run() -> Run {
    Run {
        design: "test".to_owned(),
        run: 4,
        initial: [0.0; 3],
        instrument_exogenous: Vec::new(),
        exogenous: vec![0.5; 10],
        measured: vec![0.1; 33],
        segments: vec![Segment { maneuver: "turn".to_owned(), start: 0 }],
    }
}

#[test]
fn law_every_error_comes_back_to_whom_it_happened() {
    let faults = Faults::default();
    let erased = faults.erased(&Unreadable);
    let parts: &AnyParts = &erased;
    assert_eq!((parts.count(), parts.samples(2)), (7, 10));
    let [first, second] = [[3], [5]].map(|places| parts.at(&places, &mut |_| ()).unwrap_err());
    let all = parts.each(&mut |_| ()).unwrap_err();
    assert_eq!([second, first].map(|unread| faults.take(unread)), ["no part [5]", "no part [3]"]);
    assert_eq!(faults.take(all), "no part [0, 1, 2, 3, 4, 5, 6]");
}

#[test]
fn law_runs_are_the_same_with_their_error_erased() {
    let runs = PooledRuns::of(Fading(AtomicUsize::new(2)), &BTreeMap::new()).unwrap();
    let faults = Faults::default();
    let erased = faults.erased(&runs);
    let any: &dyn AnyRuns = &erased;
    assert_eq!((any.design(), any.sources()), ("test", 1));
    let mut found = Vec::new();
    any.each_source(&mut |name, parts| found.push((name.to_owned(), parts))).unwrap();
    assert_eq!((found[0].0.as_str(), &found[0].1[0].exogenous), ("4", &run().exogenous));
    let again = any.each_source(&mut |name, _| panic!("{name} cannot be read any more")).unwrap_err();
    assert_eq!(faults.take(again), "no block 0");
}
