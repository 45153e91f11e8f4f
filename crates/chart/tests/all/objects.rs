//! Electronic charts by the rules of their classes: what is avoided, by how much, and how the rest is counted.

use std::collections::BTreeMap;

use chart::enc::{Cell, Feature, Geometry, class, class_name};
use chart::{
    Causes, Chart, Class, DANGER_M, DOUBTFUL_M, Ignored, Judged, Layer, Mark, Obstacles, Plane, PolygonLayer,
    RULES, Raster, Rules, Tallies, Treatment, objects_of_geojson,
};

use crate::support::{fixture_path, from_segment, shared_path, square};

/// A cell with its updates; `None`, said aloud, where it is not there.
fn cell(base: &std::path::Path, updates: usize) -> Option<Cell> {
    let Ok(bytes) = std::fs::read(base) else {
        println!("skipped: {} is not there", base.display());
        return None;
    };
    let mut cell = Cell::read(&bytes).unwrap();
    for number in 1..=updates {
        cell.update(&std::fs::read(base.with_extension(format!("{number:03}"))).unwrap()).unwrap();
    }
    Some(cell)
}

fn bay() -> Cell {
    cell(&fixture_path("enc/ZZ5BAY01.000"), 2).unwrap()
}

fn layer(cell: &Cell, rules: &Rules) -> (PolygonLayer, Tallies) {
    PolygonLayer::from_objects(&cell.features().unwrap(), Some(cell.scale()), rules).unwrap()
}

/// The bay about 25 E, 60 N, for a ship that needs 6 m: obstacles of maneuvers and in transit.
struct Bay {
    plane: Plane,
    both: [Obstacles; 2],
}

impl Bay {
    fn new(rules: &Rules) -> Self {
        let plane = Plane::new(25.0, 60.0).unwrap();
        let chart =
            Chart::new(plane, square(4900.0), &[Layer::Polygons(layer(&bay(), rules).0)], None).unwrap();
        let raster = Raster::covering(&square(4500.0), 10.0).unwrap();
        let both = [Obstacles::new, Obstacles::in_transit].map(|new| new(&chart, raster, 6.0, 0.0).unwrap());
        Self { plane, both }
    }

    /// Causes for maneuvers and in transit at a place and `east_m` east of it.
    fn causes(&self, [lon, lat]: [f64; 2], east_m: f64) -> [Causes; 2] {
        let [x, y] = self.plane.to_plane(lon, lat);
        [0, 1].map(|k: usize| {
            let (col, row) = self.both[k].raster().cell_at([x + east_m, y]).unwrap();
            self.both[k].causes(col, row)
        })
    }

    #[track_caller]
    fn assert_is(&self, place: [f64; 2], east_m: f64, cause: Causes) {
        assert_eq!(self.causes(place, east_m), [cause; 2], "{place:?} {east_m}");
    }
}

const WRECK: [f64; 2] = [25.01, 60.005];
const BRIDGE: [f64; 2] = [25.075, 60.003];

#[test]
fn every_object_is_treated_by_the_rule_of_its_class() {
    let bay = Bay::new(&Rules::default());
    bay.assert_is([25.0, 60.0], 0.0, Causes::LAND);
    bay.assert_is([25.003, 60.0], 0.0, Causes::SHOAL);
    // A wreck of 3.4 m, 50 m around it; a sounding of 3.2 m; a rock that dries; an obstruction of unknown depth.
    for place in [WRECK, [24.992, 60.004], [24.994, 60.0055], [24.99, 59.996]] {
        bay.assert_is(place, 0.0, Causes::SHOAL);
        bay.assert_is(place, DANGER_M - 6.0, Causes::SHOAL);
        bay.assert_is(place, DANGER_M + 12.0, Causes::NONE);
    }
    // A wreck with 7.5 m over it is none to a ship that needs 6.
    bay.assert_is([25.012, 59.996], 0.0, Causes::NONE);
    // A doubtful position.
    bay.assert_is([24.97, 60.0], DOUBTFUL_M - 15.0, Causes::SHOAL);
    bay.assert_is([24.97, 60.0], DOUBTFUL_M + 25.0, Causes::NONE);
    // The islet, as far as half a millimetre on a chart of 1 : 20,000.
    bay.assert_is([25.031, 60.001], 0.0, Causes::LAND);
    bay.assert_is([25.031, 60.001], 25.0, Causes::NONE);
    // Entry is prohibited in one restricted area, anchoring in the other.
    bay.assert_is([24.988, 60.008], 0.0, Causes::NO_GO);
    bay.assert_is([25.0145, 59.9932], 0.0, Causes::NONE);
    bay.assert_is(BRIDGE, 0.0, Causes::NO_GO);
    assert_eq!(bay.causes([25.015, 60.008], 0.0), [Causes::NO_GO, Causes::NONE]);
}

