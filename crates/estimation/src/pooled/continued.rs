use regression::pooled::{AnyParts, Unread, Windowed};

use super::searched::least_errors_any;
use super::windows::Score;
use super::{Pool, Scales, Searched};

/// Samples of the first windows of a search if whole parts diverge; their length doubles with each step.
const SHORTEST: usize = 8;
/// Factors on the start's parameters, tried in turn: with zero nothing moves, and nothing diverges.
const DAMPED: [f64; 4] = [1.0, 0.5, 0.1, 0.0];

impl Pool<'_> {
    /// Minimises the errors of free simulations of `parts`, from `start`. If these diverge, it fits short windows of
    /// them first, each from its first measured state, then longer ones from the result of the shorter ones; if need
    /// be from smaller multiples of `start`. `None` if none of this ends at a minimum.
    pub(super) fn continued(
        &self,
        parts: &AnyParts,
        start: &[f64],
        scales: &Scales,
    ) -> Result<Option<Searched>, Unread> {
        if let Some(found) = self.least_errors(parts, start, scales)? {
            return Ok(Some(found));
        }
        for share in DAMPED {
            let damped = |(value, size): (&f64, &f64)| if *size > 0.0 { share * value } else { *value };
            let from: Vec<f64> = start.iter().zip(&scales.sizes).map(damped).collect();
            let found = self.through_windows(parts, from, scales)?;
            if found.as_ref().is_some_and(|found| found.converged) {
                return Ok(found);
            }
        }
        Ok(None)
    }

    fn through_windows(
        &self,
        parts: &AnyParts,
        mut at: Vec<f64>,
        scales: &Scales,
    ) -> Result<Option<Searched>, Unread> {
        let longest = (0..parts.count()).map(|i| parts.samples(i)).max().unwrap_or(0);
        let lengths = std::iter::successors(Some(SHORTEST), |length| Some(2 * length));
        for length in lengths.take_while(|length| *length < longest) {
            let windows = Windowed::new(parts, length);
            if let Some(found) = self.least_errors(&windows, &at, scales)? {
                at = found.parameters;
            }
        }
        self.least_errors(parts, &at, scales)
    }

    pub(super) fn least_errors(
        &self,
        parts: &AnyParts,
        start: &[f64],
        Scales { std, sizes, follow }: &Scales,
    ) -> Result<Option<Searched>, Unread> {
        least_errors_any(&self.model, parts, start, *std, sizes, follow)
    }

    /// The recordings whose free simulation with `parameters` diverges, each once.
    pub(super) fn diverging(&self, parts: &AnyParts, parameters: &[f64]) -> Result<Vec<String>, Unread> {
        let mut named: Vec<String> = Vec::new();
        parts.each(&mut |part| {
            let score = Score::of(&self.model, parameters, std::iter::once(part.run));
            if score.diverged > 0 && !named.iter().any(|name| name == part.source) {
                named.push(part.source.to_owned());
            }
        })?;
        Ok(named)
    }
}
