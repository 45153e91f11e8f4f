//! Occupancy, margins and clearance against independent geometry.

use chart::{
    Bounds, Causes, Chart, Crs, Distances, Filter, Footprint, Grid, GridDeclaration, GridKind, Layer,
    LayerKind, Obstacles, Plane, PolygonLayer, Raster, Reading, Uncharted,
};
use proptest::prelude::*;

use crate::support::{self, fixture, from_polygon, inside, land, land_chart, square};

fn channel(uncharted: Option<Uncharted>, half: f64) -> Chart {
    let text = fixture("channel.geojson");
    let of = |values: &[&str]| Filter {
        property: "objl".to_owned(),
        values: values.iter().map(|v| (*v).to_owned()).collect(),
    };
    let kind = LayerKind::Depth { least: "DRVAL1".to_owned() };
    let depths = PolygonLayer::from_geojson(&text, &kind, Some(&of(&["DEPARE", "DRGARE"]))).unwrap();
    let shore = PolygonLayer::from_geojson(&text, &LayerKind::Land, Some(&of(&["LNDARE"]))).unwrap();
    let plane = Plane::new(25.0, 60.0).unwrap();
    let layers = [Layer::Polygons(depths), Layer::Polygons(shore)];
    Chart::new(plane, square(half), &layers, uncharted).unwrap()
}

fn obstacles(chart: &Chart, half: f64, cell_m: f64, depth: f64, margin: f64) -> Obstacles {
    Obstacles::new(chart, Raster::covering(&square(half), cell_m).unwrap(), depth, margin).unwrap()
}

fn causes_at(obstacles: &Obstacles, point: [f64; 2]) -> Causes {
    let (col, row) = obstacles.raster().cell_at(point).unwrap();
    obstacles.causes(col, row)
}

#[test]
fn a_channel_is_free_across_shared_borders_only_where_it_is_deep() {
    let chart = channel(None, 1000.0);
    assert_eq!(chart.uncharted(), Uncharted::Obstacle);
    let obstacles = obstacles(&chart, 990.0, 20.0, 9.0, 0.0);
    // 0.001° of latitude is 111.4 m, of longitude 55.8 m.
    assert_eq!(causes_at(&obstacles, [-500.0, -200.0]), Causes::NONE, "dredged");
    assert_eq!(causes_at(&obstacles, [-500.0, 200.0]), Causes::NONE, "deep");
    assert_eq!(causes_at(&obstacles, [-500.0, 0.0]), Causes::NONE, "on the border of both, which they share");
    assert_eq!(causes_at(&obstacles, [500.0, 200.0]), Causes::SHOAL, "unknown depth");
    assert_eq!(causes_at(&obstacles, [0.0, -700.0]), Causes::SHOAL);
    assert_eq!(causes_at(&obstacles, [0.0, 600.0]), Causes::LAND);
    assert_eq!(causes_at(&obstacles, [0.0, 960.0]), Causes::UNCHARTED);
    assert!(causes_at(&obstacles, [0.0, 445.6]).has(Causes::LAND), "shore");
    let deeper = self::obstacles(&chart, 990.0, 20.0, 11.0, 0.0);
    assert_eq!(causes_at(&deeper, [-500.0, -200.0]), Causes::SHOAL);
    assert_eq!(causes_at(&deeper, [-500.0, 200.0]), Causes::NONE);
}

#[test]
fn uncharted_places_are_obstacles_or_water_as_declared() {
    let water = channel(Some(Uncharted::Water), 2000.0);
    let obstacle = channel(Some(Uncharted::Obstacle), 2000.0);
    let at = |chart: &Chart| causes_at(&obstacles(chart, 1900.0, 20.0, 9.0, 0.0), [-1600.0, 0.0]);
    assert_eq!(at(&water), Causes::NONE);
    assert_eq!(at(&obstacle), Causes::UNCHARTED);
    let layer = [Layer::Polygons(land(&fixture("square_island.geojson")))];
    let plane = Plane::new(25.0, 60.0).unwrap();
    let refused = Chart::new(plane, square(900.0), &layer, Some(Uncharted::Obstacle)).unwrap_err();
    assert!(refused.to_string().contains("`uncharted`"));
    assert!(Chart::new(plane, square(900.0), &[], None).is_err());
}

