//! `map.svg` is put on the page unchanged if it is harmless.

use std::path::Path;

use files::{Provenance, commit, stage_document};
use report::figures::map::parted;
use report::figures::map::{ChartedArea, Class, Map, PlottedTrack, TrackStyle};
use report::figures::map_figure;
use report::{Sources, load, render};

use crate::mock_plan;

fn drawn() -> String {
    let track = PlottedTrack {
        style: TrackStyle::Basic,
        points: vec![[100.0, 200.0], [900.0, 700.0]],
        number: Some(1),
    };
    let ring = vec![[0.0, 0.0], [300.0, 0.0], [0.0, 300.0]];
    let island = ChartedArea { class: Class::Land, ring, holes: Vec::new() };
    let whole = Map {
        title: "Planned trial".to_owned(),
        description: "10 basic moves <proved> & \"done\"".to_owned(),
        areas: vec![island],
        tracks: vec![track],
        hulls: vec![vec![[5.0, 5.0], [9.0, 5.0], [5.0, 9.0]]],
        start: Some([100.0, 200.0]),
        goal: Some([900.0, 700.0]),
        ..Map::default()
    };
    map_figure(&whole).unwrap()
}

/// The page of a study whose plan has `map`, or the error.
fn page(folder: &Path, map: &str) -> Result<String, String> {
    std::fs::write(folder.join("map.svg"), map).unwrap();
    let (study, results) = (folder.to_owned(), folder.to_owned());
    let (scenarios, changes) = (Vec::new(), files::Changes::default());
    let sources = Sources { study, dictionary: None, results, scenarios, allow_mixed: false, changes };
    load(&sources).map(|study| render(&study).html).map_err(|refused| refused.to_string())
}

fn planned() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    let plan = stage_document(folder.path().join("plan.json"), &Provenance::default(), &mock_plan::plan());
    commit(vec![plan.unwrap()]).unwrap();
    std::fs::write(folder.path().join("plan.toml"), "").unwrap();
    folder
}

#[test]
fn a_map_as_drawn_is_taken_over() {
    // In two parts, the legend next to the map: only the enclosing group is lost.
    let html = page(planned().path(), &drawn()).unwrap();
    let [map, legend] = parted(&drawn()).unwrap();
    assert!(html.contains(&map) && html.contains(&legend));
    assert!(map.contains("<title>Planned trial</title>") && !map.contains(">basic move</text>"));
    assert!(legend.contains(">basic move</text>") && !legend.contains("<title>scale"));
    let elements = |svg: &str| svg.matches("/>").count() + svg.matches("</text>").count();
    assert_eq!(elements(&map) + elements(&legend), elements(&drawn()));
    // A foreign drawing is shown unchanged.
    let whole = drawn().replace("aria-label=\"Legend\"", "aria-label=\"Other\"");
    assert!(page(planned().path(), &whole).unwrap().contains(&whole));
}

#[test]
fn a_map_that_could_load_link_or_run_is_refused() {
    let folder = planned();
    let damages = [
        ("<title>", "<script>alert(1)</script><title>"),
        ("<title>", "<style>@import 'x'</style><title>"),
        ("<title>", "<foreignObject/><title>"),
        ("<title>", "<image href=\"x\"/><title>"),
        ("<title>", "<!-- --><title>"),
        ("<title>", "<title id=\"files\">"),
        ("<title>", "<title onload=\"x\">"),
        ("<title>", "<title onload=x>"),
        ("<title>", "<title\tonload=\"x\">"),
        ("<title>", "</svg><title>"),
        ("<title>", "</main><title>"),
        ("<title>", "<g><title>"),
        ("fill=\"none\"", "fill=\"URL(x)\""),
        ("<svg ", "<svg x=\"1\"y=\"2\" "),
        ("http://www.w3.org/2000/svg", "http://example.org"),
    ];
    let damaged = damages.map(|(whole, damage)| {
        let damaged = drawn().replacen(whole, damage, 1);
        assert_ne!(damaged, drawn(), "{whole}");
        damaged
    });
    let others = [String::new(), "text".into(), "<svg ".into(), drawn().trim_end().repeat(2)];
    for map in damaged.iter().chain(&others) {
        let refused = page(folder.path(), map).unwrap_err();
        assert!(refused.contains("map.svg") && refused.contains("a drawing of shapes and text"), "{refused}");
    }
}
