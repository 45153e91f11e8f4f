//! Figures of merit of standard maneuvers, by the definitions of IMO MSC.137(76) and ITTC 7.5-04-02-01.

mod criteria;
mod figure;
mod figures;
mod record;
mod spirals;

pub use figure::{Figure, Hull};
pub use figures::figures;
pub use record::Record;
