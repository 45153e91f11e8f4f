use vessel::Lane;

use crate::sensitivity::{
    Levels, Products, Recordings, Sensitivities, Step, add_draws, add_start, backward, sweep,
};

/// Covariance of Σ sᵀWe where errors are correlated over less than about 2√N samples, of recordings simulated with `unknowns` by
/// the `free` ones, in a current of `levels` that is among them. Sample 0 counts where `from_start`. free × free lanes.
pub(crate) fn correlated_scores<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    free: &[usize],
    levels: Option<&Levels>,
    from_start: bool,
    weights: [Lane; 3],
) -> Vec<Lane> {
    let mut scores = Windowed::new(recordings.longest() + 1, free.len());
    sweep(
        recordings,
        unknowns,
        free,
        levels.map(Levels::spread).as_ref(),
        &[],
        #[inline(always)]
        |step: Step<'_, Lane, N>| {
            let counts = if step.k == 0 && !from_start { Lane::ZERO } else { recordings.lasting(step.k) };
            let weighted = [0, 1, 2].map(|d: usize| weights[d] * (step.error[d] * counts));
            for (i, s) in step.sensitivities.iter().enumerate() {
                let by = [s[0] * counts, s[1] * counts, s[2] * counts];
                scores.set(i, by[0] * weighted[0] + by[1] * weighted[1] + by[2] * weighted[2]);
            }
            scores.advance();
        },
    );
    scores.finish()
}

/// What `levels` add to the covariance of Σ sᵀWe beside measurement noise, to first order around the run's simulation: every
/// draw enters the states and goes on with them; adjoints tell what a change of the states does to the scores. free × free
/// lanes.
pub(crate) fn disturbed_scores<const N: usize>(
    recordings: &Recordings,
    unknowns: &[Lane],
    kept: &Sensitivities<Lane>,
    weights: [Lane; 3],
    levels: &Levels,
) -> Vec<Lane> {
    let mut draws = Products::new(kept.free());
    let start = backward::<Lane, N>(
        recordings,
        unknowns,
        kept,
        weights,
        Some(levels),
        #[inline(always)]
        |local, adjoints: &[[Lane; N]]| add_draws(&mut draws, adjoints, local, levels),
    );
    add_start(&mut draws, &start, levels);
    draws.finish().square()
}

/// Covariance of the sum of rows of scores that are correlated over less than about 2√N rows: the mean over all windows of
/// that many rows of (Σ over the window)(…)ᵀ per row, which is what Bartlett's weights 1 − |lag|/L give.
pub(crate) struct Windowed {
    /// The rows of the latest window, and how many there have been.
    latest: Vec<Lane>,
    rows: usize,
    window: usize,
    /// Over the latest window.
    sum: Vec<Lane>,
    products: Products<Lane>,
}

impl Windowed {
    /// Of so many `rows` of `p` scores.
    pub(crate) fn new(rows: usize, p: usize) -> Self {
        let window = (2.0 * (rows as f64).sqrt()).round().max(1.0) as usize;
        let (latest, sum) = (vec![Lane::ZERO; window * p], vec![Lane::ZERO; p]);
        Self { latest, rows: 0, window, sum, products: Products::new(p) }
    }

    /// Score `i` of this row.
    #[inline(always)]
    pub(crate) fn set(&mut self, i: usize, score: Lane) {
        let leaving = &mut self.latest[self.rows % self.window * self.sum.len() + i];
        self.sum[i] = self.sum[i] + score - *leaving;
        *leaving = score;
        self.products.set(i, self.sum[i]);
    }

    /// Goes to the next row: every score was set of this one.
    #[inline(always)]
    pub(crate) fn advance(&mut self) {
        self.rows += 1;
        self.products.advance();
    }

    /// p × p lanes.
    pub(crate) fn finish(mut self) -> Vec<Lane> {
        let share = Lane::splat(1.0 / self.window as f64);
        vessel::vectorized!(self.leave());
        self.products.finish().square().into_iter().map(|sum| share * sum).collect()
    }

    /// Lets the last rows leave, one after the other.
    #[inline(always)]
    fn leave(&mut self) {
        for _ in 0..self.window {
            for i in 0..self.sum.len() {
                self.set(i, Lane::ZERO);
            }
            self.advance();
        }
    }
}
