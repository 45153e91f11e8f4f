use numerics::statistics::{MeanTrajectory, paired_median};
use rayon::prelude::*;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::{check_diverged, replay};
use ship::model::Model;

use super::nested::{Fitted, Study};
use super::{Laid, Recording, mean_of, scores, scores_of_mean, together, varying};
use crate::pooled::{FreeRunErrors, Score};

/// The whole algorithm judged by recordings that it has not seen, beside the base structure.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedScore {
    /// The ridge that was chosen without each fold; none where no candidate was left. Empty for a ship with forces.
    pub ridges: Vec<Option<f64>>,
    /// Over all recordings; none where a fold has no model, or a window diverged.
    pub search: Option<FreeRunErrors>,
    /// Those of the base structure.
    pub base: Option<FreeRunErrors>,
    /// As `search`, over windows of which one begins at every quarter of another: where the first begins hardly counts.
    pub search_overlapping: Option<FreeRunErrors>,
    /// Those of the base structure.
    pub base_overlapping: Option<FreeRunErrors>,
    /// Windows in which the found models diverged.
    pub diverged: u64,
    /// Recording by recording.
    pub recordings: Vec<NestedRecording>,
    /// Against the base structure.
    pub margin: Option<Margin>,
    /// The mean trajectory of several models that were found so, where an average was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average: Option<NestedAverage>,
}

/// The mean trajectory of several models on recordings that were left out of finding every one of them.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedAverage {
    /// Over all recordings; none where a fold lacks a model, or a window diverged.
    pub errors: Option<FreeRunErrors>,
    /// The same over windows of which one begins at every quarter of another.
    pub overlapping: Option<FreeRunErrors>,
    /// Windows in which a model diverged.
    pub diverged: u64,
    /// How far the single model's norm of RMSE/std lies above, recording by recording.
    pub over_search: Option<Margin>,
    /// How far the base structure's does.
    pub over_base: Option<Margin>,
}

/// How far one norm of RMSE/std lies above another, recording by recording: the base structure's above the found models', where
/// nothing else is said.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Margin {
    /// Recordings that were compared.
    pub pairs: u64,
    /// The median difference; null where it is infinite.
    pub median: Option<f64>,
    /// 95 % interval of that median; null at an infinite end. An interval that contains 0 tells no difference.
    pub interval: [Option<f64>; 2],
}

/// One recording when it was left out.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct NestedRecording {
    /// Its name.
    pub source: String,
    /// The fold it is in.
    pub fold: u64,
    /// Errors of the found model, against the standard deviations of its own states.
    pub search: Option<FreeRunErrors>,
    /// Those of the base structure.
    pub base: Option<FreeRunErrors>,
    /// Norm of RMSE over the standard deviations of all recordings' states.
    pub search_norm: Option<f64>,
    /// That of the base structure.
    pub base_norm: Option<f64>,
    /// Windows in which the found model diverged.
    #[serde(default, skip_serializing_if = "is_zero")]
    pub search_diverged: u64,
    /// Errors of the mean trajectory, where an average was asked for.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average: Option<FreeRunErrors>,
    /// Its norm.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub average_norm: Option<f64>,
}

// Serde passes a reference.
#[allow(clippy::trivially_copy_pass_by_ref)]
fn is_zero(count: &u64) -> bool {
    *count == 0
}

impl Margin {
    pub(crate) fn of(pairs: &[[Option<f64>; 2]]) -> Option<Self> {
        let finite = |x: f64| Some(x).filter(|x| x.is_finite());
        let [low, median, high] = paired_median(pairs.iter().copied())?;
        Some(Self { pairs: pairs.len() as u64, median: finite(median), interval: [low, high].map(finite) })
    }
}

/// The models that are scored on the fold that was left out of them.
pub(crate) struct Judged {
    pub ridge: Option<f64>,
    pub model: Option<Fitted>,
    pub base: Option<Vec<f64>>,
    pub limit: [f64; 3],
}

/// Several models found without each fold.
type Several = [Option<Vec<Fitted>>];

struct LeftOut<'a> {
    pub recording: &'a Recording,
    pub fold: usize,
    pub search: Option<Score>,
    pub base: Option<Score>,
    pub average: Option<Score>,
}

