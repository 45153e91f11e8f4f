//! Every leg, carried out once before the search.

use chart::Footprint;
use rayon::prelude::*;
use vessel::{Invalid, Pose};

use super::counts::Wanted;
use crate::{Leg, Purpose, Repertoire, Sailed, basic_legs};

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

/// Carries out every leg of the repertoire by the nominal model, informative ones by each of `others`, too.
pub(super) fn rehearse(
    repertoire: &Repertoire,
    wanted: &[Wanted],
    others: &[Vec<f64>],
) -> Result<Vec<Rehearsed>, Invalid> {
    let mut legs = basic_legs(repertoire.grid, repertoire.handling);
    let pieces = (0..wanted.len()).into_par_iter();
    let informative: Vec<Vec<Leg>> =
        pieces.map(|piece| repertoire.informative(piece)).collect::<Result<_, _>>()?;
    legs.extend(informative.into_iter().flatten());
    let one = |leg: Leg| {
        let (sailed, end) = repertoire.rehearse(&leg)?;
        let (name, others) = match &leg.purpose {
            Purpose::Basic(name) => (name.clone(), &[][..]),
            Purpose::Informative { piece, .. } => (wanted[*piece].piece.maneuver.clone(), others),
        };
        let stray =
            |parameters: &Vec<f64>| repertoire.rehearse_with(&leg, parameters).map(|(s, end)| track(&s, end));
        let strayed = others.iter().map(stray).collect::<Result<_, _>>()?;
        Ok(Rehearsed { leg, sailed, end, strayed, name })
    };
    legs.into_par_iter().map(one).collect()
}

/// Poses of all samples, and the last.
fn track(sailed: &Sailed, end: Pose) -> Vec<Pose> {
    sailed.samples.iter().map(|s| s.pose).chain([end]).collect()
}
