//! How much of a plan's information its done maneuvers have.

use std::collections::BTreeMap;

use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::error::VoyageError;
use super::moment_sums::MomentSums;
use super::task::Brief;

/// The planned information of the maneuvers that are done, of that of all in the plan, by the D-criterion.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Gathered {
    /// Σ of the shares of what is done: 1 where all is, whatever priors know. Absent where the whole plan leaves a direction unexcited.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
    /// exp((log|det| of what is done − that of the plan)/p): 0 until every direction is excited, 1 where all is done.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub efficiency: Option<f64>,
    /// p.
    pub dimension: u64,
    /// Every maneuver of the plan.
    pub maneuvers: Vec<GatheredManeuver>,
}

/// A maneuver of a plan.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct GatheredManeuver {
    /// Its name.
    pub name: String,
    /// Its uses in the plan.
    pub planned: u64,
    /// Those that are done.
    pub done: u64,
    /// tr(M⁻¹ M_q)/p of all its uses in the plan, with the information M of all maneuvers: what the D-criterion grows by, to
    /// first order. With priors, which M then has, p is tr(M⁻¹ M_q) summed over the maneuvers. Absent as above.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub share: Option<f64>,
}

impl Brief {
    /// The planned information of `done` uses of maneuvers, of that of the `planned` ones: each use adds the moments of its
    /// piece, by the nominal model in still water.
    ///
    /// # Errors
    /// A planned maneuver that the task or the dictionary lacks.
    pub fn gathered(
        &self,
        planned: &BTreeMap<String, u64>,
        done: &BTreeMap<String, u64>,
    ) -> Result<Gathered, VoyageError> {
        let (wanted, summing) = (self.wanted()?, self.summing()?);
        let mut own: Vec<(MomentSums, GatheredManeuver)> = Vec::new();
        for (name, count) in planned {
            let Some(piece) = wanted.iter().map(|own| &own.piece).find(|piece| piece.maneuver == *name)
            else {
                let known = wanted.iter().map(|own| own.piece.maneuver.clone()).collect();
                return Err(VoyageError::UnknownManeuver { name: name.clone(), known });
            };
            let done = done.get(name).copied().unwrap_or(0);
            let maneuver = GatheredManeuver { name: name.clone(), planned: *count, done, share: None };
            own.push((summing.of_piece(piece), maneuver));
        }
        Ok(of_pieces(own))
    }
}

/// Of the moments of one use of each maneuver.
fn of_pieces(mut own: Vec<(MomentSums, GatheredManeuver)>) -> Gathered {
    let (mut all, mut so_far) = (MomentSums::default(), MomentSums::default());
    for (moments, maneuver) in &own {
        all.add(moments, maneuver.planned as f64);
        so_far.add(moments, maneuver.done as f64);
    }
    for (moments, maneuver) in &mut own {
        maneuver.share = all.share_of(moments).map(|share| share * maneuver.planned as f64);
    }
    let part = |gathered_maneuver: &GatheredManeuver| {
        Some(
            gathered_maneuver.share? * gathered_maneuver.done as f64
                / gathered_maneuver.planned.max(1) as f64,
        )
    };
    let efficiency = libm::exp((so_far.log_det() - all.log_det()) / all.dimension() as f64);
    Gathered {
        share: own.iter().map(|(_, own)| part(own)).sum(),
        efficiency: Some(efficiency).filter(|own| own.is_finite()),
        dimension: all.dimension() as u64,
        maneuvers: own.into_iter().map(|(_, own)| own).collect(),
    }
}
