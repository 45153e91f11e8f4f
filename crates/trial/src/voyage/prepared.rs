//! What a search starts from: chart and lattice laid out, counts known, every leg rehearsed.

use chart::Chart;
use vessel::Streams;

use super::counts::Wanted;
use super::error::VoyageError;
use super::moment_sums::MomentSums;
use super::rehearsed::{Rehearsed, rehearse};
use super::search::Search;
use super::task::Brief;
use crate::{Grid, Piece, Repertoire, mirror};

/// How many vessels with other parameters rehearse every maneuver.
const OTHER_VESSELS: u32 = 16;

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
    /// Signs of inputs for the other side; empty where the vessel has no mirror image.
    pub(super) mirror: Vec<f64>,
    /// Every leg of the lattice.
    pub rehearsed: Vec<Rehearsed>,
    /// What each piece tells.
    pub(super) information: Vec<MomentSums>,
}

impl Prepared {
    /// Lays out chart and lattice, finds the counts and rehearses every leg.
    ///
    /// # Errors
    /// Values of the task that make no sense for this vessel, dictionary, design or chart.
    pub fn new(brief: Brief, search: &Search) -> Result<Self, VoyageError> {
        let Brief { vessel, task, .. } = &brief;
        let wanted = brief.wanted()?;
        let pieces: Vec<Piece> = wanted.iter().map(|w| w.piece.clone()).collect();
        let longest = pieces.iter().map(|piece| piece.samples).max().unwrap_or(0);
        let drift_m = task.safety.unknown_current_m_s * longest as f64 / vessel.sample_rate_hz;
        let (chart, grid) = task.ground(vessel, &brief.layers, drift_m)?;
        let information = pieces.iter().map(|piece| MomentSums::of_piece(vessel, piece)).collect();
        let mirror = mirror(vessel);
        let repertoire = Repertoire {
            vessel,
            grid: &grid,
            handling: &task.handling,
            approach: &task.approach,
            pieces: &pieces,
            mirror: mirror.as_deref(),
            mean_current_m_s: task.known_current_m_s,
        };
        let rehearsed = rehearse(&repertoire, &wanted, &brief.other_vessels(), search.go_on)?;
        let mirror = mirror.unwrap_or_default();
        Ok(Self { brief, chart, grid, wanted, pieces, mirror, rehearsed, information })
    }

    /// North and east of a pose's node \[m\].
    pub fn node(&self, pose: lattice::Pose) -> [f64; 2] {
        let at = self.grid.pose(pose.i, pose.j, 0);
        [at.x, at.y]
    }

    /// Clearance to keep for the drift of an unknown current while a leg's maneuver is run open loop \[m\].
    pub fn drift_margin_m(&self, own: &Rehearsed) -> f64 {
        let Brief { vessel, task, .. } = &self.brief;
        task.safety.unknown_current_m_s * own.open_loop() as f64 / vessel.sample_rate_hz
    }
}

impl Brief {
    /// The vessels that rehearse besides the nominal one.
    fn other_vessels(&self) -> Vec<Vec<f64>> {
        let some = if self.task.safety.parameter_error > 0.0 { OTHER_VESSELS } else { 0 };
        (0..some).map(|run| self.drawn("parameter-error", run)).collect()
    }

    /// Parameters of run `run`, each evenly within the stated error of its nominal value.
    pub(super) fn drawn(&self, purpose: &str, run: u32) -> Vec<f64> {
        const STEPS: u32 = 1 << 20;
        let error = self.task.safety.parameter_error;
        let off = |draw: u32| 1.0 + error * (2.0 * (f64::from(draw) + 0.5) / f64::from(STEPS) - 1.0);
        let drawn = Streams::new(self.seed, purpose).choices(run, 0, STEPS, self.vessel.nominal.len());
        self.vessel.nominal.iter().zip(drawn).map(|(p, draw)| p * off(draw)).collect()
    }
}
