//! What scripts draw on the page.

use files::TableReader;

use crate::support::*;

const PAGE: &str = "report.html";

#[test]
fn oracle_the_page_has_every_trial_of_the_scores() {
    let folder = with(&[PAGE, "scores.parquet"]);
    let panels = drawn(&folder, PAGE);
    assert_eq!((panels.as_array().unwrap().len(), &panels[0]["id"]), (1, &"trials".into()));
    let reader = TableReader::open(folder.path().join("scores.parquet"), "scores", 1).unwrap();
    let scores = ::study::scores::rows(&reader).unwrap();
    let rows = panels[0]["data"]["rows"].as_array().unwrap();
    assert_eq!(rows.len(), scores.len());
    for (row, score) in rows.iter().zip(&scores) {
        assert_eq!((&row[0], &row[1]), (&score.design.as_str().into(), &score.run.into()));
        let (found, error) = (row[3].as_f64(), score.parameter_error);
        let close = |(a, b): (f64, f64)| (a - b).abs() <= 5.1e-5 * b.abs();
        assert!(found.is_some() == error.is_some() && found.zip(error).is_none_or(close), "{row}");
    }
}

#[test]
fn a_page_without_trials_has_no_scripts() {
    let folder = with(&["dictionary.parquet", "moments.json", "design.json"]);
    run(&folder, REPORT).succeeds();
    assert!(drawn(&folder, PAGE).as_array().unwrap().is_empty());
}
