//! Fewer uses for less time: the front of cost and information.

use std::collections::BTreeMap;

use crate::lattice::{Problem, Solution};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};

use super::moment_sums::MomentSums;
use super::moves::Moves;
use super::prepared::Prepared;
use super::search::Search;
use super::task::Primary;
use crate::Purpose;

/// Counts with what they cost and tell.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct FrontPoint {
    /// Uses of every maneuver.
    pub counts: BTreeMap<String, u64>,
    /// Cost of the best plan with them.
    pub cost: f64,
    /// Time in informative legs \[s\].
    pub informative_s: f64,
    /// log|det| of their information.
    pub log_det: f64,
}

impl Prepared {
    /// Counts that no others beat in both cost and information, cheapest first; empty if the search is not
    /// exhaustive. A known `plan` beats all that are dearer, since more uses never carry less information.
    pub(super) fn front(
        &self,
        problem: &Problem,
        plan: Option<&Solution>,
        moves: &Moves,
        search: &Search,
    ) -> Vec<FrontPoint> {
        let order = self.pieces_in_order(moves);
        let all = search.affordable(problem, plan).into_iter().map(|found| self.front_point(&order, found));
        let mut points: Vec<FrontPoint> = all.filter(|p| p.log_det.is_finite()).collect();
        let time = |p: &FrontPoint| match self.brief.task.cost.primary {
            Primary::BasicMoves => p.informative_s,
            Primary::Seconds => 0.0,
        };
        points.sort_by(|a, b| {
            a.cost.total_cmp(&b.cost).then(b.log_det.total_cmp(&a.log_det)).then(time(a).total_cmp(&time(b)))
        });
        let mut best = f64::NEG_INFINITY;
        points.retain(|p| {
            let better = p.log_det > best;
            best = best.max(p.log_det);
            better
        });
        points
    }

    /// The piece of every informative action, in the order of the lattice's counts.
    fn pieces_in_order(&self, moves: &Moves) -> Vec<usize> {
        let informative = moves.actions.iter().filter(|a| a.required > 0);
        let piece = |name: &String| self.wanted.iter().position(|w| w.piece.maneuver == *name);
        informative.filter_map(|action| piece(&action.name)).collect()
    }

    fn front_point(&self, order: &[usize], (uses, cost): (Vec<u32>, f64)) -> FrontPoint {
        let mut information = MomentSums::default();
        let mut counts = BTreeMap::new();
        let mut informative_s = 0.0;
        for (piece, count) in order.iter().zip(&uses) {
            information.add(&self.information[*piece], f64::from(*count));
            counts.insert(self.wanted[*piece].piece.maneuver.clone(), u64::from(*count));
            informative_s += f64::from(*count) * self.shortest_leg_s(*piece);
        }
        FrontPoint { counts, cost, informative_s, log_det: information.log_det() }
    }

    /// Time of the shortest leg that uses a piece \[s\].
    pub(super) fn shortest_leg_s(&self, wanted: usize) -> f64 {
        let uses =
            |purpose: &Purpose| matches!(purpose, Purpose::Informative { piece, .. } if *piece == wanted);
        let own = self.legs.iter().filter(|leg| uses(&leg.leg.purpose));
        own.map(|own| own.seconds(self.brief.vessel.sample_rate_hz)).fold(f64::INFINITY, f64::min)
    }
}
