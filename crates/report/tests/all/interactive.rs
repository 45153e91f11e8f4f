//! What scripts draw on the page: its data, its links between steps and tracks, its escapes.

use report::Study;
use serde_json::Value;
use study::documents::{MapLine, MapTrack, MapTrackKind};

use crate::page::rendered;
use crate::{map_document, mock, mock_plan};

/// The data of the panels of a page.
fn data(page: &str) -> Value {
    let (_, after) = page.split_once("<script id=\"data\" type=\"application/json\">").unwrap();
    serde_json::from_str(after.split_once("</script>").unwrap().0).unwrap()
}

/// The tracks of the plan of [`mock_plan`], without recovery after the second maneuver.
fn tracks() -> Vec<MapTrack> {
    use MapTrackKind::{Basic, Maneuver, RunIn};
    let kinds = [Basic, RunIn, Maneuver, RunIn, Basic, Basic, RunIn, Maneuver, Basic];
    let track = |kind| MapTrack { kind, maneuver: None, number: None, line: MapLine::default() };
    kinds.into_iter().map(track).collect()
}

/// The study with a plan on a map with these tracks.
fn planned(tracks: Vec<MapTrack>) -> Study {
    let mut study = mock_plan::study();
    let main = study.trajectory.as_mut().and_then(|own| own.main.as_mut()).unwrap();
    main.document = Some(map_document::document()).map(|own| study::documents::MapDocument { tracks, ..own });
    study
}

/// The page of the study, and the panel of its plan, which stands first.
fn chart(tracks: Vec<MapTrack>) -> (String, Value) {
    let page = rendered(&planned(tracks)).html;
    let panels = data(&page);
    assert_eq!((&panels[0]["id"], &panels[1]["id"]), (&"map-layers".into(), &"trials".into()));
    let panel = panels[0]["data"].clone();
    (page, panel)
}

#[test]
fn every_part_of_the_track_is_linked_to_its_step() {
    let (page, map) = chart(tracks());
    let steps: Vec<_> =
        map["tracks"].as_array().unwrap().iter().map(|track| track[4].as_u64().unwrap()).collect();
    assert_eq!(steps, [0, 1, 1, 1, 2, 3, 4, 4, 5]);
    let rows: Vec<&str> = page.split("<tr ").filter(|row| row.contains(" data-step=")).collect();
    assert!((0..6).all(|step| rows[step].contains(&format!(" data-step=\"{step}\""))) && rows.len() == 6);
    assert!(rows[1].contains("steep, mirrored (starts to the other side)"));
}

#[test]
fn a_track_of_another_plan_is_drawn_without_links() {
    let mut fewer = tracks();
    fewer.pop();
    let map = chart(fewer).1;
    let all = map["tracks"].as_array().unwrap();
    assert!(all.len() == 8 && all.iter().all(|track| track[4].is_null()));
}

#[test]
fn law_lines_keep_their_places_to_a_tenth_of_a_metre() {
    let map = chart(tracks()).1;
    let (mut place, mut found) = ([0, 0], Vec::new());
    let line = map["contours"][0][1].as_array().unwrap();
    for step in line.chunks(2) {
        place = [0, 1].map(|k| place[k] + step[k].as_i64().unwrap());
        found.push(place.map(|tenths| tenths as f64 / 10.0));
    }
    assert_eq!(found, [[100.0, 200.0], [500.0, 400.0], [900.0, 700.0]]);
}

#[test]
fn law_no_text_of_the_study_ends_or_begins_a_script() {
    let hostile = "</script><script>alert(1)</script><!--";
    let mut study = mock::study();
    let plain = rendered(&study).html;
    study.name = hostile.to_owned();
    study.scores.iter_mut().flatten().for_each(|row| row.design = hostile.to_owned());
    let page = rendered(&study).html;
    for tag in ["<script", "</script", "<!--"] {
        assert_eq!(page.matches(tag).count(), plain.matches(tag).count(), "{tag}");
    }
    assert_eq!(data(&page)[0]["data"]["rows"][0][0], hostile);
}

#[test]
fn libraries_are_in_the_page_only_where_they_draw() {
    let [trials, plan] = [mock::study(), planned(tracks())].map(|study| rendered(&study).html);
    assert!(trials.contains("uPlot (v1.6.32)") && !trials.contains("Leaflet 1.9.4"));
    assert!(plan.contains("uPlot (v1.6.32)") && plan.contains("Leaflet 1.9.4"));
    let none = rendered(&Study::default()).html;
    assert!(!none.contains("<script"));
    for license in ["Copyright (c) 2022 Leon Sorokin", "BSD 2-Clause License"] {
        assert!(plan.contains(license), "{license}");
    }
}
