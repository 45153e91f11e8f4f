use std::path::Path;

use design::{NoDesign, Scarce};

use crate::failure::Failure;

/// Why there is no design of the moments in `moments`, with the stock in the file `available`.
pub(super) fn no_design(moments: &Path, available: Option<&Path>, why: NoDesign) -> Failure {
    let file = moments.display();
    match why {
        NoDesign::Unexcited { degree, parameter, regressor } => Failure::NoAnswer(format!(
            "{file}: parameter `{parameter}` ({degree}): found a direction that no maneuver excites, expected every parameter to \
             be excited by some maneuver; add a maneuver in which `{regressor}` varies independently of the other terms of \
             {degree}, or run `moments` with --hold-unexcited"
        )),
        NoDesign::Singular { degree, parameter } => Failure::NoAnswer(format!(
            "{file}: parameter `{parameter}` ({degree}): found a covariance that is singular, with no variance of its own, \
             expected the disturbances to reach every parameter; expect noise in {degree} too, or take --criterion d-hessian"
        )),
        NoDesign::Scarce(why) => scarce(available.unwrap_or(moments), why),
        NoDesign::OutOfReach(found) => Failure::NoAnswer(format!(
            "{file}: --accuracy: {found}; ask for that, or make more time or better maneuvers available"
        )),
        NoDesign::Search(other) => Failure::NoAnswer(format!(
            "{file}: design: found {other}, expected a convergent search; raise --starts or --tolerance"
        )),
    }
}

/// Why the available maneuvers are not enough for an experiment.
pub(super) fn scarce(file: &Path, why: Scarce) -> Failure {
    let usage = |table: &str, flags: &str| {
        Failure::Usage(format!(
            "--available: found `{table}` in {}, expected {flags} to relate them to; add it",
            file.display()
        ))
    };
    let too_little = |found: String, expected: String| {
        Failure::NoAnswer(format!(
            "{}: what is available: found {found}, expected at least {expected}; shorten the experiment or make more \
             available",
            file.display()
        ))
    };
    match why {
        Scarce::NoSegments => usage("segments", "--segments and --segment-samples"),
        Scarce::NoLength => usage("seconds", "--duration-s, or --segments and --segment-samples,"),
        Scarce::Time { share } => too_little(
            format!("{:.1} % of the experiment's time in all maneuvers together", 100.0 * share),
            "100 %".into(),
        ),
        Scarce::Segments { found, expected } => {
            too_little(format!("{found} whole segments"), expected.to_string())
        }
    }
}
