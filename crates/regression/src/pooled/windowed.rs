use std::ops::Range;

use super::{PartView, Parts};

/// Parts cut into windows, each a part by itself.
#[derive(Clone, Debug)]
pub struct Windowed<'a, P: ?Sized> {
    parts: &'a P,
    /// The part of each window, and its samples.
    windows: Vec<(usize, Range<usize>)>,
}

impl<'a, P: Parts + ?Sized> Windowed<'a, P> {
    /// The windows of each part one after another, each of `most` samples, at least 1, but for the last of a part.
    pub fn new(parts: &'a P, most: usize) -> Self {
        let of = |i: usize| {
            let samples = parts.samples(i);
            (0..samples).step_by(most).map(move |first| (i, first..(first + most).min(samples)))
        };
        Self { parts, windows: (0..parts.count()).flat_map(of).collect() }
    }
}

impl<P: Parts + ?Sized> Parts for Windowed<'_, P> {
    type Error = P::Error;

    fn count(&self) -> usize {
        self.windows.len()
    }

    fn samples(&self, i: usize) -> usize {
        self.windows[i].1.len()
    }

    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), P::Error> {
        let wanted: Vec<usize> = places.iter().map(|i| self.windows[*i].0).collect();
        let mut windows = places.iter().map(|i| &self.windows[*i].1);
        self.parts.at(&wanted, &mut |part| {
            if let Some(samples) = windows.next() {
                look(PartView { run: part.run.part(samples.clone()), ..part });
            }
        })
    }
}
