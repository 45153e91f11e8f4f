use std::collections::BTreeMap;

use design::{Bounds, Candidates, CovariancePoint, Design, Evaluation, Norm, Objective, Status};

use super::available::Available;
use super::criterion::{CovarianceCriterion, Criterion, CriterionName, OverModels};
use super::matrices::Estimated;
use crate::cli::name_of;
use crate::instruments::Removal;
use study::documents::{
    Accuracy, Counts, CovarianceCriterion as CovarianceDocument, DesignDocument, Efficiency, MomentsDocument,
    Restricted, RobustModels, Sequence, Start,
};

/// A solved design with what it was asked for.
pub struct Solved<'a> {
    /// The moments.
    pub moments: &'a MomentsDocument,
    /// Their information matrices.
    pub information: &'a Candidates,
    /// Name of the criterion.
    pub name: CriterionName,
    /// The criterion.
    pub criterion: &'a Criterion,
    /// The estimate that it is about.
    pub estimated: Estimated,
    /// Mean removal.
    pub removal: Removal,
    /// The best shares.
    pub design: &'a Design,
    /// What is available, where that is limited.
    pub available: Option<&'a Available>,
    /// Whole segments, where they were asked for.
    pub counted: Option<(Vec<u64>, Counts)>,
    /// Samples of the experiment, where known.
    pub samples: Option<f64>,
    /// How the models become one, where there are several.
    pub over: Option<OverModels>,
    /// About a restriction, where one was asked for.
    pub restricted: Option<Restricted>,
    /// About a wanted accuracy, where one was asked for.
    pub accuracy: Option<Accuracy>,
    /// Order and lengths, where they were asked for.
    pub sequence: Option<Sequence>,
}

/// `design.json`.
pub fn document(solved: Solved) -> DesignDocument {
    let Solved { moments, criterion, design, .. } = solved;
    let names: Vec<String> = moments.maneuvers.iter().map(|m| m.name.clone()).collect();
    let named =
        |values: &[f64]| names.iter().cloned().zip(values.iter().copied()).collect::<BTreeMap<_, _>>();
    let parameters = moments.degrees.iter().map(|d| d.parameters.len()).sum();
    let count = names.len();
    let p = criterion.degree();
    let starts = starts(design);
    let covariance = covariance(&solved);
    let log_det = match criterion {
        Criterion::Information(_) => design.log_det,
        Criterion::Covariance(_) => log_det(solved.information, &design.shares),
    };
    let statement = statement(&solved, &starts, p);
    let robust = robust(&solved);
    let certified = solved.restricted.is_none() && !least_largest(&solved);
    let starts = if least_largest(&solved) { Vec::new() } else { starts };
    DesignDocument {
        criterion: solved.name.title().into(),
        mean_removal: solved.removal.name().to_owned(),
        status: match (&solved.restricted, design.status) {
            (Some(_), _) => "restricted",
            (None, _) if least_largest(&solved) => "least largest",
            (None, Status::Optimal) => "optimal",
            (None, Status::Stationary) => "stationary",
            (None, Status::Stalled) => "stalled",
        }
        .into(),
        statement,
        shares: named(&design.shares),
        sensitivities: named(&design.sensitivities),
        dimension: p as u64,
        gap: design.gap,
        relative_gap: design.gap / p,
        log_det,
        proved_global: design.status == Status::Optimal && certified,
        starts,
        efficiency: Efficiency {
            equal_shares: criterion.efficiency(design, &vec![1.0 / count as f64; count], parameters),
            single: named(&criterion.single_efficiencies(design, parameters)),
        },
        counts: solved
            .counted
            .as_ref()
            .map(|(counts, _)| names.iter().cloned().zip(counts.iter().copied()).collect()),
        counted: solved.counted.map(|(_, about)| about),
        available: solved.available.map(|a| named(&a.shares)),
        covariance,
        estimator: matches!(solved.estimated, Estimated::OutputError { .. }).then(|| "output-error".into()),
        robust,
        restricted: solved.restricted,
        accuracy: solved.accuracy,
        sequence: solved.sequence,
        order: names,
    }
}

/// Whether the shares are those of the least largest error, which no criterion's certificate is about.
fn least_largest(solved: &Solved) -> bool {
    solved.accuracy.as_ref().is_some_and(|accuracy| accuracy.bound_s.is_some())
}

