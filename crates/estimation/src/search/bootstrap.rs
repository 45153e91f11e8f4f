use std::collections::BTreeMap;

use numerics::statistics::{quantile, sorted};
use rayon::prelude::*;
use ship::engine::Streams;

use crate::search::folds::folds;
use crate::search::nested::{Fitted, Study};
use crate::search::recording::{Laid, Recording};
use crate::search::scores::varying;

/// The bootstrap of a search: recordings are resampled and searched again.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct BootstrapOptions {
    /// Number of resamples, at least two.
    pub resamples: u32,
    /// The seed of the draws.
    pub seed: u64,
}

/// The result of searches over resampled recordings.
#[derive(Clone, Debug, PartialEq)]
pub struct Resampled {
    /// Searches that found a model.
    pub searches: u64,
    /// Searches that found none.
    pub failed: u64,
    /// By name, the parameters that some of these models have.
    pub parameters: BTreeMap<String, ResampledParameter>,
}

/// One parameter over these models, 0 in those without its term.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ResampledParameter {
    /// Models that have its term.
    pub chosen: u64,
    /// 2.5 % of the values are below.
    pub low: f64,
    /// 2.5 % are above.
    pub high: f64,
}

impl Study<'_> {
    /// Searches for few terms over recordings that are drawn with replacement, the same number of every kind: ridge,
    /// terms and parameters are found again each time. `None` if fewer than two of these searches find a model.
    pub fn resampled(&self, wanted: BootstrapOptions, done: &(dyn Fn(usize) + Sync)) -> Option<Resampled> {
        let streams = Streams::new(wanted.seed, "bootstrap over recordings");
        let one = |number: u32| {
            let found = self.searched_again(&draw_again(self.recordings, &streams, number));
            done(1);
            found
        };
        let all: Vec<Option<Fitted>> = (0..wanted.resamples).into_par_iter().map(one).collect();
        let failed = all.iter().filter(|found| found.is_none()).count() as u64;
        let found: Vec<Fitted> = all.into_iter().flatten().collect();
        (found.len() > 1).then(|| Resampled {
            parameters: summed_up(&found),
            searches: found.len() as u64,
            failed,
        })
    }

    /// The model of few terms that a search over the recordings at `drawn` finds.
    fn searched_again(&self, drawn: &[usize]) -> Option<Fitted> {
        let recordings: Vec<Recording> = drawn.iter().map(|i| self.recordings[*i].clone()).collect();
        let again = Study {
            base: self.base,
            library: self.library,
            recordings: &recordings,
            folds: &folds_of_drawn(self.recordings, drawn, self.all_folds().end),
            ridges: self.ridges,
            rate_hz: self.rate_hz,
            std: varying(recordings.iter(), Laid::SideBySide),
            overlapping_std: varying(recordings.iter(), Laid::Overlapping),
            choosing_std: varying(recordings.iter(), Laid::Choosing),
            whole_runs: self.whole_runs,
        };
        let choice = again.choice();
        let ridge = choice.candidates[choice.best()?].ridge;
        let (base, folds) = (again.base_of_all()?, again.others(None));
        let places = again.compact(&base, &folds, ridge)?.places;
        again.fitted(&places, &base, &folds, ridge)
    }
}

/// The quantiles over `found` of every parameter that one of them has.
fn summed_up(found: &[Fitted]) -> BTreeMap<String, ResampledParameter> {
    let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for own in found {
        let layout = own.model.layout();
        let named = own.model.parameter_names().zip(&own.theta).zip(layout.are_intercepts());
        for ((name, value), _) in named.filter(|(_, intercept)| !intercept) {
            values.entry(name.to_owned()).or_default().push(*value);
        }
    }
    let summary = |(name, own): (String, Vec<f64>)| {
        let chosen = own.len() as u64;
        let absent = std::iter::repeat_n(0.0, found.len() - own.len());
        let all = sorted(own.into_iter().chain(absent).map(Some));
        let at = |q: f64| quantile(&all, q).unwrap_or(0.0);
        (name, ResampledParameter { chosen, low: at(0.025), high: at(0.975) })
    };
    values.into_iter().map(summary).collect()
}

/// Least number of distinct recordings of a resample: with fewer, no fold can be left out.
const DISTINCT: usize = 3;
/// Maximum number of draws for a resample with enough distinct recordings.
const DRAWS: u32 = 1000;

/// Indices of `recordings` drawn with replacement, the same number of every kind. Depends on the stream and the
/// number alone.
pub fn draw_again(recordings: &[Recording], streams: &Streams, number: u32) -> Vec<usize> {
    let mut order: Vec<usize> = (0..recordings.len()).collect();
    order.sort_by_key(|i| recordings[*i].kind());
    let groups: Vec<&[usize]> =
        order.chunk_by(|a, b| recordings[*a].kind() == recordings[*b].kind()).collect();
    let mut drawn = Vec::new();
    for attempt in 0..DRAWS {
        drawn = Vec::with_capacity(recordings.len());
        for (i, group) in groups.iter().enumerate() {
            let channel = attempt * groups.len() as u32 + i as u32;
            let choices = streams.choices(number, channel, group.len() as u32, group.len());
            drawn.extend(choices.into_iter().map(|place| group[place as usize]));
        }
        drawn.sort_unstable();
        if drawn.chunk_by(|a, b| a == b).count() >= DISTINCT.min(recordings.len()) {
            break;
        }
    }
    drawn
}

/// The folds of the recordings at `drawn`, in ascending order: one that was drawn several times is in one fold, since
/// otherwise the models would be fitted to the recordings that are left out.
pub fn folds_of_drawn(recordings: &[Recording], drawn: &[usize], count: usize) -> Vec<usize> {
    let mut distinct = drawn.to_vec();
    distinct.dedup();
    let own: Vec<&Recording> = distinct.iter().map(|i| &recordings[*i]).collect();
    let found = folds(&own, count.min(own.len()));
    drawn.iter().map(|i| found[distinct.partition_point(|own| own < i)]).collect()
}
