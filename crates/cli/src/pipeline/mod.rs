//! A study from its first files to its page: what it begins with, which stages run with which flags, and which of them are
//! up to date.
//!
//! [`starting`] writes the hand-written files of a new study, [`ships`] a ship before her first trial. A [`Pipeline`] lists the stages of a study as command lines; a
//! [`Record`] knows by digests which of them need not run again. Whoever has the stages runs them.

mod folders;
mod record;
mod settings;
pub mod ships;
mod stages;
pub mod starting;
mod steps;

pub use folders::Folders;
pub use record::Record;
pub use settings::Settings;
pub use stages::Pipeline;
pub use steps::Step;
