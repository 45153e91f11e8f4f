//! The page of measured logs: the resulting model and its residuals.

use report::{MeasuredStudy, Study, render};
use serde_json::json;
use study::documents::{Absent, Compared, LeftOutScores, ModelDocument, Suspect, Trust};

fn model(truth: Option<f64>) -> ModelDocument {
    let degree = |name: &str, state: &str, unit: &str| {
        let mut parameter = json!({
            "name": format!("P_{state}"), "term": state, "unit": "1", "value": -0.5, "standard_error": 0.1,
            "least_squares": -0.4
        });
        if let Some(truth) = truth {
            parameter["truth"] = truth.into();
        }
        json!({
            "name": name, "state": state, "unit": unit, "parameters": [parameter], "constant": 0.25,
            "constant_least_squares": null, "increment_std": 0.01, "output_rmse": null
        })
    };
    let degrees = [("surge", "u", "m/s"), ("sway", "v", "m/s"), ("yaw", "r", "rad/s")];
    let degrees: Vec<_> = degrees.into_iter().map(|(name, state, unit)| degree(name, state, unit)).collect();
    serde_json::from_value(json!({
        "vessel": "ship", "sample_rate_hz": 1.0, "inputs": [], "measured": [], "degrees": degrees,
        "covariance": null, "estimator": "iv", "mean_removal": "complete", "samples": 77, "recordings": [],
        "covered": [], "rejected": null, "statements": []
    }))
    .unwrap()
}

fn crossval(recommended: Option<&str>, candidates: &[&str]) -> LeftOutScores {
    serde_json::from_value(json!({
        "mean_removal": "complete", "nominal": "given", "prior": 0.0, "intercepts": true, "window_s": null,
        "windows": 4, "samples": 400, "folds": 4, "std_u": 1.0, "std_v": 1.0, "std_r": 1.0,
        "recommended": recommended, "candidates": candidates, "differences": [], "statements": [], "estimators": []
    }))
    .unwrap()
}

fn page(measured: MeasuredStudy) -> String {
    let study = Study { name: "tank".to_owned(), measured: Some(measured), ..Study::default() };
    render(&study).html.replace('\u{a0}', " ")
}

#[test]
fn the_parameters_are_those_of_the_delivered_model_which_is_named() {
    let said = |recommended: Option<&str>, candidates: &[&str]| {
        let left_out = Some(crossval(recommended, candidates));
        page(MeasuredStudy { model: Some(model(None)), left_out, ..MeasuredStudy::default() })
    };
    for (recommended, candidates, words) in [
        (Some("iv"), &["iv"][..], "Estimated by iv, which cross-validation recommends."),
        (Some("ls"), &["ls"][..], "Cross-validation recommends ls, but this model was estimated by iv."),
        (
            None,
            &["iv", "ls"][..],
            "by iv, which has the least error in cross-validation, but the recordings cannot tell it from ls",
        ),
        (None, &["ls", "iv"][..], "by iv, which the recordings cannot tell from ls, the one of least error"),
        (None, &["ls", "auto"][..], "by iv, which is worse than ls on the recordings left out"),
        (None, &[][..], "No estimator could be simulated over all folds. This model is by iv."),
    ] {
        let html = said(recommended, candidates);
        assert!(html.contains(words) && html.contains("The delivered model, by iv"), "{words}");
        assert_eq!(html.contains("No estimator"), recommended.is_none());
    }
    let alone = page(MeasuredStudy { model: Some(model(None)), ..MeasuredStudy::default() });
    assert!(alone.contains("No cross-validation says which estimator to take."));
    assert!(alone.contains("surge constant") && alone.contains("<td class=\"number\">0.250</td>"));
    assert!(page(MeasuredStudy::default()).contains("<code>model.json</code>"));
}

#[test]
fn truth_stands_beside_the_estimates_where_there_is_one() {
    let html = |truth| page(MeasuredStudy { model: Some(model(truth)), ..MeasuredStudy::default() });
    assert!(!html(None).contains(">True<") && html(Some(-0.3)).contains(">True<"));
    // Two standard errors below.
    assert!(html(Some(-0.3)).contains("<td class=\"number\">−2.0</td>"));
}

#[test]
fn what_is_left_of_the_errors_is_drawn_over_the_band() {
    let own = |of: &str, state: &str| {
        json!({
            "of": of, "state": state, "samples": 400, "bound": 0.098, "own": [-0.5, 0.1],
            "inputs": [{"name": "rudder", "crossed": [0.0, 0.2, 0.1]}]
        })
    };
    let states = ["u", "v", "r"].map(|state| own("one-step residual", state));
    let found: Compared = serde_json::from_value(json!({
        "vessel": "ship", "window_s": 100.0, "windows": 1, "samples": 400, "std_u": 1.0, "std_v": 1.0, "std_r": 1.0,
        "statements": [], "models": [], "differences": [], "bands": null, "outside": [], "correlations": states
    }))
    .unwrap();
    let html = page(MeasuredStudy { compared: Some((found, Vec::new())), ..MeasuredStudy::default() });
    for words in ["What is left of the errors", ">rudder<", "±0.0980 with N = 400", "lag [samples]", "sway"]
    {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("Correlations of free-run errors"));
}

