//! Every figure is well-formed, scalable and free of numbers that cannot be drawn.

use report::figures::{
    AccuracyCurve, Curve, ErrorRow, FrontDot, Histogram, HistogramAxis, HistogramPanel, SensitivityRow,
    ShareRow, TraceColumn, TraceRow, TrackCell, TrackLine, accuracy, front, histogram_pair, palette,
    relative_errors, sensitivities, shares, tick_number, traces, tracks,
};
use report::picture;

use crate::drawing::{corners, elements};

/// Tags balance, quotes close, the root scales, nothing is NaN or infinite.
fn check(svg: &str) {
    assert!(svg.starts_with("<svg role=\"img\" aria-label=\""), "{}", &svg[..60]);
    let root = &svg[..svg.find('>').unwrap()];
    assert!(root.contains("viewBox=\"0 0 "), "{root}");
    assert!(!root.contains(" width=") && !root.contains(" height="), "{root}");
    for wrong in ["NaN", "inf", "id=\"", "#000000"] {
        assert!(!svg.contains(wrong), "{wrong} in the drawing");
    }
    assert_eq!(open_tags(svg), Vec::<String>::new());
}

fn open_tags(svg: &str) -> Vec<String> {
    let mut open = Vec::new();
    let mut rest = svg;
    while let Some(start) = rest.find('<') {
        let end = start + rest[start..].find('>').expect("a tag is not closed");
        let tag = &rest[start + 1..end];
        assert!(tag.matches('"').count().is_multiple_of(2), "{tag}");
        let name = tag.trim_start_matches('/').split([' ', '/']).next().unwrap_or_default().to_owned();
        if tag.starts_with('/') {
            assert_eq!(open.pop(), Some(name));
        } else if !tag.ends_with('/') {
            open.push(name);
        }
        rest = &rest[end + 1..];
    }
    open
}

fn panel<'a>(label: &'a str, values: &[Option<f64>]) -> HistogramPanel<'a> {
    HistogramPanel { label, values: values.to_vec(), note: Some("50.0 % below 5".to_owned()) }
}

const AXIS: HistogramAxis<'_> =
    HistogramAxis { title: "parameter error [1]", limit: 25.0, bins: 50, bound: Some(5.0), width: 520.0 };

#[test]
fn the_histograms_name_their_designs_and_count_the_last_bar() {
    let optimized = [Some(1.0), Some(2.0), None, Some(30.0), Some(f64::NAN)];
    let random = [Some(f64::INFINITY), None, Some(40.0), Some(41.0), Some(42.0)];
    let svg = histogram_pair(&AXIS, &[panel("optimized", &optimized), panel("random", &random)]);
    check(&svg);
    for label in ["optimized", "random", "≥ 25", "parameter error [1]", "50.0 % below 5", "runs", ">3<"] {
        assert!(svg.contains(label), "{label}");
    }
    assert!(svg.contains(&palette::hex(palette::BLUE)) && svg.contains(&palette::hex(palette::VERMILION)));
}

#[test]
fn histograms_without_runs_or_panels_are_drawn_empty() {
    check(&histogram_pair(&AXIS, &[]));
    check(&histogram_pair(&AXIS, &[panel("none", &[]), panel("all missing", &[None; 3])]));
    let endless = HistogramAxis { limit: f64::NAN, bins: 0, width: f64::NAN, ..AXIS };
    check(&histogram_pair(&endless, &[panel("none", &[Some(1.0)])]));
}

#[test]
fn shares_show_ours_and_the_published_ones() {
    let rows = [
        ShareRow { name: "spiral-fast", share: 0.352, published: Some(0.25) },
        ShareRow { name: "zig-zag <&> \"steep\"", share: 0.0, published: None },
        ShareRow { name: "odd", share: f64::NAN, published: Some(f64::INFINITY) },
    ];
    let svg = shares(&rows);
    for label in [
        "spiral-fast",
        "35.2 %",
        "published",
        "share of the experiment time [%]",
        "&lt;&amp;&gt; &quot;steep",
    ] {
        assert!(svg.contains(label), "{label}");
    }
    check(&svg);
    check(&shares(&[]));
}

#[test]
fn sensitivities_show_the_line_that_is_worth_the_time() {
    let rows = [
        SensitivityRow { name: "spiral-fast", sensitivity: 13.0, used: true },
        SensitivityRow { name: "spiral-slow", sensitivity: 6.25, used: false },
        SensitivityRow { name: "broken", sensitivity: f64::NAN, used: false },
    ];
    let svg = sensitivities(&rows, 13.0);
    check(&svg);
    for label in ["spiral-slow", "6.2", "g = p = 13"] {
        assert!(svg.contains(label), "{label}");
    }
    check(&sensitivities(&[], f64::NAN));
}

