//! The page to explore, beside the report.

use files::TableReader;

use crate::support::*;

const PAGE: &str = "explore.html";

#[test]
fn oracle_the_page_to_explore_has_every_trial_of_the_scores() {
    let folder = with(&[PAGE, "scores.parquet"]);
    let panels = explored(&folder, PAGE);
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
fn law_the_same_results_give_the_same_page_to_explore() {
    let folder = with(&MADE);
    std::fs::create_dir(folder.path().join("out")).unwrap();
    run(&folder, "report --study . --results . --out out/report.html --threads 1").succeeds();
    assert!(bytes(&folder, "out/explore.html") == study().bytes(PAGE));
}

#[test]
fn the_pages_lead_to_each_other() {
    let folder = with(&MADE);
    run(&folder, "report --study . --results . --out other.html").succeeds();
    assert!(String::from_utf8(bytes(&folder, PAGE)).unwrap().contains("href=\"./other.html\""));
    assert!(String::from_utf8(bytes(&folder, "other.html")).unwrap().contains("href=\"explore.html\""));
}

#[test]
fn a_page_to_explore_says_what_is_missing() {
    let folder = with(&["dictionary.parquet", "moments.json", "design.json"]);
    run(&folder, REPORT).succeeds();
    assert!(explored(&folder, PAGE).as_array().unwrap().is_empty());
    let page = String::from_utf8(bytes(&folder, PAGE)).unwrap();
    for name in ["scores.parquet", "compare.parquet", "map.json"] {
        assert!(page.contains(&format!("<code>{name}</code>")), "{name}");
    }
}

#[test]
fn a_report_with_the_name_of_the_page_to_explore_is_refused() {
    let folder = with(&MADE);
    let ran = run(&folder, "report --study . --results . --out explore.html");
    assert!(!folder.path().join(PAGE).exists(), "{ran}");
    ran.refuses(3, &["explore.html", "found two files of this name", "name another output"]);
}
