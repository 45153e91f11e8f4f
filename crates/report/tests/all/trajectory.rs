//! The section of a planned trajectory.

use std::collections::BTreeMap;

use crate::page::{FIGURES, rendered, without_scripts};
use crate::{mock, mock_plan};
use report::{Study, Trajectory};
use study::documents::{PlanChart, PlanChartClass, PlanDocument, PlanStatus, Voyage};

/// Edits the study's own plan.
fn with(change: impl Fn(&mut PlanDocument)) -> Study {
    let mut study = mock_plan::study();
    let main = study.trajectory.as_mut().and_then(|own| own.main.as_mut());
    main.into_iter().for_each(|main| change(&mut main.plan));
    study
}

/// Edits its part at sea.
fn at_sea(change: impl Fn(&mut Voyage)) -> Study {
    with(|plan| plan.voyage.iter_mut().for_each(&change))
}

/// The text of the section, without tags, with joined white space.
fn text(study: &Study) -> String {
    let html = rendered(study).html;
    let (_, section) = html.split_once("<section id=\"trajectory\">").expect("the section is there");
    let (section, _) = section.split_once("</section>").expect("the section ends");
    let text: Vec<&str> = section.split('<').filter_map(|piece| Some(piece.split_once('>')?.1)).collect();
    text.join(" ").split_whitespace().collect::<Vec<_>>().join(" ").replace('\u{a0}', " ")
}

fn holds(text: &str, parts: &[&str]) {
    for part in parts {
        assert!(text.contains(part), "no {part:?} in: {text}");
    }
}

#[test]
fn a_study_without_a_plan_has_no_trace_of_one() {
    let html = without_scripts(&rendered(&mock::study()).html);
    for trace in ["trajectory", "Trajectory", ".crew", "map.svg", "navigation"] {
        assert!(!html.contains(trace), "{trace}");
    }
}

#[test]
fn a_plan_adds_its_section_card_style_and_figures_and_changes_no_other_section() {
    let (without, with) = (rendered(&mock::study()), rendered(&mock_plan::study()));
    assert!(with.html.contains("href=\"#trajectory\"") && with.html.contains(".crew"));
    assert!(with.html.contains("<p class=\"what\">Trajectory</p>"));
    let own: Vec<&str> = with.figures.iter().map(|f| f.0.as_str()).filter(|f| !FIGURES.contains(f)).collect();
    assert_eq!(own, ["map.svg", "front.svg", "map-4-headings.svg"]);
    assert!(with.html.contains(mock_plan::MAP));
    for section in without.html.split("<section ").skip(1) {
        let section = section.split("</section>").next().unwrap_or_default();
        assert!(with.html.contains(section), "{}", &section[..60]);
    }
}

#[test]
fn the_facts_of_the_plan_are_printed_with_their_units() {
    holds(
        &text(&mock_plan::study()),
        &[
            "Not for navigation.",
            "Proved: no plan over the 1234 states",
            "4 basic moves",
            "no plan costs less than 4 basic moves",
            "701 s of moves",
            "12 min 02 s",
            "6 min 40 s",
            "55.4 % of the time, 2 maneuvers",
            "at least 61.5 m",
            "64 simulations",
            "up to 0.15 m/s",
            "2 of 64 (3.1 %)",
            "17 of 64 (26.6 %)",
            "5 % of runs: 12.5 m; median: 60.0 m",
            "62.9",
            "61.6 90.5 % of the promise",
            "75.9 271.8 % of the promise",
            "91.3 %",
        ],
    );
}

#[test]
fn the_maneuver_sheet_tells_the_crew_in_their_own_units() {
    let study = mock_plan::study();
    holds(
        &text(&study),
        &[
            "00:01:30",
            "60° 08.918′ N 024° 57.211′ E",
            "045°",
            "1.5 2.9",
            "steep, mirrored (starts to the other side)",
            "faster, to 1.50 m/s (2.9 kn)",
            "turn to port under way, to 000°",
            "slower, to a stop",
            "turn to starboard on the spot, to 045°",
            "31 120 200 19.7 0 212",
            "tau1 [N]",
            "tau3 [N m]",
            "wait here; drifts aground in 9 min 00 s",
            "anchorage at 045°, 0.13 NM, 4 min 10 s; drifts to 61.2 m off",
            "end of the trial, after 12 min 02 s",
        ],
    );
    let html = rendered(&study).html;
    assert_eq!(html.matches("<tr class=\"informative\"").count(), 3, "two in the sheet, one in the passage");
    assert!(html.contains("style=\"border-color:#0072B2\">1</span>"));
    assert!(html.contains("style=\"border-color:#D55E00\">2</span>"));
}

