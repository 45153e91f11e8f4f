//! Standard maneuvers of IMO and ITTC, as crews carry them out: the helm goes over where the ship has turned, or the time
//! has passed, not where a model expected it.

mod orders;
mod spec;

pub use spec::{
    Board, PullOut, ReverseSpiral, Sensors, Settings, SpiralTest, Standard, Stop, TurningCircle, WRONG_SIGN,
    ZigZagTest,
};

pub(crate) use orders::{Approach, Orders, changes};
pub(crate) use spec::{INERTIAL_END, check_names, is_turned_away, steps};
