use std::collections::BTreeMap;

use numerics::statistics::{quantile, sorted};
use rayon::prelude::*;
use regression::pooled::Part;
use ship::engine::Streams;
use ship::model::Model;

use super::compact::{delivered, without_intercepts};
use super::judged::ships;
use super::nested::{Fitted, Nested, Study};
use super::{Laid, Recording, folds, limit, scores_of_mean, together, varying};
use crate::pooled::Delivered;

/// How many models are averaged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct AverageOptions {
    /// Their number, at least two.
    pub models: u32,
    /// The seed of the draws of recordings that each structure is found on.
    pub seed: u64,
}

/// Models of few terms whose trajectories are averaged.
#[derive(Clone, Debug, PartialEq)]
pub struct Averaged {
    /// The models, in the order of their draws.
    pub members: Vec<Member>,
    /// RMSE of their mean trajectory over the recordings; `None` if a model diverges.
    pub output_rmse: Option<[f64; 3]>,
}

/// One of several models.
#[derive(Clone, Debug, PartialEq)]
pub struct Member {
    /// Its structure.
    pub model: Model,
    /// The model with this structure, fitted to all recordings.
    pub delivered: Delivered,
    /// The recordings that its structure was found on.
    pub found_on: Vec<String>,
}

/// A model, and the recordings that its structure was found on.
pub(crate) type Drawn = (Fitted, Vec<String>);

/// The models of all recordings, and those without each fold: `None` if one cannot be found.
pub(crate) struct Averages {
    all: Vec<Drawn>,
    pub by_folds: Vec<Option<Vec<Fitted>>>,
}

impl Study<'_> {
    /// Finds the `wanted` models, each structure on some recordings and fitted to all; again without each fold.
    pub fn averages(
        &self,
        nested: &Nested,
        chosen: usize,
        wanted: AverageOptions,
        done: &(dyn Fn(usize) + Sync),
    ) -> Option<Averages> {
        let sets: Vec<Option<usize>> = std::iter::once(None).chain(self.all_folds().map(Some)).collect();
        let given: Vec<Option<(f64, Vec<f64>)>> =
            sets.par_iter().map(|without| self.given(nested, chosen, *without)).collect();
        let numbers = 0..wanted.models;
        let jobs: Vec<(usize, u32)> =
            (0..sets.len()).flat_map(|set| numbers.clone().map(move |number| (set, number))).collect();
        let find = |(set, number): (usize, u32)| {
            let (ridge, base) = given[set].as_ref()?;
            let drawn = self.drawn(sets[set], (base, *ridge), wanted.seed, number);
            done(1);
            drawn
        };
        let mut members: Vec<Option<Drawn>> = jobs.into_par_iter().map(find).collect();
        let without = members.split_off(wanted.models as usize);
        let fitted = |drawn: &mut [Option<Drawn>]| {
            drawn.iter_mut().map(|member| Some(member.take()?.0)).collect::<Option<Vec<_>>>()
        };
        let mut without = without;
        let by_folds = without.chunks_mut(wanted.models as usize).map(fitted).collect();
        Some(Averages { all: members.into_iter().collect::<Option<_>>()?, by_folds })
    }

    /// Model `number`, whose structure is found on the recordings that it draws, and that is fitted to all but one fold.
    fn drawn(
        &self,
        without: Option<usize>,
        (base, ridge): (&[f64], f64),
        seed: u64,
        number: u32,
    ) -> Option<Drawn> {
        let recordings = self.picked(|fold| Some(fold) != without);
        let purpose = without.map_or("average".to_owned(), |fold| format!("average without fold {fold}"));
        let drawn = draw_most(&recordings, &Streams::new(seed, &purpose), number);
        let count = self.all_folds().end.min(drawn.len());
        let dealt = folds(&drawn, count);
        let of = |fold: usize| {
            drawn
                .iter()
                .zip(&dealt)
                .filter(|(_, of_recording)| **of_recording == fold)
                .map(|(r, _)| *r)
                .collect()
        };
        let within: Vec<Vec<&Recording>> = (0..count).map(of).collect();
        let places = self.compact(base, &within, ridge)?.places;
        let fitted = self.fitted(&places, base, &self.others(without), ridge)?;
        Some((fitted, drawn.iter().map(|recording| recording.name.clone()).collect()))
    }
}

impl Averages {
    /// The models with their errors, for the result.
    pub fn delivered(self, recordings: &[Recording], parts: &[Part]) -> Averaged {
        let (fitted, found_on): (Vec<Fitted>, Vec<Vec<String>>) = self.all.into_iter().unzip();
        let all: Vec<&Recording> = recordings.iter().collect();
        let followed = scores_of_mean(&ships(&fitted), &all, Laid::SideBySide, limit(&all));
        let member = |(fitted, found_on): (&Fitted, Vec<String>)| {
            let model = without_intercepts(&fitted.model);
            Member { delivered: delivered(&model, fitted, recordings, parts), model, found_on }
        };
        let members = fitted.iter().zip(found_on).map(member).collect();
        Averaged { members, output_rmse: together(followed.iter()).rmse() }
    }
}