#[test]
fn law_cells_on_no_chart_are_the_same_whatever_they_count_as() {
    let raster = Raster::covering(&square(1900.0), 20.0).unwrap();
    let [water, obstacle] = [Uncharted::Water, Uncharted::Obstacle].map(|own| channel(Some(own), 2000.0));
    let uncharted = obstacle.uncharted_cells(raster);
    assert_eq!(uncharted, water.uncharted_cells(raster));
    let obstacles = Obstacles::new(&obstacle, raster, 9.0, 0.0).unwrap();
    let cells = (0..raster.ny).flat_map(|row| (0..raster.nx).map(move |col| (col, row)));
    assert!(cells.zip(&uncharted).all(|((c, r), own)| obstacles.causes(c, r).has(Causes::UNCHARTED) == *own));
    let share = uncharted.iter().filter(|own| **own).count() as f64 / uncharted.len() as f64;
    assert!(share > 0.2 && share < 0.9, "{share}");
    let land = land_chart(&fixture("square_island.geojson"), 25.0, 60.0, 2000.0);
    assert!(land.uncharted_cells(raster).iter().all(|own| !own), "a chart of land shows water, too");
}

#[test]
fn a_grid_of_land_shows_what_it_covers() {
    let crs = Crs::new("EPSG:32635").unwrap();
    let declared =
        GridDeclaration { kind: GridKind::LandMask, crs: Some(crs.clone()), unit: None, open_sea: false };
    let text = "ncols 2\nnrows 2\nxllcorner 500000\nyllcorner 6650000\ncellsize 500\n0 0\n1 0\n";
    let grid = Grid::from_ascii(text, &declared, &Reading::whole()).unwrap();
    let (lon, lat) = crs.to_geographic([500_500.0, 6_650_500.0]).unwrap();
    let chart =
        Chart::new(Plane::new(lon, lat).unwrap(), square(1000.0), &[Layer::Grid(grid)], None).unwrap();
    let raster = Raster::covering(&square(1000.0), 10.0).unwrap();
    let uncharted = chart.uncharted_cells(raster).iter().filter(|own| **own).count() as f64;
    // 1 km of 2 km on a side, and the cells along its edge.
    assert!((uncharted / 40_000.0 - 0.75).abs() < 0.02, "{uncharted}");
}

#[test]
fn a_lake_is_water_and_beyond_the_area_nothing_is_known() {
    let chart = land_chart(&fixture("square_island.geojson"), 25.0, 60.0, 1500.0);
    assert!(!chart.has_depth());
    let obstacles = obstacles(&chart, 1600.0, 20.0, 5.0, 0.0);
    assert_eq!(causes_at(&obstacles, [100.0, 100.0]), Causes::NONE, "lake");
    assert_eq!(causes_at(&obstacles, [-100.0, 100.0]), Causes::LAND);
    assert_eq!(causes_at(&obstacles, [1000.0, 0.0]), Causes::NONE);
    assert_eq!(causes_at(&obstacles, [1550.0, 0.0]), Causes::UNCHARTED);
    assert!(obstacles.is_blocked(10_000, 0) && obstacles.causes(0, 10_000) == Causes::UNCHARTED);
    assert_eq!(obstacles.distance_m(1e9, 0.0), 0.0);
}

#[test]
fn a_grid_blocks_what_its_bad_cells_touch() {
    let crs = Crs::new("EPSG:32635").unwrap();
    let declared =
        GridDeclaration { kind: GridKind::Depth, crs: Some(crs.clone()), unit: None, open_sea: false };
    let grid = Grid::from_ascii(&fixture("depth_5x4.asc"), &declared, &Reading::whole()).unwrap();
    let (lon, lat) = crs.to_geographic([500_250.0, 6_650_200.0]).unwrap();
    let plane = Plane::new(lon, lat).unwrap();
    let chart = Chart::new(plane, square(400.0), &[Layer::Grid(grid)], None).unwrap();
    let obstacles = obstacles(&chart, 350.0, 10.0, 7.0, 0.0);
    let at = |column: f64, row: f64| {
        let (lon, lat) = crs.to_geographic([500_000.0 + 100.0 * column, 6_650_000.0 + 100.0 * row]).unwrap();
        causes_at(&obstacles, plane.to_plane(lon, lat))
    };
    assert_eq!(at(0.5, 3.5), Causes::NONE);
    assert_eq!(at(2.5, 2.5), Causes::NONE, "7 m");
    assert_eq!(at(1.0, 3.0), Causes::NONE, "between deep cells");
    assert_eq!(at(3.5, 2.5), Causes::SHOAL, "6 m");
    assert_eq!(at(3.02, 2.5), Causes::SHOAL, "touched by 6 m");
    assert_eq!(at(4.5, 3.5), Causes::UNCHARTED, "no data");
    assert_eq!(at(2.5, 0.5), Causes::SHOAL, "drying");
    assert_eq!(at(-0.5, 3.5), Causes::UNCHARTED, "off the grid");
    // The western edge is at x = −250.1 m: a scale of 0.9996 on the central meridian.
    assert_eq!(at(0.02, 3.5), Causes::NONE, "the first whole cell");
    assert_eq!(at(0.0005, 3.5), Causes::UNCHARTED, "partly off the grid");
}

