//! Intervals of searches for few terms: the example counts many, this test a few.

#[allow(dead_code)]
#[path = "../../../examples/compact_intervals.rs"]
mod example;

use std::collections::BTreeMap;

use estimation::search::{Cut, SearchError, SearchOptions, Searched, search};
use example::{Disturbed, covered, recorded, ship};
use regression::pooled::PooledRuns;
use ship::engine::{Run, Streams};
use ship::model::terms::listed;

/// 22 intervals of 14 resamples: 95 % of them would contain the truth, except that with few resamples intervals are
/// narrower.
#[test]
fn law_most_intervals_of_few_terms_hold_the_truth() {
    let found = covered(2, 14, Disturbed::ForceNoise, 4);
    let held: u32 = found.iter().map(|(_, held)| held).sum();
    assert!(held >= 17, "{found:?}");
}

/// Searches among few terms in recordings of which some are changed.
fn searched(recordings: u32, change: impl Fn(&mut Run)) -> Result<Searched, SearchError> {
    let vessel = ship();
    let streams = Streams::new(9, "recordings");
    let all = recorded(&vessel, Disturbed::White, &streams, 0);
    let mut all: Vec<Run> = all.into_iter().take(recordings as usize).collect();
    all.iter_mut().for_each(change);
    let runs = PooledRuns::new(all, &BTreeMap::new());
    let own = |term: &str| vec![term.to_owned()];
    let lists = [own("u"), own("r"), own("v")];
    let library = listed(&vessel.model, lists.each_ref().map(Vec::as_slice)).unwrap();
    let options = SearchOptions {
        cut: Cut { window: 30, every: 30, scored: None },
        folds: 3,
        ridges: SearchOptions::half_decades(),
        compact: false,
        bootstrap: None,
        average: None,
        rate_hz: 1.0,
    };
    search(&vessel.model, &library, &runs, &options, &|_| ())
}

fn said(found: &Searched) -> String {
    found.statements.join("; ")
}

#[test]
fn a_recording_that_contradicts_the_others_is_named() {
    // A rudder with the opposite sign.
    let turned = |run: &mut Run| {
        if run.run == 4 {
            run.exogenous.chunks_exact_mut(2).for_each(|row| row[1] = -row[1]);
        }
    };
    let told = match searched(8, turned) {
        Ok(found) => said(&found),
        Err(error) => error.to_string(),
    };
    assert!(told.contains("`4`") && !told.contains("`3`"), "{told}");
    let agreed = searched(8, |_| ()).unwrap();
    assert!(!said(&agreed).contains("contradict"), "{}", said(&agreed));
}

#[test]
fn few_recordings_are_too_few_to_tell() {
    let few = searched(4, |_| ()).unwrap();
    assert!(said(&few).contains("too few recordings to tell it from the base structure"), "{}", said(&few));
    let many = searched(12, |_| ()).unwrap();
    assert!(!said(&many).contains("too few"), "{}", said(&many));
}
