//! The page of a study shows existing results and names missing ones.

use crate::mock;
use report::{ManeuverTrace, Rendered, Study, render};
use study::documents::{
    DesignPromise, Estimator, PromiseUpdate, SampledFrom, Unreached, UpdatedError, UpdatedParameter,
};

const SECTIONS: [&str; 9] = [
    "comparison",
    "shares",
    "certificate",
    "dictionary",
    "errors",
    "parameters",
    "excitation",
    "notation",
    "files",
];
pub const FIGURES: [&str; 11] = [
    "parameter-error.svg",
    "simulation-error.svg",
    "rmse-surge.svg",
    "rmse-sway.svg",
    "rmse-yaw.svg",
    "validation-input.svg",
    "relative-errors.svg",
    "shares.svg",
    "sensitivities.svg",
    "dictionary.svg",
    "tracks.svg",
];
/// Elements of HTML without a closing tag.
const VOID: [&str; 3] = ["meta", "!DOCTYPE", "br"];

/// Every page must be complete, self-contained, balanced, and free of NaN.
fn check(page: &Rendered) {
    for section in SECTIONS {
        assert!(page.html.contains(&format!("<section id=\"{section}\">")), "{section}");
        assert!(page.html.contains(&format!("href=\"#{section}\"")), "{section}");
    }
    let html = without_scripts(&page.html);
    let known =
        ["http-equiv", "xmlns=\"http://www.w3.org/2000/svg\""].map(|known| html.matches(known).count());
    assert_eq!(without(&html, "style").matches("http").count(), known.iter().sum::<usize>());
    for wrong in ["<script", "<link", "<img", "url(", "@import", "NaN", ">inf", "null"] {
        assert!(!html.contains(wrong), "{wrong} on the page");
    }
    assert!(html.contains("default-src 'none'"));
    balanced(&html);
}

/// The page as it is read where scripts do not run.
pub fn without_scripts(html: &str) -> String {
    without(html, "script")
}

fn without(html: &str, tag: &str) -> String {
    let (begin, end) = (format!("<{tag}"), format!("</{tag}>"));
    html.split(&end).filter_map(|part| part.split(&begin).next()).collect()
}

fn balanced(html: &str) {
    let mut open: Vec<&str> = Vec::new();
    for piece in html.split('<').skip(1) {
        let (tag, _) = piece.split_once('>').expect("a tag is not closed");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap_or_default();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') && !VOID.contains(&name) {
            open.push(name);
        }
    }
    assert_eq!(open, Vec::<&str>::new());
}

pub fn rendered(study: &Study) -> Rendered {
    let page = render(study);
    check(&page);
    page
}

#[test]
fn an_empty_study_says_what_is_missing() {
    let page = rendered(&Study { name: "empty".to_owned(), ..Study::default() });
    assert!(page.figures.is_empty());
    for file in ["design.json", "validation.json", "scores.parquet", "estimate.json", "moments.json"] {
        assert!(page.html.contains(&format!("<code>{file}</code>")), "{file}");
    }
}

#[test]
fn a_full_study_shows_every_figure_and_nothing_is_missing() {
    let page = rendered(&mock::study());
    let names: Vec<&str> = page.figures.iter().map(|(name, _)| name.as_str()).collect();
    assert_eq!(names, FIGURES);
    assert!(page.figures.iter().all(|(_, svg)| page.html.contains(svg.as_str())));
    assert!(!page.html.contains("class=\"missing\""));
}

#[test]
fn the_headline_answers_in_two_sentences_from_the_data() {
    let html = rendered(&mock::study()).html.replace('\u{a0}', " ");
    assert!(
        html.contains("The optimized experiment of 125 s keeps the parameter error below 5 in 98.6 % (96.6 to 99.6 %) of 500 realizations (seed 1)")
    );
    assert!(html.contains("; random experiments of the same length do so in 52.0 % (50.0 to 53.0 %)"));
    assert!(html.contains("; practice experiments of the same length do so in 75.0 % ("));
    assert!(html.contains("today's practice: the maneuvers of the dictionary, one after another"));
}

#[test]
fn published_shares_are_printed_as_published() {
    let html = rendered(&mock::study()).html.replace('\u{a0}', " ");
    for printed in ["&gt; 99 %", ">49 %<", ">42 %<"] {
        assert!(html.contains(printed), "{printed}");
    }
}