#[test]
fn the_passage_plan_tells_the_bridge() {
    holds(
        &text(&mock_plan::study()),
        &[
            "Passage plan",
            "Times count from the departure at 2026-06-01T08:00:00Z.",
            "Charted depths count with a tide of −0.400 m, its least over the 60 min 00 s of the slot.",
            "036° 0.25 2.9 00:01:30 13, 41 213 9.2 WRECKS Träholm, 90 m, bearing 271° straight",
            "036° 0.25 2.9 00:04:50 13, 41 – 9.2 WRECKS Träholm, 90 m, bearing 271° steep (mirrored), turn-starboard",
        ],
    );
}

#[test]
fn moves_front_variants_and_trials_are_shown() {
    let study = mock_plan::study();
    holds(
        &text(&study),
        &[
            "60 × 50 nodes, 120 m apart, with 8 headings",
            "2 moves, off their nodes by at most 1.21 m and 0.252°.",
            "135° 090° 360 −120 180 266 1.21 0.252 27.0 1513",
            "1 0 2 3 min 20 s 55.0 54.5 %",
            "1 1 4 6 min 40 s 62.9 100.0 %",
            "4 headings: optimal, 4 basic moves (at least 4 basic moves), 6 steps, 12 min 02 s at sea",
            "planned 200 87.5 % (96.6 to 99.6 %) 0.777 (1.78 to 2.38)",
            "optimized 500 98.6 %",
            "it also contains the legs between the maneuvers",
        ],
    );
}

#[test]
fn what_is_missing_of_a_plan_is_said() {
    let empty = Study { trajectory: Some(Trajectory::default()), ..mock::study() };
    holds(
        &text(&empty),
        &["there is no plan.json", "no planned/validation.json", "no planned/estimate.json"],
    );
    let mut bare = mock_plan::study();
    let own = bare.trajectory.iter_mut();
    own.for_each(|own| {
        own.main.iter_mut().chain(&mut own.variants).for_each(|trial| trial.map = None);
        own.main.iter_mut().for_each(|main| main.stale = vec!["vessel.toml".to_owned()]);
    });
    bare.vessel = None;
    bare.validation = None;
    holds(
        &text(&bare),
        &[
            "no map.svg",
            "No map.svg",
            "made from another vessel.toml",
            "no vessel.toml",
            "no validation.json",
        ],
    );
    holds(&text(&with(|plan| plan.voyage = None)), &["Times, places and clearances not shown"]);
    let poor = at_sea(|voyage| {
        voyage.front.clear();
        voyage.primitives.clear();
        voyage.check.runs = 0;
        voyage.information.realised_log_det = None;
        voyage.information.efficiency = None;
        voyage.information.design_efficiency = None;
    });
    holds(
        &text(&poor),
        &[
            "the search was not exhaustive",
            "lists no moves",
            "asks for no runs",
            "not comparable",
            "made without design.json",
        ],
    );
}

#[test]
fn a_plan_that_is_not_proved_or_not_clear_is_not_praised() {
    let study = with(|plan| {
        plan.status = PlanStatus::Feasible;
        (plan.lower_bound, plan.gap) = (3.0, 1.0);
        plan.voyage.iter_mut().for_each(|v| v.check.clear = false);
    });
    let text = text(&study);
    holds(
        &text,
        &[
            "feasible at most 1 basic move dearer than the best",
            "no plan costs less than 3 basic moves",
            "the hull touches an obstacle",
            "Unsafe. The plan fails its own check and was written by --allow=unsafe only: 2 of 64 runs aground",
            "Unsafe: 2 of 64 runs aground (3.1 %, 0.9 to 10.7 %).",
            "64 simulations of the whole plan (seed 1)",
            "within 35.0 % of the nominal ones",
            "2 of 64 (3.1 %) 95 % interval 0.9 % to 10.7 %",
        ],
    );
    assert!(!text.contains("at least 61.5 m"));
    let html = rendered(&study).html;
    assert!(
        html.contains("at sea, touches an obstacle")
            && html.contains("<span class=\"big\">4</span> <span class=\"who\">basic moves, at most 1 basic move dearer than the best</span>")
    );
}

