//! Few maneuvers, each for a while at least.

use crate::{Bounds, Criterion, Design, Error, Method, Options, Restriction};

/// Shares that keep a restriction, and what that costs.
#[derive(Clone, Debug, PartialEq)]
pub struct Restricted {
    /// The shares, as a design.
    pub design: Design,
    /// How they were found.
    pub method: Method,
    /// Choices of maneuvers that were tried.
    pub tried: usize,
    /// The fraction of the experiment's time that the restriction costs at most; proved where the design without it is.
    pub loss: f64,
}

/// The design that keeps `restriction`, from `relaxed`, the one that need not. `parameters`: their number.
///
/// # Errors
/// As [`Criterion::select`].
pub fn restricted(
    criterion: &Criterion,
    relaxed: &Design,
    bounds: &Bounds,
    restriction: &Restriction,
    options: &Options,
    parameters: usize,
) -> Result<Restricted, Error> {
    let found = criterion.select(relaxed, bounds, restriction, options)?;
    let loss = found.loss_bound(relaxed, criterion.per_time(parameters));
    let method = if found.exhaustive { Method::Exhaustive } else { Method::Exchange };
    let design = Design {
        shares: found.shares,
        log_det: found.value,
        sensitivities: found.sensitivities,
        gap: found.gap,
        status: relaxed.status,
        starts: relaxed.starts.clone(),
    };
    Ok(Restricted { design, method, tried: found.tried, loss })
}
