//! A planned trial, for summaries and maps of it.

use super::prepared::Prepared;
use super::sailing::Sailing;
use super::solve::Solved;

/// A trial with its plan and the simulation of it.
#[derive(Clone, Copy, Debug)]
pub struct SailedPlan<'a> {
    /// Chart, lattice and moves.
    pub prepared: &'a Prepared,
    /// The cheapest walk.
    pub solved: &'a Solved,
    /// The simulated plan.
    pub sailing: &'a Sailing,
}