#[test]
fn relative_errors_name_parameters_and_designs() {
    let rows = [
        ErrorRow { name: "X_u", errors: vec![Some((0.02, 0.1)), Some((-3.0, 40.0))] },
        ErrorRow { name: "X_uu", errors: vec![None, Some((f64::NAN, 1.0))] },
    ];
    let svg = relative_errors(&["optimized", "random"], &rows);
    check(&svg);
    for label in ["X_uu", "optimized", "random", "−10", "relative error"] {
        assert!(svg.contains(label), "{label}");
    }
    check(&relative_errors(&[], &[]));
}

#[test]
fn traces_survive_gaps_and_unequal_lengths() {
    let t: Vec<f64> = (0..300).map(|i| f64::from(i) / 8.0).collect();
    let mut values: Vec<f64> = t.iter().map(|t| t.sin()).collect();
    values[10] = f64::NAN;
    let columns = [
        TraceColumn { title: "inputs", legend: vec![("tau1, 1 = 4.3 kN".to_owned(), palette::input(0))] },
        TraceColumn { title: "surge u [m/s]", legend: Vec::new() },
    ];
    let cells = vec![
        vec![Curve { values, colour: Some(palette::input(0)), ..Curve::default() }],
        vec![Curve { values: vec![1.0; 7], ..Curve::default() }],
    ];
    let row = TraceRow { name: "zig-zag", note: Some("10.0 % of the time".to_owned()), t: &t, cells };
    let svg = traces(&columns, &[row]);
    check(&svg);
    for label in ["zig-zag", "surge u [m/s]", "tau1, 1 = 4.3 kN", "time [s]", "10.0 % of the time"] {
        assert!(svg.contains(label), "{label}");
    }
    check(&traces(&[], &[]));
}

fn track<'a>(name: &'a str, x: &'a [f64], y: &'a [f64]) -> TrackCell<'a> {
    TrackCell { name, lines: vec![TrackLine { x, y, colour: None }] }
}

#[test]
fn tracks_share_one_scale() {
    let x: Vec<f64> = (0..100).map(f64::from).collect();
    let y = vec![0.0; 100];
    let svg = tracks(&[track("straight", &x, &y), track("none", &[], &[])]);
    check(&svg);
    assert!(svg.contains("straight") && svg.contains(" m</text>"));
    check(&tracks(&[]));
}

#[test]
fn long_names_of_tracks_keep_both_ends() {
    let names = ["zigzag_31-Jul-2020_13_14_21_first", "zigzag_31-Jul-2020_13_50_28_second"];
    let svg = tracks(&names.map(|name| track(name, &[0.0, 9.0], &[0.0, 1.0])));
    check(&svg);
    assert!(svg.contains("zigzag_31-Ju…") && svg.contains("first<") && svg.contains("second<"), "{svg}");
}

#[test]
fn a_front_names_its_dots_and_fills_the_chosen_one() {
    let dots = [
        FrontDot { cost: 8.0, log_det: 60.7, label: "3 <2> 3", chosen: false },
        FrontDot { cost: 10.0, log_det: 62.9, label: "3 3 3", chosen: true },
        FrontDot { cost: f64::NAN, log_det: 61.0, label: "broken", chosen: false },
        FrontDot { cost: 9.0, log_det: f64::INFINITY, label: "endless", chosen: false },
    ];
    let svg = front(&dots, "basic moves");
    check(&svg);
    for label in ["3 &lt;2&gt; 3", "3 3 3", "basic moves", "log|det| of the moments [1]"] {
        assert!(svg.contains(label), "{label}");
    }
    assert!(!svg.contains("broken") && !svg.contains("endless"));
    let filled = format!("fill=\"{}\"", palette::hex(palette::BLUE));
    assert_eq!(svg.matches("<circle").count(), 2);
    assert_eq!(svg.matches("<circle").count() - 1, svg.matches(&filled).count());
    check(&front(&[], "cost"));
    check(&front(&dots[1..2], "cost"));
}

#[test]
fn the_same_input_gives_the_same_bytes() {
    let rows = [ShareRow { name: "a", share: 0.5, published: Some(0.4) }];
    assert_eq!(shares(&rows), shares(&rows));
}

#[test]
fn law_every_run_is_counted_once() {
    let values =
        [Some(0.0), Some(1.0), Some(4.99), Some(5.0), None, Some(f64::INFINITY), Some(f64::NAN), Some(-1.0)];
    let histogram = Histogram::new(&values, 5.0, 5);
    assert_eq!(histogram.counts, [2, 1, 0, 0, 1]);
    assert_eq!((histogram.beyond, histogram.missing), (1, 3));
    assert_eq!(histogram.runs(), values.len());
}

#[test]
fn a_tick_has_as_many_decimals_as_its_step() {
    assert_eq!(tick_number(0.5, 0.25), "0.5");
    assert_eq!(tick_number(0.30000000000000004, 0.1), "0.3");
    assert_eq!(tick_number(-1e-17, 0.1), "0");
    assert_eq!(tick_number(2.5e-6, 5e-7), "2.5·10⁻⁶");
    assert_eq!(tick_number(f64::NAN, 1.0), "");
}

