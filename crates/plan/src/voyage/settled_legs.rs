//! Simulates every leg before the search, by the nominal and the sampled vessels.

use std::sync::Arc;

use chart::Footprint;
use rayon::prelude::*;
use refusal::Invalid;
use ship::engine::{Pose, Run};
use trial::Piece;

use super::error::VoyageError;
use super::task::{Brief, ManeuverUse, Shares};
use crate::{
    BASIC_MOVES, Farthest, Grid, Leg, Outcome, Purpose, Repertoire, Sailed, SampledVessel, Settled, Side,
    Unsettled,
};

/// Greatest distance of a track's poses in raster cells, and greatest turn between them \[rad\].
const APART: f64 = 0.25;
const TURNED: f64 = 0.1;

/// A leg on which all sampled vessels settle.
#[derive(Clone, Debug)]
pub struct SettledLeg {
    /// The leg.
    pub leg: Leg,
    /// The trajectory of the nominal model in the known current, from the origin.
    pub sailed: Sailed,
    /// Its end.
    pub end: Pose,
    /// The longest time that it takes the nominal or a sampled vessel \[samples\].
    pub longest: usize,
    /// The sampled vessel, in an unknown current and from its offset, that is farthest from the nominal one at
    /// the same time before the recovery.
    pub farthest: Option<Farthest>,
    /// Name of the action.
    pub name: String,
    /// The area that the hull sweeps, for any of these vessels.
    pub(super) footprint: Footprint,
    /// Index of its group of legs.
    pub(super) group: usize,
}

/// A leg after its simulation: to be offered, or dropped.
type Tried = Result<Arc<SettledLeg>, Dropped>;

/// A leg that is not offered to the search.
#[derive(Clone, Debug, PartialEq)]
pub struct Dropped {
    /// Name of the action.
    pub name: String,
    /// The side, for a maneuver.
    pub side: Option<Side>,
    /// Heading level and mode at its beginning.
    pub from: usize,
    /// The reason.
    pub why: String,
    /// Parameters of the vessel that does not settle; `None` for the nominal one.
    pub parameters: Option<Vec<f64>>,
}

/// Legs with the same beginning, which are simulated together.
#[derive(Clone, Debug)]
pub(super) struct LegGroup {
    level: usize,
    what: What,
    /// Counter-examples from checks for legs of this group.
    counter_examples: Vec<SampledVessel>,
    /// Results of the simulations; `None` if vessels were added since.
    outcomes: Option<Arc<Vec<Tried>>>,
}

/// The data for simulating legs.
pub(super) struct LegSimulation<'a> {
    pub repertoire: Repertoire<'a>,
    pub wanted: &'a [Wanted],
    /// The sampled vessels of every leg.
    pub others: &'a [SampledVessel],
    /// Outline of the hull \[m\], and the size of the cells of its footprint \[m\].
    pub hull: Vec<[f64; 2]>,
    pub cell_m: f64,
}

#[derive(Clone, Copy, Debug)]
enum What {
    /// The basic moves of a mode.
    Basic(usize),
    /// A piece.
    Informative(usize),
}

impl SettledLeg {
    /// Its duration \[s\].
    pub fn seconds(&self, rate_hz: f64) -> f64 {
        self.sailed.samples.len() as f64 / rate_hz
    }

    /// Duration of its maneuver \[samples\].
    pub fn maneuver(&self) -> usize {
        self.sailed.samples.iter().filter(|s| s.informative).count()
    }

    /// The leg rotated to port by quarter turns.
    fn turned(&self, quarters: usize, grid: &Grid) -> Self {
        let Self { name, leg, sailed, .. } = self.clone();
        let Settled { leg, sailed, .. } =
            Settled { leg, sailed, tracks: Vec::new(), farthest: None }.turned(quarters, grid);
        let footprint = self.footprint.turned(quarters);
        let (end, farthest) = (end(&sailed), self.farthest.clone());
        Self { name, leg, end, sailed, footprint, farthest, ..*self }
    }

    /// The largest distance of a sampled vessel from the nominal one after a maneuver \[m\].
    pub fn spread_m(&self) -> f64 {
        self.farthest.as_ref().map_or(0.0, |farthest| farthest.distance_m)
    }

    /// Whether it is an informative maneuver.
    pub fn is_informative(&self) -> bool {
        matches!(self.leg.purpose, Purpose::Informative { .. })
    }
}

/// Poses between which a track is straight to a fraction of a raster cell, including the last.
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

