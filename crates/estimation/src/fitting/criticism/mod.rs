//! What is wrong with a fitted ship: signs of geometry, inputs that act late, and forces that she lacks.
//!
//! Signs come first. Each is turned by itself and the ship is fitted again from there ([`Turn`]). If no sign is wrong, the
//! fit is tested for what it lacks: products of motion and inputs as forces, and inputs that act later than they are logged.
//! A candidate has a number that is 0 in the model. Its score is the derivative of half the cost by that number, from which
//! what the fitted numbers and the starts of windows can explain is taken away: g = Σ Jᵀe, H = Σ JᵀJ. It would lower the
//! cost by g²/H. Windows, or pieces of them, are independent units: z = g/√V, V the sum of their squared scores. The
//! probability counts all candidates: signs of the units are drawn anew, and the largest |z| of a draw is compared.

mod chance;
mod columns;
mod criticise;
mod late;
mod products;
mod scores;
mod turn;
mod turned;

pub use criticise::{AbsentTerm, Channels, Criticism, LEVEL};
pub use late::{LateInput, Lateness};
pub use turn::Turn;
pub use turned::TurnedSign;
