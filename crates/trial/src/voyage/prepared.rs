//! What a search starts from: chart and lattice laid out, counts known, every leg rehearsed.

use std::sync::Arc;

use chart::Chart;
use refusal::Invalid;

use super::counts::Wanted;
use super::error::VoyageError;
use super::moment_sums::MomentSums;
use super::rehearsed::{Dropped, Group, Rehearsal, Rehearsed, groups};
use super::search::Search;
use super::task::Brief;
use crate::{Grid, Piece, Rehearser, Repertoire, mirror};

/// What is known of legs: rehearsals, legs that all end settled, legs that some do not.
pub(super) type Known = (Vec<Group>, Vec<Arc<Rehearsed>>, Vec<Dropped>);

/// A trial prepared for the search.
#[derive(Clone, Debug)]
pub struct Prepared {
    /// What it was prepared from.
    pub brief: Brief,
    /// The chart on its plane.
    pub chart: Chart,
    /// The lattice.
    pub grid: Grid,
    /// Pieces with their counts.
    pub wanted: Vec<Wanted>,
    /// The same pieces.
    pub(super) pieces: Vec<Piece>,
    /// Signs of inputs for the other side, where the vessel has a mirror image.
    pub(super) mirror: Option<Vec<f64>>,
    groups: Vec<Group>,
    others: Vec<Rehearser>,
    /// Every leg of the lattice.
    pub rehearsed: Vec<Arc<Rehearsed>>,
    /// Legs that nobody could be sure to end.
    pub dropped: Vec<Dropped>,
    /// What each piece tells.
    pub(super) information: Vec<MomentSums>,
}

impl Prepared {
    /// Lays out chart and lattice, finds the counts and rehearses every leg.
    ///
    /// # Errors
    /// Values of the task that make no sense for this vessel, dictionary, design or chart; rasters that do not fit in the
    /// memory; a maneuver that nobody can be sure to recover from.
    pub fn new(mut brief: Brief, search: &Search) -> Result<Self, VoyageError> {
        let layers = std::mem::take(&mut brief.layers);
        let Brief { vessel, task, .. } = &brief;
        let wanted = brief.wanted()?;
        let pieces: Vec<Piece> = wanted.iter().map(|w| w.piece.clone()).collect();
        let (chart, grid) = task.ground(vessel, &layers, brief.drift_m(&wanted), search.go_on)?;
        drop(layers);
        let information = pieces.iter().map(|piece| MomentSums::of_piece(vessel, piece)).collect();
        let (mirror, others) = (mirror(vessel), brief.rehearsers());
        let (rehearsed, dropped) = (Vec::new(), Vec::new());
        let mut prepared = Self {
            brief,
            chart,
            grid,
            wanted,
            pieces,
            mirror,
            groups: Vec::new(),
            others,
            rehearsed,
            dropped,
            information,
        };
        prepared.check_modes()?;
        prepared.check_rasters(search)?;
        prepared.groups = groups(&prepared.repertoire());
        prepared.learn(Vec::new(), search)?;
        prepared.check_offered()?;
        Ok(prepared)
    }

    /// Everything that legs are made from.
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
        }
    }

    fn check_modes(&self) -> Result<(), Invalid> {
        (0..self.pieces.len()).try_for_each(|piece| self.repertoire().mode_of(piece).map(|_| ()))
    }

    /// Refuses a maneuver that has no leg from any heading.
    pub(super) fn check_offered(&self) -> Result<(), VoyageError> {
        let offered = |name: &str| self.rehearsed.iter().any(|own| own.name == name);
        let mut names = self.wanted.iter().map(|wanted| wanted.piece.maneuver.as_str());
        let Some(name) = names.find(|name| !offered(name)) else { return Ok(()) };
        let why = self.dropped.iter().find(|dropped| dropped.name == name);
        let why = why.map_or_else(String::new, |dropped| format!(", {}", dropped.why));
        Err(VoyageError::NoAnswer(Invalid::new(
            format!("maneuver `{name}`"),
            format!("no leg that all who rehearse it end settled{why}"),
            "a node that every vessel within `safety.parameter_error` recovers to in any unknown current",
            "raise the tolerances of `approach`, know the parameters better, or shorten the maneuver",
        )))
    }

    /// Lets those who failed a leg rehearse it from now on; gives what was known before.
    pub(super) fn learn(
        &mut self,
        taught: Vec<(usize, Rehearser)>,
        search: &Search,
    ) -> Result<Known, VoyageError> {
        let mut groups = self.groups.clone();
        taught.into_iter().for_each(|(leg, who)| groups[self.rehearsed[leg].group].learn(who));
        let task = &self.brief.task;
        let rehearsal = Rehearsal {
            repertoire: self.repertoire(),
            wanted: &self.wanted,
            others: &self.others,
            hull: task.hull.outline(),
            cell_m: task.raster(&self.grid).cell_m,
        };
        let (rehearsed, dropped) = rehearsal.rehearse(&mut groups, search.go_on)?;
        Ok(self.know((groups, rehearsed, dropped)))
    }

    /// Takes what is known; gives what was known before.
    pub(super) fn know(&mut self, (groups, rehearsed, dropped): Known) -> Known {
        let groups = std::mem::replace(&mut self.groups, groups);
        let rehearsed = std::mem::replace(&mut self.rehearsed, rehearsed);
        (groups, rehearsed, std::mem::replace(&mut self.dropped, dropped))
    }

    /// North and east of a pose's node \[m\].
    pub fn node(&self, pose: lattice::Pose) -> [f64; 2] {
        let at = self.grid.pose(pose.i, pose.j, 0);
        [at.x, at.y]
    }
}
