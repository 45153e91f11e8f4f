//! A planned trial, for those who say or draw what it comes to.

use super::prepared::Prepared;
use super::sailing::Sailing;
use super::solve::Solved;

/// A trial with its plan, and that as sailed.
#[derive(Clone, Copy, Debug)]
pub struct SailedPlan<'a> {
    /// Chart, lattice and moves.
    pub prepared: &'a Prepared,
    /// The cheapest walk.
    pub solved: &'a Solved,
    /// What is sailed of it.
    pub sailing: &'a Sailing,
}
