use estimation::pooled::Score;
use estimation::{Estimator, ScoreStatus};
use rayon::prelude::*;
use regression::pooled::{Part, PooledRuns};
use ship::model::Model;

use super::cross::{CrossValidation, Cut, Tried};
use super::error::CrossError;
use super::folds::Folds;

/// The free numbers of a ship that was fitted without the runs of these names, or why there are none.
pub type Fitting<'a> = &'a dyn Fn(&[String]) -> Result<Vec<f64>, String>;

/// As [`super::cross_validate`], of a ship with forces `model`: `fit` is called with the names of what is left out. Each fit has all threads.
///
/// # Errors
/// Nothing can be left out; no window.
pub fn cross_validate_forces(
    model: &Model,
    runs: &PooledRuns,
    (window, folds): (Option<usize>, &Folds),
    fit: Fitting,
    done: &(dyn Fn(usize) + Sync),
) -> Result<CrossValidation, CrossError> {
    let cut = Cut::new(runs, window)?;
    let folds = cut.folds(folds)?;
    let held = runs.are_inputs_held();
    let tried = |left_out: &Vec<usize>| {
        let names: Vec<String> = left_out.iter().map(|place| cut.windows[*place].0.clone()).collect();
        let tried = match fit(&names) {
            Ok(theta) => {
                let score = |place: &usize| {
                    let windows = cut.windows[*place].1.iter().map(Part::view);
                    (*place, Score::replayed(model, &theta, windows, held))
                };
                Tried { scores: left_out.par_iter().map(score).collect(), ..Tried::default() }
            }
            Err(why) => {
                let why = format!("without {}: {why}", names.join(", "));
                Tried { failed: Some((ScoreStatus::NotConverged, why)), ..Tried::default() }
            }
        };
        done(1);
        tried
    };
    let tried: Vec<Tried> = folds.iter().map(tried).collect();
    let score = cut.score(Estimator::OutputError, &tried);
    Ok(cut.validation(folds.len(), vec![score]))
}