#[test]
fn radii_rules_and_the_air_draught_are_the_users_own() {
    let changed =
        [("FAIRWY", Treatment::Ignore), ("RESARE", Treatment::ManeuversAvoid), ("WRECKS", Treatment::Ignore)];
    let bay = Bay::new(&Rules {
        changed: changed.map(|(name, treatment)| (name.to_owned(), treatment)).into(),
        air_draught_m: Some(12.5),
        radius_m: Some(120.0),
        doubtful_radius_m: Some(200.0),
    });
    bay.assert_is([25.015, 60.008], 0.0, Causes::NONE);
    bay.assert_is(WRECK, 0.0, Causes::NONE);
    bay.assert_is(BRIDGE, 0.0, Causes::NONE);
    bay.assert_is([24.99, 59.996], 110.0, Causes::SHOAL);
    bay.assert_is([24.97, 60.0], 220.0, Causes::NONE);
    assert_eq!(bay.causes([25.0145, 59.9932], 0.0), [Causes::NO_GO, Causes::NONE]);
    let higher = Bay::new(&Rules { air_draught_m: Some(12.6), ..Rules::default() });
    higher.assert_is(BRIDGE, 0.0, Causes::NO_GO);
}

#[test]
fn what_becomes_of_every_object_is_counted() {
    let (_, tallies) = layer(&bay(), &Rules::default());
    let found: BTreeMap<&str, [u64; 4]> = tallies
        .iter()
        .map(|(class, t)| (class.as_str(), [t.objects, t.avoided, t.maneuvers_avoid, t.ignored]))
        .collect();
    let expected = [
        ("BRIDGE", [1, 1, 0, 0]),
        ("COALNE", [1, 0, 0, 1]),
        ("C_AGGR", [1, 0, 0, 1]),
        ("DEPARE", [3, 3, 0, 0]),
        ("FAIRWY", [1, 0, 1, 0]),
        ("LNDARE", [2, 2, 0, 0]),
        ("M_COVR", [1, 0, 0, 1]),
        ("OBSTRN", [2, 2, 0, 0]),
        ("RESARE", [2, 1, 0, 1]),
        ("SOUNDG", [1, 1, 0, 0]),
        ("UWTROC", [1, 1, 0, 0]),
        ("WRECKS", [2, 2, 0, 0]),
    ];
    assert_eq!(found, expected.into());
}

/// All positions of a place, sorted: GeoJSON turns rings round.
fn sorted(geometry: &Geometry) -> Vec<[f64; 3]> {
    let flat = |places: &[[f64; 2]]| places.iter().map(|p| [p[0], p[1], 0.0]).collect::<Vec<_>>();
    let mut all = match geometry {
        Geometry::None => Vec::new(),
        Geometry::Points(points) => flat(points),
        Geometry::Soundings(points) => points.clone(),
        Geometry::Lines(lines) => lines.iter().flat_map(|line| flat(line)).collect(),
        Geometry::Area(polygons) => polygons.iter().flatten().flat_map(|ring| flat(&ring[1..])).collect(),
    };
    all.sort_by(|a, b| a.partial_cmp(b).unwrap());
    all
}