/// `candidates` candidates for a missing term, the first `likely` of which are likely; the first parameter is at its
/// bound.
fn trust(candidates: usize, likely: usize) -> Trust {
    let absent = |i: usize| {
        let current = i == 1;
        let values = if current { vec![0.25, -0.5] } else { vec![-0.4] };
        json!({
            "name": if current { "current".to_owned() } else { format!("v^{i}") },
            "degree": if current { None } else { Some("sway") }, "unit": "1/m", "value": values,
            "standard_error": vec![0.03; values.len()], "visible_from": 0.117, "p_value": 0.0004,
            "evidence": 100.0 - i as f64, "candidate": i < likely
        })
    };
    let parameter = |name: &str, at_bound: bool| {
        json!({
            "name": name, "term": "v", "unit": "1/s", "estimate": -0.1, "standard_error": null, "at_bound": at_bound,
            "bootstrap_std": null, "bootstrap_low": null, "bootstrap_high": null, "variation": 1.0,
            "instrument_strength": null
        })
    };
    serde_json::from_value(json!({
        "estimator": "output-error", "mean_removal": "complete", "nominal": "given", "prior": 0.0, "parts": 4,
        "sources": 2, "samples": 400, "bandwidth": 4, "replicates": 0, "statements": [], "runs": [],
        "degrees": [{
            "name": "sway", "status": "identified", "reason": null, "estimator": "output-error", "condition": 2.0,
            "condition_index": 3.0, "weakest": "", "correlation": [0.0, 0.0, 0.0, 1.0], "whiteness": null,
            "parameters": [parameter("Y_v", true), parameter("Y_r", false)], "instrument_residual": null,
            "instrument_fit": null
        }],
        "criticism": {
            "rejected": likely > 0, "verdict": if likely > 0 { "rejected" } else { "not-rejected" }, "p_value": 0.0004, "stated_noise": false, "noise_u": 0.02, "noise_v": 0.02,
            "noise_r": 0.02, "current_std": 0.1, "current_time_s": 30.0, "noise": {
                "kind": "forces-and-current",
                "drifts": [{ "of": "force", "state": "u", "std": 0.004, "unit": "m/s", "time_s": 8.0 }],
                "others": [{ "kind": "white", "below": 123.4 }, { "kind": "sensors", "below": 210.0 }],
                "turns": 3, "at_rest": true
            }, "error_ratio": 1.0, "whiteness": [],
            "absent": (0..candidates).map(absent).collect::<Vec<_>>(), "hidden": ["`v` in yaw"], "statements": []
        }
    }))
    .unwrap()
}

#[test]
fn what_a_model_may_lack_is_ranked_and_the_unlikely_is_folded_away() {
    let said = |candidates: usize, likely: usize| {
        page(MeasuredStudy { trust: Some(trust(candidates, likely)), ..MeasuredStudy::default() })
    };
    let all = said(9, 7);
    let (open, folded) = all.split_once("<details>").unwrap();
    assert!(open.contains("<code>v^6</code>") && !open.contains("<code>v^7</code>"), "{open}");
    assert!(folded.contains("2 more candidates") && folded.contains("<code>v^8</code>"), "{folded}");
    assert!(open.contains("−0.400 ± 0.0300") && open.contains("0.250 ± 0.0300, −0.500 ± 0.0300"), "{open}");
    assert!(open.contains("&lt; 0.001") && open.contains("<td>sway</td>") && open.contains("<td>all</td>"));
    assert!(
        folded.contains("own terms: <code>v</code> in yaw") && folded.contains("Noise found"),
        "{folded}"
    );
    let noise = ["drifting forces and a drifting current", "force u 0.00400 m/s over 8.00 s", "3 turns"];
    assert!(noise.iter().all(|own| folded.contains(own)), "{folded}");
    assert!(folded.contains("white noise by 123"), "{folded}");
    assert!(said(9, 0).split_once("<details>").unwrap().1.contains("4 more candidates"));
    assert!(!said(3, 0).contains("<details>") && !said(3, 0).contains(">Cost<"));
    // A ship with forces has the same section.
    let mut forces = trust(3, 1);
    if let Some(found) = forces.criticism.as_mut() {
        (found.units, found.noise_u, found.absent[0].share) = (Some(64), None, Some(0.079));
        found.absent[2] =
            Absent { kind: Suspect::Sign, name: "`delta` acts".to_owned(), ..Absent::default() };
    }
    let html = page(MeasuredStudy { trust: Some(forces), ..MeasuredStudy::default() });
    for words in [
        "What is wrong with the model",
        ">Cost<",
        "−7.9 %",
        "64 windows",
        "<code>delta</code> acts",
        "diverges",
    ] {
        assert!(html.contains(words), "{words}");
    }
    assert!(!html.contains("Noise found"));
}

#[test]
fn a_parameter_at_its_bound_correlates_with_nothing() {
    let html = page(MeasuredStudy { trust: Some(trust(1, 0)), ..MeasuredStudy::default() });
    let (_, table) = html.split_once(">Correlation<").unwrap();
    let cells: Vec<&str> = table.split("<td class=\"number\">").skip(1).take(4).collect();
    let cell = |i: usize| cells[i].split('<').next().unwrap();
    assert_eq!([0, 1, 2, 3].map(cell), ["–", "–", "–", "1.00"]);
    assert!(table.contains("A dash: Y_v at its bound"));
}
