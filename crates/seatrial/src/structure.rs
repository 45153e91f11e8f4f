//! The structure of a model, found from recordings.

use model::terms::listed;
use model::{Model, Vessel};
use refusal::Invalid;
use regression::pooled::PooledRuns;
use search::{NamedRoles, Roles, SearchError, SearchOptions, library, search, with_channels};
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
        let found = search(&vessel.model, &self.library, runs, options, done)?;
        let Ok(magnitudes) = Magnitudes::of(&vessel.model, runs, vessel.sample_rate_hz);
        let averaged = |all| AverageDocument::new(vessel, all, found.samples, magnitudes.as_ref());
        Ok(FoundStructure {
            search: SearchDocument::new(vessel, options, &found),
            average: found.average.as_ref().map(averaged),
            model: ModelDocument { magnitudes, ..ModelDocument::searched(vessel, &found) },
        })
    }
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