#[test]
fn rasters_and_margins_that_make_no_sense_are_refused() {
    let chart = land_chart(&fixture("square_island.geojson"), 25.0, 60.0, 1500.0);
    let good = Raster::covering(&square(100.0), 10.0).unwrap();
    assert_eq!((good.nx, good.ny), (20, 20));
    for (depth, margin) in [(f64::NAN, 0.0), (0.0, f64::NAN), (0.0, -1.0), (0.0, f64::INFINITY), (0.0, 1e9)] {
        assert!(Obstacles::new(&chart, good, depth, margin).is_err(), "{depth} {margin}");
    }
    for raster in [
        Raster { nx: 0, ..good },
        Raster { cell_m: 0.0, ..good },
        Raster { cell_m: f64::NAN, ..good },
        Raster { nx: usize::MAX, ..good },
        Raster { origin: [f64::NAN, 0.0], ..good },
    ] {
        assert!(Obstacles::new(&chart, raster, 0.0, 0.0).is_err(), "{raster:?}");
    }
    assert!(Raster::covering(&square(1e6), 1e-3).is_err());
    assert!(Bounds::new([0.0, 0.0], [0.0, 1.0]).is_err());
    assert!(Bounds::new([0.0, f64::NAN], [1.0, 1.0]).is_err());
}

/// Small islands with bays, whole numbers of 10⁻⁵ degrees about 25° east, 60° north.
fn islands() -> impl Strategy<Value = Vec<Vec<[f64; 2]>>> {
    let island = (-800..800_i32, -400..400_i32, prop::collection::vec(30..300_i32, 4..12));
    prop::collection::vec(island, 1..4).prop_map(|all| {
        let ring = |(x, y, radii): (i32, i32, Vec<i32>)| {
            let n = radii.len() as f64;
            let corner = |(i, r): (usize, &i32)| {
                let (sin, cos) = (std::f64::consts::TAU * i as f64 / n).sin_cos();
                let lon = 25.0 + (f64::from(x) + f64::from(*r) * cos * 2.0).round() * 1e-5;
                [lon, 60.0 + (f64::from(y) + f64::from(*r) * sin).round() * 1e-5]
            };
            let mut ring: Vec<_> = radii.iter().enumerate().map(corner).collect();
            ring.push(ring[0]);
            ring
        };
        all.into_iter().map(ring).collect()
    })
}

