use std::convert::Infallible;
use std::fmt;
use std::path::{Path, PathBuf};
use std::str::FromStr;

use artifact::{Provenance, read_document};
use identification::pooled::{Options, fit};
use identification::{MeanRemoval, Sums};
use vessel::Vessel;

use crate::failure::Failure;
use study::documents::EstimateDocument;

/// The nominal model that was asked for.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub enum Nominal {
    /// The nominal values of `vessel.toml`.
    #[default]
    Given,
    /// The least-squares fit of the same data.
    LeastSquares,
    /// The mean estimate of a previous `estimate.json`.
    File(PathBuf),
}

impl FromStr for Nominal {
    type Err = Infallible;

    fn from_str(text: &str) -> Result<Self, Infallible> {
        Ok(match text {
            "given" => Self::Given,
            "least-squares" => Self::LeastSquares,
            file => Self::File(file.into()),
        })
    }
}

impl fmt::Display for Nominal {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(match self {
            Self::Given => "given",
            Self::LeastSquares => "least-squares",
            Self::File(_) => "estimate",
        })
    }
}

/// A nominal model: known now, or to be fitted to whatever data is used.
#[derive(Clone, Debug, PartialEq)]
pub enum NominalModel {
    /// θ: surge, sway, yaw.
    Known(Vec<f64>),
    /// The least-squares fit.
    Fitted,
}

impl NominalModel {
    /// Reads what `nominal` names.
    ///
    /// # Errors
    /// A file that is refused, of several designs, or of other parameters.
    pub fn read(nominal: &Nominal, vessel: &Vessel, provenance: &mut Provenance) -> Result<Self, Failure> {
        provenance.settings.insert("nominal".into(), nominal.to_string().into());
        match nominal {
            Nominal::Given => Ok(Self::Known(vessel.nominal.clone())),
            Nominal::LeastSquares => Ok(Self::Fitted),
            Nominal::File(path) => {
                let loaded = read_document::<EstimateDocument>(path)?;
                provenance.inputs.insert("nominal".into(), loaded.digest);
                previous(path, &loaded.data, vessel).map(Self::Known)
            }
        }
    }

    /// θ and intercepts, with the least-squares `sums` of the data at hand. `None` where those identify no model.
    pub fn parameters(&self, sums: &[&Sums], removal: MeanRemoval) -> Option<(Vec<f64>, [f64; 3])> {
        match self {
            Self::Known(theta) => Some((theta.clone(), [0.0; 3])),
            Self::Fitted => {
                let options = Options { removal, prior: None, most: f64::INFINITY };
                let fits = fit(sums, &options).map(|degree| degree.solution);
                let theta: Option<Vec<Vec<f64>>> =
                    fits.iter().map(|s| s.as_ref().map(|s| s.theta.clone())).collect();
                Some((theta?.concat(), fits.map(|s| s.map_or(0.0, |s| s.intercept))))
            }
        }
    }
}

fn previous(path: &Path, document: &EstimateDocument, vessel: &Vessel) -> Result<Vec<f64>, Failure> {
    let [design] = document.designs.as_slice() else {
        let found = format!("{} designs", document.designs.len());
        let remedy = "name an estimate.json of `estimate pool`";
        return Err(Failure::refuse(path, "data.designs", &found, "one", remedy));
    };
    let value = |name: &str| {
        let found = design.parameters.iter().find(|p| p.name == name).and_then(|p| p.mean);
        found.ok_or_else(|| {
            let remedy = "estimate it, or name the vessel that the estimate is of";
            Failure::refuse(path, &format!("parameter `{name}`"), "no estimate", "one", remedy)
        })
    };
    vessel.model.parameter_names().map(value).collect()
}
