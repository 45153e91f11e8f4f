/// One move of the lattice as a script for the autopilot. Positions are north and east of the start node \[m\],
/// headings compass \[rad\].
#[derive(Clone, Debug, PartialEq)]
pub struct Leg {
    /// What it is for.
    pub purpose: Purpose,
    /// Layer of the start node.
    pub from: usize,
    /// Displacement in nodes, east.
    pub di: i32,
    /// Displacement in nodes, north.
    pub dj: i32,
    /// Layer of the end node.
    pub to: usize,
    /// Carried out one after the other.
    pub phases: Vec<Phase>,
}

/// What a leg is for.
#[derive(Clone, Debug, PartialEq)]
pub enum Purpose {
    /// Getting somewhere: name of the action.
    Basic(String),
    /// Using a piece of a maneuver.
    Informative {
        /// Index of the piece.
        piece: usize,
        /// Which way.
        side: Side,
    },
}

impl Purpose {
    /// Which way a maneuver is run.
    pub fn side(&self) -> Option<Side> {
        match self {
            Self::Informative { side, .. } => Some(*side),
            Self::Basic(_) => None,
        }
    }
}

vessel::choices! {
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
        /// Speed where it is taken up \[m/s\].
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
    /// The piece's inputs, open loop.
    Maneuver,
}