#[test]
fn other_bounds_are_not_compared_silently() {
    let mut study = mock_plan::study();
    assert!(!text(&study).contains("not comparable"));
    mock_plan::otherwise_bounded(&mut study);
    holds(&text(&study), &["Shares are not comparable", "4 and 0.15, the others against 5 and 0.15"]);
}

#[test]
fn the_headline_answers_from_the_plan_where_nothing_is_validated() {
    let planned = mock_plan::study().trajectory;
    let html = rendered(&Study { trajectory: planned, ..Study::default() }).html;
    holds(
        &html.replace('\u{a0}', " "),
        &[
            "The planned trial of 12 min 02 s holds 2 informative maneuvers and costs 4 basic moves, and no plan costs less.",
            "2 of 64 runs touch an obstacle, and 1 of 375 vessels that a search for the worst tried.",
        ],
    );
    assert!(!html.contains("Nothing has been designed"));
}

#[test]
fn names_in_a_plan_are_escaped_and_odd_numbers_survive() {
    let study = with(|plan| {
        plan.statement = "<script>".to_owned();
        plan.steps.truncate(1);
        plan.counts.clear();
        let Some(voyage) = &mut plan.voyage else { return };
        voyage.legs[0].name = "<b>".to_owned();
        voyage.legs[0].speed_m_s = f64::NAN;
        voyage.legs[0].largest_inputs.insert("<i>".to_owned(), f64::INFINITY);
        voyage.duration_s = 0.0;
        voyage.lattice.headings = 0;
        voyage.lattice.modes.clear();
        voyage.information.dimension = 0;
    });
    assert!(rendered(&study).html.contains("&lt;script&gt;"));
    rendered(&at_sea(|voyage| voyage.legs.clear()));
    rendered(&with(|plan| plan.steps.clear()));
}

#[test]
fn the_same_plan_gives_the_same_bytes() {
    assert_eq!(rendered(&mock_plan::study()).html, rendered(&mock_plan::study()).html);
}

#[test]
fn what_charts_left_out_is_listed_by_class_with_count_and_reason() {
    let class = |ignored: u64, why: &str| PlanChartClass {
        objects: 9,
        avoided: 9 - ignored,
        maneuvers_avoid: 0,
        ignored,
        reasons: BTreeMap::from([(why.to_owned(), ignored)]),
    };
    let fairway =
        PlanChartClass { maneuvers_avoid: 9, avoided: 0, ignored: 0, reasons: BTreeMap::new(), objects: 9 };
    let chart = PlanChart {
        file: "US5WA22M.000".to_owned(),
        edition: Some("40".to_owned()),
        update: Some(3),
        issued: Some("20250923".to_owned()),
        scale: Some(15_000),
        sounding_datum: Some("mean lower low water".to_owned()),
        vertical_datum: Some("mean high water".to_owned()),
        notes: vec!["all 4 files agree with CATALOG.031".to_owned()],
        classes: BTreeMap::from([
            ("LNDMRK".to_owned(), class(7, "on land")),
            ("LIGHTS".to_owned(), class(9, "no body")),
            ("FAIRWY".to_owned(), fairway),
        ]),
        depths: None,
    };
    let told = text(&with(|plan| plan.charts = vec![chart.clone()]));
    holds(
        &told,
        &[
            "US5WA22M.000 (edition 40, update 3, 1 : 15000), depths below mean lower low water",
            "all 4 files agree with CATALOG.031",
            "LNDMRK 7 on land",
            "LIGHTS 9 no body",
            "FAIRWY 9 only maneuvers avoid it",
        ],
    );
    assert!(!text(&mock_plan::study()).contains("Electronic charts"));
}
