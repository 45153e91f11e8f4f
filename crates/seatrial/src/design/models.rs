//! The criterion of one model, and of several.

use std::path::Path;

use design::{Candidates, Covariance, Norm, Over, Robust};

use super::criterion::{Asked, CriterionName, LARGEST, OverModels};
use super::matrices::{information, middle};
use super::refusal::no_design;
use crate::failure::Failure;
use study::documents::MomentsDocument;

/// Sharpness of what stands for the worst model: within log(models)/s of it.
const WORST: f64 = 1e5;

/// The criterion of one model.
pub(super) fn covariance(
    asked: &Asked,
    file: &Path,
    moments: &MomentsDocument,
    information: &Candidates,
) -> Result<Covariance, Failure> {
    let middle = middle(file, moments, asked.estimated)?;
    let norm = match asked.name {
        CriterionName::DHessian | CriterionName::D => Norm::LogDet,
        CriterionName::A | CriterionName::ARelative | CriterionName::V => Norm::PowerMean(1.0),
        CriterionName::E => Norm::PowerMean(LARGEST),
    };
    let built = match asked.name {
        CriterionName::V => Covariance::of_matrices(information, &middle, &[validation(file, moments)?]),
        _ => Covariance::new(information, &middle, &lifted(moments, asked), norm),
    };
    built.map_err(|e| no_design(file, moments, asked.estimated, e))
}

/// All models together.
pub(super) fn robust(asked: &Asked, moments: &MomentsDocument, own: &Covariance) -> Result<Robust, Failure> {
    let mut models = vec![own.clone()];
    for (file, other) in asked.also {
        let names = |m: &MomentsDocument| m.maneuvers.iter().map(|m| m.name.clone()).collect::<Vec<_>>();
        if names(other) != names(moments) || other.degrees.len() != moments.degrees.len() {
            return Err(Failure::refuse(
                file,
                "`data.maneuvers`",
                &format!("{} maneuvers of other names or in another order", other.maneuvers.len()),
                &format!("the {} of --moments", moments.maneuvers.len()),
                "run `moments` on the same trajectories",
            ));
        }
        let information = information(file, other, asked.estimated)?;
        models.push(covariance(asked, file, other, &information)?);
    }
    let over = match asked.over {
        OverModels::Mean => Over::Mean,
        OverModels::Worst => Over::Worst(WORST),
    };
    Robust::new(models, over)
        .map_err(|e| Failure::NoAnswer(format!("models: found {e}, expected models alike; name others")))
}

fn validation(file: &Path, moments: &MomentsDocument) -> Result<Vec<f64>, Failure> {
    moments.output_error.as_ref().and_then(|o| o.g.clone()).ok_or_else(|| {
        Failure::refuse(
            file,
            "`data.output_error.G`",
            "none",
            "what free runs over the validation maneuvers depend on",
            "run `moments` again with --campaign and --estimator output-error",
        )
    })
}

/// Weights of all rows: 0 for intercepts.
fn lifted(moments: &MomentsDocument, asked: &Asked) -> Vec<f64> {
    let mut rest = asked.weights.iter().copied();
    let mut out = Vec::new();
    for degree in &moments.degrees {
        out.extend(rest.by_ref().take(degree.parameters.len()));
        if asked.estimated.has_intercepts() {
            out.push(0.0);
        }
    }
    out
}
