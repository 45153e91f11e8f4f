//! A map is drawn again from `map.json`.

use std::collections::BTreeMap;

use files::{Provenance, commit, stage_document};
use report::figures::map as figure;
use report::{Sources, load, plan_map, render};
use study::documents::*;

use crate::mock_plan;

fn line(points: &[[f64; 2]]) -> MapLine {
    MapLine { east_m: points.iter().map(|p| p[0]).collect(), north_m: points.iter().map(|p| p[1]).collect() }
}

fn place([east_m, north_m]: [f64; 2]) -> MapPlace {
    MapPlace { east_m, north_m }
}

const ISLAND: [[f64; 2]; 3] = [[0.0, 0.0], [300.0, 0.0], [0.0, 300.0]];
const LAKE: [[f64; 2]; 3] = [[20.0, 20.0], [60.0, 20.0], [20.0, 60.0]];
const SHOAL: [[f64; 2]; 3] = [[700.0, 0.0], [900.0, 0.0], [900.0, 200.0]];
const RING: [[f64; 2]; 4] = [[100.0, 100.0], [900.0, 100.0], [900.0, 150.0], [100.0, 150.0]];
const WAY: [[f64; 2]; 3] = [[100.0, 200.0], [500.0, 400.0], [900.0, 700.0]];

/// Every part of a map; the depth of the two easternmost columns is 3 m, that of the others 12 m.
pub fn document() -> MapDocument {
    let raster = MapRaster { west_m: 0.0, south_m: 0.0, cell_m: 250.0, columns: 4, rows: 2 };
    let runs = |runs: &[u64]| MapRuns(runs.to_vec());
    let water =
        |least_m, own| MapCellClass { class: MapClass::Depth, least_m: Some(least_m), runs: runs(own) };
    let classes = vec![water(3.0, &[2, 2, 2, 2]), water(12.0, &[0, 2, 2, 2, 2])];
    let track = |kind, maneuver: Option<&str>, number| MapTrack {
        kind,
        maneuver: maneuver.map(str::to_owned),
        number,
        line: line(&WAY),
    };
    MapDocument {
        safe: false,
        statement: "10 basic moves <proved>".to_owned(),
        counts: BTreeMap::from([("circle".to_owned(), 2), ("zig-zag".to_owned(), 1)]),
        longitude_deg: 25.0,
        latitude_deg: 60.0,
        frame: MapFrame { west_m: 0.0, south_m: 0.0, east_m: 1000.0, north_m: 900.0 },
        uncharted_is_water: false,
        depth_limits_m: vec![5.0, 10.0],
        cells: Some(MapCells { raster, classes }),
        areas: vec![
            MapArea { class: MapClass::Land, least_m: None, rings: vec![line(&ISLAND), line(&LAKE)] },
            MapArea { class: MapClass::Depth, least_m: Some(-1.5), rings: vec![line(&SHOAL)] },
            MapArea { class: MapClass::NoGo, least_m: None, rings: vec![line(&SHOAL)] },
        ],
        contours: vec![MapContour { depth_m: Some(7.0), line: line(&WAY) }],
        margins: vec![
            MapMargin { purpose: MapPurpose::Trial, raster, runs: runs(&[1, 4, 3]) },
            MapMargin { purpose: MapPurpose::Transit, raster, runs: runs(&[1, 2, 5]) },
        ],
        spots: vec![
            MapSpot {
                place: place([400.0, 800.0]),
                symbol: MapSymbol::Sounding,
                depth_m: Some(4.4),
                title: "a".into(),
            },
            MapSpot {
                place: place([600.0, 800.0]),
                symbol: MapSymbol::Danger,
                depth_m: None,
                title: "b".into(),
            },
        ],
        names: vec![MapName { place: place([500.0, 500.0]), name: "Träholm".to_owned() }],
        swept: Some(MapSwept { vessels: 64, raster, runs: runs(&[4, 4]) }),
        corridors: vec![line(&RING)],
        edge: Some(line(&RING)),
        speed_limits: vec![line(&SHOAL)],
        tracks: vec![
            track(MapTrackKind::Basic, None, None),
            track(MapTrackKind::RunIn, Some("zig-zag"), None),
            track(MapTrackKind::Maneuver, Some("zig-zag"), Some(1)),
        ],
        aborts: vec![line(&WAY)],
        hulls: vec![line(&LAKE)],
        start: Some(place(WAY[0])),
        goal: Some(place(WAY[2])),
        meridians: vec![MapMeridian { longitude_deg: -24.05, east_m: 400.0 }],
        parallels: vec![MapParallel { latitude_deg: 60.125, north_m: 300.0 }],
    }
}

