use crate::Number;

/// Trajectories that are averaged sample by sample.
///
/// The mean moves towards each by its share of what it is off, so that the mean of equals is what they are, to the bit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct MeanTrajectory<N> {
    count: u32,
    mean: Vec<N>,
    /// Sums of squared distances from the mean.
    squares: Vec<N>,
}

impl<N: Number> MeanTrajectory<N> {
    /// Adds one, as long as the others.
    pub fn add(&mut self, states: &[N]) {
        if self.count == 0 {
            (self.mean, self.squares) = (states.to_vec(), vec![N::ZERO; states.len()]);
        }
        self.count += 1;
        let share = N::from(f64::from(self.count).recip());
        for ((mean, squares), state) in self.mean.iter_mut().zip(&mut self.squares).zip(states) {
            let off = *state - *mean;
            *mean += off * share;
            *squares += off * (*state - *mean);
        }
    }

    /// The mean.
    pub fn mean(&self) -> &[N] {
        &self.mean
    }
}

impl MeanTrajectory<f64> {
    /// Standard deviations of the trajectories about their mean, with one less than their number; 0 of a single one.
    pub fn spread(&self) -> Vec<f64> {
        let freedom = f64::from(self.count.max(2) - 1);
        self.squares.iter().map(|sum| (sum / freedom).sqrt()).collect()
    }
}
