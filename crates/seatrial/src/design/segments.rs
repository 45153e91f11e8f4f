//! Whole segments.

use design::{CountOptions, Counted, Design, Error, Method, Status};

use super::criterion::Criterion;
use study::documents::Counts;

/// The whole segments that are asked for.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    /// Their number n.
    pub total: u64,
    /// Samples of each.
    pub samples: u64,
    /// At most so many of every maneuver.
    pub limits: Option<Vec<u64>>,
}

/// The best counts and what is known of them. `parameters`: their number.
///
/// # Errors
/// As the search.
pub fn counted(
    criterion: &Criterion,
    design: &Design,
    segments: &Segments,
    options: &CountOptions,
    parameters: usize,
) -> Result<(Vec<u64>, Counts), Error> {
    let found = match criterion.count(&design.shares, segments.total, segments.limits.as_deref(), options) {
        // Too few segments for any regular mixture: the shares apportioned, of no efficiency.
        Err(Error::Solver(_)) => return Ok(singular(design, segments)),
        found => found?,
    };
    let shares: Vec<f64> = found.counts.iter().map(|n| *n as f64 / segments.total as f64).collect();
    let degree = degree(criterion, parameters);
    let loss = found.loss_bound(design, degree);
    let about = Counts {
        segments: segments.total,
        segment_samples: segments.samples,
        efficiency: criterion.efficiency(design, &shares, parameters),
        method: Some(
            match found.method {
                Method::Exhaustive => "exhaustive",
                Method::Exchange => "exchange",
            }
            .into(),
        ),
        gap: Some(loss),
        statement: Some(statement(&found, design, loss, degree)),
    };
    Ok((found.counts, about))
}

fn singular(design: &Design, segments: &Segments) -> (Vec<u64>, Counts) {
    let counts = design::apportion(&design.shares, segments.total);
    let about = Counts {
        segments: segments.total,
        segment_samples: segments.samples,
        efficiency: 0.0,
        method: None,
        gap: Some(1.0),
        statement: Some("So few segments excite not every parameter, whichever maneuvers they are.".into()),
    };
    (counts, about)
}

/// What the criterion gains per log of time spent at fixed shares, per parameter for D.
fn degree(criterion: &Criterion, parameters: usize) -> f64 {
    match criterion {
        Criterion::Information(_) => parameters as f64,
        Criterion::Covariance(_) => criterion.degree(),
    }
}

fn statement(found: &Counted, design: &Design, loss: f64, degree: f64) -> String {
    let searched = match found.method {
        Method::Exhaustive => format!("Best of all counts ({} tried)", found.tried),
        Method::Exchange => {
            format!("No exchange of one segment for another is better ({} counts tried)", found.tried)
        }
    };
    let against = match design.status {
        Status::Optimal => "at most, proved: the problem is concave",
        Status::Stationary | Status::Stalled => "against the best shares found, which are not proved global",
    };
    let apportioned = ((found.apportioned - found.value) / degree).exp();
    format!(
        "{searched}; whole segments cost {:.2} % of the time {against}; apportioned shares would be worth {:.2} % of these \
         counts.",
        100.0 * loss,
        100.0 * apportioned
    )
}
