//! The table of scores: one row per run, with its errors.

use ::refusal::listed;
use std::collections::HashSet;

use estimation::{
    Contender, Estimator, MOST_WITHOUT_ESTIMATE, PairedDifference, Quantiles, Recommendation, ScoreStatus,
    Share,
};
use files::{Columns, Error, Provenance, TableReader};
use ship::model::DegreeOfFreedom;

use crate::documents::{
    Bounds, ComparedError, DesignScores, EstimatorRecommendation, EstimatorScores, ScoredEstimates,
};
use crate::tables::estimates::{distinct, implausible, is_error, seed};

pub use estimation::RunScore as Row;

/// Schema id of scores.
pub const ID: &str = "scores";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// A table of scores whose rows are `R`: estimates of runs, models from picks, or trials in rounds.
pub(crate) fn of<R: 'static>() -> Columns<R> {
    Columns::new(ID, VERSION)
}

/// A row whose design, run and estimator another row has too.
pub fn doubled(rows: &[Row]) -> Option<&Row> {
    let mut known = HashSet::with_capacity(rows.len());
    rows.iter().find(|row| !known.insert((row.design.as_str(), row.run, row.estimator.name())))
}

/// The columns.
pub fn columns() -> Columns<Row> {
    let columns = of::<Row>()
        .text("design", |r| &r.design, |r, design| r.design = design.to_owned())
        .integer("run", "1", |r| r.run, |r, run| r.run = run)
        .choice("estimator", |r| r.estimator, |r, estimator| r.estimator = estimator)
        .choice("status", |r| r.status, |r, status| r.status = status)
        .optional("parameter_error", "1", |r| r.parameter_error, |r, error| r.parameter_error = error);
    let rmse = |columns: Columns<Row>, degree: DegreeOfFreedom| {
        let (name, d) = (format!("rmse_{}", degree.state()), degree as usize);
        columns.optional(name, degree.unit(), move |r| r.rmse[d], move |r, rmse| r.rmse[d] = rmse)
    };
    DegreeOfFreedom::ALL.into_iter().fold(columns, rmse).optional(
        "simulation_error",
        "m/s, m/s and rad/s as numbers",
        |r| r.simulation_error,
        |r, error| r.simulation_error = error,
    )
}

/// Reads the whole table.
///
/// # Errors
/// Missing columns, damaged blocks; invalid scores.
pub fn rows(reader: &TableReader) -> Result<Vec<Row>, Error> {
    let blank = Row {
        design: String::new(),
        run: 0,
        estimator: Estimator::Iv,
        status: ScoreStatus::NotIdentifiable,
        parameter_error: None,
        rmse: [None; 3],
        simulation_error: None,
    };
    let rows = columns().read(reader, &blank)?;
    for (number, row) in rows.iter().enumerate() {
        let scores = row.rmse.into_iter().chain([row.parameter_error, row.simulation_error]).flatten();
        if let Some(value) = scores.into_iter().find(|score| !is_error(*score)) {
            return Err(implausible(reader.path(), number, value));
        }
    }
    Ok(rows)
}

/// The estimators of `rows`, in their order.
pub fn estimators(rows: &[Row]) -> Vec<Estimator> {
    distinct(rows.iter().map(|row| row.estimator))
}

/// The leading estimator of a study: the only one, or `iv` if several are compared.
pub fn leading(rows: &[Row]) -> Option<Estimator> {
    let known = estimators(rows);
    known.iter().find(|e| **e == Estimator::Iv).or(known.first()).copied()
}

/// Statistics of the scores of each design, in the order of the rows, by the [`leading`] estimator.
pub fn summarize(rows: &[Row], bounds: Bounds) -> Vec<DesignScores> {
    leading(rows).map_or(Vec::new(), |estimator| by_estimator(rows, estimator, bounds))
}

/// The same for every estimator, if there are several.
pub fn compare(rows: &[Row], bounds: Bounds) -> Option<Vec<EstimatorScores>> {
    let all = estimators(rows);
    let of = |estimator: &Estimator| EstimatorScores {
        estimator: *estimator,
        designs: by_estimator(rows, *estimator, bounds),
    };
    (all.len() > 1).then(|| all.iter().map(of).collect())
}

fn by_estimator(rows: &[Row], estimator: Estimator, bounds: Bounds) -> Vec<DesignScores> {
    let mut designs: Vec<&str> = rows.iter().map(|r| r.design.as_str()).collect();
    designs.dedup();
    designs.iter().map(|design| design_scores(design, estimator, rows, bounds)).collect()
}

