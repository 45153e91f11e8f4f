use crate::pooled::{FreeRunErrors, Score};
use ship::model::Model;

use crate::search::judged::{Margin, NestedAverage, NestedRecording, NestedScore};
use crate::search::nested::{Fitted, Study};
use crate::search::recording::{Laid, Recording};
use crate::search::scores::{scores, scores_of_mean, together, varying};

/// The models that are scored on the fold that was left out of them.
pub(crate) struct Judged {
    pub ridge: Option<f64>,
    pub model: Option<Fitted>,
    pub base: Option<Vec<f64>>,
    pub limit: [f64; 3],
}

/// A recording when it was left out.
pub(crate) struct LeftOut<'a> {
    pub recording: &'a Recording,
    pub fold: usize,
    pub search: Option<Score>,
    pub base: Option<Score>,
    pub average: Option<Score>,
}

impl Study<'_> {
    /// Scores the models that were found without each fold on that fold; likewise the means of several models, if
    /// there are `averages`.
    pub fn judged(&self, by_folds: &[Judged], averages: Option<&[Option<Vec<Fitted>>]>) -> NestedScore {
        let laid = |laid| self.left_out(by_folds, averages, laid);
        let all = [laid(Laid::SideBySide), laid(Laid::Overlapping)];
        let ridges = by_folds.iter().map(|own| own.ridge).collect();
        nested_score(&all, [self.std, self.overlapping_std], averages.is_some(), ridges)
    }

    /// Every recording when it was left out, in the order of the recordings.
    fn left_out(
        &self,
        by_folds: &[Judged],
        averages: Option<&[Option<Vec<Fitted>>]>,
        laid: Laid,
    ) -> Vec<LeftOut<'_>> {
        let mut all = Vec::new();
        for (fold, Judged { model, base, limit, .. }) in by_folds.iter().enumerate() {
            let recordings = self.within(fold);
            let of = |model: &Model, theta: &[f64]| scores(model, theta, &recordings, laid, *limit);
            let found = model.as_ref().map(|found| of(&found.model, &found.theta));
            let base = base.as_ref().map(|base| of(self.base, base));
            let several = averages.and_then(|all| all[fold].as_deref());
            let average = several.map(|several| scores_of_mean(&ships(several), &recordings, laid, *limit));
            for (i, recording) in recordings.iter().enumerate() {
                let [search, base, average] =
                    [&found, &base, &average].map(|scores| scores.as_ref().map(|s| s[i]));
                all.push(LeftOut { recording, fold, search, base, average });
            }
        }
        all.sort_by_key(|one| self.recordings.iter().position(|own| own.name == one.recording.name));
        all
    }
}

/// All scores: of every recording when it was left out, over windows side by side and over those that overlap, whose states
/// have these standard deviations.
pub(crate) fn nested_score(
    [all, overlapping]: &[Vec<LeftOut>; 2],
    [std, overlapping_std]: [[f64; 3]; 2],
    has_averages: bool,
    ridges: Vec<Option<f64>>,
) -> NestedScore {
    let norm = |score: Option<Score>| score?.norm(std);
    let nested = |LeftOut { recording, fold, search, base, average }: &LeftOut| NestedRecording {
        source: recording.name.clone(),
        fold: *fold as u64,
        search: own(*search, recording),
        base: own(*base, recording),
        search_norm: norm(*search),
        base_norm: norm(*base),
        search_diverged: search.map_or(0, |score| score.diverged),
        average: own(*average, recording),
        average_norm: norm(*average),
    };
    let simulated: Vec<&LeftOut> =
        all.iter().filter(|one| one.recording.scored(Laid::SideBySide).next().is_some()).collect();
    let paired = |own: fn(&LeftOut) -> Option<Score>, other: fn(&LeftOut) -> Option<Score>| {
        Margin::of(&simulated.iter().map(|one| [norm(own(one)), norm(other(one))]).collect::<Vec<_>>())
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

/// Structures with their parameters.
pub(crate) fn ships(all: &[Fitted]) -> Vec<(&Model, &[f64])> {
    all.iter().map(|own| (&own.model, own.theta.as_slice())).collect()
}

/// Against the standard deviations of its own states.
fn own(score: Option<Score>, recording: &Recording) -> Option<FreeRunErrors> {
    score?.errors(varying(std::iter::once(recording), Laid::SideBySide))
}

/// All together against `std`; `None` if one has no model.
fn whole(scores: impl Iterator<Item = Option<Score>>, std: [f64; 3]) -> Option<FreeRunErrors> {
    let all: Vec<Score> = scores.collect::<Option<_>>()?;
    together(all.iter()).errors(std)
}
