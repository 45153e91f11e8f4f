//! The information of a simulated plan against the prediction of its counts.

use std::ops::Range;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::moment_sums::MomentSums;
use super::prepared::Prepared;
use crate::{Piece, Sailed};

/// log|det| of the information, per the nominal model; none where a direction is not excited at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Information {
    /// Promised by the counts: each use adds the moments of its piece.
    pub predicted_log_det: Option<f64>,
    /// Of the informative parts of the trajectory actually sailed.
    pub realised_log_det: Option<f64>,
    /// The same, with everything between them.
    pub whole_log_det: Option<f64>,
    /// exp((realised − predicted)/p).
    pub efficiency: Option<f64>,
    /// exp((predicted − optimum)/p) for the design's shares over the same time, where a design was given.
    pub design_efficiency: Option<f64>,
    /// p.
    pub dimension: u64,
}

impl Prepared {
    /// The information of `sailed`, against the prediction of its `legs`.
    pub(super) fn information_of_plan(&self, legs: &[usize], sailed: &Sailed) -> Information {
        let predicted = self.promised(legs);
        let mut realised = MomentSums::default();
        let mut start = 0;
        for part in sailed.samples.chunk_by(|a, b| a.leg == b.leg && a.informative == b.informative) {
            let end = start + part.len();
            if part[0].informative {
                realised.add(&self.information_of(sailed, start..end), 1.0);
            }
            start = end;
        }
        let whole = self.information_of(sailed, 0..sailed.samples.len());
        let known = |x: f64| Some(x).filter(|x| x.is_finite());
        let (promise, information, p) = (predicted.log_det(), realised.log_det(), predicted.dimension());
        Information {
            predicted_log_det: known(promise),
            realised_log_det: known(information),
            whole_log_det: known(whole.log_det()),
            efficiency: known(libm::exp((information - promise) / p as f64)),
            design_efficiency: self.design_efficiency(legs, &predicted),
            dimension: p as u64,
        }
    }

    /// The pieces of the informative ones among `legs`.
    fn pieces_of<'a>(&'a self, legs: &'a [usize]) -> impl Iterator<Item = usize> + 'a {
        legs.iter().filter_map(|leg| self.legs[*leg].leg.purpose.piece())
    }

    fn promised(&self, legs: &[usize]) -> MomentSums {
        let mut promised = MomentSums::default();
        self.pieces_of(legs).for_each(|piece| promised.add(&self.information[piece], 1.0));
        promised
    }

    fn information_of(&self, sailed: &Sailed, range: Range<usize>) -> MomentSums {
        let own = &sailed.samples[range.clone()];
        let inputs: Vec<f64> = own.iter().flat_map(|s| s.inputs.iter().copied()).collect();
        let after = sailed.samples.get(range.end).map(|s| s.state);
        let after = after.or(sailed.ends.last().map(|(_, state)| *state)).unwrap_or_default();
        let states: Vec<f64> = own.iter().map(|s| s.state).chain([after]).flatten().collect();
        MomentSums::of(&self.brief.vessel, &inputs, &states)
    }

    /// The counts compared with the design's shares over the same time in maneuvers.
    fn design_efficiency(&self, legs: &[usize], own: &MomentSums) -> Option<f64> {
        let (design, vessel) = (self.brief.design.as_ref()?, &self.brief.vessel);
        let samples: f64 = self.pieces_of(legs).map(|piece| self.pieces[piece].samples as f64).sum();
        let mut best = MomentSums::default();
        for run in &self.brief.dictionary {
            let share = design.share.get(&run.segments[0].maneuver).copied().unwrap_or(0.0);
            if share > 0.0 {
                let own = MomentSums::of_piece(vessel, &Piece::whole(vessel, run));
                best.add(&own, share * samples / run.samples() as f64);
            }
        }
        let efficiency = libm::exp((own.log_det() - best.log_det()) / own.dimension() as f64);
        efficiency.is_finite().then_some(efficiency)
    }
}