fn design_scores(design: &str, estimator: Estimator, rows: &[Row], bounds: Bounds) -> DesignScores {
    let counted = || rows.iter().filter(|r| r.design == design && r.estimator == estimator);
    let runs = counted().count();
    let with = |status: ScoreStatus| counted().filter(|r| r.status == status).count() as u64;
    let below = |value: fn(&Row) -> Option<f64>, bound: f64| {
        counted().filter(|r| value(r).is_some_and(|v| v < bound)).count()
    };
    let parameter_errors = Share::of(below(|r| r.parameter_error, bounds.parameter_error), runs);
    let simulation_errors = Share::of(below(|r| r.simulation_error, bounds.simulation_error), runs);
    let without_estimate = Share::of(counted().filter(|r| !r.status.estimated()).count(), runs);
    DesignScores {
        design: design.to_owned(),
        runs: runs as u64,
        not_identifiable: with(ScoreStatus::NotIdentifiable),
        not_converged: estimator.searches().then(|| with(ScoreStatus::NotConverged)),
        diverged: with(ScoreStatus::Diverged),
        parameter_error_share: parameter_errors.share,
        parameter_error_share_interval: parameter_errors.interval,
        simulation_error_share: simulation_errors.share,
        simulation_error_share_interval: simulation_errors.interval,
        without_estimate_share: Some(without_estimate.share),
        parameter_error: Quantiles::of(counted().map(|r| r.parameter_error)),
        simulation_error: Quantiles::of(counted().map(|r| r.simulation_error)),
        rmse_u: Quantiles::of(counted().map(|r| r.rmse[0])),
        rmse_v: Quantiles::of(counted().map(|r| r.rmse[1])),
        rmse_r: Quantiles::of(counted().map(|r| r.rmse[2])),
    }
}

/// The recommended estimator for each design, if the rows are of several.
pub fn recommendations(rows: &[Row]) -> Option<Vec<EstimatorRecommendation>> {
    let designs = distinct(rows.iter().map(|row| row.design.as_str()));
    let of = |design: &&str| {
        let of_design: Vec<&Row> = rows.iter().filter(|row| row.design == *design).collect();
        recommendation(design, &of_design, &estimators(rows))
    };
    (estimators(rows).len() > 1).then(|| designs.iter().map(of).collect())
}

fn recommendation(design: &str, rows: &[&Row], estimators: &[Estimator]) -> EstimatorRecommendation {
    let known = rows.iter().any(|row| row.parameter_error.is_some());
    let error = if known { ComparedError::ParameterError } else { ComparedError::SimulationError };
    let contenders: Vec<Contender> = estimators.iter().map(|e| contender(*e, rows, error)).collect();
    let runs = contenders.iter().map(|c| c.errors.len()).max().unwrap_or(0);
    let recommendation = Recommendation::new(&contenders);
    EstimatorRecommendation {
        design: design.to_owned(),
        error,
        runs: runs as u64,
        most_without_estimate: MOST_WITHOUT_ESTIMATE,
        estimator: recommendation.as_ref().and_then(Recommendation::estimator),
        candidates: recommendation.as_ref().map_or(Vec::new(), Recommendation::candidates),
        others: recommendation.iter().flat_map(|r| &r.others).map(PairedDifference::from).collect(),
        statement: statement(recommendation.as_ref(), design, error, runs),
    }
}

fn contender(estimator: Estimator, rows: &[&Row], error: ComparedError) -> Contender {
    let of_estimator = || rows.iter().filter(|row| row.estimator == estimator);
    let value = |row: &&Row| match error {
        ComparedError::ParameterError => row.parameter_error,
        ComparedError::SimulationError => row.simulation_error,
    };
    Contender {
        estimator,
        errors: of_estimator().map(value).collect(),
        without_estimate: of_estimator().filter(|row| !row.status.estimated()).count(),
    }
}

fn statement(
    recommendation: Option<&Recommendation>,
    design: &str,
    error: ComparedError,
    runs: usize,
) -> String {
    let share = format!("{} % of the runs", 100.0 * MOST_WITHOUT_ESTIMATE);
    let Some(recommendation) = recommendation else {
        return format!(
            "No estimator can be recommended for the {design} design: each leaves more than {share} without an estimate."
        );
    };
    let what = match error {
        ComparedError::ParameterError => "parameter error",
        ComparedError::SimulationError => "simulation error",
    };
    let least =
        format!("{} has the least median {what} ({:.3})", recommendation.least, recommendation.median);
    let among = format!("of the estimators that leave at most {share} without an estimate");
    match recommendation.estimator() {
        Some(_) if recommendation.others.is_empty() => {
            format!("For the {design} design {least}; it is the only one {among}.")
        }
        Some(_) => format!(
            "For the {design} design {least} {among}; over {runs} runs its paired difference from each of the others is \
             larger than chance (95 % interval above 0)."
        ),
        None => {
            let close: Vec<String> =
                recommendation.candidates()[1..].iter().map(Estimator::to_string).collect();
            format!(
                "For the {design} design {least} {among}; there is no difference from {} that {runs} runs can tell: the \
                 95 % interval of the paired difference contains 0.",
                listed(&close)
            )
        }
    }
}

/// The summary of `rows`, scored over `samples` samples of validation runs with `provenance`.
pub fn validated(rows: &[Row], bounds: Bounds, samples: u64, provenance: &Provenance) -> ScoredEstimates {
    ScoredEstimates {
        bounds,
        samples,
        seed: seed(provenance),
        designs: summarize(rows, bounds),
        recommendations: recommendations(rows),
        compared: compare(rows, bounds),
    }
}