fn as_geojson(rings: &[Vec<[f64; 2]>]) -> String {
    let polygons: Vec<_> = rings.iter().map(|r| vec![r]).collect();
    format!(r#"{{"type": "MultiPolygon", "coordinates": {}}}"#, serde_json::to_string(&polygons).unwrap())
}

fn on_plane(rings: &[Vec<[f64; 2]>], plane: &Plane) -> Vec<Vec<Vec<[f64; 2]>>> {
    let ring = |r: &Vec<[f64; 2]>| vec![r.iter().map(|p| plane.to_plane(p[0], p[1])).collect()];
    rings.iter().map(ring).collect()
}

/// Points of a cell, the corners included.
fn samples(raster: Raster, col: usize, row: usize, n: usize) -> Vec<[f64; 2]> {
    let step = raster.cell_m / (n - 1) as f64;
    let [x, y] = raster.node(col, row);
    (0..n * n).map(|i| [x + (i % n) as f64 * step, y + (i / n) as f64 * step]).collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(40))]

    #[test]
    fn oracle_a_cell_is_an_obstacle_when_any_part_of_it_is_land(rings in islands()) {
        let chart = land_chart(&as_geojson(&rings), 25.0, 60.0, 900.0);
        let polygons = on_plane(&rings, chart.plane());
        let obstacles = obstacles(&chart, 800.0, 40.0, 0.0, 0.0);
        let raster = obstacles.raster();
        for (col, row) in (0..raster.nx).flat_map(|c| (0..raster.ny).map(move |r| (c, r))) {
            let points = samples(raster, col, row, 9);
            if points.iter().any(|p| polygons.iter().any(|g| inside(g, *p))) {
                prop_assert!(obstacles.is_blocked(col, row), "missed {col} {row}");
            } else if obstacles.is_blocked(col, row) {
                // What the samples miss is a corner of land within half their spacing and the chord of an edge.
                let near = points.iter().flat_map(|p| polygons.iter().map(|g| from_polygon(g, *p)));
                prop_assert!(near.fold(f64::MAX, f64::min) < 40.0 / 8.0 * 0.7072 + 0.1, "blocked {col} {row}");
            }
        }
    }

    #[test]
    fn oracle_a_cell_is_free_when_all_of_it_is_charted_deep(rings in islands()) {
        let depth = format!(
            r#"{{"type": "Feature", "properties": {{"d": 20}}, "geometry": {}}}"#,
            as_geojson(&rings)
        );
        let kind = LayerKind::Depth { least: "d".to_owned() };
        let layer = PolygonLayer::from_geojson(&depth, &kind, None).unwrap();
        let plane = Plane::new(25.0, 60.0).unwrap();
        let chart = Chart::new(plane, square(900.0), &[Layer::Polygons(layer)], None).unwrap();
        let polygons = on_plane(&rings, &plane);
        let obstacles = obstacles(&chart, 800.0, 30.0, 10.0, 0.0);
        let raster = obstacles.raster();
        for (col, row) in (0..raster.nx).flat_map(|c| (0..raster.ny).map(move |r| (c, r))) {
            let points = samples(raster, col, row, 9);
            let outside = points.iter().any(|p| polygons.iter().all(|g| from_polygon(g, *p) > 0.1));
            prop_assert!(!outside || obstacles.is_blocked(col, row), "part of {col} {row} is not charted");
            if polygons.len() == 1 && !outside && obstacles.is_blocked(col, row) {
                // One area: what the samples miss is within half their spacing of its border.
                let ring = &polygons[0][0];
                let from_border = |p: &[f64; 2]| {
                    ring.windows(2).map(|w| support::from_segment(*p, w[0], w[1])).fold(f64::MAX, f64::min)
                };
                let near = points.iter().map(from_border).fold(f64::MAX, f64::min);
                prop_assert!(near < 30.0 / 8.0 * 0.7072 + 0.1, "blocked {col} {row}: {near}");
            }
        }
    }

    #[test]
    fn oracle_margin_and_clearance_are_gaps_between_cells(rings in islands(), margin in 0.0..300.0_f64) {
        let chart = land_chart(&as_geojson(&rings), 25.0, 60.0, 1300.0);
        let obstacles = obstacles(&chart, 600.0, 50.0, 0.0, margin);
        let wide = self::obstacles(&chart, 1000.0, 50.0, 0.0, 0.0);
        let (small, large) = (obstacles.raster(), wide.raster());
        let set: Vec<_> = (0..large.nx)
            .flat_map(|c| (0..large.ny).map(move |r| (c, r)))
            .filter(|(c, r)| wide.is_blocked(*c, *r))
            .collect();
        let pad = (margin / 50.0).ceil() + 1.0;
        for (col, row) in (0..small.nx).flat_map(|c| (0..small.ny).map(move |r| (c, r))) {
            let own = [col as f64 + 8.0, row as f64 + 8.0];
            let gap = |(c, r): &(usize, usize)| {
                let d = [(*c as f64 - own[0]).abs(), (*r as f64 - own[1]).abs()];
                50.0 * (d[0] - 1.0).max(0.0).hypot((d[1] - 1.0).max(0.0))
            };
            let truth = set.iter().map(gap).fold(f64::INFINITY, f64::min);
            let is_obstacle = wide.is_blocked(col + 8, row + 8);
            prop_assert_eq!(obstacles.is_blocked(col, row), is_obstacle || truth < margin);
            let edge = col.min(row).min(small.nx - 1 - col).min(small.ny - 1 - row) as f64 + pad;
            let [x, y] = small.node(col, row);
            let found = obstacles.distance_m(x + 25.0, y + 25.0);
            let expected = if is_obstacle { 0.0 } else { truth.min(edge * 50.0) };
            prop_assert!((found - expected).abs() < 1e-3 && found <= expected, "{found} {expected}");
        }
    }

    #[test]
    fn law_distances_between_cells_join_those_at_their_centres(
        rings in islands(),
        place in [-620.0..620.0_f64, -620.0..620.0_f64],
        course in 0.0..6.3_f64,
    ) {
        let chart = land_chart(&as_geojson(&rings), 25.0, 60.0, 1300.0);
        let raster = Raster::covering(&square(600.0), 50.0).unwrap();
        let distances = Distances::new(&chart, raster, [0.0, 400.0], &|| true).unwrap().unwrap();
        let [x, y] = place;
        let (own, between) = (distances.distance_m(x, y), distances.between_cells_m(x, y));
        let Some((col, row)) = raster.cell_at(place) else {
            prop_assert_eq!(between, 0.0);
            return Ok(());
        };
        let [west, south] = raster.node(col, row);
        prop_assert!((distances.between_cells_m(west + 25.0, south + 25.0) - own).abs() < 1e-9);
        prop_assert!((between - own).abs() <= 50.0 * 2.0_f64.sqrt() + 1e-3, "{between} {own}");
        // No faster than the distance itself may change along both axes.
        let next = [x + 0.5 * course.cos(), y + 0.5 * course.sin()];
        if raster.cell_at(next).is_some() {
            let change = distances.between_cells_m(next[0], next[1]) - between;
            prop_assert!(change.abs() <= 0.5 * 2.0_f64.sqrt() + 1e-3, "{change}");
        }
    }

    #[test]
    fn law_free_cells_keep_the_margin_to_the_shore(rings in islands(), margin in 0.0..200.0_f64) {
        let chart = land_chart(&as_geojson(&rings), 25.0, 60.0, 1300.0);
        let polygons = on_plane(&rings, chart.plane());
        let obstacles = obstacles(&chart, 800.0, 50.0, 0.0, margin);
        let raster = obstacles.raster();
        for (col, row) in (0..raster.nx).flat_map(|c| (0..raster.ny).map(move |r| (c, r))) {
            let cell = samples(raster, col, row, 2);
            let from_shore = |p: &[f64; 2]| polygons.iter().map(|g| from_polygon(g, *p)).fold(f64::MAX, f64::min);
            let least = cell.iter().map(from_shore).fold(f64::MAX, f64::min);
            let [x, y] = cell[0];
            prop_assert!(obstacles.distance_m(x + 25.0, y + 25.0) <= least + 0.1);
            prop_assert!(obstacles.is_blocked(col, row) || least >= margin - 0.1, "{least} {margin}");
        }
    }

    #[test]
    fn law_more_margin_and_more_depth_only_add_obstacles(
        a in 0.0..200.0_f64, b in 0.0..200.0_f64, shallow in 0.0..15.0_f64, deep in 0.0..15.0_f64,
    ) {
        let chart = channel(None, 1200.0);
        let transit = obstacles(&chart, 1000.0, 30.0, shallow.min(deep), a.min(b));
        let trial = obstacles(&chart, 1000.0, 30.0, shallow.max(deep), a.max(b));
        let nested = transit.blocked().iter().zip(trial.blocked()).all(|(t, u)| *u || !*t);
        prop_assert!(nested);
    }

    #[test]
    fn oracle_a_footprint_is_free_where_all_its_cells_are(
        rings in islands(), turn in -3.0..3.0_f64, way in 0.0..400.0_f64, nodes in prop::collection::vec((0..40_usize, 0..40_usize), 60),
    ) {
        let chart = land_chart(&as_geojson(&rings), 25.0, 60.0, 1300.0);
        let obstacles = obstacles(&chart, 500.0, 25.0, 0.0, 30.0);
        let hull = [[40.0, 0.0], [20.0, 9.0], [-40.0, 9.0], [-40.0, -9.0], [20.0, -9.0]];
        let footprint = Footprint::swept(&hull, &[(0.0, 0.0, 0.3), (way, way / 2.0, 0.3 + turn)], 25.0).unwrap();
        for (col, row) in nodes {
            let free = footprint.runs().iter().all(|run| {
                (run.first..=run.last).all(|c| {
                    let (c, r) = (col as i64 + i64::from(c), row as i64 + i64::from(run.row));
                    c >= 0 && r >= 0 && !obstacles.is_blocked(c as usize, r as usize)
                })
            });
            prop_assert_eq!(obstacles.is_free(&footprint, col, row), free);
        }
        let other = Footprint::swept(&hull, &[(0.0, 0.0, 0.0)], 20.0).unwrap();
        prop_assert!(!obstacles.is_free(&other, 20, 20), "another cell size");
        prop_assert!(!obstacles.is_free(&footprint, usize::MAX, 0));
    }
}

