//! Parts and runs with their error type erased: what computes from them is compiled once, wherever they are stored.

use std::sync::{Mutex, MutexGuard, PoisonError};

use super::{Part, PartView, Parts, PooledRuns, Recorded};

/// The place in [`Faults`] of why something could not be read.
#[derive(Debug)]
pub struct Unread(usize);

/// Parts of any kind.
pub type AnyParts<'a> = dyn Parts<Error = Unread> + 'a;

/// Runs of any kind, by their sources.
pub trait AnyRuns: Sync {
    /// See [`PooledRuns::design`].
    fn design(&self) -> &str;
    /// See [`PooledRuns::sources`].
    fn sources(&self) -> usize;
    /// Calls `look` with the name and the whole runs of every source, see [`PooledRuns::each_source`].
    fn each_source(&self, look: &mut dyn FnMut(&str, Vec<Part>)) -> Result<(), Unread>;
}

/// Why parts or runs could not be read.
#[derive(Debug)]
pub struct Faults<E>(Mutex<Vec<Option<E>>>);

/// Parts or runs whose errors are kept in [`Faults`].
#[derive(Debug)]
pub struct Erased<'a, T, E> {
    inner: &'a T,
    faults: &'a Faults<E>,
}

impl<E> Default for Faults<E> {
    fn default() -> Self {
        Self(Mutex::default())
    }
}

impl<E> Faults<E> {
    /// `inner` with its errors kept here.
    pub fn erased<'a, T>(&'a self, source: &'a T) -> Erased<'a, T, E> {
        Erased { inner: source, faults: self }
    }

    /// The error that was kept there, once.
    pub fn take(&self, Unread(place): Unread) -> E {
        match self.all().get_mut(place).and_then(Option::take) {
            Some(error) => error,
            None => unreachable!("an error is kept before its place is known"),
        }
    }

    fn keep(&self, error: E) -> Unread {
        let mut all = self.all();
        all.push(Some(error));
        Unread(all.len() - 1)
    }

    fn all(&self) -> MutexGuard<'_, Vec<Option<E>>> {
        self.0.lock().unwrap_or_else(PoisonError::into_inner)
    }
}

impl<P: Parts> Parts for Erased<'_, P, P::Error> {
    type Error = Unread;

    fn count(&self) -> usize {
        self.inner.count()
    }

    fn samples(&self, i: usize) -> usize {
        self.inner.samples(i)
    }

    fn at(&self, places: &[usize], look: &mut dyn FnMut(PartView)) -> Result<(), Unread> {
        self.inner.at(places, look).map_err(|error| self.faults.keep(error))
    }
}

impl<R: Recorded> AnyRuns for Erased<'_, PooledRuns<R>, R::Error> {
    fn design(&self) -> &str {
        self.inner.design()
    }

    fn sources(&self) -> usize {
        self.inner.sources()
    }

    fn each_source(&self, look: &mut dyn FnMut(&str, Vec<Part>)) -> Result<(), Unread> {
        self.inner.each_source(None, look).map_err(|error| self.faults.keep(error))
    }
}
