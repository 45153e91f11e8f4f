//! Whole segments of a design.

use crate::{Available, CountOptions, Counted, Criterion, Design, Error, apportion};

/// The requested whole segments.
#[derive(Clone, Debug, PartialEq)]
pub struct Segments {
    /// Their number n.
    pub total: u64,
    /// Samples of each.
    pub samples: u64,
    /// Maximum number of segments of every maneuver.
    pub limits: Option<Vec<u64>>,
}

impl Segments {
    /// So many segments of so many samples, within what is available; none of maneuvers that a restricted design does
    /// not use.
    pub fn within(
        (total, samples): (u64, u64),
        available: Option<&Available>,
        restricted: Option<&Design>,
    ) -> Self {
        let mut limits = available.and_then(|available| available.counts.clone());
        if let Some(design) = restricted {
            let known = limits.unwrap_or_else(|| vec![total; design.shares.len()]);
            let used = known.iter().zip(&design.shares);
            limits = Some(used.map(|(limit, share)| if *share > 0.0 { *limit } else { 0 }).collect());
        }
        Self { total, samples, limits }
    }
}

/// Counts of whole segments, and their efficiency against the shares.
#[derive(Clone, Debug, PartialEq)]
pub struct Whole {
    /// Segments of every maneuver.
    pub counts: Vec<u64>,
    /// The result of the search; `None` if all choices of so few segments are singular: then the shares are
    /// apportioned.
    pub found: Option<Counted>,
    /// Efficiency of the counts against the shares.
    pub efficiency: f64,
    /// Upper bound on the fraction of the experiment's time that the counts waste against the best shares.
    pub loss: f64,
    /// The fraction of the time that the counts need for the information of the apportioned shares.
    pub apportioned: f64,
}

/// The best counts. `parameters`: their number.
///
/// # Errors
/// As [`Criterion::count`].
pub fn counted(
    criterion: &Criterion,
    design: &Design,
    segments: &Segments,
    options: &CountOptions,
    parameters: usize,
) -> Result<Whole, Error> {
    let found = match criterion.count(&design.shares, segments.total, segments.limits.as_deref(), options) {
        Err(Error::Solver(_)) => {
            let counts = apportion(&design.shares, segments.total);
            return Ok(Whole { counts, found: None, efficiency: 0.0, loss: 1.0, apportioned: 0.0 });
        }
        found => found?,
    };
    let shares: Vec<f64> = found.counts.iter().map(|n| *n as f64 / segments.total as f64).collect();
    let degree = criterion.per_time(parameters);
    Ok(Whole {
        counts: found.counts.clone(),
        efficiency: criterion.efficiency(design, &shares, parameters),
        loss: found.loss_bound(design, degree),
        apportioned: libm::exp((found.apportioned - found.value) / degree),
        found: Some(found),
    })
}
