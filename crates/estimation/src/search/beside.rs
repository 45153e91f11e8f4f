//! What a search found beside forces of the same ship, and their mean, on recordings that were left out of both.

use crate::pooled::{FreeRunErrors, Score};
use numerics::statistics::MeanTrajectory;
use rayon::prelude::*;
use ship::engine::{check_diverged, replay};

use super::judged::FittedShip;
use crate::search::judged::{Margin, NestedAverage, NestedRecording, NestedScore};
use crate::search::recording::{Laid, Recording};
use crate::search::scores::{mean_of, together, varying};

/// Recordings dealt into folds.
#[derive(Clone, Copy)]
pub struct Dealt<'a> {
    /// The fold of each recording.
    pub folds: &'a [usize],
    /// Whether each row of inputs acts during its whole sample; else they are linear between samples.
    pub are_inputs_held: bool,
}

/// One model of the ship, with the recordings in its own channels.
#[derive(Clone, Copy)]
pub struct Kind<'a> {
    /// The recordings, in the order of the folds.
    pub recordings: &'a [Recording],
    /// What was fitted without each fold; `None` where there is no fit.
    pub without: &'a [Option<FittedShip>],
}

impl Dealt<'_> {
    /// How the mean trajectory of `kinds` follows each recording that was left out of all, over windows side by side; of one kind it is
    /// that model alone. `None` where a model is missing.
    pub fn scores(&self, kinds: &[Kind]) -> Vec<Option<Score>> {
        self.laid(kinds, Laid::SideBySide)
    }

    fn laid(&self, kinds: &[Kind], laid: Laid) -> Vec<Option<Score>> {
        let held = self.are_inputs_held;
        let score = |(i, fold): (usize, &usize)| {
            let ships: Vec<&FittedShip> =
                kinds.iter().map(|own| own.without[*fold].as_ref()).collect::<Option<_>>()?;
            let mut windows: Vec<_> = kinds.iter().map(|own| own.recordings[i].scored(laid)).collect();
            let mut score = Score::default();
            while let Some(own) = windows.iter_mut().map(Iterator::next).collect::<Option<Vec<_>>>() {
                let mut mean = MeanTrajectory::default();
                let states = ships.iter().zip(&own).map(|(ship, window)| {
                    replay(&ship.model, &ship.theta, window.initial, window.exogenous, held)
                });
                let mut lost = None;
                for states in states {
                    match check_diverged(states.iter().copied()) {
                        Some(_) => lost = Some(states),
                        None => mean.add(&states),
                    }
                }
                score.add_states(lost.as_deref().unwrap_or(mean.mean()), own[0]);
            }
            Some(score)
        };
        self.folds.par_iter().enumerate().map(score).collect()
    }

    /// Mean fit of u, v and r over the recordings, but for those of the fold at `without` \[%\]; `None` where a model is missing or a
    /// window diverged.
    pub fn fit(&self, kind: &Kind, scores: &[Option<Score>], without: Option<usize>) -> Option<f64> {
        let kept = scores.iter().zip(self.folds).filter(|(_, fold)| Some(**fold) != without);
        let kept: Vec<Score> = kept.map(|(own, _)| *own).collect::<Option<_>>()?;
        mean_of(&together(kept.iter()).errors(varying(kind.recordings.iter(), Laid::SideBySide))?)
    }

    /// `nested` of the search of the first of `kinds`, with the scores of the average of all of them; and those of the second alone.
    pub fn averaged(&self, mut nested: NestedScore, kinds: &[Kind; 2]) -> (NestedScore, Alone) {
        let recordings = kinds[0].recordings;
        let both = [Laid::SideBySide, Laid::Overlapping].map(|laid| {
            let std = varying(recordings.iter(), laid);
            let [mean, second] = [&kinds[..], &kinds[1..]].map(|own| self.laid(own, laid));
            (whole(&mean, std), whole(&second, std), mean, std)
        });
        let [(errors, alone, mean, std), (overlapping, alone_overlapping, ..)] = both;
        for (own, (score, recording)) in nested.recordings.iter_mut().zip(mean.iter().zip(recordings)) {
            let varied = || varying(std::iter::once(recording), Laid::SideBySide);
            own.average = score.and_then(|score| score.errors(varied()));
            own.average_norm = score.and_then(|score| score.norm(std));
        }
        let scored = nested.recordings.iter().zip(recordings).filter(|(_, own)| own.windows() > 0);
        let norms = |of: fn(&NestedRecording) -> Option<f64>| {
            let pairs = scored.clone().map(|(own, _)| [own.average_norm, of(own)]);
            Margin::of(&pairs.collect::<Vec<_>>())
        };
        let (over_search, over_base) = (norms(|own| own.search_norm), norms(|own| own.base_norm));
        nested.average = Some(NestedAverage {
            errors,
            overlapping,
            diverged: mean.iter().flatten().map(|score| score.diverged).sum(),
            over_search,
            over_base,
        });
        (nested, Alone { errors: alone, overlapping: alone_overlapping })
    }
}

/// One kind of model on the recordings that were left out of it.
#[derive(Clone, Copy, Debug)]
pub struct Alone {
    /// Over windows side by side; `None` where a fold lacks a model, or a window diverged.
    pub errors: Option<FreeRunErrors>,
    /// Over windows of which one begins at every quarter of another.
    pub overlapping: Option<FreeRunErrors>,
}

fn whole(scores: &[Option<Score>], std: [f64; 3]) -> Option<FreeRunErrors> {
    let all: Vec<Score> = scores.iter().copied().collect::<Option<_>>()?;
    together(all.iter()).errors(std)
}
