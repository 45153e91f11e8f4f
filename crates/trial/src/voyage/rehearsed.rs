//! Every leg, carried out once before the search.

use chart::Footprint;
use rayon::prelude::*;
use vessel::{Invalid, Pose};

use super::counts::Wanted;
use super::error::VoyageError;
use crate::{Astray, Leg, Purpose, Repertoire, Sailed, basic_legs};

/// A leg, carried out from the origin by the nominal model in the known current.
#[derive(Clone, Debug)]
pub struct Rehearsed {
    /// What is carried out.
    pub leg: Leg,
    /// What is sailed.
    pub sailed: Sailed,
    /// Where it ends.
    pub end: Pose,
    /// Where it leads vessels with other parameters: their poses.
    pub strayed: Vec<Vec<Pose>>,
    /// Name of the action.
    pub name: String,
}

impl Rehearsed {
    /// How long it takes \[s\].
    pub fn seconds(&self, rate_hz: f64) -> f64 {
        self.sailed.samples.len() as f64 / rate_hz
    }

    /// How long its open-loop part takes \[samples\].
    pub fn open_loop(&self) -> usize {
        self.sailed.samples.iter().filter(|s| s.informative).count()
    }

    /// Whether it is an informative maneuver.
    pub fn is_informative(&self) -> bool {
        matches!(self.leg.purpose, Purpose::Informative { .. })
    }

    /// The area that the hull sweeps, by any of the vessels that rehearsed the leg.
    pub(super) fn footprint(&self, hull: &[[f64; 2]], cell_m: f64) -> Result<Footprint, Invalid> {
        let swept = |poses: &[Pose]| {
            let poses: Vec<(f64, f64, f64)> = poses.iter().map(|p| (p.y, p.x, p.psi)).collect();
            Footprint::swept(hull, &poses, cell_m)
        };
        let nominal = swept(&track(&self.sailed, self.end))?;
        self.strayed.iter().try_fold(nominal, |whole, poses| Ok(whole.union(&swept(poses)?)))
    }
}

/// Carries out every leg of the repertoire by the nominal model, and by each of `others`.
pub(super) fn rehearse(
    repertoire: &Repertoire,
    wanted: &[Wanted],
    others: &[Vec<f64>],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<Vec<Rehearsed>, VoyageError> {
    let mut legs = basic_legs(repertoire.grid, repertoire.handling);
    let pieces = (0..wanted.len()).into_par_iter();
    let informative: Vec<Vec<Leg>> =
        pieces.map(|piece| in_time(go_on, || repertoire.informative(piece))).collect::<Result<_, _>>()?;
    legs.extend(informative.into_iter().flatten());
    let each = others.par_iter().map(|parameters| in_time(go_on, || strays(repertoire, &legs, parameters)));
    let each: Vec<Vec<Vec<Vec<Pose>>>> = each.collect::<Result<_, VoyageError>>()?;
    let mut strayed = vec![Vec::new(); legs.len()];
    for of_vessel in each {
        strayed.iter_mut().zip(of_vessel).for_each(|(all, own)| all.extend(own));
    }
    let one = |(leg, strayed): (Leg, Vec<Vec<Pose>>)| {
        let (sailed, end) = in_time(go_on, || repertoire.rehearse(&leg))?;
        let name = match &leg.purpose {
            Purpose::Basic(name) => name.clone(),
            Purpose::Informative { piece, .. } => wanted[*piece].piece.maneuver.clone(),
        };
        Ok(Rehearsed { leg, sailed, end, strayed, name })
    };
    legs.into_par_iter().zip(strayed).map(one).collect()
}

/// What `work` gives, unless the time is over.
fn in_time<T>(
    go_on: &(dyn Fn() -> bool + Sync),
    work: impl Fn() -> Result<T, Invalid>,
) -> Result<T, VoyageError> {
    if go_on() { Ok(work()?) } else { Err(VoyageError::OutOfTime("the rehearsal of legs")) }
}

/// Where every leg leads a vessel with other `parameters`: from its node, and from as far off it as an earlier leg leaves
/// the vessel. Errors chain: a vessel whose maneuvers end astray begins the next leg there.
fn strays(repertoire: &Repertoire, legs: &[Leg], parameters: &[f64]) -> Result<Vec<Vec<Vec<Pose>>>, Invalid> {
    let from_node = |leg| repertoire.rehearse_with(leg, parameters, None);
    let first = legs.iter().map(from_node).collect::<Result<Vec<_>, _>>()?;
    let mut worst: Vec<Option<Astray>> = vec![None; repertoire.grid.layers()];
    for (leg, (sailed, _)) in legs.iter().zip(&first) {
        let end = repertoire.astray(leg, sailed);
        let known = &mut worst[leg.to];
        if end.is_some_and(|end| known.is_none_or(|worst| end.distance_m() > worst.distance_m())) {
            *known = end;
        }
    }
    let again = |(leg, (sailed, end)): (&Leg, &(Sailed, Pose))| {
        let mut tracks = vec![track(sailed, *end)];
        if let Some(start) = &worst[leg.from] {
            let (sailed, end) = repertoire.rehearse_with(leg, parameters, Some(start))?;
            tracks.push(track(&sailed, end));
        }
        Ok(tracks)
    };
    legs.iter().zip(&first).map(again).collect()
}

/// Poses of all samples, and the last.
fn track(sailed: &Sailed, end: Pose) -> Vec<Pose> {
    sailed.samples.iter().map(|s| s.pose).chain([end]).collect()
}