#[test]
fn geojson_that_gdal_made_of_a_cell_is_the_same_objects() {
    let objects = bay().features().unwrap();
    for name in ["WRECKS", "SOUNDG", "DEPARE", "RESARE"] {
        let path = fixture_path(&format!("enc/ZZ5BAY01_{name}.geojson"));
        let found = objects_of_geojson(&std::fs::read_to_string(path).unwrap()).unwrap();
        let own: Vec<&Feature> = objects.iter().filter(|o| Some(o.class) == class(name)).collect();
        assert_eq!(found.len(), own.len());
        for (found, own) in found.iter().zip(own) {
            let (place, own_place) = (sorted(&found.geometry), sorted(&own.geometry));
            assert_eq!((found.class, &found.id, place), (own.class, &own.id, own_place));
            let rules = Rules::default();
            let judged = |object: &Feature| {
                let layer = PolygonLayer::from_objects(std::slice::from_ref(object), Some(20_000), &rules);
                layer.map(|(layer, tallies)| {
                    let marks = layer.marks.into_iter().map(|mark| Mark { feature: 0, ..mark });
                    let classes = layer.areas.iter().map(|area| area.class).collect::<Vec<_>>();
                    (classes, marks.collect::<Vec<_>>(), tallies)
                })
            };
            assert_eq!(judged(found), judged(own));
        }
    }
}

#[test]
fn contours_are_kept_for_maps_and_block_nothing() {
    let cell = bay();
    let mut objects = cell.features().unwrap();
    let plane = Plane::new(25.0, 60.0).unwrap();
    let line = |east: f64| vec![[east, 60.0], [east, 60.001]];
    objects.push(Feature {
        class: class("DEPCNT").unwrap(),
        id: "1-2-3".into(),
        attributes: BTreeMap::from([(chart::enc::VALDCO.0, "5".to_owned())]),
        geometry: Geometry::Lines(vec![line(25.001), line(27.0)]),
        position_quality: Vec::new(),
    });
    let (layer, tallies) =
        PolygonLayer::from_objects(&objects, Some(cell.scale()), &Rules::default()).unwrap();
    assert_eq!((tallies["DEPCNT"].objects, tallies["DEPCNT"].ignored), (1, 1));
    let without = self::layer(&cell, &Rules::default()).0;
    assert_eq!((layer.areas.len(), layer.marks.len()), (without.areas.len(), without.marks.len()));
    let chart = Chart::new(plane, square(4900.0), &[Layer::Polygons(layer)], None).unwrap();
    let [own] = chart.contours() else { panic!("{:?}", chart.contours()) };
    assert_eq!((own.depth_m, own.line[0]), (Some(5.0), plane.to_plane(25.001, 60.0)));
}

#[test]
fn objects_that_matter_have_a_place() {
    let wreck = |geometry| Feature {
        class: class("WRECKS").unwrap(),
        id: "1-2-3".into(),
        attributes: BTreeMap::new(),
        geometry,
        position_quality: Vec::new(),
    };
    let layer = |object, rules: &Rules| PolygonLayer::from_objects(&[object], Some(20_000), rules);
    let message = layer(wreck(Geometry::None), &Rules::default()).unwrap_err().to_string();
    assert!(message.contains("WRECKS 1-2-3") && message.contains("no geometry"), "{message}");
    let mut deep = wreck(Geometry::Points(vec![[25.0, 60.0]]));
    deep.attributes.insert(chart::enc::VALSOU.0, "5 m".into());
    let message = layer(deep, &Rules::default()).unwrap_err().to_string();
    assert!(message.contains("VALSOU") && message.contains("5 m"), "{message}");
    // A class that no standard knows may be anything.
    let unknown = Feature { class: 17_003, ..wreck(Geometry::Points(vec![[25.0, 60.0]])) };
    let (layer, _) = layer(unknown, &Rules::default()).unwrap();
    assert_eq!(layer.marks[0].class, Class::NoGo);
}

/// An object of a class.
fn object(name: &str, geometry: Geometry) -> Feature {
    Feature {
        class: class(name).unwrap(),
        id: format!("of {name}"),
        attributes: BTreeMap::new(),
        geometry,
        position_quality: Vec::new(),
    }
}

fn rectangle([west, south]: [f64; 2], [east, north]: [f64; 2]) -> Vec<[f64; 2]> {
    vec![[west, south], [east, south], [east, north], [west, north], [west, south]]
}

