//! The paper's study on measured data: models from sub-experiments that a design picked, against random picks.

mod counts;
mod draw;
mod realize;
mod stage;

pub use counts::counts;
pub use draw::Draw;
pub use realize::{Realization, Realizer};
pub use stage::{Wanted, select};
