use crate::support::*;
use crate::{STAGES, made, small, told};

#[test]
fn everything_that_is_made_of_simulated_logs_says_so() {
    for name in ["ingest", "moments", "design", "estimate", "validation"] {
        assert_eq!(told(&format!("{name}.json"))["settings"]["data"], "simulated logs", "{name}");
    }
    assert_eq!(told("ingest.json")["data"]["data"], "simulated logs");
    assert_eq!(told("estimate.json")["data"]["designs"][0]["design"], "simulated logs");
    assert_eq!(told("ingest.json")["data"]["runs"], 22);
    // No recording contradicts the others, and those that steer are judged by them: six of eleven maneuvers do.
    let recordings = told("ingest.json")["data"]["recordings"].as_array().unwrap().clone();
    let counted = |key: &str| recordings.iter().filter(|one| one[key].is_string()).count();
    assert!(counted("contradicts") == 0 && counted("unjudged") <= 11, "{recordings:?}");
    let page = str::from_utf8(made().bytes("report.html")).unwrap();
    for piece in [
        "Data: <b>simulated logs</b>. No real ship was measured",
        "<section id=\"published\">",
        "Ours: simulated logs.",
        "more often in agreement",
        "20\u{a0}%",
    ] {
        assert!(page.contains(piece), "{piece}");
    }
    for design in told("validation.json")["data"]["picks"]["designs"].as_array().unwrap() {
        let (share, norm) = (&design["beyond_published"]["norm"], &design["overlapping"]["rmse_norm"]);
        let (share, ends) =
            (share["share"].as_f64().unwrap(), [0, 1].map(|i| share["interval"][i].as_f64().unwrap()));
        assert!(ends[0] <= share && share <= ends[1] && ends[0] < ends[1], "{design}");
        let below = norm["median"].as_f64().is_some_and(|median| median < 1.0);
        assert!(share == 0.5 || below == (share < 0.5), "a median below the limit where most are: {design}");
    }
}

#[test]
fn law_the_study_gives_the_same_bytes_for_any_number_of_threads() {
    let one = small();
    for stage in STAGES {
        run(&one, &format!("{stage} --threads 1")).succeeds();
    }
    for name in ["trajectories.parquet", "moments.json", "design.json", "scores.parquet", "report.html"] {
        assert!(bytes(&one, name) == made().bytes(name), "{name} has other bytes");
    }
}