/// The same, as a figure takes it.
fn figure() -> figure::Map {
    use figure::{
        Cells, ChartedArea, Class, Contour, Margin, PlottedTrack, Purpose, Spot, Symbol, TrackStyle, Tube,
    };
    let grid = figure::Raster { origin: [0.0, 0.0], cell_m: 250.0, nx: 4, ny: 2 };
    let depth = |least_m| Class::Depth { least_m };
    let [deep, shoal] = [Some(depth(12.0)), Some(depth(3.0))];
    let set = |text: &str| text.chars().map(|c| c == '#').collect::<Vec<_>>();
    let track = |style, number| PlottedTrack { style, points: WAY.to_vec(), number };
    let area = |class, ring: [[f64; 2]; 3], holes| ChartedArea { class, ring: ring.to_vec(), holes };
    let spot = |at, symbol, depth_m, title: &str| Spot { at, symbol, depth_m, title: title.to_owned() };
    figure::Map {
        title: "Planned trial, unsafe".to_owned(),
        description: "10 basic moves <proved>".to_owned(),
        warning: Some("Unsafe: the plan fails its own check".to_owned()),
        frame: figure::Frame { west: 0.0, south: 0.0, east: 1000.0, north: 900.0 },
        uncharted: true,
        depth_limits_m: vec![5.0, 10.0],
        cells: Some(Cells { grid, classes: [deep, deep, shoal, shoal].repeat(2) }),
        areas: vec![
            area(Class::Land, ISLAND, vec![LAKE.to_vec()]),
            area(depth(-1.5), SHOAL, Vec::new()),
            area(Class::NoGo, SHOAL, Vec::new()),
        ],
        contours: vec![Contour { depth_m: Some(7.0), line: WAY.to_vec() }],
        margins: vec![
            Margin { purpose: Purpose::Trial, grid, blocked: set(".####...") },
            Margin { purpose: Purpose::Transit, grid, blocked: set(".##.....") },
        ],
        spots: vec![
            spot([400.0, 800.0], Symbol::Sounding, Some(4.4), "a"),
            spot([600.0, 800.0], Symbol::Danger, None, "b"),
        ],
        names: vec![([500.0, 500.0], "Träholm".to_owned())],
        tube: Some(Tube { grid, swept: set("....####"), vessels: 64 }),
        corridors: vec![RING.to_vec()],
        edge: RING.to_vec(),
        speed_limits: vec![SHOAL.to_vec()],
        maneuvers: vec![("circle".to_owned(), 2), ("zig-zag".to_owned(), 1)],
        tracks: vec![
            track(TrackStyle::Basic, None),
            track(TrackStyle::RunIn, None),
            track(TrackStyle::Maneuver(1), Some(1)),
        ],
        aborts: vec![WAY.to_vec()],
        hulls: vec![LAKE.to_vec()],
        start: Some(WAY[0]),
        goal: Some(WAY[2]),
        graticule: figure::Graticule {
            x: vec![(400.0, "24° 3.0′ W".to_owned())],
            y: vec![(300.0, "60° 7.5′ N".to_owned())],
        },
    }
}

#[test]
fn law_every_part_of_a_document_is_drawn() {
    assert_eq!(plan_map(&document()).unwrap(), figure::map_figure(&figure()).unwrap());
    let safe = plan_map(&MapDocument { safe: true, ..document() }).unwrap();
    assert!(safe.contains("<title>Planned trial</title>") && !safe.contains("Unsafe"));
}

#[test]
fn a_page_draws_the_map_from_its_document_where_there_is_one() {
    let folder = tempfile::tempdir().unwrap();
    let (path, provenance) = (folder.path(), Provenance::default());
    let plan = stage_document(path.join("plan.json"), &provenance, &mock_plan::plan()).unwrap();
    let map = stage_document(path.join("map.json"), &provenance, &document()).unwrap();
    commit(vec![plan, map]).unwrap();
    std::fs::write(path.join("plan.toml"), "").unwrap();
    // An unused drawing need not be safe for a page.
    std::fs::write(path.join("map.svg"), "<script>alert(1)</script>").unwrap();
    let (study, results) = (path.to_owned(), path.to_owned());
    let (scenarios, changes) = (Vec::new(), files::Changes::default());
    let sources = Sources { study, dictionary: None, results, scenarios, allow_mixed: false, changes };
    let html = render(&load(&sources).unwrap()).html;
    assert!(html.contains("<title>Planned trial, unsafe</title>") && !html.contains("alert(1)"));
    assert!(html.contains("map.json") && html.contains("map.svg"));
}
