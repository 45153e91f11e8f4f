//! The structure of a model, found from recordings.

use estimation::against_nominal;
use estimation::search::{
    NamedRoles, Roles, SearchError, SearchOptions, Searched, core, library, search, with_channels,
};
use numerics::statistics::mean;
use refusal::Invalid;
use regression::pooled::PooledRuns;
use ship::model::terms::listed;
use ship::model::{Actuator, Model, Vessel};
use study::TermLists;
use study::documents::{AverageDocument, ModelDocument, SearchDocument};
use validation::comparison::Magnitudes;

/// The start of a search, and its candidate terms.
#[derive(Clone, Debug)]
pub struct StructureSearch {
    /// The vessel, whose terms the search begins with, and the channels that the terms need: runs need all of them.
    pub vessel: Vessel,
    /// Its model with all candidate terms.
    pub library: Model,
}

impl StructureSearch {
    /// Refuses a ship with forces.
    ///
    /// # Errors
    /// Names what finds forces that she lacks.
    pub fn check(vessel: &Vessel) -> Result<(), Invalid> {
        let remedy =
            "search for forces that she lacks by `ForceSearch`, or give it a vessel with terms per sample";
        vessel.check_terms("search").map_err(|own| Invalid { remedy: remedy.into(), ..own })
    }

    /// A search over the library of terms for the channels of `vessel` in these roles.
    ///
    /// # Errors
    /// Roles of channels that do not exist.
    pub fn by_roles(vessel: Vessel, roles: &NamedRoles) -> Result<Self, Invalid> {
        Self::check(&vessel)?;
        let roles = Roles::new(&vessel.model, roles)?;
        let (model, roles) = with_channels(&vessel.model, &roles)?;
        let library = library(&model, &roles);
        Ok(Self { vessel: Vessel { model, ..vessel }, library })
    }

    /// A search over the same library that begins with a core of terms ([`core_of`]) instead of those of `vessel`, or of her forces.
    ///
    /// # Errors
    /// As [`Self::by_roles`].
    pub fn by_core(vessel: &Vessel, roles: &NamedRoles) -> Result<Self, Invalid> {
        let (vessel, roles) = with_core(vessel, roles)?;
        let library = library(&vessel.model, &roles);
        Ok(Self { vessel, library })
    }

    /// A search over these terms.
    ///
    /// # Errors
    /// A term with channels that do not exist.
    pub fn by_terms(vessel: Vessel, TermLists { surge, sway, yaw }: &TermLists) -> Result<Self, Invalid> {
        Self::check(&vessel)?;
        let library = listed(&vessel.model, [surge, sway, yaw])?;
        Ok(Self { vessel, library })
    }

    /// Searches `runs`; `done` is called with the number of fits that are done, of [`SearchOptions::fits`] at most.
    ///
    /// # Errors
    /// Too few recordings; no model that follows them.
    pub fn find(
        &self,
        runs: &PooledRuns,
        options: &SearchOptions,
        done: &(dyn Fn(usize) + Sync),
    ) -> Result<FoundStructure, SearchError> {
        let vessel = &self.vessel;
        let mut found = search(&vessel.model, &self.library, runs, options, done)?;
        found.statements.extend(self.turned(&found));
        let model = self.model(runs, &found);
        let averaged = |all| AverageDocument::new(vessel, all, found.samples, model.magnitudes.as_ref());
        Ok(FoundStructure {
            search: SearchDocument::new(vessel, options, &found),
            average: found.average.as_ref().map(averaged),
            model,
        })
    }

    /// Estimates with another sign than the nominal value, in words; standard errors are those of the jackknife over folds.
    fn turned(&self, found: &Searched) -> Option<String> {
        let of = |model: &Model, theta: &[f64], name: &str| {
            theta.get(model.parameter_names().position(|own| own == name)?).copied()
        };
        let known = self.vessel.model.parameter_names().map(|name| {
            let ships = found.without.iter().flatten();
            let without: Vec<f64> = ships.filter_map(|own| of(&own.model, &own.theta, name)).collect();
            let (count, mean) = (without.len() as f64, mean(&without)?);
            let squares: f64 = without.iter().map(|own| (own - mean).powi(2)).sum();
            Some([of(&found.model, &found.delivered.theta, name)?, ((count - 1.0) / count * squares).sqrt()])
        });
        against_nominal(&self.vessel.model, &self.vessel.nominal, &known.collect::<Vec<_>>())
    }

    /// The model that was found in `runs`.
    pub(crate) fn model(&self, runs: &PooledRuns, found: &Searched) -> ModelDocument {
        let Ok(magnitudes) = Magnitudes::of(&self.vessel.model, runs, self.vessel.sample_rate_hz);
        ModelDocument { magnitudes, ..ModelDocument::searched(&self.vessel, found) }
    }
}

/// `vessel` with a core of terms per sample in place of her own, or of her forces: [`estimation::search::core`]. Nothing is known of their values.
///
/// # Errors
/// Roles of channels that do not exist.
pub fn core_of(vessel: &Vessel, roles: &NamedRoles) -> Result<Vessel, Invalid> {
    with_core(vessel, roles).map(|(vessel, _)| vessel)
}

fn with_core(vessel: &Vessel, roles: &NamedRoles) -> Result<(Vessel, Roles), Invalid> {
    let roles = Roles::new(&vessel.model, roles)?;
    let astern = |own: &Actuator| own.range.is_some_and(|[low, _]| low < 0.0);
    let reversing: Vec<usize> =
        (3..).zip(&vessel.actuators).filter(|(_, own)| astern(own)).map(|(i, _)| i).collect();
    let (model, roles) = core(&vessel.model, &roles, &reversing)?;
    if model.degrees == vessel.model.degrees && vessel.model.forces.is_none() {
        return Ok((Vessel { model, ..vessel.clone() }, roles));
    }
    let count = model.parameters();
    let (value, nominal) = (vec![None; count], vec![0.0; count]);
    Ok((Vessel { model, value, nominal, constrained: Vec::new(), ..vessel.clone() }, roles))
}

/// The result of a search.
#[derive(Clone, Debug)]
pub struct FoundStructure {
    /// `search.json`: how it was found, and its validation.
    pub search: SearchDocument,
    /// `model.json`.
    pub model: ModelDocument,
    /// `average.json`, if several models were requested.
    pub average: Option<AverageDocument>,
}