/// Water of 20 m around an island with a lake, and one more object.
fn island_with(own: Feature, rules: &Rules) -> (PolygonLayer, Tallies) {
    let outer = rectangle([24.0, 59.0], [26.0, 61.0]);
    let island = rectangle([24.99, 59.99], [25.01, 60.01]);
    let lake = rectangle([25.004, 60.004], [25.006, 60.006]);
    let mut water = object("DEPARE", Geometry::Area(vec![vec![outer, island.clone()], vec![lake.clone()]]));
    water.attributes.insert(chart::enc::DRVAL1.0, "20".into());
    let land = object("LNDARE", Geometry::Area(vec![vec![island, lake]]));
    PolygonLayer::from_objects(&[water, land, own], Some(20_000), rules).unwrap()
}

/// What became of the one object, and why.
fn became(own: Feature) -> (u64, Vec<Ignored>) {
    let name = class_name(own.class).map_or_else(|| own.class.to_string(), str::to_owned);
    let tally = &island_with(own, &Rules::default()).1[&name];
    (tally.avoided, tally.reasons.keys().copied().collect())
}

/// Whether an object counts is decided by where it stands, not by its class: every class with a body, and every code that the
/// standard lacks.
#[test]
fn law_solid_objects_are_obstacles_in_water_and_none_on_land() {
    let bodies =
        RULES.iter().filter(|rule| matches!(rule.judged, Judged::Body | Judged::Clearance | Judged::Unknown));
    let mut classes: Vec<u16> =
        bodies.flat_map(|rule| rule.classes).map(|name| class(name).unwrap()).collect();
    assert!(classes.len() > 45, "{}", classes.len());
    classes.extend([17_003, 401 + 2, 65_535]);
    let of = |class: u16, geometry: Geometry| Feature { class, ..object("LNDMRK", geometry) };
    let point = |place: [f64; 2]| Geometry::Points(vec![place]);
    for code in classes {
        let named = class_name(code).unwrap_or("unknown");
        for (place, is_water) in [
            ([25.02, 60.0], true),
            ([25.005, 60.005], true),
            ([27.0, 60.0], true),
            // On the shore.
            ([25.01, 60.0], true),
            ([25.0, 60.0], false),
            ([25.0099999, 60.0], false),
        ] {
            let own = of(code, point(place));
            let expected = if is_water { (1, vec![]) } else { (0, vec![Ignored::OnLand]) };
            assert_eq!(became(own.clone()), expected, "{named} at {place:?}");
            if let ([mark], true) = (&island_with(own, &Rules::default()).0.marks[..], is_water) {
                assert_eq!((mark.radius_m, &mark.positions[..]), (DANGER_M, &[place][..]), "{named}");
            }
        }
        let line = |to: [f64; 2]| Geometry::Lines(vec![vec![[24.995, 59.995], [25.0, 60.0], to]]);
        let area = |ring: Vec<[f64; 2]>| Geometry::Area(vec![vec![ring]]);
        for (geometry, is_water) in [
            (line([25.003, 60.003]), false),
            (line([25.02, 60.0]), true),
            // Over the lake, from land to land.
            (line([25.008, 60.008]), true),
            (area(rectangle([24.995, 59.995], [25.003, 60.003])), false),
            (area(rectangle([24.995, 59.995], [25.008, 60.008])), true),
            (area(rectangle([25.005, 59.995], [25.02, 60.003])), true),
        ] {
            let expected = if is_water { (1, vec![]) } else { (0, vec![Ignored::OnLand]) };
            assert_eq!(became(of(code, geometry.clone())), expected, "{named}: {geometry:?}");
        }
    }
}

