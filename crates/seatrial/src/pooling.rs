//! Several runs to one model.

use estimation::Estimator;
use estimation::pooled::{Grown, Judgement, Pool, PoolError, Resampling, grown, unstated};
use estimation::runs::AdditionalUnknowns;
use regression::pooled::{NominalModel, NominalSource, PooledRuns, Recorded};
use ship::model::Vessel;
use study::pooled_set::PooledSet;
use validation::comparison::Magnitudes;

/// Options of a model from several runs.
#[derive(Clone)]
pub struct Pooling<'a> {
    /// The vessel, the removal of means, the model of the instruments, the additional unknowns.
    pub pool: Pool<'a>,
    /// The source of the nominal model of instruments.
    pub nominal: NominalSource,
    /// Number of resamples of sub-experiments, and their seed.
    pub judgement: Judgement,
    /// Maximum number of missing terms that are added.
    pub most_added: usize,
}

/// A remark if no estimator was requested.
const NO_NOISE: &str = "estimated by `output-error`: no noise known here describes the errors, and filters for another one predict worse; \
     --estimator takes others";

impl<'a> Pooling<'a> {
    /// Defaults for `vessel`: instruments by its nominal values, no added terms, no resamples.
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

    /// The model of `runs`, by the requested estimator `asked`, or the default for measured logs.
    ///
    /// # Errors
    /// Parameters that the runs do not determine; a failed search; runs that cannot be read again.
    pub fn model<R: Recorded>(
        &self,
        runs: &PooledRuns<R>,
        asked: Option<Estimator>,
    ) -> Result<PooledSet, PoolError<R::Error>> {
        if let Err(refused) = self.pool.vessel.check_terms("estimate pool") {
            return Err(PoolError::NotIdentifiable(vec![refused.to_string()]));
        }
        let estimator = match asked.or_else(|| self.pool.usual(false)) {
            Some(estimator) => estimator,
            None => unstated(&self.pool, runs)?,
        };
        let grown = grown(&self.pool, runs, estimator, &self.judgement, self.most_added)?;
        self.judged(grown, runs, (estimator, asked.is_none()), Resampling::Drawn(&|_| ()))
    }

    /// The model of `runs` with the terms of `grown`; and whether the estimator was the default.
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
