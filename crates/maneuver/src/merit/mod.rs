//! Figures of merit of standard maneuvers, by the definitions of IMO MSC.137(76) and ITTC 7.5-04-02-01.

mod criteria;
mod figure;
mod figures;
mod helm;
mod record;
mod sailed;
mod spirals;

pub use figure::{Figure, Hull};
pub use figures::{Found, figures};
pub use record::Record;
