use std::ops::Range;

use vessel::Number;

use super::regressors::{ALL, Picked, Regressors, SPAN, Span};
use crate::Batch;
use crate::batch::{AnyBatch, parts};

/// ζ at all samples of a batch whose runs share it, evaluated once for all passes and for all batches that share it.
pub(crate) struct Kept<X> {
    /// As in [`Regressors`]: so many signals, span after span, and of every term the place of its own.
    width: usize,
    signals: Vec<Span<X>>,
    places: Vec<usize>,
}

impl Kept<f64> {
    /// Of a batch whose runs share ζ, and of a model whose structure is not known.
    pub(crate) fn of(batch: AnyBatch) -> Option<Self> {
        let AnyBatch::Shared(batch) = batch else { return None };
        if batch.model.structure().is_some() {
            return None;
        }
        let (mut regressors, mut signals) = (Regressors::of(batch.model, ALL), Vec::new());
        vessel::vectorized!(for (k, count) in parts::<SPAN>(0..batch.samples()) {
            batch.zeta(k, count, &mut regressors);
            signals.extend_from_slice(&regressors.signals);
        });
        Some(Self { width: regressors.signals.len(), signals, places: regressors.places })
    }
}

/// Where ζ comes from.
pub(super) enum Zeta<'k, X> {
    /// It was kept, of the batch's first sample and all after it.
    Kept(&'k Kept<X>),
    /// It is evaluated, span by span.
    Evaluated(Regressors<X>),
}

impl<'k, X: Number> Zeta<'k, X> {
    /// ζ at samples `range`, those in `terms` of each degree of freedom. What was kept serves where `range` begins and ends with
    /// its spans.
    pub(super) fn new(
        kept: Option<&'k Kept<X>>,
        batch: &Batch<X>,
        range: &Range<usize>,
        terms: [Range<usize>; 3],
    ) -> Self {
        let whole = |k: usize| k.is_multiple_of(SPAN) || k == batch.samples();
        match kept.filter(|_| whole(range.start) && whole(range.end)) {
            Some(kept) => Self::Kept(kept),
            None => Self::Evaluated(Regressors::of(batch.model, terms)),
        }
    }

    /// Its terms at samples `k..k + count`, `count` ≤ [`SPAN`]. Zero beyond.
    #[inline(always)]
    pub(super) fn at(&mut self, batch: &Batch<X>, k: usize, count: usize) -> Picked<'_, X> {
        match self {
            Self::Kept(Kept { width, signals, places }) => {
                Picked { signals: &signals[k / SPAN * width..][..*width], places }
            }
            Self::Evaluated(regressors) => {
                batch.zeta(k, count, regressors);
                regressors.terms()
            }
        }
    }
}
