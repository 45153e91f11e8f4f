use std::path::Path;

use design::Error;

use super::matrices::Estimated;
use crate::failure::Failure;
use study::documents::MomentsDocument;

/// What concerns the one block of all parameters, told of the degree of freedom that it concerns most.
fn by_degree(moments: &MomentsDocument, estimated: Estimated, error: Error) -> Error {
    if let Estimated::Iv(_) = estimated {
        return error;
    }
    let ends: Vec<usize> = moments
        .degrees
        .iter()
        .scan(0, |end, d| {
            *end += d.regressors.len();
            Some(*end)
        })
        .collect();
    let degree = |row: usize| ends.iter().position(|end| row < *end).unwrap_or(0);
    let first = |d: usize| if d == 0 { 0 } else { ends[d - 1] };
    match error {
        Error::Unexcited { direction, .. } => {
            let largest =
                (0..direction.len()).max_by(|a, b| direction[*a].abs().total_cmp(&direction[*b].abs()));
            let block = degree(largest.unwrap_or(0));
            let direction = direction.get(first(block)..ends[block]).unwrap_or_default().to_vec();
            Error::Unexcited { block, direction }
        }
        Error::SingularCovariance { row, .. } => {
            let block = degree(row);
            Error::SingularCovariance { block, row: row - first(block) }
        }
        other => other,
    }
}

/// Why there is no design of the moments in `file`.
pub fn no_design(file: &Path, moments: &MomentsDocument, estimated: Estimated, error: Error) -> Failure {
    match by_degree(moments, estimated, error) {
        Error::Unexcited { block, direction } => {
            let degree = &moments.degrees[block];
            let weight = |i: &usize| direction[*i].abs();
            let parameter =
                (0..degree.parameters.len()).max_by(|a, b| weight(a).total_cmp(&weight(b))).unwrap_or(0);
            Failure::NoAnswer(format!(
                "{}: parameter `{}` ({}): found a direction that no maneuver excites, expected every parameter to be \
                 excited by some maneuver; add a maneuver in which `{}` varies independently of the other terms of {}",
                file.display(),
                degree.parameters[parameter],
                degree.name,
                degree.regressors[parameter],
                degree.name
            ))
        }
        Error::SingularCovariance { block, row } => {
            let degree = &moments.degrees[block];
            Failure::NoAnswer(format!(
                "{}: parameter `{}` ({}): found a covariance that is singular, with no variance of its own, expected the \
                 disturbances to reach every parameter; expect noise in {} too, or take --criterion d-hessian",
                file.display(),
                degree.parameters.get(row).or(degree.parameters.last()).map_or("", String::as_str),
                degree.name,
                degree.name
            ))
        }
        Error::Empty => {
            Failure::refuse(file, "`data.maneuvers`", "none", "at least one maneuver", "run `moments` again")
        }
        other => Failure::NoAnswer(format!(
            "{}: design: found {other}, expected a convergent search; raise --starts or --tolerance",
            file.display()
        )),
    }
}
