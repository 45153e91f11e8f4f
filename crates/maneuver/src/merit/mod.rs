//! Figures of merit of standard maneuvers, by the definitions of IMO MSC.137(76) and ITTC 7.5-04-02-01.

mod criteria;
mod figures;
mod record;
mod spirals;

pub use figures::{Figure, Hull, figures};
pub use record::Record;