impl Study<'_> {
    /// Scores the models found without each fold on that fold; likewise the means of several, with `averages`.
    pub fn judged(&self, by_folds: &[Judged], averages: Option<&Several>) -> NestedScore {
        let laid = |laid| self.left_out(by_folds, averages, laid);
        let all = [laid(Laid::SideBySide), laid(Laid::Overlapping)];
        let ridges = by_folds.iter().map(|judged| judged.ridge).collect();
        nested_score(&all, [self.std, self.overlapping_std], averages.is_some(), ridges)
    }

    fn left_out(&self, by_folds: &[Judged], averages: Option<&Several>, laid: Laid) -> Vec<LeftOut<'_>> {
        let mut all = Vec::new();
        for (fold, Judged { model, base, limit, .. }) in by_folds.iter().enumerate() {
            let recordings = self.within(fold);
            let of = |model: &Model, theta: &[f64]| scores(model, theta, &recordings, laid, *limit);
            let searched = model.as_ref().map(|fitted| of(&fitted.model, &fitted.theta));
            let base = base.as_ref().map(|base| of(self.base, base));
            let several = averages.and_then(|all| all[fold].as_deref());
            let average = several.map(|several| scores_of_mean(&ships(several), &recordings, laid, *limit));
            for (i, recording) in recordings.iter().enumerate() {
                let [search, base, average] =
                    [&searched, &base, &average].map(|all| all.as_ref().map(|s| s[i]));
                all.push(LeftOut { recording, fold, search, base, average });
            }
        }
        all.sort_by_key(|one| self.recordings.iter().position(|r| r.name == one.recording.name));
        all
    }
}

/// All scores: of every recording when it was left out, over windows side by side and over those that overlap, whose states
/// have these standard deviations.
fn nested_score(
    [all, overlapping]: &[Vec<LeftOut>; 2],
    [std, overlapping_std]: [[f64; 3]; 2],
    has_averages: bool,
    ridges: Vec<Option<f64>>,
) -> NestedScore {
    let norm = |score: Option<Score>| score?.norm(std);
    let nested = |LeftOut { recording, fold, search, base, average }: &LeftOut| NestedRecording {
        source: recording.name.clone(),
        fold: *fold as u64,
        search: own_errors(*search, recording),
        base: own_errors(*base, recording),
        search_norm: norm(*search),
        base_norm: norm(*base),
        search_diverged: search.map_or(0, |score| score.diverged),
        average: own_errors(*average, recording),
        average_norm: norm(*average),
    };
    let simulated: Vec<&LeftOut> =
        all.iter().filter(|one| one.recording.scored(Laid::SideBySide).next().is_some()).collect();
    let paired = |one_score: fn(&LeftOut) -> Option<Score>, other: fn(&LeftOut) -> Option<Score>| {
        Margin::of(&simulated.iter().map(|one| [norm(one_score(one)), norm(other(one))]).collect::<Vec<_>>())
    };
    let diverged = |of: fn(&LeftOut) -> Option<Score>| {
        all.iter().filter_map(of).map(|score| score.diverged).sum::<u64>()
    };
    NestedScore {
        ridges,
        search: whole(all.iter().map(|one| one.search), std),
        base: whole(all.iter().map(|one| one.base), std),
        search_overlapping: whole(overlapping.iter().map(|one| one.search), overlapping_std),
        base_overlapping: whole(overlapping.iter().map(|one| one.base), overlapping_std),
        diverged: diverged(|one| one.search),
        margin: paired(|one| one.search, |one| one.base),
        average: has_averages.then(|| NestedAverage {
            errors: whole(all.iter().map(|one| one.average), std),
            overlapping: whole(overlapping.iter().map(|one| one.average), overlapping_std),
            diverged: diverged(|one| one.average),
            over_search: paired(|one| one.average, |one| one.search),
            over_base: paired(|one| one.average, |one| one.base),
        }),
        recordings: all.iter().map(nested).collect(),
    }
}

pub(crate) fn ships(all: &[Fitted]) -> Vec<(&Model, &[f64])> {
    all.iter().map(|fitted| (&fitted.model, fitted.theta.as_slice())).collect()
}

fn own_errors(score: Option<Score>, recording: &Recording) -> Option<FreeRunErrors> {
    score?.errors(varying(std::iter::once(recording), Laid::SideBySide))
}

