use std::ops::Range;

use regression::pooled::{PartView, Parts};

use super::windows::Score;
use super::{Pool, Scales, Searched, least_errors};

/// Samples of the first windows of a search if whole parts diverge; their length doubles with each step.
const SHORTEST: usize = 8;
/// Factors on the start's parameters, tried in turn: with zero nothing moves, and nothing diverges.
const DAMPED: [f64; 4] = [1.0, 0.5, 0.1, 0.0];

impl Pool<'_> {
    /// Minimises the errors of free simulations of `parts`, from `start`. If these diverge, it fits short windows of
    /// them first, each from its first measured state, then longer ones from the result of the shorter ones; if need
    /// be from smaller multiples of `start`. `None` if none of this ends at a minimum.
    pub(super) fn continued<P: Parts>(
        &self,
        parts: &P,
        start: &[f64],
        scales: &Scales,
    ) -> Result<Option<Searched>, P::Error> {
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

    fn through_windows<P: Parts>(
        &self,
        parts: &P,
        mut at: Vec<f64>,
        scales: &Scales,
    ) -> Result<Option<Searched>, P::Error> {
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

    pub(super) fn least_errors<P: Parts>(
        &self,
        parts: &P,
        start: &[f64],
        Scales { std, sizes, follow }: &Scales,
    ) -> Result<Option<Searched>, P::Error> {
        least_errors(&self.model, parts, start, *std, sizes, follow)
    }

    /// The recordings whose free simulation with `parameters` diverges, each once.
    pub(super) fn diverging<P: Parts>(&self, parts: &P, parameters: &[f64]) -> Result<Vec<String>, P::Error> {
        let mut named: Vec<String> = Vec::new();
        parts.each(|part| {
            let score = Score::of(&self.model, parameters, std::iter::once(part.run));
            if score.diverged > 0 && !named.iter().any(|name| name == part.source) {
                named.push(part.source.to_owned());
            }
        })?;
        Ok(named)
    }
}

/// Windows of parts, with a maximum number of samples.
struct Windowed<'a, P> {
    parts: &'a P,
    /// The part of each window, and its samples.
    windows: Vec<(usize, Range<usize>)>,
}

impl<'a, P: Parts> Windowed<'a, P> {
    fn new(parts: &'a P, most: usize) -> Self {
        let of = |i: usize| {
            let samples = parts.samples(i);
            (0..samples).step_by(most).map(move |first| (i, first..(first + most).min(samples)))
        };
        Self { parts, windows: (0..parts.count()).flat_map(of).collect() }
    }
}

impl<P: Parts> Parts for Windowed<'_, P> {
    type Error = P::Error;

    fn count(&self) -> usize {
        self.windows.len()
    }

    fn samples(&self, i: usize) -> usize {
        self.windows[i].1.len()
    }

    fn at(&self, places: &[usize], mut look: impl FnMut(PartView)) -> Result<(), P::Error> {
        let wanted: Vec<usize> = places.iter().map(|i| self.windows[*i].0).collect();
        let mut windows = places.iter().map(|i| &self.windows[*i].1);
        self.parts.at(&wanted, |part| {
            if let Some(samples) = windows.next() {
                look(PartView { run: part.run.part(samples.clone()), ..part });
            }
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use regression::pooled::Part;

    #[test]
    fn law_windows_hold_every_sample_once_and_come_in_any_order() {
        let part = |first: f64, samples: usize| Part {
            label: String::new(),
            source: first.to_string(),
            instrument_exogenous: Vec::new(),
            exogenous: (0..samples).map(|k| first + k as f64).collect(),
            measured: (0..3 * (samples + 1)).map(|k| first + k as f64).collect(),
        };
        let parts = vec![part(100.0, 19), part(200.0, 8), part(300.0, 3)];
        let windows = Windowed::new(&parts, 8);
        assert_eq!((0..windows.count()).map(|i| windows.samples(i)).collect::<Vec<_>>(), [8, 8, 3, 8, 3]);
        let mut inputs = Vec::new();
        let Ok(()) = windows.each(|window| inputs.extend_from_slice(window.run.exogenous));
        assert_eq!(inputs, parts.iter().flat_map(|part| part.exogenous.clone()).collect::<Vec<_>>());
        let mut firsts = Vec::new();
        let Ok(()) = windows.at(&[4, 1, 1, 0], |w| firsts.push((w.source.to_owned(), w.run.measured[0])));
        let named = |source: &str, first| (source.to_owned(), first);
        assert_eq!(
            firsts,
            [named("300", 300.0), named("100", 124.0), named("100", 124.0), named("100", 100.0)]
        );
    }
}