pub(crate) fn share(recordings: usize) -> usize {
    (7 * recordings + 5) / 10
}

/// Seven tenths of `recordings`, of each kind alike, in their order. Depends on stream and number alone.
pub fn draw_most<'a>(recordings: &[&'a Recording], streams: &Streams, number: u32) -> Vec<&'a Recording> {
    let all = recordings.len();
    let mut rest: Vec<usize> = (0..all).collect();
    let mut order = Vec::with_capacity(all);
    for channel in 0..all as u32 {
        let place = streams.choices(number, channel, rest.len() as u32, 1)[0];
        order.push(rest.swap_remove(place as usize));
    }
    // Recordings of one kind stay in the order of the draw.
    order.sort_by_key(|i| recordings[*i].kind());
    // Evenly spaced in that order, so that each kind has its share, with a random offset.
    let first = streams.choices(number, all as u32, all as u32, 1)[0] as usize;
    let before = |place: usize| (place * share(all) + first) / all;
    let mut drawn: Vec<usize> =
        (0..all).filter(|place| before(place + 1) > before(*place)).map(|place| order[place]).collect();
    drawn.sort_unstable();
    drawn.into_iter().map(|i| recordings[i]).collect()
}

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
    /// Searches for few terms over recordings drawn with replacement; `None` if fewer than two of these find a model.
    pub fn resampled(&self, wanted: BootstrapOptions, done: &(dyn Fn(usize) + Sync)) -> Option<Resampled> {
        let streams = Streams::new(wanted.seed, "bootstrap over recordings");
        let one = |number: u32| {
            let model = self.searched_again(&draw_again(self.recordings, &streams, number));
            done(1);
            model
        };
        let all: Vec<Option<Fitted>> = (0..wanted.resamples).into_par_iter().map(one).collect();
        let failed = all.iter().filter(|fitted| fitted.is_none()).count() as u64;
        let all: Vec<Fitted> = all.into_iter().flatten().collect();
        (all.len() > 1).then(|| Resampled { parameters: summed_up(&all), searches: all.len() as u64, failed })
    }

    /// The model of few terms that a search over the recordings at `drawn` finds.
    fn searched_again(&self, drawn: &[usize]) -> Option<Fitted> {
        let recordings: Vec<Recording> = drawn.iter().map(|i| self.recordings[*i].clone()).collect();
        let again = Study {
            recordings: &recordings,
            folds: &folds_of_drawn(self.recordings, drawn, self.all_folds().end),
            std: varying(recordings.iter(), Laid::SideBySide),
            overlapping_std: varying(recordings.iter(), Laid::Overlapping),
            choosing_std: varying(recordings.iter(), Laid::Choosing),
            ..*self
        };
        let choice = again.choice();
        let ridge = choice.candidates[choice.best()?].ridge;
        let (base, folds) = (again.base_of_all()?, again.others(None));
        let places = again.compact(&base, &folds, ridge)?.places;
        again.fitted(&places, &base, &folds, ridge)
    }
}

/// The quantiles over `models` of every parameter that one of them has.
fn summed_up(models: &[Fitted]) -> BTreeMap<String, ResampledParameter> {
    let mut values: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for fitted in models {
        let layout = fitted.model.layout();
        let named = fitted.model.parameter_names().zip(&fitted.theta).zip(layout.are_intercepts());
        for ((name, value), _) in named.filter(|(_, intercept)| !intercept) {
            values.entry(name.to_owned()).or_default().push(*value);
        }
    }
    let summary = |(name, values): (String, Vec<f64>)| {
        let chosen = values.len() as u64;
        let absent = std::iter::repeat_n(0.0, models.len() - values.len());
        let all = sorted(values.into_iter().chain(absent).map(Some));
        let at = |q: f64| quantile(&all, q).unwrap_or(0.0);
        (name, ResampledParameter { chosen, low: at(0.025), high: at(0.975) })
    };
    values.into_iter().map(summary).collect()
}

/// Least number of distinct recordings of a resample: with fewer, no fold can be left out.
const DISTINCT: usize = 3;
/// Maximum number of draws for a resample with enough distinct recordings.
const DRAWS: u32 = 1000;

/// Indices drawn with replacement, as many of every kind. Depends on stream and number alone.
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
    let kept: Vec<&Recording> = distinct.iter().map(|i| &recordings[*i]).collect();
    let dealt = folds(&kept, count.min(kept.len()));
    drawn.iter().map(|i| dealt[distinct.partition_point(|drawn| drawn < i)]).collect()
}
