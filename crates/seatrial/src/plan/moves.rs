//! Legs at sea as moves of the lattice: what they cost and where they fit on the chart.

use chart::{Footprint, Invalid as ChartInvalid};
use lattice::{Action, Cost, Move, MoveId};
use rayon::prelude::*;
use trial::{Leg, Purpose, Repertoire, Sailed};
use vessel::{Invalid, Pose};

use super::config::{CostSpec, Primary, Secondary};
use super::counts::Wanted;
use super::waters::CLEARANCE_CLASSES;

/// A leg, carried out from the origin by the nominal model in the known current.
#[derive(Clone, Debug)]
pub(super) struct Rehearsed {
    pub leg: Leg,
    pub sailed: Sailed,
    pub end: Pose,
    /// Where it leads vessels with other parameters.
    pub strayed: Vec<Vec<Pose>>,
    /// Name of the action.
    pub name: String,
}

impl Rehearsed {
    pub(super) fn seconds(&self, rate_hz: f64) -> f64 {
        self.sailed.samples.len() as f64 / rate_hz
    }

    pub(super) fn is_informative(&self) -> bool {
        matches!(self.leg.purpose, Purpose::Informative { .. })
    }
}

/// Carries out every leg of the repertoire by the nominal model, informative ones by each of `others`, too.
pub(super) fn rehearse(
    repertoire: &Repertoire,
    wanted: &[Wanted],
    others: &[Vec<f64>],
) -> Result<Vec<Rehearsed>, Invalid> {
    let mut legs = trial::basic_legs(repertoire.grid, repertoire.handling);
    let informative: Vec<Vec<Leg>> = (0..wanted.len())
        .into_par_iter()
        .map(|piece| repertoire.informative(piece))
        .collect::<Result<_, _>>()?;
    legs.extend(informative.into_iter().flatten());
    let one = |leg: Leg| {
        let (sailed, end) = repertoire.rehearse(&leg)?;
        let name = match &leg.purpose {
            Purpose::Basic(name) => name.clone(),
            Purpose::Informative { piece, .. } => wanted[*piece].piece.maneuver.clone(),
        };
        let others = if matches!(leg.purpose, Purpose::Informative { .. }) { others } else { &[] };
        let stray =
            |parameters: &Vec<f64>| repertoire.rehearse_with(&leg, parameters).map(|(s, end)| track(&s, end));
        let strayed = others.iter().map(stray).collect::<Result<_, _>>()?;
        Ok(Rehearsed { leg, sailed, end, strayed, name })
    };
    legs.into_par_iter().map(one).collect()
}

/// The lattice's actions, and which leg stands behind each of their moves.
pub(super) struct Moves {
    pub actions: Vec<Action>,
    /// Per action and move: index of the leg, and the clearance class that it stands for.
    pub legs: Vec<Vec<(usize, usize)>>,
}

impl Moves {
    /// Groups legs by name; the costs as `spec` says.
    pub(super) fn new(rehearsed: &[Rehearsed], wanted: &[Wanted], spec: &CostSpec, rate_hz: f64) -> Self {
        let mut moves = Self { actions: Vec::new(), legs: Vec::new() };
        let classes = if spec.secondary == Secondary::Clearance { CLEARANCE_CLASSES } else { 1 };
        for (index, own) in rehearsed.iter().enumerate() {
            let action = moves.action(own, wanted);
            for class in 0..classes {
                let cost = cost(own, spec, class, rate_hz);
                let Leg { from, di, dj, to, .. } = own.leg;
                moves.actions[action].moves.push(Move { from, di, dj, to, cost });
                moves.legs[action].push((index, class));
            }
        }
        moves
    }

    fn action(&mut self, own: &Rehearsed, wanted: &[Wanted]) -> usize {
        if let Some(known) = self.actions.iter().position(|a| a.name == own.name) {
            return known;
        }
        let required = match own.leg.purpose {
            Purpose::Informative { piece, .. } => wanted[piece].count,
            Purpose::Basic(_) => 0,
        };
        self.actions.push(Action { name: own.name.clone(), required, moves: Vec::new() });
        self.legs.push(Vec::new());
        self.actions.len() - 1
    }

    /// The leg behind a move.
    pub(super) fn leg(&self, id: MoveId) -> usize {
        self.legs[id.action][id.index].0
    }

    /// The leg behind a step.
    pub(super) fn leg_of_step(&self, step: &lattice::Step) -> usize {
        let own =
            self.actions[step.action].moves.iter().enumerate().filter(|(_, m)| m.from == step.from.layer);
        let index = own.map(|(index, _)| index).nth(step.variant).unwrap_or(0);
        self.leg(MoveId { action: step.action, index })
    }
}

fn cost(own: &Rehearsed, spec: &CostSpec, class: usize, rate_hz: f64) -> Cost {
    let seconds = own.seconds(rate_hz);
    let primary = match spec.primary {
        Primary::BasicMoves => f64::from(u8::from(!own.is_informative())),
        Primary::Seconds => seconds,
    };
    let secondary = match spec.secondary {
        Secondary::Seconds if spec.primary == Primary::Seconds => 0.0,
        Secondary::Seconds => seconds,
        Secondary::Turns => f64::from(u8::from(own.name.starts_with("turn-"))),
        Secondary::Clearance => class as f64,
    };
    Cost { primary, secondary }
}

/// Poses of all samples, and the last.
fn track(sailed: &Sailed, end: Pose) -> Vec<Pose> {
    sailed.samples.iter().map(|s| s.pose).chain([end]).collect()
}

/// The area that the hull sweeps on a leg, by any of the vessels that rehearsed it.
pub(super) fn footprint(hull: &[[f64; 2]], own: &Rehearsed, cell_m: f64) -> Result<Footprint, ChartInvalid> {
    let nominal = track(&own.sailed, own.end);
    let swept = |poses: &Vec<Pose>| {
        let poses: Vec<(f64, f64, f64)> = poses.iter().map(|p| (p.y, p.x, p.psi)).collect();
        Footprint::swept(hull, &poses, cell_m)
    };
    let mut whole = swept(&nominal)?;
    for poses in &own.strayed {
        whole = whole.union(&swept(poses)?);
    }
    Ok(whole)
}