fn whole(scores: impl Iterator<Item = Option<Score>>, std: [f64; 3]) -> Option<FreeRunErrors> {
    let all: Vec<Score> = scores.collect::<Option<_>>()?;
    together(all.iter()).errors(std)
}

/// A ship as she was fitted.
#[derive(Clone, Debug, PartialEq)]
pub struct FittedShip {
    /// Her model.
    pub model: Model,
    /// Her free numbers.
    pub theta: Vec<f64>,
}

/// The scores of a search without a model; `folds` has the fold of each of `recordings`.
pub fn unscored(recordings: &[Recording], folds: &[usize]) -> NestedScore {
    let none = |(recording, fold): (_, &usize)| LeftOut {
        recording,
        fold: *fold,
        search: None,
        base: None,
        average: None,
    };
    let all = [(); 2].map(|()| recordings.iter().zip(folds).map(none).collect::<Vec<LeftOut>>());
    let std = [Laid::SideBySide, Laid::Overlapping].map(|laid| varying(recordings.iter(), laid));
    nested_score(&all, std, false, Vec::new())
}

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
                kinds.iter().map(|k| k.without[*fold].as_ref()).collect::<Option<_>>()?;
            let mut windows: Vec<_> = kinds.iter().map(|kind| kind.recordings[i].scored(laid)).collect();
            let mut score = Score::default();
            while let Some(views) = windows.iter_mut().map(Iterator::next).collect::<Option<Vec<_>>>() {
                let mut mean = MeanTrajectory::default();
                let states = ships.iter().zip(&views).map(|(ship, window)| {
                    replay(&ship.model, &ship.theta, window.initial, window.exogenous, held)
                });
                let mut lost = None;
                for states in states {
                    match check_diverged(states.iter().copied()) {
                        Some(_) => lost = Some(states),
                        None => mean.add(&states),
                    }
                }
                score.add_states(lost.as_deref().unwrap_or(mean.mean()), views[0]);
            }
            Some(score)
        };
        self.folds.par_iter().enumerate().map(score).collect()
    }

    /// Mean fit of u, v and r over the recordings, but for those of the fold at `without` \[%\]; `None` where a model is missing or a
    /// window diverged.
    pub fn fit(&self, kind: &Kind, scores: &[Option<Score>], without: Option<usize>) -> Option<f64> {
        let kept = scores.iter().zip(self.folds).filter(|(_, fold)| Some(**fold) != without);
        let kept: Vec<Score> = kept.map(|(score, _)| *score).collect::<Option<_>>()?;
        mean_of(&together(kept.iter()).errors(varying(kind.recordings.iter(), Laid::SideBySide))?)
    }

    /// `nested` of the search of the first of `kinds`, with the scores of the average of all of them; and those of the second alone.
    pub fn averaged(&self, mut nested: NestedScore, kinds: &[Kind; 2]) -> (NestedScore, Alone) {
        let recordings = kinds[0].recordings;
        let both = [Laid::SideBySide, Laid::Overlapping].map(|laid| {
            let std = varying(recordings.iter(), laid);
            let [mean, second] = [&kinds[..], &kinds[1..]].map(|members| self.laid(members, laid));
            (whole(mean.iter().copied(), std), whole(second.iter().copied(), std), mean, std)
        });
        let [(errors, alone, mean, std), (overlapping, alone_overlapping, ..)] = both;
        for (nested_recording, (score, recording)) in
            nested.recordings.iter_mut().zip(mean.iter().zip(recordings))
        {
            let varied = || varying(std::iter::once(recording), Laid::SideBySide);
            nested_recording.average = score.and_then(|score| score.errors(varied()));
            nested_recording.average_norm = score.and_then(|score| score.norm(std));
        }
        let scored = nested.recordings.iter().zip(recordings).filter(|(_, r)| r.windows() > 0);
        let norms = |of: fn(&NestedRecording) -> Option<f64>| {
            let pairs = scored.clone().map(|(recording, _)| [recording.average_norm, of(recording)]);
            Margin::of(&pairs.collect::<Vec<_>>())
        };
        let (over_search, over_base) = (norms(|r| r.search_norm), norms(|r| r.base_norm));
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
