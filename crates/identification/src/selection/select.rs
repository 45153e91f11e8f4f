use std::collections::BTreeMap;

use numerics::statistics::{quantile, sorted};
use rayon::prelude::*;
use vessel::LANES;

use super::counts::available;
use super::draw::Draw;
use super::prepared::Prepared;
use super::realize::{Realization, Realizer};
use crate::Estimator;
use crate::pooled::{Errors, LostInstruments, Part, Pool, PooledRuns, Window, Windows, deviations};

/// Norm of RMSE/std, √3, from which a model is degenerate: no better than the mean of the data.
pub const DEGENERATE: f64 = 1.732_050_807_568_877_2;

/// What is picked, how often, and by whom.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct SelectionOptions {
    /// The estimator: `ls`, `iv` or `auto`.
    pub estimator: Estimator,
    /// How many sub-experiments of each maneuver the design picks.
    pub counts: BTreeMap<String, u64>,
    /// Realizations per design.
    pub realizations: u32,
    /// Seed of the picks.
    pub seed: u64,
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
    pub designs: [Selected; 2],
    /// 90 % quantile of the optimized error norm over that of the random one; none where either is infinite.
    pub ratio_q90: Option<f64>,
    /// The result, and what went wrong, in words.
    pub statements: Vec<String>,
}

/// The realizations of one design.
#[derive(Clone, Debug, PartialEq)]
pub struct Selected {
    /// `optimized` or `random`.
    pub design: &'static str,
    /// In order.
    pub realizations: Vec<Realization>,
}

impl Selected {
    /// Share of the realizations without a model, or with a degenerate one.
    fn degenerate_share(&self) -> f64 {
        let degenerate = |r: &&Realization| norm(r).is_none_or(|norm| norm >= DEGENERATE);
        self.realizations.iter().filter(degenerate).count() as f64 / self.realizations.len().max(1) as f64
    }

    fn q90(&self) -> Option<f64> {
        quantile(&sorted(self.realizations.iter().map(norm)), 0.9)
    }
}

fn norm(realization: &Realization) -> Option<f64> {
    realization.overlapping.as_ref().and_then(Errors::norm)
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
    let parts: Vec<Part> = runs.segments(pool.vessel, None).concat();
    let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
    let windows = Windows::new(&pool.model, &parts.iter().map(window).collect::<Vec<_>>());
    let realizer =
        Realizer { pool, estimator: options.estimator, prepared: &prepared, windows: &windows, std };
    let labels: Vec<&str> = parts.iter().map(|p| p.label.as_str()).collect();
    let picks = options.counts.values().sum::<u64>();
    let draws = [
        ("optimized", Draw::by_design(options.seed, &labels, &options.counts)),
        ("random", Draw::at_random(options.seed, parts.len(), picks as usize)),
    ];
    let designs = draws.map(|(design, draw)| {
        let chunk = |i: usize| {
            let first = i * LANES;
            let count = LANES.min(options.realizations as usize - first);
            let found = realizer.chunk(&draw, first as u32, count);
            done(count);
            found
        };
        let chunks = (options.realizations as usize).div_ceil(LANES);
        let realizations: Vec<Vec<Realization>> = (0..chunks).into_par_iter().map(chunk).collect();
        Selected { design, realizations: realizations.concat() }
    });
    let mut statements = vec![conclusion(&designs)];
    statements.extend(prepared.warnings);
    Ok(Selection {
        picks,
        available: available(&parts),
        parts: parts.len(),
        samples: parts.iter().map(|p| p.samples() as u64).sum(),
        std,
        instrument_fit: prepared.instrument_fit,
        ratio_q90: designs[0].q90().zip(designs[1].q90()).map(|(optimized, random)| optimized / random),
        designs,
        statements,
    })
}

fn window(part: &Part) -> Window {
    Window { exogenous: part.exogenous.clone(), measured: part.measured.clone() }
}

fn conclusion([optimized, random]: &[Selected; 2]) -> String {
    let told = |selected: &Selected| selected.q90().map_or("infinite".to_owned(), |q| format!("{q:.2}"));
    let share = |selected: &Selected| 100.0 * selected.degenerate_share();
    format!(
        "90 % quantile of the error norm: optimized {}, random {}; degenerate: optimized {:.1} %, random {:.1} %",
        told(optimized),
        told(random),
        share(optimized),
        share(random)
    )
}
