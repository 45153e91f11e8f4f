//! Search for a model that generalises, from recordings alone.
//!
//! In addition to the base structure, a library of terms is fitted by the errors of free simulations over overlapping
//! windows, with a ridge penalty Λβ² on each scaled parameter β. Λ is chosen by cross-validation over whole
//! recordings, each fold on its own path. The whole algorithm is then scored on recordings that it has not seen. A search that
//! adds forces to a ship is scored in the same way ([`judged_ships`]).

mod average;
mod beside;
mod bootstrap;
mod compact;
mod core_terms;
mod deliver;
mod folds;
mod gram;
mod judged;
mod left_out;
mod library;
mod made;
mod minimum;
mod nested;
mod pairs;
mod physical;
mod problem;
mod recording;
mod roles;
mod scores;
mod searched;
mod wind;
mod words;

pub use average::{AverageOptions, Averaged, Member, draw_most};
pub use beside::{Alone, Dealt, Kind};
pub use bootstrap::{BootstrapOptions, Resampled, ResampledParameter, draw_again, folds_of_drawn};
pub use compact::SizeScore;
pub use core_terms::core;
pub use folds::folds;
pub use judged::{Margin, NestedAverage, NestedRecording, NestedScore};
pub use library::{library, with_channels};
pub use nested::Candidate;
pub use physical::{FittedShip, JudgedShips, ShipsWithoutFold, judged_ships};
pub use recording::{Cut, Recording};
pub use roles::{NamedRoles, Roles};
pub use searched::{SearchError, SearchOptions, Searched, search};
pub use words::{averaged, fits, left_out};
