//! The information of a simulated plan against the prediction of its counts.

use std::ops::Range;

use refusal::Invalid;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::moment_sums::{MomentSums, Summing};
use super::prepared::Prepared;
use crate::Sailed;
use crate::leg::turned_back;
use trial::Piece;

/// log|det| of the information, per the nominal model; none where a direction is not excited at all.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Information {
    /// Promised by the counts: each use adds the moments of its piece.
    pub predicted_log_det: Option<f64>,
    /// Of the informative parts of the trajectory actually sailed.
    pub realised_log_det: Option<f64>,
    /// The same, with everything between them. None of a ship with forces: simulated without her autopilot for minutes, an
    /// unstable one would seem to tell of her numbers without bound.
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
    ///
    /// # Errors
    /// As [`Brief::summing`](super::task::Brief).
    pub(super) fn information_of_plan(
        &self,
        legs: &[usize],
        sailed: &Sailed,
    ) -> Result<Information, Invalid> {
        let summing = self.brief.summing()?;
        let predicted = self.promised(legs);
        let mut realised = MomentSums::default();
        let mut start = 0;
        for part in sailed.samples.chunk_by(|a, b| a.leg == b.leg && a.informative == b.informative) {
            let end = start + part.len();
            if part[0].informative {
                realised.add(&self.information_of(&summing, sailed, start..end), 1.0);
            }
            start = end;
        }
        let known = |x: f64| Some(x).filter(|x| x.is_finite());
        let whole = || self.information_of(&summing, sailed, 0..sailed.samples.len()).log_det();
        let (promise, information, p) = (predicted.log_det(), realised.log_det(), predicted.dimension());
        Ok(Information {
            predicted_log_det: known(promise),
            realised_log_det: known(information),
            whole_log_det: (!summing.is_of_forces()).then(whole).and_then(known),
            efficiency: known(libm::exp((information - promise) / p as f64)),
            design_efficiency: self.design_efficiency(&summing, legs, &predicted),
            dimension: p as u64,
        })
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

    /// The information of a segment; of a ship with forces as she moves through the water, which the known current only carries.
    fn information_of(&self, summing: &Summing, sailed: &Sailed, range: Range<usize>) -> MomentSums {
        let sample = &sailed.samples[range.clone()];
        let inputs: Vec<f64> = sample.iter().flat_map(|s| s.inputs.iter().copied()).collect();
        let after = sailed.samples.get(range.end).map(|s| s.state);
        let after = after.or(sailed.ends.last().map(|(_, state)| *state)).unwrap_or_default();
        let mut states: Vec<f64> = sample.iter().map(|s| s.state).chain([after]).flatten().collect();
        if summing.is_of_forces() {
            let [along, across] =
                turned_back(self.brief.task.known_current_m_s, sample.first().map_or(0.0, |s| s.pose.psi));
            (states[0], states[1]) = (states[0] - along, states[1] - across);
        }
        summing.of(&inputs, &states)
    }

    /// The counts compared with the design's shares over the same time in maneuvers.
    fn design_efficiency(&self, summing: &Summing, legs: &[usize], moment_sums: &MomentSums) -> Option<f64> {
        let (design, vessel) = (self.brief.design.as_ref()?, &self.brief.vessel);
        let samples: f64 = self.pieces_of(legs).map(|piece| self.pieces[piece].samples as f64).sum();
        let mut best = MomentSums::default();
        for run in &self.brief.dictionary {
            let share = design.share.get(&run.segments[0].maneuver).copied().unwrap_or(0.0);
            if share > 0.0 {
                let of_piece = summing.of_piece(&Piece::whole(vessel, run));
                best.add(&of_piece, share * samples / run.samples() as f64);
            }
        }
        let efficiency = libm::exp((moment_sums.log_det() - best.log_det()) / moment_sums.dimension() as f64);
        efficiency.is_finite().then_some(efficiency)
    }
}
