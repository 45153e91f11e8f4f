//! Figures of merit of standard maneuvers, by the definitions of IMO MSC.137(76) and ITTC 7.5-04-02-01.

mod figures;
mod helm;
mod record;
mod sailed;

pub use figures::{Found, figures};
pub use record::{Figure, Hull, Record};
