use crate::pooled::Delivered;
use rayon::prelude::*;
use regression::pooled::Part;
use ship::engine::Streams;
use ship::model::Model;

use crate::search::deliver::{delivered, without_intercepts};
use crate::search::folds::folds;
use crate::search::left_out::ships;
use crate::search::nested::{Fitted, Nested, Study};
use crate::search::problem::limit;
use crate::search::recording::{Laid, Recording};
use crate::search::scores::{scores_of_mean, together};

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
    /// Finds the `wanted` number of models, each structure on some of the recordings and fitted to all; again without
    /// each fold. The ridge and the base structure's fit were found before. `None` if a model cannot be found.
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
            let found = self.drawn(sets[set], (base, *ridge), wanted.seed, number);
            done(1);
            found
        };
        let mut found: Vec<Option<Drawn>> = jobs.into_par_iter().map(find).collect();
        let without = found.split_off(wanted.models as usize);
        let fitted = |own: &mut [Option<Drawn>]| {
            own.iter_mut().map(|found| Some(found.take()?.0)).collect::<Option<Vec<_>>>()
        };
        let mut without = without;
        let by_folds = without.chunks_mut(wanted.models as usize).map(fitted).collect();
        Some(Averages { all: found.into_iter().collect::<Option<_>>()?, by_folds })
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
            drawn.iter().zip(&dealt).filter(|(_, own)| **own == fold).map(|(r, _)| *r).collect()
        };
        let within: Vec<Vec<&Recording>> = (0..count).map(of).collect();
        let places = self.compact(base, &within, ridge)?.places;
        let fitted = self.fitted(&places, base, &self.others(without), ridge)?;
        Some((fitted, drawn.iter().map(|own| own.name.clone()).collect()))
    }
}

impl Averages {
    /// The models with their errors, for the result.
    pub fn delivered(self, recordings: &[Recording], parts: &[Part]) -> Averaged {
        let (fitted, found_on): (Vec<Fitted>, Vec<Vec<String>>) = self.all.into_iter().unzip();
        let all: Vec<&Recording> = recordings.iter().collect();
        let followed = scores_of_mean(&ships(&fitted), &all, Laid::SideBySide, limit(&all));
        let member = |(found, found_on): (&Fitted, Vec<String>)| {
            let model = without_intercepts(&found.model);
            Member { delivered: delivered(&model, found, recordings, parts), model, found_on }
        };
        let members = fitted.iter().zip(found_on).map(member).collect();
        Averaged { members, output_rmse: together(followed.iter()).rmse() }
    }
}

/// The number of recordings that a structure is found on: seven tenths.
pub(crate) fn share(recordings: usize) -> usize {
    (7 * recordings + 5) / 10
}

/// Seven tenths of `recordings`, with the same share of each kind as far as possible, in their order. Depends on the
/// stream and the number alone.
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