#[test]
fn what_has_no_body_is_ignored_wherever_it_is_and_with_its_reason() {
    let point = || Geometry::Points(vec![[25.02, 60.0]]);
    for (name, why) in [
        ("LIGHTS", Ignored::NoBody),
        ("TOPMAR", Ignored::NoBody),
        ("SEAARE", Ignored::NoBody),
        ("SBDARE", Ignored::ForOthers),
        ("COALNE", Ignored::SaidElsewhere),
        ("M_QUAL", Ignored::AboutData),
    ] {
        assert_eq!(became(object(name, point())), (0, vec![why]), "{name}");
    }
    let mut mark = object("DISMAR", point());
    assert_eq!(became(mark.clone()), (1, vec![]));
    mark.attributes.insert(chart::enc::CATDIS.0, "1".into());
    assert_eq!(became(mark), (0, vec![Ignored::Unmarked]));
    let rules = |treatment| Rules { changed: [("LNDMRK".to_owned(), treatment)].into(), ..Rules::default() };
    let turbine = |treatment| island_with(object("LNDMRK", point()), &rules(treatment)).1["LNDMRK"].clone();
    let own = turbine(Treatment::Ignore);
    assert_eq!((own.ignored, own.reasons.keys().copied().collect::<Vec<_>>()), (1, vec![Ignored::Rule]));
    assert_eq!(turbine(Treatment::ManeuversAvoid).maneuvers_avoid, 1);
}

#[test]
fn parts_in_other_units_or_of_another_datum_are_refused() {
    let area = || Geometry::Area(vec![vec![rectangle([24.0, 59.0], [26.0, 61.0])]]);
    let message = |name: &str, (code, _): (u16, &str), value: &str| {
        let mut own = object(name, area());
        own.attributes.insert(code, value.into());
        let land = object("LNDARE", Geometry::Points(vec![[25.0, 60.0]]));
        PolygonLayer::from_objects(&[own, land], None, &Rules::default())
            .map(|_| ())
            .map_err(|e| e.to_string())
    };
    use chart::enc::{DUNITS, HORDAT, HUNITS};
    for (name, attribute, good, bad) in
        [("M_UNIT", DUNITS, "1", "3"), ("M_UNIT", HUNITS, "1", "2"), ("M_HDAT", HORDAT, "2", "1")]
    {
        assert_eq!(message(name, attribute, good), Ok(()));
        let message = message(name, attribute, bad).unwrap_err();
        assert!(message.contains(name) && message.contains(attribute.1), "{message}");
    }
}

#[test]
fn rules_of_what_is_no_class_or_has_none_are_refused() {
    let refused = |name: &str, treatment: Treatment| {
        let rules = Rules { changed: [(name.to_owned(), treatment)].into(), ..Rules::default() };
        rules.check().map_err(|e| e.to_string())
    };
    let message = refused("WRECK", Treatment::Avoid).unwrap_err();
    assert!(message.contains("rules.WRECK") && message.contains("did you mean `WRECKS`"), "{message}");
    assert!(refused("DEPARE", Treatment::Ignore).unwrap_err().contains("safety.transit_depth_m"));
    assert!(refused("OBSTRN", Treatment::ManeuversAvoid).unwrap_err().contains("`avoid` or `ignore`"));
    assert_eq!(refused("CTNARE", Treatment::Avoid), Ok(()));
    assert_eq!(refused("17003", Treatment::Ignore), Ok(()));
}

#[test]
fn the_table_names_each_class_of_the_standard_once_and_the_page_has_what_has_an_effect() {
    let page = std::fs::read_to_string(fixture_path("../../docs/own-chart.md")).unwrap();
    let mut seen = Vec::new();
    for rule in RULES {
        for name in rule.classes {
            assert!(class(name).is_some() && !seen.contains(name), "{name}");
            seen.push(name);
            let has_effect = rule.treatment != Treatment::Ignore;
            assert!(!has_effect || page.contains(&format!("`{name}`")), "docs/own-chart.md lacks {name}");
        }
    }
    let missing: Vec<&str> = (1..500).filter_map(class_name).filter(|name| !seen.contains(name)).collect();
    assert!(missing.is_empty(), "no rule for {missing:?}");
}

