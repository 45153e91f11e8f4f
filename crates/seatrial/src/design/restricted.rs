//! Few maneuvers, each for a while at least.

use std::path::Path;

use design::{Bounds, Design, Error, Options, Restriction, Status};

use super::criterion::Criterion;
use crate::failure::Failure;
use study::documents::Restricted;

/// What is asked for besides the criterion.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Few {
    /// At most so many maneuvers.
    pub most_maneuvers: Option<u64>,
    /// Each for at least so long \[s\].
    pub minimal_s: Option<f64>,
}

impl Few {
    /// Why there is none.
    pub fn refusal(&self, file: &Path, error: &Error) -> Failure {
        let asked = [
            self.most_maneuvers.map(|k| format!("--most-maneuvers {k}")),
            self.minimal_s.map(|s| format!("--minimal-s {s}")),
        ];
        Failure::NoAnswer(format!(
            "{}: {}: found no such choice that excites every parameter ({error}), expected one; allow more or shorter maneuvers",
            file.display(),
            asked.into_iter().flatten().collect::<Vec<_>>().join(" ")
        ))
    }
}

/// The design that keeps `few`, in an experiment of `duration_s` where that is known, from the one that need not.
/// `parameters`: their number.
///
/// # Errors
/// As the search.
pub fn restricted(
    criterion: &Criterion,
    relaxed: &Design,
    bounds: &Bounds,
    few: &Few,
    duration_s: Option<f64>,
    options: &Options,
    parameters: usize,
) -> Result<(Design, Restricted), Error> {
    let least = few.minimal_s.zip(duration_s).map_or(0.0, |(minimal, duration)| minimal / duration);
    let most = few.most_maneuvers.map_or(usize::MAX, |k| k as usize).min(relaxed.shares.len());
    let found = criterion.select(relaxed, bounds, &Restriction { most, least }, options)?;
    let degree = match criterion {
        Criterion::Information(_) => parameters as f64,
        Criterion::Covariance(_) => criterion.degree(),
    };
    let loss = found.loss_bound(relaxed, degree);
    let method = if found.exhaustive { "exhaustive" } else { "exchange" };
    let used = found.shares.iter().filter(|w| **w > 0.0).count();
    let searched = match found.exhaustive {
        true => format!("Best of all choices of maneuvers ({} tried)", found.tried),
        false => format!(
            "No exchange of one maneuver for another saves 0.1 % of the time ({} choices tried)",
            found.tried
        ),
    };
    let against = match relaxed.status {
        Status::Optimal => "at most, proved: the problem without it is concave",
        Status::Stationary | Status::Stalled => {
            "against the best shares found without it, which are not proved global"
        }
    };
    let statement = format!(
        "{searched}: {used} maneuvers; the restriction costs {:.2} % of the time {against}.",
        100.0 * loss
    );
    let design = Design {
        shares: found.shares,
        log_det: found.value,
        sensitivities: found.sensitivities,
        gap: found.gap,
        status: relaxed.status,
        starts: relaxed.starts.clone(),
    };
    let about = Restricted {
        most_maneuvers: few.most_maneuvers,
        minimal_s: few.minimal_s,
        method: method.into(),
        gap: loss,
        statement,
    };
    Ok((design, about))
}
