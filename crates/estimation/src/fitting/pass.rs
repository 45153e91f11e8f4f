use std::ops::Deref;

use crate::fitting::Problem;

/// A problem with what its windows start from.
#[derive(Clone, Copy)]
pub(crate) struct Pass<'p> {
    problem: &'p Problem<'p>,
    /// How many samples the first one of u, v and r counts as, where windows have starts of their own; none where they start
    /// at it.
    pub first: Option<[f64; 3]>,
}

impl<'p> Pass<'p> {
    pub fn new(problem: &'p Problem<'p>, first: Option<[f64; 3]>) -> Self {
        Self { problem, first }
    }

    /// Unknowns of a window: θ and its start.
    pub fn unknowns(&self) -> usize {
        self.forces.parameters().len() + if self.first.is_some() { 3 } else { 0 }
    }

    /// What errors of u, v and r are multiplied by in sample `k`.
    #[inline(always)]
    pub fn scales(&self, k: usize) -> [f64; 3] {
        let scales = self.deviations.map(|own| 1.0 / own);
        match (k, self.first) {
            (0, Some(first)) => [0, 1, 2].map(|d| scales[d] * first[d].sqrt()),
            (0, None) => [0.0; 3],
            _ => scales,
        }
    }
}

impl<'p> Deref for Pass<'p> {
    type Target = Problem<'p>;

    fn deref(&self) -> &Problem<'p> {
        self.problem
    }
}
