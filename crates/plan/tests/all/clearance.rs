//! Clearance of the hull from charted obstacles.

use chart::{Bounds, Chart, Distances, Layer, LayerKind, Plane, PolygonLayer, Raster};
use plan::voyage::Clearance;
use ship::engine::{Pose, Streams};

/// A ship of 20 m and an island next to a square of 800 m, with a chart that extends to 700 m.
fn around_an_island() -> Clearance {
    let island = r#"{"type": "Polygon", "coordinates": [[[0.001, 0.001], [0.002, 0.001], [0.002, 0.003], [0.001, 0.001]]]}"#;
    let land = PolygonLayer::from_geojson(island, &LayerKind::Land, None).unwrap();
    let square = |half: f64| Bounds { min: [-half; 2], max: [half; 2] };
    let plane = Plane::new(0.0, 0.0).unwrap();
    let chart = Chart::new(plane, square(2000.0), &[Layer::Polygons(land)], None).unwrap();
    let raster = Raster::covering(&square(700.0), 10.0).unwrap();
    let sight_m = 300.0;
    let transit = Distances::in_transit(&chart, raster, [5.0, sight_m], &|| true).unwrap().unwrap();
    let outline = vec![[10.0, 0.0], [8.0, 3.0], [-10.0, 3.0], [-10.0, -3.0], [8.0, -3.0]];
    let radius_m = libm::hypot(10.0, 3.0);
    Clearance { outline, radius_m, transit, trial: None, area: square(400.0), polygon: None, sight_m }
}

#[test]
fn law_what_is_passed_over_would_have_changed_nothing() {
    let clearance = around_an_island();
    let mut counts = [0; 4];
    for track in 0..400 {
        let mut drawn = [0.0; 803];
        Streams::new(1, "tracks").normals(track, 0, &mut drawn);
        let [x, y, psi, turns @ ..] = drawn;
        let mut pose = Pose { x: 200.0 * x, y: 200.0 * y, psi: 3.0 * psi };
        let (mut passage, mut least, mut left) = (clearance.open(), clearance.sight_m, false);
        let (mut compared, mut between) = (clearance.open_to_compare(), clearance.sight_m);
        for turn in turns.into_iter().take(2 * track as usize) {
            pose.psi += 0.05 * turn;
            let (sin, cos) = libm::sincos(pose.psi);
            (pose.x, pose.y) = (pose.x + 2.0 * cos, pose.y + 2.0 * sin);
            clearance.add(&mut passage, pose, false);
            clearance.add(&mut compared, pose, false);
            for [x, y] in &clearance.outline {
                let place = [pose.y + x * sin + y * cos, pose.x + x * cos - y * sin];
                least = clearance.transit.distance_m(place[0], place[1]).min(least);
                between = clearance.transit.between_cells_m(place[0], place[1]).min(between);
                left |= !clearance.area.contains(place);
            }
        }
        assert_eq!((passage.clearance_m, passage.left_area), (least, left), "{track}");
        assert_eq!((compared.clearance_m, compared.left_area), (least, left), "{track}");
        assert_eq!((passage.between_cells_m, compared.between_cells_m), (None, Some(between)), "{track}");
        let beyond = !clearance.transit.raster().bounds().contains([pose.y, pose.x]);
        assert!(!beyond || least == 0.0, "{track}: {least}");
        [!left, left, beyond, least == 0.0].iter().zip(&mut counts).for_each(|(is, n)| *n += u32::from(*is));
    }
    assert!(counts.iter().all(|n| *n > 40), "{counts:?}");
}