/// The groups of legs of a lattice: from all heading levels, or from those of a quarter turn if all directions are equivalent.
pub(super) fn groups(repertoire: &Repertoire) -> Vec<LegGroup> {
    let grid = repertoire.grid;
    let levels = if repertoire.is_isotropic() { grid.headings / 4 } else { grid.headings };
    let basic = (0..grid.modes.len()).map(What::Basic);
    let all = basic.chain((0..repertoire.pieces.len()).map(What::Informative));
    all.flat_map(|what| {
        (0..levels).map(move |level| LegGroup { level, what, counter_examples: Vec::new(), outcomes: None })
    })
    .collect()
}

impl LegSimulation<'_> {
    /// Simulates the legs of every group with the sampled vessels and the group's counter-examples, unless done already.
    pub fn run(
        &self,
        groups: &mut [LegGroup],
        keep_going: &(dyn Fn() -> bool + Sync),
    ) -> Result<(Vec<Arc<SettledLeg>>, Vec<Dropped>), VoyageError> {
        let new = groups.par_iter_mut().enumerate().filter(|(_, group)| group.outcomes.is_none());
        new.try_for_each(|(index, group)| {
            if !keep_going() {
                return Err(VoyageError::OutOfTime("the simulation of legs"));
            }
            group.outcomes = Some(Arc::new(self.tried(group, index)?));
            Ok(())
        })?;
        let (mut legs, mut dropped) = (Vec::new(), Vec::new());
        let all = groups.iter().filter_map(|group| group.outcomes.as_deref()).flatten();
        all.for_each(|tried| match tried {
            Ok(leg) => legs.push(leg.clone()),
            Err(reason) => dropped.push(reason.clone()),
        });
        Ok((legs, dropped))
    }

    /// The legs of a group, from its heading level and from those that lie quarter turns to port of it.
    fn tried(&self, group: &LegGroup, index: usize) -> Result<Vec<Tried>, Invalid> {
        let (grid, outcomes) = (self.repertoire.grid, group.simulated(&self.repertoire, self.others)?);
        let tried = |outcome: Outcome| match outcome {
            Ok(settled) => self.settled_leg(settled, index).map(Ok),
            Err(Unsettled { from, purpose, why, parameters }) => {
                Ok(Err(Dropped { name: self.name(&purpose), side: purpose.side(), from, why, parameters }))
            }
        };
        let settled = outcomes.into_iter().map(tried).collect::<Result<Vec<_>, Invalid>>()?;
        let quarters = if self.repertoire.is_isotropic() { 4 } else { 1 };
        let all = (0..quarters).flat_map(|quarter| settled.iter().map(move |outcome| (quarter, outcome)));
        let turned = |(quarter, outcome): (usize, &Result<SettledLeg, Dropped>)| match outcome {
            Ok(leg) => Ok(Arc::new(leg.turned(quarter, grid))),
            Err(failed) => Err(Dropped { from: grid.turned(failed.from, quarter), ..failed.clone() }),
        };
        Ok(all.map(turned).collect())
    }

    fn name(&self, purpose: &Purpose) -> String {
        match purpose {
            Purpose::Basic(name) => name.clone(),
            Purpose::Informative { piece, .. } => self.wanted[*piece].piece.maneuver.clone(),
        }
    }

    fn settled_leg(&self, settled: Settled, group: usize) -> Result<SettledLeg, Invalid> {
        let footprint = self.footprint(&settled)?;
        let Settled { leg, sailed, farthest, tracks } = settled;
        let end = end(&sailed);
        let longest = tracks.iter().map(|poses| poses.len() - 1).fold(sailed.samples.len(), usize::max);
        let name = self.name(&leg.purpose);
        Ok(SettledLeg { name, leg, sailed, end, longest, farthest, footprint, group })
    }

    fn footprint(&self, Settled { sailed, tracks, .. }: &Settled) -> Result<Footprint, Invalid> {
        let swept = |poses: &[Pose]| {
            let poses: Vec<_> = thinned(poses, self.cell_m).map(|p| (p.y, p.x, p.psi)).collect();
            Footprint::swept(&self.hull, &poses, self.cell_m)
        };
        let nominal: Vec<Pose> = sailed.samples.iter().map(|s| s.pose).chain([end(sailed)]).collect();
        tracks.iter().try_fold(swept(&nominal)?, |whole, poses| Ok(whole.union(&swept(poses)?)))
    }
}

/// The final pose.
fn end(sailed: &Sailed) -> Pose {
    sailed.ends.last().map(|(pose, _)| *pose).unwrap_or_default()
}

impl LegGroup {
    /// Adds a counter-example.
    pub(super) fn learn(&mut self, who: SampledVessel) {
        self.counter_examples.push(who);
        self.outcomes = None;
    }

