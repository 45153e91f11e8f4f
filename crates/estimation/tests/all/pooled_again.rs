//! Runs that are read repeatedly give the same result as runs in memory.

use std::borrow::Cow;
use std::collections::BTreeMap;
use std::convert::Infallible;
use std::sync::atomic::{AtomicI32, Ordering};

use estimation::Estimator;
use estimation::pooled::{Judgement, Pool, PoolError, Resampling, estimate};
use regression::MeanRemoval;
use regression::pooled::{PooledRuns, Recorded};
use ship::engine::{Run, Segment};
use ship::model::Vessel;

use crate::support::craft::{craft, part};
use crate::support::noise::Normals;

/// Runs in blocks, as in a file, with little in memory at a time.
struct Blocks(Vec<Vec<Run>>);

impl Recorded for Blocks {
    type Error = Infallible;

    fn blocks(&self) -> usize {
        self.0.len()
    }

    fn block(&self, i: usize) -> Result<Cow<'_, [Run]>, Infallible> {
        Ok(Cow::Owned(self.0[i].clone()))
    }

    fn window(&self) -> usize {
        100
    }
}

/// Runs of several lengths and of two or three segments; run 4 continues where run 3 ends.
pub fn runs(vessel: &Vessel) -> Vec<Run> {
    let mut normals = Normals::new(9);
    let lengths = [60, 45, 60, 90, 30, 45, 75, 60];
    let run = |(i, samples): (usize, usize)| {
        let part = part(vessel, samples, i, &mut normals, true);
        let starts = [0, 20, 30].into_iter().filter(|start| *start < samples && (*start != 20 || i % 2 == 0));
        let segments = starts.map(|start| Segment { maneuver: format!("from {start}"), start }).collect();
        let initial = [0, 1, 2].map(|d| part.measured[d]);
        let design = "measured".to_owned();
        Run {
            design,
            run: i as i32,
            segments,
            instrument_exogenous: Vec::new(),
            exogenous: part.exogenous,
            measured: part.measured,
            initial,
        }
    };
    let mut runs: Vec<Run> = lengths.into_iter().enumerate().map(run).collect();
    let end: Vec<f64> = runs[3].measured[runs[3].measured.len() - 3..].to_vec();
    runs[4].measured[..3].copy_from_slice(&end);
    runs
}

#[test]
fn law_runs_that_are_read_again_give_the_same_bits() {
    let vessel = craft();
    let runs = runs(&vessel);
    let recordings: BTreeMap<i32, String> = [(1, "first"), (3, "second"), (4, "second"), (6, "first")]
        .map(|(run, of)| (run, of.to_owned()))
        .into();
    let blocks = vec![runs[..3].to_vec(), runs[3..4].to_vec(), runs[4..].to_vec()];
    let again = PooledRuns::of(Blocks(blocks), &recordings);
    let (held, Ok(mut again)) = (PooledRuns::new(runs, &recordings), again);
    let judgement = Judgement { replicates: 2, seed: 3 };
    for (removal, part_samples) in
        [(MeanRemoval::None, None), (MeanRemoval::Batch, None), (MeanRemoval::Complete, Some(25))]
    {
        let pool = Pool { removal, part_samples, ..Pool::new(&vessel) };
        // Each with one of the estimators, and all with one of them: every estimate takes a second.
        let wanted = |own: &Estimator| match removal {
            MeanRemoval::None => *own == Estimator::Ls,
            MeanRemoval::Batch => *own == Estimator::Iv,
            MeanRemoval::Complete => true,
        };
        for estimator in Estimator::POOLED.into_iter().filter(wanted) {
            let expected = estimate(&pool, &held, estimator, &judgement, Resampling::Drawn(&|_| ())).unwrap();
            let found = estimate(&pool, &again, estimator, &judgement, Resampling::Drawn(&|_| ())).unwrap();
            // Compared as text, so that every digit counts and NaN equals itself.
            assert_eq!(format!("{found:?}"), format!("{expected:?}"), "{estimator} {removal}");
            assert_eq!(found.sources.len(), 6);
            let resampled = found.degrees.iter().flat_map(|degree| &degree.parameters);
            assert!(resampled.clone().count() > 0 && resampled.clone().all(|p| p.bootstrap_std.is_some()));
        }
    }
    again.select(&["second".to_owned()], &["4".to_owned()]).unwrap();
    assert_eq!((again.count(), again.samples()), (1, (90, 90)));
}

/// Runs of which so many blocks can be read, and no more.
struct Fading(Vec<Vec<Run>>, AtomicI32);

impl Recorded for Fading {
    type Error = String;

    fn blocks(&self) -> usize {
        self.0.len()
    }

    fn block(&self, i: usize) -> Result<Cow<'_, [Run]>, String> {
        match self.1.fetch_sub(1, Ordering::Relaxed) {
            1.. => Ok(Cow::Borrowed(&self.0[i])),
            _ => Err(format!("block {i} is gone")),
        }
    }
}

#[test]
fn law_an_estimate_ends_with_the_error_of_the_block_that_cannot_be_read_again() {
    let vessel = craft();
    let (runs, pool) = (runs(&vessel), Pool::new(&vessel));
    let judgement = Judgement { replicates: 2, seed: 3 };
    let mut ends = [0; 2];
    // Two blocks are read once to know their runs, then in every pass: sums twice, statistics, resamples, whole recordings.
    for reads in [2, 5, 8, 11, 1000] {
        let blocks = vec![runs[..3].to_vec(), runs[3..].to_vec()];
        let fading = PooledRuns::of(Fading(blocks, AtomicI32::new(reads)), &BTreeMap::new()).unwrap();
        match estimate(&pool, &fading, Estimator::Iv, &judgement, Resampling::Drawn(&|_| ())) {
            Ok(_) => ends[0] += 1,
            Err(PoolError::Unread(error)) => {
                assert!(error == "block 0 is gone" || error == "block 1 is gone", "{error}");
                ends[1] += 1;
            }
            Err(other) => panic!("{reads}: {other}"),
        }
    }
    assert_eq!(ends, [1, 4]);
}
