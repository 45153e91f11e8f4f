//! Several runs to one model.

use identification::Estimator;
use identification::pooled::{Grown, Judgement, Pool, PoolError, Resampling, grown, unstated};
use identification::runs::AdditionalUnknowns;
use model::Vessel;
use regression::pooled::{NominalModel, NominalSource, PooledRuns, Recorded};
use study::pooled_set::PooledSet;
use validation::comparison::Magnitudes;

/// How one model is made of several runs.
#[derive(Clone)]
pub struct Pooling<'a> {
    /// The vessel, how means are removed, what instruments are simulated with, what is unknown.
    pub pool: Pool<'a>,
    /// Where the nominal model of instruments comes from.
    pub nominal: NominalSource,
    /// How often sub-experiments are drawn again, and the seed of that.
    pub judgement: Judgement,
    /// Terms that are added at most where the model is found to lack them.
    pub most_added: usize,
}

/// Where nobody asked for an estimator.
const NO_NOISE: &str = "estimated by `output-error`: no noise known here describes the errors, and filters for another one predict worse; \
     --estimator takes others";

impl<'a> Pooling<'a> {
    /// As usual for `vessel`: instruments by its nominal values, no terms added, nothing drawn again.
    pub fn new(vessel: &'a Vessel) -> Self {
        let judgement = Judgement { replicates: 0, seed: 1 };
        Self { pool: Pool::new(vessel), nominal: NominalSource::Given, judgement, most_added: 0 }
    }

    /// The same with instruments by least squares of the same data.
    #[must_use]
    pub fn by_least_squares(mut self) -> Self {
        (self.pool.nominal, self.nominal) = (NominalModel::Fitted, NominalSource::LeastSquares);
        self
    }

    /// The model of `runs`, by the estimator that is `asked` for or the usual one of measured logs.
    ///
    /// # Errors
    /// Parameters that the runs do not determine; a search that leads nowhere; runs that cannot be read again.
    pub fn model<R: Recorded>(
        &self,
        runs: &PooledRuns<R>,
        asked: Option<Estimator>,
    ) -> Result<PooledSet, PoolError<R::Error>> {
        let estimator = match asked.or_else(|| self.pool.usual(false)) {
            Some(estimator) => estimator,
            None => unstated(&self.pool, runs)?,
        };
        let grown = grown(&self.pool, runs, estimator, &self.judgement, self.most_added)?;
        self.judged(grown, runs, (estimator, asked.is_none()), Resampling::Drawn(&|_| ()))
    }

    /// The model of `runs` with the terms that `grown` says; and whether the estimator was the usual one.
    ///
    /// # Errors
    /// See [`Pooling::model`].
    pub fn judged<R: Recorded>(
        &self,
        grown: Grown,
        runs: &PooledRuns<R>,
        (estimator, is_usual): (Estimator, bool),
        resampling: Resampling,
    ) -> Result<PooledSet, PoolError<R::Error>> {
        let Self { pool, judgement, .. } = self;
        let mut found = grown.judged(pool, runs, estimator, judgement, resampling)?;
        if is_usual && estimator == Estimator::OutputError && pool.additional == AdditionalUnknowns::default()
        {
            found.found.statements.insert(0, NO_NOISE.to_owned());
        }
        let own = pool.of(&found.vessel, pool.nominal.clone());
        let made = (estimator, judgement.replicates);
        let mut set = PooledSet::new(&own, self.nominal, made, (&found.found, &found.added));
        if let Some(model) = &mut set.model {
            let Vessel { model: of, sample_rate_hz, .. } = pool.vessel;
            model.magnitudes = Magnitudes::of(of, runs, *sample_rate_hz).map_err(PoolError::Unread)?;
        }
        Ok(set)
    }
}
