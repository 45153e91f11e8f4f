use estimation::{Contender, Estimator, MOST_WITHOUT_ESTIMATE, PairedDifference, Recommendation};

use crate::documents::{ComparedError, EstimatorRecommendation};
use crate::estimates::distinct;
use crate::scores::{Row, estimators};
use ::refusal::listed;

/// The recommended estimator for each design, if the rows are of several.
pub fn recommendations(rows: &[Row]) -> Option<Vec<EstimatorRecommendation>> {
    let designs = distinct(rows.iter().map(|row| row.design.as_str()));
    let of = |design: &&str| {
        let own: Vec<&Row> = rows.iter().filter(|row| row.design == *design).collect();
        recommendation(design, &own, &estimators(rows))
    };
    (estimators(rows).len() > 1).then(|| designs.iter().map(of).collect())
}

fn recommendation(design: &str, rows: &[&Row], estimators: &[Estimator]) -> EstimatorRecommendation {
    let known = rows.iter().any(|row| row.parameter_error.is_some());
    let error = if known { ComparedError::ParameterError } else { ComparedError::SimulationError };
    let contenders: Vec<Contender> = estimators.iter().map(|e| contender(*e, rows, error)).collect();
    let runs = contenders.iter().map(|c| c.errors.len()).max().unwrap_or(0);
    let found = Recommendation::new(&contenders);
    EstimatorRecommendation {
        design: design.to_owned(),
        error,
        runs: runs as u64,
        most_without_estimate: MOST_WITHOUT_ESTIMATE,
        estimator: found.as_ref().and_then(Recommendation::estimator),
        candidates: found.as_ref().map_or(Vec::new(), Recommendation::candidates),
        others: found.iter().flat_map(|found| &found.others).map(PairedDifference::from).collect(),
        statement: statement(found.as_ref(), design, error, runs),
    }
}

fn contender(estimator: Estimator, rows: &[&Row], error: ComparedError) -> Contender {
    let own = || rows.iter().filter(|row| row.estimator == estimator);
    let value = |row: &&Row| match error {
        ComparedError::ParameterError => row.parameter_error,
        ComparedError::SimulationError => row.simulation_error,
    };
    Contender {
        estimator,
        errors: own().map(value).collect(),
        without_estimate: own().filter(|row| !row.status.estimated()).count(),
    }
}

fn statement(found: Option<&Recommendation>, design: &str, error: ComparedError, runs: usize) -> String {
    let share = format!("{} % of the runs", 100.0 * MOST_WITHOUT_ESTIMATE);
    let Some(found) = found else {
        return format!(
            "No estimator can be recommended for the {design} design: each leaves more than {share} without an estimate."
        );
    };
    let what = match error {
        ComparedError::ParameterError => "parameter error",
        ComparedError::SimulationError => "simulation error",
    };
    let least = format!("{} has the least median {what} ({:.3})", found.least, found.median);
    let among = format!("of the estimators that leave at most {share} without an estimate");
    match found.estimator() {
        Some(_) if found.others.is_empty() => {
            format!("For the {design} design {least}; it is the only one {among}.")
        }
        Some(_) => format!(
            "For the {design} design {least} {among}; over {runs} runs its paired difference from each of the others is \
             larger than chance (95 % interval above 0)."
        ),
        None => {
            let close: Vec<String> = found.candidates()[1..].iter().map(Estimator::to_string).collect();
            format!(
                "For the {design} design {least} {among}; there is no difference from {} that {runs} runs can tell: the \
                 95 % interval of the paired difference contains 0.",
                listed(&close)
            )
        }
    }
}
