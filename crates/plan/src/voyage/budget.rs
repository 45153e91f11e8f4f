//! Whether chart, lattice and check fit in the memory, decided before large allocations.

use std::collections::BTreeSet;

use crate::lattice::{Demand, Lattice};

use super::check::TRACKS;
use super::check_run::Drawn;
use super::clearance::cells_around;
use super::error::VoyageError;
use super::footing::Footing;
use super::moves::Moves;
use super::prepared::Prepared;
use super::search::Search;
use super::settled_legs::SettledLeg;
use super::task::Secondary;
use crate::{Fix, Sample, SampledVessel};

/// Approximate bytes of inputs, threads and output.
const READ_BYTES: u128 = 28 << 20;
const WRITTEN_BYTES: u128 = 12 << 20;

/// Most uses of a maneuver that are budgeted for before the search, which refuses more.
const MOST_USES: u32 = 1000;

/// Refuses a footing that exceeds `memory_bytes`.
fn fits(footing: Footing, memory_bytes: u64) -> Result<(), VoyageError> {
    if footing.bytes() > u128::from(memory_bytes) { Err(VoyageError::TooLarge(footing)) } else { Ok(()) }
}

impl Prepared {
    /// Refuses rasters that exceed the memory, regardless of legs.
    pub(super) fn check_rasters(&self, search: &Search) -> Result<(), VoyageError> {
        fits(self.footing(&[])?, search.options.memory_bytes)
    }

    /// Refuses rasters and legs that exceed the memory; else returns the search with the remaining memory.
    pub(super) fn within<'a>(&self, moves: &Moves, search: &Search<'a>) -> Result<Search<'a>, VoyageError> {
        let footing = self.footing(&moves.actions)?;
        fits(footing, search.options.memory_bytes)?;
        Ok(search.reserving(footing.kept_bytes()))
    }

    /// Refuses a plan whose check exceeds the memory; else returns a concurrent search with the remaining
    /// memory.
    pub(super) fn within_check<'a>(
        &self,
        moves: &Moves,
        (round, samples): (u32, usize),
        search: &Search<'a>,
    ) -> Result<Search<'a>, VoyageError> {
        let footing = Footing { check: self.check_bytes(round, samples), ..self.footing(&moves.actions)? };
        fits(footing, search.options.memory_bytes)?;
        Ok(search.reserving(footing.kept_bytes() + footing.lattice.kept_bytes() + footing.check))
    }

    fn footing(&self, actions: &[crate::lattice::Action]) -> Result<Footing, VoyageError> {
        let (task, grid) = (&self.brief.task, &self.grid);
        let raster = task.raster(grid);
        let layers =
            self.obstacle_kinds().0.len().max(1) + usize::from(task.cost.secondary == Secondary::Clearance);
        let masks = usize::from(!task.area.corners.is_empty()) + task.speed_limits.len();
        let around = cells_around(&raster, task.safety.margin_m);
        Ok(Footing {
            lattice: self.demand(actions),
            cells: layers as u128 * around + (masks * raster.nx * raster.ny) as u128,
            clearance_cells: self.clearance_cells()?,
            // The chart was in memory as it was read, too, except for the cells of its grids.
            other: self.read_bytes()
                + 2 * u128::from(self.chart.bytes())
                + u128::from(self.chart.grid_bytes())
                + self.leg_bytes(),
            check: self.check_bytes(1, self.least_samples()),
        })
    }

    fn demand(&self, actions: &[crate::lattice::Action]) -> Demand {
        let grid = &self.grid;
        Demand::new(Lattice { nx: grid.nx, ny: grid.ny, layers: grid.layers() }, actions)
    }

    /// Bytes of a round's plan while the next one is searched: its problem, and its legs that are simulated
    /// again.
    pub(super) fn last_bytes(&self, moves: &Moves, counter_examples: &[(usize, SampledVessel)]) -> u128 {
        let anew: BTreeSet<usize> = counter_examples.iter().map(|(leg, _)| self.legs[*leg].group).collect();
        let legs = self.legs.iter().filter(|leg| anew.contains(&leg.group));
        self.demand(&moves.actions).kept_bytes() + legs.map(|own| self.bytes_of(own)).sum::<u128>()
    }

    /// Bytes of the inputs.
    fn read_bytes(&self) -> u128 {
        READ_BYTES.max(self.brief.chart_bytes.into())
    }

    /// Bytes of the simulated legs.
    fn leg_bytes(&self) -> u128 {
        self.legs.iter().map(|leg| self.bytes_of(leg)).sum()
    }

    fn bytes_of(&self, settled_leg: &SettledLeg) -> u128 {
        let sample = size_of::<Sample>() + 8 * self.brief.vessel.model.inputs;
        (settled_leg.sailed.samples.len() * sample + size_of_val(settled_leg.footprint.runs())) as u128
    }

    /// Bytes of a check's runs, of the tracks that are kept of them and of the nominal one.
    fn check_bytes(&self, round: u32, samples: usize) -> u128 {
        let runs = self.runs(round);
        let sample = size_of::<Sample>() + 8 * self.brief.vessel.model.inputs;
        let tracks = runs.min(TRACKS) as usize * size_of::<Fix>() * 9 / 8;
        WRITTEN_BYTES + (runs as usize * size_of::<Drawn>()) as u128 + (samples * (tracks + sample)) as u128
    }

    /// Samples of all maneuvers, each from the fastest heading: any plan has more.
    fn least_samples(&self) -> usize {
        let rate_hz = self.brief.vessel.sample_rate_hz;
        let pieces = self.wanted.iter().enumerate();
        let seconds =
            pieces.map(|(piece, own)| f64::from(own.count.min(MOST_USES)) * self.shortest_leg_s(piece));
        seconds.filter(|s| s.is_finite()).map(|s| (s * rate_hz) as usize).sum()
    }
}
