use std::collections::BTreeMap;

use rayon::prelude::*;
use vessel::{LANES, RunView};

use super::counts::available;
use super::draw::Draw;
use super::prepared::Prepared;
use super::realize::{Realization, Realizer};
use super::scores::{PublishedLimits, SelectionScores};
use identification::Estimator;
use identification::pooled::{LostInstruments, Part, Pool, PooledRuns, deviations};

/// What is picked, how often, and by whom.
#[derive(Clone, Debug, PartialEq)]
pub struct SelectionOptions {
    /// The estimator: `ls`, `iv` or `auto`.
    pub estimator: Estimator,
    /// How many sub-experiments of each maneuver the design picks.
    pub counts: BTreeMap<String, u64>,
    /// Realizations per design.
    pub realizations: u32,
    /// Seed of the picks.
    pub seed: u64,
    /// Where the figures of a published study end.
    pub published_limits: Option<PublishedLimits>,
}

/// Models from picked sub-experiments.
#[derive(Clone, Debug, PartialEq)]
pub struct Selection {
    /// Sub-experiments per realization.
    pub picks: u64,
    /// Sub-experiments there are of each maneuver.
    pub available: BTreeMap<String, u64>,
    /// Number of sub-experiments, all of which every model is simulated over.
    pub parts: usize,
    /// Their samples.
    pub samples: u64,
    /// Standard deviations of the measured u, v, r over them.
    pub std: [f64; 3],
    /// How well the instruments follow the measured u, v, r: 100 (1 − RMSE/std) \[%\].
    pub instrument_fit: Option<[f64; 3]>,
    /// Picked as the design says, and at random.
    pub designs: [SelectionScores; 2],
    /// Those of both, in order.
    pub realizations: Vec<Realization>,
    /// 90 % quantile of the optimized error norm over that of the random one; none where either is infinite.
    pub ratio_q90: Option<f64>,
    /// The result, and what went wrong, in words.
    pub statements: Vec<String>,
}

/// Picks, estimates, simulates. `done` is called with the number of realizations that are done.
///
/// # Errors
/// The nominal simulation diverges.
pub fn select(
    pool: &Pool,
    runs: &PooledRuns,
    options: &SelectionOptions,
    done: &(dyn Fn(usize) + Sync),
) -> Result<Selection, LostInstruments> {
    let prepared = Prepared::new(pool, runs, options.estimator)?;
    let parts: Vec<Part> = runs.parts(None);
    let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
    let views: Vec<RunView> = parts.iter().map(Part::view).collect();
    let realizer = Realizer { pool, estimator: options.estimator, prepared: &prepared, parts: &views, std };
    let labels: Vec<&str> = parts.iter().map(|p| p.label.as_str()).collect();
    let picks = options.counts.values().sum::<u64>();
    let draws = [
        Draw::by_design(options.seed, &labels, &options.counts),
        Draw::at_random(options.seed, parts.len(), picks as usize),
    ];
    let realizations = draws.each_ref().map(|draw| {
        let chunk = |i: usize| {
            let first = i * LANES;
            let count = LANES.min(options.realizations as usize - first);
            let found = realizer.chunk(draw, first as u32, count);
            done(count);
            found
        };
        let chunks = (options.realizations as usize).div_ceil(LANES);
        let realizations: Vec<Vec<Realization>> = (0..chunks).into_par_iter().map(chunk).collect();
        realizations.concat()
    });
    let designs =
        [0, 1].map(|i| SelectionScores::new(draws[i].design, &realizations[i], options.published_limits));
    let mut statements = vec![conclusion(&designs)];
    statements.extend(prepared.warnings);
    Ok(Selection {
        picks,
        available: available(&parts),
        parts: parts.len(),
        samples: parts.iter().map(|p| p.samples() as u64).sum(),
        std,
        instrument_fit: prepared.instrument_fit,
        ratio_q90: q90(&designs[0]).zip(q90(&designs[1])).map(|(optimized, random)| optimized / random),
        designs,
        realizations: realizations.concat(),
        statements,
    })
}

fn q90(scores: &SelectionScores) -> Option<f64> {
    scores.overlapping.error_norm.q90
}

fn conclusion([optimized, random]: &[SelectionScores; 2]) -> String {
    let told = |scores: &SelectionScores| q90(scores).map_or("infinite".to_owned(), |q| format!("{q:.2}"));
    let share = |scores: &SelectionScores| 100.0 * scores.degenerate_share;
    format!(
        "90 % quantile of the error norm: optimized {}, random {}; degenerate: optimized {:.1} %, random {:.1} %",
        told(optimized),
        told(random),
        share(optimized),
        share(random)
    )
}