fn robust(solved: &Solved) -> Option<RobustModels> {
    let (Criterion::Covariance(c), Some(over)) = (solved.criterion, solved.over) else { return None };
    let values = c.robust.as_ref()?.values(&solved.design.shares);
    Some(RobustModels { over: name_of(over), values })
}

/// Of the information at `shares`, which the solver has found regular.
fn log_det(information: &Candidates, shares: &[f64]) -> f64 {
    let scaled = information.scaled().ok();
    let value = scaled.and_then(|(scaled, offset)| {
        scaled.evaluate(shares, &mut Evaluation::default()).map(|value| value + offset)
    });
    value.unwrap_or(f64::MIN)
}

fn covariance(solved: &Solved) -> Option<CovarianceDocument> {
    let Criterion::Covariance(criterion) = solved.criterion else { return None };
    let CovarianceCriterion { covariance, weights, .. } = criterion.as_ref();
    let samples = solved.samples.map_or(1.0, f64::round).max(1.0);
    let degrees = &solved.moments.degrees;
    let names = || degrees.iter().flat_map(|d| &d.parameters).cloned();
    let rows = covariance.variances(&solved.design.shares)?;
    let mut rest = rows.into_iter();
    let mut variances = Vec::new();
    for degree in degrees {
        variances.extend(rest.by_ref().take(degree.parameters.len()));
        if solved.estimated.has_intercepts() {
            rest.next();
        }
    }
    let errors = variances.iter().map(|v| (v.max(0.0) / samples).sqrt());
    let value = covariance.value(&solved.design.shares, &mut CovariancePoint::default())?;
    let value = match covariance.norm() {
        Norm::LogDet => -value - weights.len() as f64 * samples.ln(),
        Norm::PowerMean(_) => (-value).exp() / samples,
    };
    Some(CovarianceDocument {
        name: name_of(solved.name),
        value,
        weights: names().zip(weights.iter().copied()).collect(),
        samples: samples as u64,
        standard_errors: names().zip(errors).collect(),
    })
}

fn starts(design: &Design) -> Vec<Start> {
    let agrees = |log_det: f64| (design.log_det - log_det).abs() <= 1e-8 * design.log_det.abs().max(1.0);
    let start = |(i, s): (usize, &design::Start)| Start {
        name: if i == 0 { "equal".into() } else { format!("random {i}") },
        log_det: s.log_det,
        relative_gap: s.relative_gap,
        iterations: s.iterations,
        agrees: agrees(s.log_det),
    };
    design.starts.iter().enumerate().map(start).collect()
}

fn statement(solved: &Solved, starts: &[Start], p: f64) -> String {
    let design = solved.design;
    if let Some(restricted) = &solved.restricted {
        return restricted.statement.clone();
    }
    if let Some(accuracy) = solved.accuracy.as_ref().filter(|_| least_largest(solved)) {
        return accuracy.statement.clone();
    }
    let agreeing = starts.iter().filter(|s| s.agrees).count();
    let starts = format!("{agreeing} of {} starts reached this value", starts.len());
    let gap = design.gap / p;
    let within = match solved.available {
        Some(available) if Bounds::new(&available.shares).is_ok_and(|b| b.bind()) => " that are available",
        _ => "",
    };
    match (design.status, solved.criterion) {
        (Status::Optimal, Criterion::Information(_)) => format!(
            "Globally optimal: the problem is concave, and no shares{within} have a criterion more than {:.1e} higher; \
             {starts}.",
            design.gap.max(0.0)
        ),
        (Status::Optimal, Criterion::Covariance(c)) => {
            // A power mean is above the largest eigenvalue by at most this.
            let above = match c.covariance.norm() {
                Norm::PowerMean(power) if power > 1.0 => (c.covariance.eigenvalues() as f64).ln() / power,
                _ => c.robust.as_ref().map_or(0.0, design::Robust::excess),
            };
            format!(
                "Globally optimal: the problem is convex, and no shares{within} save more than {:.1e} of the time; {starts}.",
                gap.max(0.0) + above
            )
        }
        (Status::Stationary, _) => format!(
            "Stationary{} to a relative gap of {gap:.1e}, not proved global (the problem is not concave); {starts}.",
            if within.is_empty() { "" } else { " within what is available" }
        ),
        (Status::Stalled, _) => {
            format!("The search stalled at a relative gap of {gap:.1e}: not optimal; {starts}.")
        }
    }
}
