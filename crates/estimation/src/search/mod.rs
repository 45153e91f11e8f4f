//! Search for a model that generalises, from recordings alone.
//!
//! In addition to the base structure, a library of terms is fitted by the errors of free simulations over overlapping
//! windows, with a ridge penalty Λβ² on each scaled parameter β. Λ is chosen by cross-validation over whole
//! recordings, each fold on its own path. The whole algorithm is then scored on recordings that it has not seen. A search that
//! adds forces to a ship is scored in the same way ([`judged_ships`]).

mod average;
mod beside;
mod compact;
mod judged;
mod library;
mod nested;
mod problem;
mod recording;
mod roles;
mod scores;
mod searched;
mod words;

pub use average::{
    AverageOptions, Averaged, BootstrapOptions, Member, Resampled, ResampledParameter, draw_again, draw_most,
    folds_of_drawn,
};
pub use beside::{Alone, Dealt, Kind};
pub use compact::SizeScore;
pub use judged::{
    FittedShip, JudgedShips, Margin, NestedAverage, NestedRecording, NestedScore, ShipsWithoutFold,
    judged_ships,
};
pub use library::{core, library, with_channels};
pub use nested::Candidate;
pub use recording::{Cut, Recording, folds};
pub use roles::{NamedRoles, Roles};
pub use searched::{SearchError, SearchOptions, Searched, search};
pub use words::{averaged, fits, left_out};
