//! Names in files are those on the command line.

use estimation::{EstimateStatus, Estimator, ScoreStatus};
use serde::Serialize;

fn check<T: Copy + Serialize>(all: &[T], name: fn(T) -> &'static str) {
    for one in all {
        assert_eq!(serde_json::to_value(one).unwrap(), name(*one));
    }
}

#[test]
fn choices_are_called_in_files_what_their_names_say() {
    check(&Estimator::ALL, Estimator::name);
    check(&EstimateStatus::ALL, EstimateStatus::name);
    check(&ScoreStatus::ALL, ScoreStatus::name);
}
