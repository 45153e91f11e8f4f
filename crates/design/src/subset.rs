use crate::Objective;

/// An [`Objective`] over some of its candidates; the others have no share.
pub(crate) struct Subset<'a, O> {
    pub objective: &'a O,
    pub members: Vec<usize>,
}

impl<O: Objective> Subset<'_, O> {
    /// Shares of all candidates.
    pub(crate) fn whole(&self, shares: &[f64]) -> Vec<f64> {
        let mut whole = vec![0.0; self.objective.len()];
        self.members.iter().zip(shares).for_each(|(q, w)| whole[*q] = *w);
        whole
    }
}

impl<O: Objective> Objective for Subset<'_, O> {
    type Point = O::Point;

    fn len(&self) -> usize {
        self.members.len()
    }

    fn degree(&self) -> f64 {
        self.objective.degree()
    }

    fn size(&self) -> usize {
        self.objective.size()
    }

    fn exponent(&self) -> f64 {
        self.objective.exponent()
    }

    fn evaluate(&self, shares: &[f64], at: &mut O::Point) -> Option<f64> {
        self.objective.evaluate(&self.whole(shares), at)
    }

    fn value(&self, shares: &[f64], at: &mut O::Point) -> Option<f64> {
        self.objective.value(&self.whole(shares), at)
    }

    fn sensitivity(&self, q: usize, at: &O::Point) -> f64 {
        self.objective.sensitivity(self.members[q], at)
    }

    fn curvature(&self, members: &[usize], at: &O::Point) -> Vec<f64> {
        let mapped: Vec<usize> = members.iter().map(|q| self.members[*q]).collect();
        self.objective.curvature(&mapped, at)
    }
}
