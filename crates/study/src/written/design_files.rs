//! The hand-written files of a design: the stock of maneuvers.

use std::collections::BTreeMap;
use std::path::Path;

use design::Stock;
use files::{Digest, Error, Provenance, STUDY_ROLES, read_document, read_json};
use refusal::Invalid;
use ship::model::Source;
use trial::moments::Moments;

use crate::documents::{DesignDocument, IngestDocument, ModelDocument, MomentsDocument};
use crate::figure_goals::FigureGoals;
use crate::invalid;

/// A design whose trial has been run, and what it was made from.
pub struct Promised {
    /// The design.
    pub design: DesignDocument,
    /// Its moments.
    pub moments: Moments,
    /// The parameters that its errors are relative to.
    pub relative_to: Source,
    /// Figures of merit, if given.
    pub figures: Option<FigureGoals>,
}

impl Promised {
    /// Reads the files and notes their digests.
    ///
    /// # Errors
    /// A file that is refused; moments that the design was not made from.
    pub fn read(
        design: &Path,
        moments: &Path,
        figures: Option<&Path>,
        provenance: &mut Provenance,
    ) -> Result<Self, Error> {
        let document = read_document::<DesignDocument>(design)?;
        provenance.made("design", design, document.digest, &document.provenance)?;
        let read = read_document::<MomentsDocument>(moments)?;
        provenance.made("moments", moments, read.digest, &read.provenance)?;
        let of = read.data.moments().map_err(|e| invalid(moments, &e))?;
        if of.prior.is_some() {
            let expected = "information in proportion to time, by which a promise is updated";
            let remedy = "compare with the standard errors of the model.json";
            let refused = Invalid::new("`data.prior`", "priors, which count once", expected, remedy);
            return Err(invalid(moments, &refused));
        }
        let relative_to = document.provenance.settings.get("relative_to").and_then(|name| name.as_str());
        let is_value = relative_to == Some(Source::Value.name());
        Ok(Self {
            design: document.data,
            figures: figures.map(|path| FigureGoals::read(path, &of, provenance)).transpose()?,
            moments: of,
            relative_to: if is_value { Source::Value } else { Source::Nominal },
        })
    }

    /// Reads the estimate of the trial; it may be by another vessel.toml than the design's, with other nominal values.
    ///
    /// # Errors
    /// A file that is refused, or was made from another design.
    pub fn model(&self, path: &Path, provenance: &mut Provenance) -> Result<ModelDocument, Error> {
        let loaded = read_document::<ModelDocument>(path)?;
        let mut from = loaded.provenance;
        let others: Vec<&str> = STUDY_ROLES.into_iter().filter(|role| *role != "design").collect();
        from.forget(&others);
        provenance.made("model", path, loaded.digest, &from)?;
        Ok(loaded.data)
    }
}

/// Reads the available amount of every maneuver and notes the file's digest: tables `seconds` and `segments` in TOML
/// or JSON, or the segments that `ingest.json` counts.
///
/// # Errors
/// A file that is refused, a maneuver that is not in `maneuvers` or that is limited twice, a negative time.
pub fn read_stock(path: &Path, maneuvers: &[String], provenance: &mut Provenance) -> Result<Stock, Error> {
    let json = path.extension().is_some_and(|e| e.eq_ignore_ascii_case("json"));
    let stock = if json {
        let (stock, digest) = stock_of_json(path)?;
        provenance.written("available", path, digest)?;
        stock
    } else {
        provenance.read_toml("available", "available", path)?
    };
    check_stock(&stock, maneuvers).map_err(|e| invalid(path, &e))?;
    Ok(stock)
}

fn stock_of_json(path: &Path) -> Result<(Stock, Digest), Error> {
    let (value, digest) = read_json::<serde_json::Value>(path)?;
    if value.get("schema").is_some() {
        let loaded = read_document::<IngestDocument>(path)?;
        let segments = loaded.data.maneuvers.into_iter().map(|m| (m.name, m.segments)).collect();
        return Ok((Stock { seconds: BTreeMap::new(), segments }, loaded.digest));
    }
    Ok((read_json::<Stock>(path)?.0, digest))
}

fn check_stock(stock: &Stock, maneuvers: &[String]) -> Result<(), Invalid> {
    let mut keys = stock.seconds.keys().chain(stock.segments.keys());
    if let Some(unknown) = keys.find(|key| !maneuvers.contains(key)) {
        let expected = "a maneuver of the moments".into();
        let unknown = Invalid::unknown("maneuver", unknown, maneuvers.iter().map(String::as_str));
        return Err(Invalid { expected, ..unknown });
    }
    if let Some(twice) = stock.seconds.keys().find(|key| stock.segments.contains_key(*key)) {
        let thing = format!("maneuver `{twice}`");
        let given = "a limit in `seconds` and one in `segments`";
        return Err(Invalid::new(thing, given, "one limit", "remove one"));
    }
    Ok(())
}