#[test]
fn long_edges_follow_the_parallel_of_the_file() {
    // At 60° the ends of a parallel 0.6° long are 38 m north of its middle on the plane.
    let north = r#"{"type": "Polygon", "coordinates": [[[24.7, 60], [25.3, 60], [25.3, 60.1], [24.7, 60.1], [24.7, 60]]]}"#;
    let obstacles = obstacles(&land_chart(north, 25.0, 60.0, 700.0), 600.0, 5.0, 0.0, 0.0);
    for x in [-500.0, 0.0, 500.0] {
        assert_eq!(causes_at(&obstacles, [x, 7.0]), Causes::LAND);
        assert_eq!(causes_at(&obstacles, [x, -7.0]), Causes::NONE);
    }
}

#[test]
fn layers_made_by_hand_are_checked() {
    let plane = Plane::new(25.0, 60.0).unwrap();
    let mut layer = land(&fixture("square_island.geojson"));
    layer.areas[0].rings[0][0][1] = 91.0;
    assert!(Chart::new(plane, square(900.0), &[Layer::Polygons(layer)], None).is_err());
    let crs = Crs::new("EPSG:32635").unwrap();
    let declared = GridDeclaration { kind: GridKind::Depth, crs: Some(crs), unit: None, open_sea: false };
    let mut grid = Grid::from_ascii(&fixture("depth_5x4.asc"), &declared, &Reading::whole()).unwrap();
    grid.rows -= 1;
    assert!(Chart::new(plane, square(900.0), &[Layer::Grid(grid)], None).is_err());
}