#[test]
fn each_figure_of_a_picture_has_a_place_of_its_own() {
    let figure = |name: &str| format!("<svg viewBox=\"0 0 10 10\"><title>{name}</title></svg>\n");
    let made = picture(&figure("map"), &[&figure("one"), &figure("two")]);
    assert_eq!(made.matches("<svg ").count(), 4);
    assert_eq!(made.matches("</svg>").count(), 4);
    for place in ["x=\"20\" y=\"20\" width=\"1140\"", "x=\"20\" y=\"800\"", "x=\"600\" y=\"800\""] {
        assert!(made.contains(place), "{place}");
    }
}

#[test]
fn law_a_curve_of_one_over_the_root_of_time_is_straight() {
    let points: Vec<(f64, f64)> = (1..=8).map(|i| (f64::from(i * i), 1.0 / f64::from(i))).collect();
    let svg = accuracy(&[AccuracyCurve { label: "design", points }], (16.0, 0.25), "error [1]");
    check(&svg);
    let curves = elements(&svg, "path").flat_map(corners);
    let curve = curves.max_by_key(Vec::len).unwrap();
    let (first, last) = (curve[0], curve[7]);
    let slope = (last.1 - first.1) as f64 / (last.0 - first.0) as f64;
    for (x, y) in &curve {
        let off = (y - first.1) as f64 - slope * (x - first.0) as f64;
        assert!(off.abs() <= 1.0, "{curve:?}");
    }
}

#[test]
fn ticks_of_a_logarithmic_axis_are_inside_and_few() {
    let ticks = |points: Vec<(f64, f64)>, wanted: (f64, f64)| {
        let svg = accuracy(&[AccuracyCurve { label: "design", points }], wanted, "error [1]");
        let texts = elements(&svg, "text").filter_map(|text| text.split_once('>')?.1.parse::<f64>().ok());
        texts.filter(|tick| *tick >= 1.0).collect::<Vec<_>>()
    };
    let coarse = ticks(vec![(8.0, 0.5), (2100.0, 0.5)], (8.0, 0.5));
    assert!(
        (2..=8).contains(&coarse.len()) && coarse.iter().all(|t| (7.0..2400.0).contains(t)),
        "{coarse:?}"
    );
    assert_eq!(ticks(vec![(0.9, 0.5), (11.0, 0.5)], (2.0, 0.5)), [1.0, 2.0, 5.0, 10.0]);
}

fn dots(costs: &[(f64, f64)]) -> String {
    let dot =
        |(cost, log_det): &(f64, f64)| FrontDot { cost: *cost, log_det: *log_det, label: "", chosen: false };
    front(&costs.iter().map(dot).collect::<Vec<_>>(), "cost")
}

#[test]
fn whole_costs_have_whole_ticks() {
    let labels = |svg: &str| {
        let texts = elements(svg, "text").filter_map(|text| text.split_once('>')?.1.parse::<f64>().ok());
        texts.take_while(|tick| *tick < 20.0).collect::<Vec<_>>()
    };
    assert_eq!(labels(&dots(&[(8.0, 60.0), (10.0, 63.0)])), [8.0, 9.0, 10.0]);
    assert!(labels(&dots(&[(8.0, 60.0), (10.1, 63.0)])).len() > 3);
}

#[test]
fn law_the_steps_never_fall_and_skip_what_is_beaten() {
    let svg = dots(&[(8.0, 60.0), (9.0, 59.0), (10.0, 63.0)]);
    let steps = elements(&svg, "path").flat_map(corners).find(|line| line.len() > 2).unwrap();
    let circles: Vec<(i64, i64)> = elements(&svg, "circle")
        .map(|tag| (crate::drawing::attribute(tag, "cx"), crate::drawing::attribute(tag, "cy")))
        .collect();
    let ((cheap, low), (dear, high)) = (circles[0], circles[2]);
    assert_eq!(steps[..3], [(cheap, low), (dear, low), (dear, high)]);
    assert!(steps.len() == 4 && steps[3].0 > dear && steps[3].1 == high, "{steps:?}");
}

#[test]
fn peaks_survive_and_gaps_are_dropped() {
    let mut values = vec![0.0; 10_000];
    (values[4321], values[77]) = (7.0, f64::NAN);
    let t: Vec<f64> = (0..10_000).map(f64::from).collect();
    let column = TraceColumn { title: "u", legend: Vec::new() };
    let cells = vec![vec![Curve { values, ..Curve::default() }]];
    let svg = traces(&[column], &[TraceRow { name: "m", note: None, t: &t, cells }]);
    check(&svg);
    let curve = elements(&svg, "path").flat_map(corners).max_by_key(Vec::len).unwrap();
    let floor = curve[0].1;
    let peaks: Vec<&(i64, i64)> = curve.iter().filter(|(_, y)| *y != floor).collect();
    assert!(curve.len() <= 604 && peaks.len() == 1 && floor - peaks[0].1 > 400, "{peaks:?}");
}