    fn simulated(&self, repertoire: &Repertoire, others: &[SampledVessel]) -> Result<Vec<Outcome>, Invalid> {
        let all: Vec<SampledVessel> = others.iter().chain(&self.counter_examples).cloned().collect();
        match self.what {
            What::Basic(mode) => repertoire.basic(self.level, mode, &all),
            What::Informative(piece) => repertoire.informative(piece, self.level, &all),
        }
    }
}

/// Most uses of a maneuver that a share may lead to.
const MOST_USES: f64 = 1e6;

/// A piece with the number of its uses.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The piece that is run as one use.
    pub piece: Piece,
    /// How often.
    pub count: u32,
}

impl Brief {
    /// The pieces of the maneuvers that the task names (by default of those in the design) with their counts.
    pub(super) fn wanted(&self) -> Result<Vec<Wanted>, VoyageError> {
        let mut all: Vec<Wanted> = Vec::new();
        for maneuver in &self.named()? {
            check_name(&maneuver.name, &all)?;
            let piece = self.piece(maneuver)?;
            let count = maneuver.count.map_or_else(|| self.count(&piece), Ok)?;
            if count > 0 {
                all.push(Wanted { piece, count });
            }
        }
        if all.is_empty() {
            let none = "no maneuver that is used at least once";
            let remedy = "raise a `count`, lengthen `informative_s` or shorten `piece_s`";
            return Err(Invalid::new("counts", none, "at least one use", remedy).into());
        }
        Ok(all)
    }

    /// The maneuvers that the task names; those of the design where it names none.
    ///
    /// # Errors
    /// Neither names nor a design.
    pub fn named(&self) -> Result<Vec<ManeuverUse>, Invalid> {
        match (&self.task.maneuvers[..], &self.design) {
            ([], Some(design)) => Ok(design.used()),
            ([], None) => Err(Invalid::new(
                "[[maneuver]]",
                "none, and no design",
                "maneuvers with their counts, or a design that has shares",
                "add [[maneuver]] tables, or give --design",
            )),
            (named, _) => Ok(named.to_vec()),
        }
    }

    /// The run of a maneuver in the dictionary.
    pub fn run(&self, name: &str) -> Option<&Run> {
        self.dictionary.iter().find(|run| run.segments[0].maneuver == name)
    }

    fn piece(&self, wanted: &ManeuverUse) -> Result<Piece, VoyageError> {
        let names = || self.dictionary.iter().map(|run| run.segments[0].maneuver.clone());
        let Some(run) = self.run(&wanted.name) else {
            return Err(VoyageError::UnknownManeuver { name: wanted.name.clone(), known: names().collect() });
        };
        let target = wanted.piece_s.map(|s| self.vessel.samples(s));
        let helm = self.programs.get(&wanted.name).cloned();
        let whole = Piece { helm, ..Piece::whole(&self.vessel, run) };
        Ok(whole.cut(target)?.timed(&self.vessel)?)
    }

    /// n_q = N_q / N′_q, rounded, with N_q = share × time.
    fn count(&self, piece: &Piece) -> Result<u32, VoyageError> {
        let refuse = |value: &str, remedy: &str| {
            let expected = "a `count`, or a design's share of `informative_s`";
            Err(Invalid::new(format!("maneuver `{}`", piece.maneuver), value, expected, remedy).into())
        };
        let Some(design) = &self.design else {
            return refuse("no `count` and no design", "add `count` or give --design");
        };
        let Some(time) = self.task.informative_s else {
            return refuse("no `count` and no `informative_s`", "add one of them");
        };
        let Some(share) = design.share.get(&piece.maneuver) else {
            let (maneuver, known) = (piece.maneuver.clone(), design.order.clone());
            return Err(VoyageError::NoShare { maneuver, known });
        };
        let uses = share * time * self.vessel.sample_rate_hz / piece.samples as f64;
        Ok(uses.round().min(MOST_USES) as u32)
    }
}

impl Shares {
    /// The maneuvers with a share in the design.
    fn used(&self) -> Vec<ManeuverUse> {
        let used = self.order.iter().filter(|name| self.share.get(*name).is_some_and(|w| *w > 0.0));
        used.map(|name| ManeuverUse { name: name.clone(), count: None, piece_s: None }).collect()
    }
}

fn check_name(name: &str, earlier: &[Wanted]) -> Result<(), Invalid> {
    let thing = || format!("maneuver `{name}`");
    if BASIC_MOVES.contains(&name) {
        let expected = "a name that is no basic move's";
        let remedy = "rename it in the dictionary, and here";
        return Err(Invalid::new(thing(), "the name of a basic move", expected, remedy));
    }
    match earlier.iter().any(|w| w.piece.maneuver == name) {
        true => Err(Invalid::new(thing(), "it twice", "every maneuver once", "remove one")),
        false => Ok(()),
    }
}
