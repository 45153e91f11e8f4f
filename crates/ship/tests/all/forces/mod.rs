//! Published ships, laws of steps and tangents, and what is refused.

mod guess;
mod laws;
mod published;
mod refusals;
mod ships;
mod similar;
