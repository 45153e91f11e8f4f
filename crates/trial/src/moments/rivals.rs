use design::{Bounds, Options, Rivals, solve_within};
use regression::MeanRemoval;
use ship::engine::Streams;

use super::{Estimated, Moments};

/// Random designs for the median.
const RANDOM: u32 = 400;
/// Segments of a random design, as in the paper.
const SEGMENTS: u32 = 5;

impl Moments {
    /// The designs for comparison: the shares of the paper's criterion, and random designs of equally long
    /// segments, each any maneuver.
    pub fn rivals(&self, removal: MeanRemoval, seed: u64) -> Rivals {
        let streams = Streams::new(seed, "random designs");
        let count = self.maneuvers.len();
        let random = |run: u32| {
            let mut shares = vec![0.0; count];
            for q in streams.choices(run, 0, count as u32, SEGMENTS as usize) {
                shares[q as usize] += 1.0 / f64::from(SEGMENTS);
            }
            shares
        };
        Rivals {
            paper: self.papers_shares(removal),
            random: (0..RANDOM).map(random).collect(),
            random_segments: SEGMENTS,
        }
    }

    fn papers_shares(&self, removal: MeanRemoval) -> Option<Vec<f64>> {
        let dictionary = self.dictionary(Estimated::Iv(removal)).ok()?;
        let options = Options { random_starts: 0, tolerance: 1e-8, ..Options::default() };
        solve_within(&dictionary.information, &Bounds::default(), &options).ok().map(|design| design.shares)
    }
}
