//! Every leg, carried out before the search by whoever may have to sail it.

use std::sync::Arc;

use chart::Footprint;
use rayon::prelude::*;
use vessel::{Invalid, Pose};

use super::counts::Wanted;
use super::error::VoyageError;
use crate::{Grid, Leg, Outcome, Purpose, Rehearser, Repertoire, Sailed, Settled, Side};

/// How far a rehearsed track's corners are apart at most, in raster cells, and how far it turns between them \[rad\].
const APART: f64 = 0.25;
const TURNED: f64 = 0.1;

/// A leg that all who rehearsed it end settled.
#[derive(Clone, Debug)]
pub struct Rehearsed {
    /// What is carried out.
    pub leg: Leg,
    /// What the nominal model sails in the known current, from the origin.
    pub sailed: Sailed,
    /// Where that ends.
    pub end: Pose,
    /// Where it leads other vessels, in currents that are not known, from wherever legs may end: their poses.
    pub strayed: Vec<Vec<Pose>>,
    /// Name of the action.
    pub name: String,
    /// Index of the group of legs that it was rehearsed with.
    pub(super) group: usize,
}

/// A leg that the search is not offered.
#[derive(Clone, Debug, PartialEq)]
pub struct Dropped {
    /// Name of the action.
    pub name: String,
    /// Which way, for a maneuver.
    pub side: Option<Side>,
    /// Heading level and mode that it would begin from.
    pub from: usize,
    /// Why.
    pub why: String,
}

/// Legs that begin alike and are rehearsed together.
#[derive(Clone, Debug)]
pub(super) struct Group {
    level: usize,
    what: What,
    /// Who showed in a check that a leg of theirs is not as good as it was thought to be.
    taught: Vec<Rehearser>,
    /// What rehearsals came to; nothing where someone has not rehearsed yet.
    outcomes: Option<Arc<Vec<Outcome>>>,
}

#[derive(Clone, Copy, Debug)]
enum What {
    /// The basic moves of a mode.
    Basic(usize),
    /// A piece.
    Informative(usize),
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

    /// The largest distance between where those who rehearsed it and the nominal vessel are at the same time before the
    /// recovery \[m\].
    pub fn spread_m(&self) -> f64 {
        let open = self.sailed.samples.iter().rposition(|s| s.informative);
        let Some(own) = open.map(|last| self.sailed.samples[last].pose) else { return 0.0 };
        let others = self.strayed.iter().filter_map(|track| track.get(open.unwrap_or(0)));
        others.map(|pose| libm::hypot(pose.x - own.x, pose.y - own.y)).fold(0.0, f64::max)
    }

    /// The area that the hull sweeps, by any of the vessels that rehearsed the leg.
    pub(super) fn footprint(&self, hull: &[[f64; 2]], cell_m: f64) -> Result<Footprint, Invalid> {
        let swept = |poses: &[Pose]| {
            let poses: Vec<(f64, f64, f64)> = thinned(poses, cell_m).map(|p| (p.y, p.x, p.psi)).collect();
            Footprint::swept(hull, &poses, cell_m)
        };
        let nominal: Vec<Pose> = self.sailed.samples.iter().map(|s| s.pose).chain([self.end]).collect();
        self.strayed.iter().try_fold(swept(&nominal)?, |whole, poses| Ok(whole.union(&swept(poses)?)))
    }
}

/// The poses between which a track is straight to a fraction of a raster cell, the last among them.
fn thinned(poses: &[Pose], cell_m: f64) -> impl Iterator<Item = Pose> {
    let mut kept: Option<Pose> = None;
    poses.iter().enumerate().filter_map(move |(index, pose)| {
        let near = kept.is_some_and(|kept| {
            libm::hypot(pose.x - kept.x, pose.y - kept.y) < APART * cell_m
                && (pose.psi - kept.psi).abs() < TURNED
        });
        if near && index + 1 < poses.len() {
            return None;
        }
        kept = Some(*pose);
        kept
    })
}

/// The groups of legs of a lattice: from all heading levels, or from those of a quarter turn where all directions of the sea
/// are alike.
pub(super) fn groups(repertoire: &Repertoire) -> Vec<Group> {
    let grid = repertoire.grid;
    let levels = if repertoire.is_isotropic() { grid.headings / 4 } else { grid.headings };
    let basic = (0..grid.modes.len()).map(What::Basic);
    let all = basic.chain((0..repertoire.pieces.len()).map(What::Informative));
    all.flat_map(|what| {
        (0..levels).map(move |level| Group { level, what, taught: Vec::new(), outcomes: None })
    })
    .collect()
}

/// Rehearses the legs of every group by `others`, and by those who taught the group, unless they have done so.
pub(super) fn rehearse(
    repertoire: &Repertoire,
    groups: &mut [Group],
    wanted: &[Wanted],
    others: &[Rehearser],
    go_on: &(dyn Fn() -> bool + Sync),
) -> Result<(Vec<Rehearsed>, Vec<Dropped>), VoyageError> {
    groups.par_iter_mut().filter(|group| group.outcomes.is_none()).try_for_each(|group| {
        if !go_on() {
            return Err(VoyageError::OutOfTime("the rehearsal of legs"));
        }
        group.outcomes = Some(Arc::new(group.rehearsed(repertoire, others)?));
        Ok(())
    })?;
    let name = |purpose: &Purpose| match purpose {
        Purpose::Basic(name) => name.clone(),
        Purpose::Informative { piece, .. } => wanted[*piece].piece.maneuver.clone(),
    };
    let (mut rehearsed, mut dropped) = (Vec::new(), Vec::new());
    let quarters = if repertoire.is_isotropic() { 4 } else { 1 };
    for (index, group) in groups.iter().enumerate() {
        let outcomes = group.outcomes.as_deref().map_or(&[][..], |outcomes| outcomes);
        for (quarter, outcome) in (0..quarters).flat_map(|q| outcomes.iter().map(move |o| (q, o))) {
            match outcome {
                Ok(settled) => {
                    rehearsed.push(Rehearsed::new(settled, quarter, repertoire.grid, index, &name))
                }
                Err(unsettled) => dropped.push(Dropped {
                    name: name(&unsettled.purpose),
                    side: unsettled.purpose.side(),
                    from: repertoire.grid.turned(unsettled.from, quarter),
                    why: unsettled.why.clone(),
                }),
            }
        }
    }
    Ok((rehearsed, dropped))
}

impl Rehearsed {
    fn new(
        settled: &Settled,
        quarter: usize,
        grid: &Grid,
        group: usize,
        name: &dyn Fn(&Purpose) -> String,
    ) -> Self {
        let Settled { leg, sailed, tracks } = settled.turned(quarter, grid);
        let end = sailed.ends.last().map(|(pose, _)| *pose).unwrap_or_default();
        Self { name: name(&leg.purpose), leg, sailed, end, strayed: tracks, group }
    }
}

impl Group {
    /// Lets `who` rehearse, too, from now on.
    pub(super) fn learn(&mut self, who: Rehearser) {
        self.taught.push(who);
        self.outcomes = None;
    }

    fn rehearsed(&self, repertoire: &Repertoire, others: &[Rehearser]) -> Result<Vec<Outcome>, Invalid> {
        let all: Vec<Rehearser> = others.iter().chain(&self.taught).cloned().collect();
        match self.what {
            What::Basic(mode) => repertoire.basic(self.level, mode, &all),
            What::Informative(piece) => repertoire.informative(piece, self.level, &all),
        }
    }
}
