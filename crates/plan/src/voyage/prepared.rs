//! The start of a search: chart and lattice laid out, counts determined, every leg simulated.

use std::sync::Arc;

use chart::Chart;
use refusal::Invalid;

use super::counts::Wanted;
use super::error::VoyageError;
use super::moment_sums::MomentSums;
use super::off_nominal::parameters_in_words;
use super::search::Search;
use super::settled_legs::{Dropped, Group, LegSimulation, SettledLeg, groups};
use super::task::Brief;
use crate::{Grid, Repertoire, SampledVessel, mirror};
use trial::Piece;

/// The groups of legs, the legs on which all vessels settle, and the others.
pub(super) type Known = (Vec<Group>, Vec<Arc<SettledLeg>>, Vec<Dropped>);

/// A trial prepared for the search.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// Its inputs.
    pub brief: Brief,
    /// The chart on its plane.
    pub chart: Chart,
    /// The lattice.
    pub grid: Grid,
    /// Pieces with their counts.
    pub wanted: Vec<Wanted>,
    /// The pieces alone.
    pub(super) pieces: Vec<Piece>,
    /// Signs of inputs for the other side, if the vessel has mirror symmetry.
    pub(super) mirror: Option<Vec<f64>>,
    groups: Vec<Group>,
    others: Vec<SampledVessel>,
    /// Every leg of the lattice.
    pub legs: Vec<Arc<SettledLeg>>,
    /// Legs on which not all vessels settle.
    pub dropped: Vec<Dropped>,
    /// The information of each piece.
    pub(super) information: Vec<MomentSums>,
}

impl Prepared {
    /// Lays out chart and lattice, determines the counts and simulates every leg.
    ///
    /// # Errors
    /// Values of the task that are invalid for this vessel, dictionary, design or chart; rasters that exceed
    /// the memory; a maneuver without a leg on which all vessels settle.
    pub fn new(mut brief: Brief, search: &Search) -> Result<Self, VoyageError> {
        let layers = std::mem::take(&mut brief.layers);
        let Brief { vessel, task, .. } = &brief;
        let wanted = brief.wanted()?;
        let pieces: Vec<Piece> = wanted.iter().map(|w| w.piece.clone()).collect();
        let (chart, grid) = task.ground(vessel, &layers, brief.drift_m(&wanted), search.keep_going)?;
        drop(layers);
        let summing = brief.summing()?;
        let information = pieces.iter().map(|piece| summing.of_piece(piece)).collect();
        let others = brief.sampled_vessels();
        let mirror =
            mirror(vessel).filter(|signs| pieces.iter().all(|own| own.is_mirrored_within(vessel, signs)));
        let (legs, dropped) = (Vec::new(), Vec::new());
        let mut prepared = Self {
            brief,
            chart,
            grid,
            wanted,
            pieces,
            mirror,
            groups: Vec::new(),
            others,
            legs,
            dropped,
            information,
        };
        prepared.check_modes()?;
        prepared.check_rasters(search)?;
        prepared.check_steered()?;
        prepared.groups = groups(&prepared.repertoire());
        prepared.learn(Vec::new(), search)?;
        prepared.check_offered()?;
        Ok(prepared)
    }

    /// The data that legs are made from.
    pub(super) fn repertoire(&self) -> Repertoire<'_> {
        let task = &self.brief.task;
        Repertoire {
            vessel: &self.brief.vessel,
            grid: &self.grid,
            handling: &task.handling,
            approach: &task.approach,
            pieces: &self.pieces,
            mirror: self.mirror.as_deref(),
            mean_current_m_s: task.known_current_m_s,
            deviations: &task.deviations,
            unknown_current_m_s: task.safety.unknown_current_m_s,
            sensors: task.sensors,
            changes: task.changes,
            seed: self.brief.seed,
        }
    }

    fn check_modes(&self) -> Result<(), Invalid> {
        (0..self.pieces.len()).try_for_each(|piece| self.repertoire().mode_of(piece).map(|_| ()))
    }

    /// Refuses maneuvers that have no leg from any heading: all of them at once.
    pub(super) fn check_offered(&self) -> Result<(), VoyageError> {
        let offered = |name: &&str| self.legs.iter().any(|own| own.name == **name);
        let mut names: Vec<&str> = self.wanted.iter().map(|wanted| wanted.piece.maneuver.as_str()).collect();
        names.retain(|name| !offered(name));
        names.dedup();
        let dropped = |name: &str| self.dropped.iter().find(|dropped| dropped.name == name);
        let Some((name, others)) = names.split_first() else { return Ok(()) };
        let why = dropped(name).map_or_else(String::new, |dropped| self.named(dropped));
        let others = others.iter().map(|name| {
            let why = dropped(name).map_or_else(String::new, |dropped| format!(" ({})", dropped.why));
            format!("; nor of `{name}`{why}")
        });
        Err(VoyageError::NoAnswer(Invalid::new(
            format!("maneuver `{name}`"),
            format!("no leg on which all sampled vessels settle{why}{}", others.collect::<String>()),
            format!("one for all within `{}`", self.brief.task.safety.key()),
            "know the parameters better, raise the tolerances of `approach`, or shorten it",
        )))
    }

    /// The vessel that does not settle on a dropped leg, and how.
    fn named(&self, Dropped { why, parameters, .. }: &Dropped) -> String {
        match parameters {
            None => format!(", {why}"),
            Some(parameters) => {
                format!(", such as {}: {why}", parameters_in_words(&self.brief.vessel, parameters))
            }
        }
    }

    /// Adds counter-examples to the sampled vessels of their legs; returns the previous state.
    pub(super) fn learn(
        &mut self,
        counter_examples: Vec<(usize, SampledVessel)>,
        search: &Search,
    ) -> Result<Known, VoyageError> {
        let mut groups = self.groups.clone();
        counter_examples.into_iter().for_each(|(leg, who)| groups[self.legs[leg].group].learn(who));
        let task = &self.brief.task;
        let simulation = LegSimulation {
            repertoire: self.repertoire(),
            wanted: &self.wanted,
            others: &self.others,
            hull: task.hull.outline(),
            cell_m: task.raster(&self.grid).cell_m,
        };
        let (legs, dropped) = simulation.run(&mut groups, search.keep_going)?;
        Ok(self.know((groups, legs, dropped)))
    }

    /// Replaces the known legs; returns the previous ones.
    pub(super) fn know(&mut self, (groups, legs, dropped): Known) -> Known {
        let groups = std::mem::replace(&mut self.groups, groups);
        let legs = std::mem::replace(&mut self.legs, legs);
        (groups, legs, std::mem::replace(&mut self.dropped, dropped))
    }

    /// North and east of a pose's node \[m\].
    pub fn node(&self, pose: crate::lattice::Pose) -> [f64; 2] {
        let at = self.grid.pose(pose.i, pose.j, 0);
        [at.x, at.y]
    }
}
