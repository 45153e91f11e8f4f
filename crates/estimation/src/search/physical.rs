//! Ships with forces, scored on recordings that were left out of the search for forces that they lack.

use crate::pooled::Score;
use rayon::prelude::*;
use ship::model::Model;

use crate::search::judged::NestedScore;
use crate::search::left_out::{LeftOut, nested_score};
use crate::search::recording::{Laid, Recording};
use crate::search::scores::varying;

/// A ship as she was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedShip {
    /// Her model.
    pub model: Model,
    /// Her free numbers.
    pub theta: Vec<f64>,
}

/// What was fitted without the recordings of a fold; none where there is no fit.
#[derive(Clone, Debug)]
pub struct ShipsWithoutFold {
    /// The ship with the forces that a search added.
    pub search: Option<FittedShip>,
    /// The ship that it began with.
    pub base: Option<FittedShip>,
}

/// Ships on recordings that were left out.
#[derive(Clone, Debug)]
pub struct JudgedShips {
    /// Their scores.
    pub nested: NestedScore,
    /// Windows that they were scored on.
    pub windows: u64,
    /// Standard deviations of u, v, r over these.
    pub std: [f64; 3],
}

/// Scores the ships of `by_folds` on the recordings of the fold that each was fitted without; `folds` has the fold of each of
/// `recordings`. Each row of inputs acts during its whole sample where `are_inputs_held`, else inputs are linear between samples.
pub fn judged_ships(
    recordings: &[Recording],
    folds: &[usize],
    by_folds: &[ShipsWithoutFold],
    are_inputs_held: bool,
) -> JudgedShips {
    let all = [Laid::SideBySide, Laid::Overlapping].map(|laid| {
        let places = (0..recordings.len()).into_par_iter();
        let left_out: Vec<LeftOut> = places
            .map(|i| {
                let (recording, fold) = (&recordings[i], folds[i]);
                let ShipsWithoutFold { search, base } = &by_folds[fold];
                let of = |ship: &FittedShip| {
                    Score::replayed(&ship.model, &ship.theta, recording.scored(laid), are_inputs_held)
                };
                let [search, base] = [search, base].map(|ship| ship.as_ref().map(of));
                LeftOut { recording, fold, search, base, average: None }
            })
            .collect();
        left_out
    });
    let std = [Laid::SideBySide, Laid::Overlapping].map(|laid| varying(recordings.iter(), laid));
    let windows = recordings.iter().map(|own| own.windows() as u64).sum();
    JudgedShips { nested: nested_score(&all, std, false, Vec::new()), windows, std: std[0] }
}
