//! Legs as moves of the lattice, with their costs.

use std::sync::Arc;

use crate::lattice::{Action, Cost, Move, Step};

use super::counts::Wanted;
use super::settled_legs::SettledLeg;
use super::task::{CostRule, Primary, Secondary};
use super::waters::CLEARANCE_CLASSES;
use crate::Leg;

/// The lattice's actions, and the legs of their moves.
#[derive(Clone, Debug)]
pub struct Moves {
    /// The actions.
    pub actions: Vec<Action>,
    /// Per action and move: index of the leg, and its clearance class.
    pub(super) legs: Vec<Vec<(usize, usize)>>,
}

impl Moves {
    /// Groups legs by name; costs follow `rule`.
    pub(super) fn new(legs: &[Arc<SettledLeg>], wanted: &[Wanted], rule: &CostRule, rate_hz: f64) -> Self {
        let mut moves = Self { actions: Vec::new(), legs: Vec::new() };
        let classes = if rule.secondary == Secondary::Clearance { CLEARANCE_CLASSES } else { 1 };
        for (index, leg) in legs.iter().enumerate() {
            let action = moves.action(leg, wanted);
            // The time of a maneuver that reacts differs by vessel: the cost bounds it.
            let reacts = leg.leg.purpose.piece().is_some_and(|piece| wanted[piece].piece.helm.is_some());
            let seconds = if reacts { leg.longest as f64 / rate_hz } else { leg.seconds(rate_hz) };
            for class in 0..classes {
                let cost = cost(leg, rule, class, seconds);
                let Leg { from, di, dj, to, .. } = leg.leg;
                moves.actions[action].moves.push(Move { from, di, dj, to, cost });
                moves.legs[action].push((index, class));
            }
        }
        moves
    }

    fn action(&mut self, settled_leg: &SettledLeg, wanted: &[Wanted]) -> usize {
        if let Some(known) = self.actions.iter().position(|a| a.name == settled_leg.name) {
            return known;
        }
        let required = settled_leg.leg.purpose.piece().map_or(0, |piece| wanted[piece].count);
        self.actions.push(Action { name: settled_leg.name.clone(), required, moves: Vec::new() });
        self.legs.push(Vec::new());
        self.actions.len() - 1
    }

    /// The leg of a step.
    pub(super) fn leg_of_step(&self, step: &Step) -> usize {
        let moves = self.actions[step.action].moves.iter().enumerate();
        let own = moves.filter(|(_, m)| m.from == step.from.layer);
        let index = own.map(|(index, _)| index).nth(step.variant).unwrap_or(0);
        self.legs[step.action][index].0
    }
}

fn cost(settled_leg: &SettledLeg, rule: &CostRule, class: usize, seconds: f64) -> Cost {
    let primary = match rule.primary {
        Primary::BasicMoves => f64::from(u8::from(!settled_leg.is_informative())),
        Primary::Seconds => seconds,
    };
    let secondary = match rule.secondary {
        Secondary::Seconds if rule.primary == Primary::Seconds => 0.0,
        Secondary::Seconds => seconds,
        Secondary::Turns => f64::from(u8::from(settled_leg.name.starts_with("turn-"))),
        Secondary::Clearance => class as f64,
    };
    Cost { primary, secondary }
}