#[test]
fn drawn_polygons_are_cut_to_the_box() {
    let chart = land_chart(&fixture("square_island.geojson"), 25.0, 60.0, 1500.0);
    let bounds = Bounds::new([0.0, -300.0], [300.0, 300.0]).unwrap();
    let drawn = chart.drawn(&bounds);
    assert_eq!(drawn.len(), 1);
    assert_eq!(drawn[0].rings.len(), 2, "the lake is kept");
    let area = |r: &Vec<[f64; 2]>| {
        (0..r.len())
            .map(|i| r[i][0] * r[(i + 1) % r.len()][1] - r[(i + 1) % r.len()][0] * r[i][1])
            .sum::<f64>()
            / 2.0
    };
    // The box is inside the island; the lake is 0.002° × 0.004°.
    assert!((area(&drawn[0].rings[0]) - 300.0 * 600.0).abs() < 1.0);
    assert!((area(&drawn[0].rings[1]) + 222.8 * 223.1).abs() < 100.0, "{}", area(&drawn[0].rings[1]));
    assert!(chart.drawn(&Bounds::new([1200.0, 0.0], [1300.0, 100.0]).unwrap()).is_empty());
}

/// An island across the antimeridian, cut there as RFC 7946 has it, and one whose edges cross it uncut.
#[test]
fn islands_across_the_antimeridian_are_where_they_are() {
    let cut = r#"{"type": "MultiPolygon", "coordinates": [
        [[[179.99, -18.0], [180.0, -18.0], [180.0, -17.99], [179.99, -17.99], [179.99, -18.0]]],
        [[[-180.0, -18.0], [-179.99, -18.0], [-179.99, -17.99], [-180.0, -17.99], [-180.0, -18.0]]]]}"#;
    let uncut = r#"{"type": "Polygon", "coordinates":
        [[[179.99, -18.0], [-179.99, -18.0], [-179.99, -17.99], [179.99, -17.99], [179.99, -18.0]]]}"#;
    for text in [cut, uncut] {
        let chart = land_chart(text, 180.0, -18.0, 6000.0);
        let obstacles =
            Obstacles::new(&chart, Raster::covering(&square(5000.0), 25.0).unwrap(), 0.0, 0.0).unwrap();
        let is_land = |lon: f64, lat: f64| {
            let (col, row) = obstacles.raster().cell_at(chart.plane().to_plane(lon, lat)).unwrap();
            obstacles.causes(col, row) == Causes::LAND
        };
        for (lon, land) in [(179.985, false), (179.995, true), (-179.995, true), (-179.985, false)] {
            assert_eq!(is_land(lon, -17.995), land, "{lon} of {text}");
        }
    }
}
