use std::f64::consts::FRAC_PI_2;

use crate::Grid;
use crate::grid::wrap;

/// One move of the lattice as a script for the autopilot. Positions are north and east of the start node \[m\],
/// headings compass \[rad\].
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// Its purpose.
    pub purpose: Purpose,
    /// Layer of the start node.
    pub from: usize,
    /// Displacement in nodes, east.
    pub di: i32,
    /// Displacement in nodes, north.
    pub dj: i32,
    /// Layer of the end node.
    pub to: usize,
    /// Its phases, in order.
    pub phases: Vec<Phase>,
}

/// The purpose of a leg.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// Transit: name of the action.
    Basic(String),
    /// Using a piece of a maneuver.
    Informative {
        /// Index of the piece.
        piece: usize,
        /// The side.
        side: Side,
    },
}

impl Purpose {
    /// The index of a maneuver's piece.
    pub fn piece(&self) -> Option<usize> {
        match self {
            Self::Informative { piece, .. } => Some(*piece),
            Self::Basic(_) => None,
        }
    }

    /// The side of a maneuver.
    pub fn side(&self) -> Option<Side> {
        match self {
            Self::Informative { side, .. } => Some(*side),
            Self::Basic(_) => None,
        }
    }
}

refusal::choices! {
    /// Which way a maneuver is run.
    pub enum Side {
        /// As in the dictionary.
        AsDesigned = "as designed",
        /// To the other side.
        Mirrored = "mirrored",
    }
}

/// A part of a leg.
#[derive(Clone, Debug, PartialEq)]
pub enum Phase {
    /// Along the straight line that ends at `to`, speed changing evenly with distance.
    Line {
        /// End of the line.
        to: [f64; 2],
        /// Heading of the line.
        heading_rad: f64,
        /// Speed at its beginning \[m/s\].
        from_m_s: f64,
        /// Speed at its end \[m/s\].
        to_m_s: f64,
    },
    /// Along an arc.
    Arc {
        /// Its centre.
        centre: [f64; 2],
        /// Its radius \[m\].
        radius_m: f64,
        /// Heading at its end.
        to_rad: f64,
        /// +1 to starboard, −1 to port.
        side: f64,
        /// Speed \[m/s\].
        speed_m_s: f64,
    },
    /// At rest: to a place and heading, turning on the spot.
    Hold {
        /// The place.
        at: [f64; 2],
        /// The heading.
        heading_rad: f64,
    },
    /// The piece's commands.
    Maneuver,
}

impl Leg {
    /// The leg rotated to port by `quarters` quarter turns: without a known current all directions are
    /// equivalent.
    pub(crate) fn turned(&self, quarters: usize, grid: &Grid) -> Self {
        let ([dj, di], mut phases) = (turned([self.dj, self.di], quarters), self.phases.clone());
        phases.iter_mut().for_each(|phase| phase.turn(quarters));
        Self {
            purpose: self.purpose.clone(),
            from: grid.turned(self.from, quarters),
            di,
            dj,
            to: grid.turned(self.to, quarters),
            phases,
        }
    }
}

impl Phase {
    fn turn(&mut self, quarters: usize) {
        let by = |heading: &mut f64| *heading = wrap(*heading - quarters as f64 * FRAC_PI_2);
        match self {
            Self::Line { to, heading_rad, .. } => (*to, ()) = (turned(*to, quarters), by(heading_rad)),
            Self::Arc { centre, to_rad, .. } => (*centre, ()) = (turned(*centre, quarters), by(to_rad)),
            Self::Hold { at, heading_rad } => (*at, ()) = (turned(*at, quarters), by(heading_rad)),
            Self::Maneuver => {}
        }
    }
}

/// North and east, rotated to port by quarter turns.
pub(crate) fn turned<T: Copy + std::ops::Neg<Output = T>>([north, east]: [T; 2], quarters: usize) -> [T; 2] {
    match quarters % 4 {
        0 => [north, east],
        1 => [east, -north],
        2 => [-north, -east],
        _ => [-east, north],
    }
}

/// North and east, as along and across a heading, to starboard.
pub(crate) fn turned_back([north, east]: [f64; 2], heading_rad: f64) -> [f64; 2] {
    let (sin, cos) = libm::sincos(heading_rad);
    [north * cos + east * sin, east * cos - north * sin]
}