/// The figure: of a whole cell 192 obstructions and 109 wrecks that are points or lines, all kept, and nothing free nearer
/// to one than its radius where it is too shoal or of unknown depth.
#[test]
fn every_charted_obstruction_and_wreck_is_kept() {
    let Some(cell) = cell(&shared_path("enc/US4MD81M.000"), 3) else { return };
    let objects = cell.features().unwrap();
    let (layer, tallies) = layer(&cell, &Rules::default());
    let own = |name: &str| {
        let is = |mark: &&Mark| class_name(objects[mark.feature].class) == Some(name);
        layer.marks.iter().filter(is).collect::<Vec<_>>()
    };
    let (obstructions, wrecks) = (own("OBSTRN"), own("WRECKS"));
    assert_eq!((obstructions.len(), wrecks.len()), (192, 109));
    assert_eq!((tallies["OBSTRN"].avoided, tallies["WRECKS"].avoided), (219, 111));
    const CELL_M: f64 = 50.0;
    let plane = Plane::new(-76.32, 38.7).unwrap();
    let chart = Chart::new(plane, square(40_000.0), &[Layer::Polygons(layer.clone())], None).unwrap();
    let raster = Raster::covering(&square(39_000.0), CELL_M).unwrap();
    let (least_depth_m, margin_m) = (8.0, 100.0);
    let obstacles = Obstacles::new(&chart, raster, least_depth_m, margin_m).unwrap();
    let mut looked_at = 0;
    for mark in obstructions.into_iter().chain(wrecks) {
        let Class::Danger { least_m } = mark.class else { panic!("{mark:?}") };
        let line: Vec<[f64; 2]> = mark.positions.iter().map(|p| plane.to_plane(p[0], p[1])).collect();
        let Some((col, row)) = raster.cell_at(line[0]) else { continue };
        if least_m.is_some_and(|depth| depth >= least_depth_m) {
            continue;
        }
        assert!(obstacles.causes(col, row).has(Causes::SHOAL), "{mark:?}");
        let reach = ((mark.radius_m + margin_m) / CELL_M) as usize + 2;
        for k in 0..(2 * reach + 1).pow(2) {
            let (c, r) = (col + k % (2 * reach + 1) - reach, row + k / (2 * reach + 1) - reach);
            let centre = raster.node(c, r).map(|v| v + CELL_M / 2.0);
            let segments = line.windows(line.len().min(2));
            let away =
                segments.map(|w| from_segment(centre, w[0], w[w.len() - 1])).fold(f64::INFINITY, f64::min);
            assert!(
                obstacles.is_blocked(c, r) || away >= mark.radius_m + margin_m,
                "{mark:?}: free at {away} m"
            );
        }
        looked_at += 1;
    }
    assert!(looked_at > 200, "{looked_at}");
}

#[test]
fn anchorages_are_areas_that_ships_may_pass() {
    let object = |code: u16, west: f64, more: &str| {
        let (east, [south, north]) = (west + 0.01, [59.99, 60.01]);
        format!(
            "{{\"type\": \"Feature\", \"properties\": {{\"OBJL\": {code}{more}}}, \"geometry\": {{\"type\": \"Polygon\", \
             \"coordinates\": [[[{west}, {south}], [{east}, {south}], [{east}, {north}], [{west}, {north}], \
             [{west}, {south}]]]}}}}"
        )
    };
    let [depth, anchorage, berth] = ["DEPARE", "ACHARE", "ACHBRT"].map(|name| class(name).unwrap());
    let objects = [
        object(depth, 24.99, ", \"DRVAL1\": 12.0"),
        object(anchorage, 24.99, ""),
        object(anchorage, 25.0, ", \"RESTRN\": \"7\""),
        object(berth, 25.005, ""),
    ];
    let text = format!("{{\"type\": \"FeatureCollection\", \"features\": [{}]}}", objects.join(", "));
    let objects = objects_of_geojson(&text).unwrap();
    let places = |rules: &Rules| {
        let (layer, _) = PolygonLayer::from_objects(&objects, None, rules).unwrap();
        let plane = Plane::new(25.0, 60.0).unwrap();
        let chart = Chart::new(plane, square(3000.0), &[Layer::Polygons(layer)], None).unwrap();
        chart.anchorages().map(|polygon| polygon.bounds.min[0].round()).collect::<Vec<f64>>()
    };
    // Entry into the second one is prohibited.
    assert_eq!(places(&Rules::default()), [-558.0, 279.0]);
    let avoided = BTreeMap::from([("ACHARE".to_owned(), Treatment::Avoid)]);
    assert_eq!(places(&Rules { changed: avoided, ..Rules::default() }), [279.0]);
}
