//! How much every parameter's variance counts.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Provenance, read_toml};
use clap::ValueEnum;
use serde::Deserialize;
use vessel::nearest;

use super::criterion::CriterionName;
use crate::failure::Failure;
use study::documents::{ExpectedDisturbances, MomentsDocument};

/// Which parameters relative errors are relative to.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
pub enum Relative {
    /// The nominal ones
    Nominal,
    /// Those that the disturbances were linearised with: the true ones where they are known
    Value,
}

/// `weights.toml`: parameter → weight of its variance.
#[derive(Clone, Debug, Deserialize)]
#[serde(deny_unknown_fields)]
struct WeightsFile {
    weight: BTreeMap<String, f64>,
}

/// The weight of every parameter: 1, 1/θ², or those of a file, in which parameters that are not named count nothing.
///
/// # Errors
/// Usage where the criterion has no weights; a weight of an unknown parameter or below zero; a parameter of zero.
pub fn weights(
    name: CriterionName,
    relative: Relative,
    given: Option<&Path>,
    file: &Path,
    moments: &MomentsDocument,
    provenance: &mut Provenance,
) -> Result<Vec<f64>, Failure> {
    let parameters: Vec<&str> =
        moments.degrees.iter().flat_map(|d| d.parameters.iter().map(String::as_str)).collect();
    match (given, name) {
        (Some(path), CriterionName::A | CriterionName::ARelative | CriterionName::E) => {
            let (written, digest) = read_toml::<WeightsFile>(path)?;
            provenance.inputs.insert("weights".into(), digest);
            check_weights(path, &written.weight, &parameters)?;
            Ok(parameters.iter().map(|p| written.weight.get(*p).copied().unwrap_or(0.0)).collect())
        }
        (Some(_), _) => Err(Failure::Usage(
            "--weights: found weights for a D-criterion, which no weights change, expected --criterion a, a-relative or e; \
             leave them out"
                .into(),
        )),
        (None, CriterionName::ARelative) => Ok(squares(relative, file, moments)?.iter().map(|s| 1.0 / s).collect()),
        (None, _) => Ok(vec![1.0; parameters.len()]),
    }
}

/// The squares of the parameters that errors are relative to.
///
/// # Errors
/// A parameter of zero.
pub fn squares(relative: Relative, file: &Path, moments: &MomentsDocument) -> Result<Vec<f64>, Failure> {
    let parameters = moments.degrees.iter().flat_map(|d| &d.parameters);
    // Without disturbances the criterion itself is refused.
    let Some(disturbances) = &moments.disturbances else { return Ok(parameters.map(|_| 1.0).collect()) };
    let of = |d: &ExpectedDisturbances, name: &str| match relative {
        Relative::Nominal => d.nominal.get(name).copied(),
        Relative::Value => d.parameters.get(name).copied(),
    };
    let square = |name: &String| match of(disturbances, name) {
        Some(theta) if theta != 0.0 && theta.is_finite() => Ok(theta * theta),
        found => Err(Failure::refuse(
            file,
            &format!("parameter `{name}`"),
            &found.map_or("no value".into(), |v| format!("{v}")),
            "a value other than 0 that its error can be relative to",
            match relative {
                Relative::Nominal => "take --relative-to value, or name --weights",
                Relative::Value => "name --weights",
            },
        )),
    };
    parameters.map(square).collect()
}

fn check_weights(path: &Path, written: &BTreeMap<String, f64>, parameters: &[&str]) -> Result<(), Failure> {
    if let Some(unknown) = written.keys().find(|key| !parameters.contains(&key.as_str())) {
        let remedy = match nearest(unknown, parameters.iter().copied()) {
            Some(near) => format!("did you mean `{near}`?"),
            None => "name one of them".into(),
        };
        let expected = format!("a parameter: one of {}", parameters.join(", "));
        return Err(Failure::refuse(path, "`weight`", &format!("`{unknown}`"), &expected, &remedy));
    }
    if let Some((name, weight)) = written.iter().find(|(_, w)| !(w.is_finite() && **w >= 0.0)) {
        let thing = format!("`weight` of `{name}`");
        return Err(Failure::refuse(path, &thing, &weight.to_string(), "zero or more", "correct it"));
    }
    match written.values().any(|w| *w > 0.0) {
        true => Ok(()),
        false => Err(Failure::refuse(path, "`weight`", "none above zero", "at least one", "add one")),
    }
}
