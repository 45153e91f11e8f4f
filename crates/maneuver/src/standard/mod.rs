//! Standard maneuvers of IMO and ITTC, as crews carry them out: the helm goes over where the ship has turned, or the time
//! has passed, not where a model expected it.

mod checks;
mod orders;
mod spec;

pub use spec::{
    Board, PullOut, ReverseSpiral, Sensors, SpiralTest, Standard, Stop, TurningCircle, ZigZagTest,
};

pub(crate) use orders::{Approach, Orders};
pub(crate) use spec::{Settings, steps};