#[test]
fn the_captions_account_for_truncated_and_missing_runs() {
    let html = rendered(&mock::study()).html;
    let mut scores = mock::study().scores.unwrap_or_default();
    scores.retain(|row| row.design == "random");
    let missing = scores.iter().filter(|row| row.parameter_error.is_none()).count();
    let beyond = scores.iter().filter_map(|row| row.parameter_error).filter(|error| *error >= 25.0).count();
    assert!(missing > 0 && beyond > 0);
    assert!(html.contains(&format!("random: {beyond} of 500 runs truncated, {missing} without a value")));
}

#[test]
fn text_of_the_study_is_escaped() {
    let mut study = mock::study();
    study.name = "<script>alert(1)</script>".to_owned();
    study.files.push(("<b>".to_owned(), "&".to_owned(), "\"".to_owned()));
    let page = rendered(&study);
    assert!(page.html.contains("&lt;script&gt;"));
}

#[test]
fn every_part_may_be_missing_on_its_own() {
    let absent: [fn(&mut Study); 10] = [
        |s| s.vessel = None,
        |s| s.dictionary = None,
        |s| s.moments = None,
        |s| s.design = None,
        |s| s.estimate = None,
        |s| s.validation = None,
        |s| s.scores = None,
        |s| s.validation_trace = None,
        |s| s.reference = None,
        |s| s.experiment_s = None,
    ];
    for forget in absent {
        let mut study = mock::study();
        forget(&mut study);
        rendered(&study);
    }
}

#[test]
fn runs_without_any_value_and_designs_without_runs_are_shown() {
    let mut study = mock::study();
    for (run, row) in study.scores.iter_mut().flatten().enumerate() {
        row.parameter_error = None;
        row.rmse[0] = None;
        row.simulation_error = Some([f64::NAN, f64::INFINITY][run % 2]);
    }
    if let Some(estimate) = &mut study.estimate {
        estimate.designs[0].parameters.clear();
        estimate.designs[1].degrees.clear();
    }
    if let Some(validation) = &mut study.validation {
        validation.designs.clear();
    }
    rendered(&study);
}

#[test]
fn the_same_study_gives_the_same_bytes() {
    assert_eq!(rendered(&mock::study()).html, rendered(&mock::study()).html);
}

#[test]
fn a_large_dictionary_is_shown_by_the_maneuvers_that_matter() {
    let mut study = mock::study();
    for index in 0..3000 {
        let name = format!("candidate-{index}");
        let design = study.design.iter_mut();
        design.for_each(|d| {
            d.shares.insert(name.clone(), 0.0);
            d.sensitivities.insert(name.clone(), 1e-4 * f64::from(index));
            d.order.insert(0, name.clone());
        });
        let trace = ManeuverTrace { name, ..ManeuverTrace::default() };
        study.dictionary.iter_mut().for_each(|d| d.insert(0, trace.clone()));
    }
    let html = rendered(&study).html;
    assert!(html.contains("40 of 3011 maneuvers are shown"));
    assert!(html.contains("spiral-fast") && !html.contains("candidate-17<"));
}

#[test]
fn a_promise_is_shown_with_its_range_and_what_became_of_it() {
    let error = UpdatedError::of(0.5, 0.4);
    let update = PromiseUpdate {
        statement: "After 125.0 s the parameter error is 0.400".to_owned(),
        estimator: Estimator::OutputError,
        samples: 1000,
        duration_s: 125.0,
        parameters: vec![UpdatedParameter {
            name: "X_u".to_owned(),
            estimate: -0.061,
            scale: Some(0.05),
            standard_error: error,
        }],
        parameter_error: Some(error),
        criterion: None,
        figures: Vec::new(),
        after_another: None,
        accuracy: None,
        statements: vec!["The promise is one for iv.".to_owned()],
    };
    let mut study = mock::study();
    assert!(!rendered(&study).html.contains("became of the promise"));
    study.update = Some(update);
    let design = study.design.as_mut().unwrap();
    let statement =
        "Promised parameter error: 0.82 (0.48 to 1.40, as the nominal model may be off by some 40 %).";
    design.promise =
        Some(DesignPromise { parameter_error: 0.82, range: [0.48, 1.4], statement: statement.to_owned() });
    design.unreached = Some(Unreached {
        from: SampledFrom::Nominal,
        ships: 64,
        motions: Vec::new(),
        statement: "Inputs miss `zig-zag`.".to_owned(),
    });
    let html = rendered(&study).html.replace('\u{a0}', " ");
    for piece in
        [statement, "Inputs miss <code>zig-zag</code>", "After 125.0 s", "1.25", "The promise is one for iv."]
    {
        assert!(html.contains(piece), "{piece}");
    }
}
