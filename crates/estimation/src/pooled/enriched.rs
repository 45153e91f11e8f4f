use regression::pooled::{NominalModel, PooledRuns, Recorded};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::model::terms::listed;
use ship::model::{DegreeOfFreedom, Vessel};

use super::estimate::{PoolError, Pooled, estimate};
use super::{Judgement, Pool, Resampling};
use crate::Estimator;
use crate::criticism::Absent;

/// A term that a model lacked and was given.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct Added {
    /// The term.
    pub term: String,
    /// `surge`, `sway` or `yaw`.
    pub degree: String,
    /// What its parameter is called.
    pub parameter: String,
    /// The parameter's unit.
    pub unit: String,
    /// How probable it was under the model without it that anything looked for seems as likely to be missing.
    pub p_value: f64,
    /// The estimate in the model as it is now; null where it has none.
    pub value: Option<f64>,
    /// Its standard error.
    pub standard_error: Option<f64>,
}

/// An estimate of a vessel whose model was extended by terms.
#[derive(Clone, Debug)]
pub struct Enriched {
    /// The vessel with those terms.
    pub vessel: Vessel,
    /// Its estimate.
    pub found: Pooled,
    /// The terms, in the order in which they were found to be missing.
    pub added: Vec<Added>,
}

/// A vessel whose model was extended by the terms that it lacked.
#[derive(Clone, Debug)]
pub struct Grown {
    /// The vessel.
    pub vessel: Vessel,
    /// The model that its instruments are simulated with.
    pub nominal: NominalModel,
    /// The terms, without estimates of them.
    added: Vec<Added>,
    /// Its estimate, judged without resamples; `None` if no term was added.
    pooled: Option<Pooled>,
}

/// Estimates as [`grown`] and [`estimate`] do.
///
/// # Errors
/// See [`estimate`].
pub fn enriched<R: Recorded>(
    pool: &Pool,
    runs: &PooledRuns<R>,
    estimator: Estimator,
    judgement: &Judgement,
    most: usize,
    resampling: Resampling,
) -> Result<Enriched, PoolError<R::Error>> {
    grown(pool, runs, estimator, judgement, most)?.judged(pool, runs, estimator, judgement, resampling)
}

/// Estimates as [`estimate`] does, adds the term that a rejected model most likely lacks, and estimates again: until
/// it is not rejected, lacks something other than a term, or `most` were added. A term is not added if the model is
/// not identifiable with it.
///
/// # Errors
/// See [`estimate`].
pub fn grown<R: Recorded>(
    pool: &Pool,
    runs: &PooledRuns<R>,
    estimator: Estimator,
    judgement: &Judgement,
    most: usize,
) -> Result<Grown, PoolError<R::Error>> {
    let quick = Judgement { replicates: 0, ..*judgement };
    let judged = |pool: &Pool| estimate(pool, runs, estimator, &quick, Resampling::Given(&[]));
    let (vessel, nominal) = (pool.vessel.clone(), pool.nominal.clone());
    let mut grown = Grown { vessel, nominal, added: Vec::new(), pooled: None };
    if most > 0 {
        grown.pooled = Some(judged(pool)?);
    }
    while grown.added.len() < most {
        let lacks = |pooled| lacking(&grown.vessel, pooled);
        let Some((richer, place, more)) = grown.pooled.as_ref().and_then(lacks) else { break };
        let mut theta = grown.nominal.clone();
        if let NominalModel::Known(theta) = &mut theta {
            theta.insert(place, richer.nominal[place]);
        }
        match judged(&pool.of(&richer, theta.clone())) {
            Ok(again) if again.delivered.is_some() => grown.pooled = Some(again),
            Err(PoolError::Unread(e)) => return Err(PoolError::Unread(e)),
            _ => break,
        }
        (grown.vessel, grown.nominal) = (richer, theta);
        grown.added.push(more);
    }
    Ok(grown)
}

impl Grown {
    /// The estimate, judged.
    ///
    /// # Errors
    /// See [`estimate`].
    pub fn judged<R: Recorded>(
        self,
        pool: &Pool,
        runs: &PooledRuns<R>,
        estimator: Estimator,
        judgement: &Judgement,
        resampling: Resampling,
    ) -> Result<Enriched, PoolError<R::Error>> {
        let Self { vessel, nominal, mut added, pooled } = self;
        let mut pooled = match pooled.filter(|_| judgement.replicates == 0) {
            Some(pooled) => pooled,
            None => estimate(&pool.of(&vessel, nominal), runs, estimator, judgement, resampling)?,
        };
        for more in &mut added {
            let parameter =
                pooled.degrees.iter().flat_map(|d| &d.parameters).find(|p| p.name == more.parameter);
            (more.value, more.standard_error) =
                parameter.map_or((None, None), |p| (p.estimate, p.standard_error));
        }
        let sentences = added.iter().map(Added::sentence);
        pooled.statements = sentences.chain(std::mem::take(&mut pooled.statements)).collect();
        Ok(Enriched { vessel, found: pooled, added })
    }
}

impl Added {
    fn sentence(&self) -> String {
        let number = |x: Option<f64>| x.map_or("none".to_owned(), |x| format!("{x:.3e}"));
        let p = if self.p_value < 1e-4 { "p < 0.0001".to_owned() } else { format!("p {:.4}", self.p_value) };
        let (value, error) = (number(self.value), number(self.standard_error));
        format!("`{}` added in {} ({p} without it): {value} ± {error} {}", self.term, self.degree, self.unit)
    }
}

/// `vessel` with the term that is most likely missing, and its place; `None` if the model lacks no term.
fn lacking(vessel: &Vessel, pooled: &Pooled) -> Option<(Vessel, usize, Added)> {
    let criticism = pooled.criticism.as_ref().filter(|criticism| criticism.rejected)?;
    let first: &Absent = criticism.absent.first()?;
    let degree = DegreeOfFreedom::ALL.into_iter().find(|d| first.degree.as_deref() == Some(d.name()))?;
    let mut lists: [&[String]; 3] = [&[]; 3];
    let term = [first.name.clone()];
    lists[degree as usize] = &term;
    let model = listed(&vessel.model, lists).ok()?;
    let place = model.layout().terms(degree as usize).end - 1;
    let added = Added {
        term: first.name.clone(),
        degree: degree.name().to_owned(),
        parameter: model.degrees[degree as usize].parameters.last()?.clone(),
        unit: first.unit.clone(),
        p_value: first.p_value,
        value: None,
        standard_error: None,
    };
    let mut richer = Vessel { model, ..vessel.clone() };
    richer.value.insert(place, None);
    richer.nominal.insert(place, *first.value.first()?);
    (richer.model.parameters() == richer.nominal.len()).then_some((richer, place, added))
}
