//! Real charts: they pass the checks, and grids made of them elsewhere agree with what is rasterized here.

use chart::{
    Causes, Chart, Crs, Filter, Grid, GridCell, GridDeclaration, GridKind, Layer, LayerKind, Obstacles,
    Plane, PolygonLayer, Raster, Reading,
};

use crate::support::{fixture, land, land_chart, shared, square};

fn declared(kind: GridKind, crs: &str) -> GridDeclaration {
    GridDeclaration { kind, crs: Some(Crs::new(crs).unwrap()), unit: None, open_sea: false }
}

/// The corners of a grid's cells on a plane.
struct Placed<'a> {
    grid: &'a Grid,
    corners: Vec<[f64; 2]>,
}

impl<'a> Placed<'a> {
    fn new(grid: &'a Grid, plane: &Plane) -> Self {
        let own = |k: usize, i: usize| grid.corner[k] + i as f64 * grid.cell;
        let all = (0..=grid.rows).flat_map(|j| (0..=grid.columns).map(move |i| [own(0, i), own(1, j)]));
        let place = |own| {
            let (lon, lat) = grid.crs.to_geographic(own).unwrap();
            plane.to_plane(lon, lat)
        };
        Self { grid, corners: all.map(place).collect() }
    }

    /// Points of a cell, `n` × `n` over the cell without a frame that is `inset` of its side wide.
    fn samples(&self, (i, j): (usize, usize), n: usize, inset: f64) -> Vec<[f64; 2]> {
        let corner = |a: usize, b: usize| self.corners[(j + b) * (self.grid.columns + 1) + i + a];
        let share =
            |m: usize| inset + (1.0 - 2.0 * inset) * if n == 1 { 0.5 } else { m as f64 / (n - 1) as f64 };
        let at = |m: usize| {
            let (s, t) = (share(m % n), share(m / n));
            [0, 1].map(|k: usize| {
                (1.0 - t) * ((1.0 - s) * corner(0, 0)[k] + s * corner(1, 0)[k])
                    + t * ((1.0 - s) * corner(0, 1)[k] + s * corner(1, 1)[k])
            })
        };
        (0..n * n).map(at).collect()
    }

    /// Cells away from the grid's edge that are on the raster with two cells to spare.
    fn cells(&self, raster: Raster) -> impl Iterator<Item = (usize, usize)> + '_ {
        let grid = self.grid;
        let all = (2..grid.rows - 2).flat_map(move |j| (2..grid.columns - 2).map(move |i| (i, j)));
        all.filter(move |c| self.samples(*c, 2, -2.0).iter().all(|p| raster.cell_at(*p).is_some()))
    }
}

fn blocked(obstacles: &Obstacles, p: &[f64; 2]) -> bool {
    obstacles.raster().cell_at(*p).is_none_or(|(col, row)| obstacles.is_blocked(col, row))
}

#[test]
fn the_helsinki_shoreline_is_read() {
    let layer = land(&fixture("helsinki_land_gshhg.geojson"));
    assert_eq!((layer.areas.len(), layer.marks.len()), (366, 0));
}

#[test]
fn oracle_the_helsinki_land_mask_agrees() {
    let Some(text) = shared("helsinki_landmask_25m_tm35fin.asc") else { return };
    let mask =
        Grid::from_ascii(&text, &declared(GridKind::LandMask, "EPSG:3067"), &Reading::whole()).unwrap();
    let chart = land_chart(&fixture("helsinki_land_gshhg.geojson"), 24.97, 60.13, 6000.0);
    let raster = Raster::covering(&square(4500.0), 5.0).unwrap();
    let obstacles = Obstacles::new(&chart, raster, 0.0, 0.0).unwrap();
    let [mut land, mut missed, mut water, mut extra] = [0; 4];
    let placed = Placed::new(&mask, chart.plane());
    let cells: Vec<GridCell> = mask.cells().collect();
    for cell in placed.cells(raster) {
        // The mask has land wherever a cell touches land. Our cells are 5 m: what we block inside its water
        // is within a diagonal of the cell's side.
        if cells[cell.1 * mask.columns + cell.0] == GridCell::Land {
            land += 1;
            let points = placed.samples(cell, 11, 0.0);
            missed += usize::from(!points.iter().any(|p| blocked(&obstacles, p)));
        } else {
            water += 1;
            let points = placed.samples(cell, 5, 7.2 / 25.0);
            extra += usize::from(points.iter().any(|p| blocked(&obstacles, p)));
        }
    }
    println!("{land} land cells, {missed} missed; {water} water cells, {extra} blocked");
    assert!(land > 20_000 && water > 40_000);
    assert_eq!((missed, extra), (0, 0));
}

#[test]
fn the_land_mask_as_a_chart_agrees_with_the_polygons() {
    let Some(text) = shared("helsinki_landmask_25m_tm35fin.asc") else { return };
    let mask =
        Grid::from_ascii(&text, &declared(GridKind::LandMask, "EPSG:3067"), &Reading::whole()).unwrap();
    let plane = Plane::new(24.97, 60.13).unwrap();
    let raster = Raster::covering(&square(4000.0), 25.0).unwrap();
    let by_mask = Chart::new(plane, square(4500.0), &[Layer::Grid(mask)], None).unwrap();
    let by_mask = Obstacles::new(&by_mask, raster, 0.0, 0.0).unwrap();
    let polygons = land_chart(&fixture("helsinki_land_gshhg.geojson"), 24.97, 60.13, 4500.0);
    // Every difference disappears under a margin of two cells and their diagonals.
    let near = |chart: &Chart| Obstacles::new(chart, raster, 0.0, 75.0).unwrap();
    let (by_polygons, wide) = (Obstacles::new(&polygons, raster, 0.0, 0.0).unwrap(), near(&polygons));
    let outside = by_mask.blocked().iter().zip(wide.blocked()).filter(|(m, p)| **m && !**p).count();
    let both = by_mask.blocked().iter().zip(by_polygons.blocked()).filter(|(m, p)| **m && **p).count();
    let ours = by_polygons.blocked().iter().filter(|p| **p).count();
    println!("{ours} cells blocked by polygons, {both} by both, {outside} by the mask far from any polygon");
    assert_eq!(outside, 0);
    assert!(both * 100 > ours * 90);
}

fn tacoma(text: &str, half: f64) -> Chart {
    let of = |values: &[&str]| Filter {
        property: "objl".to_owned(),
        values: values.iter().map(|v| (*v).to_owned()).collect(),
    };
    let kind = LayerKind::Depth { least: "DRVAL1".to_owned() };
    let depths = PolygonLayer::from_geojson(text, &kind, Some(&of(&["DEPARE", "DRGARE"]))).unwrap();
    let solid = of(&["LNDARE", "PONTON", "HULKES"]);
    let land = PolygonLayer::from_geojson(text, &LayerKind::Land, Some(&solid)).unwrap();
    assert_eq!(depths.areas.len() + land.areas.len(), 478);
    let plane = Plane::new(-122.43, 47.28).unwrap();
    Chart::new(plane, square(half), &[Layer::Polygons(depths), Layer::Polygons(land)], None).unwrap()
}

#[test]
fn oracle_the_tacoma_depth_grid_agrees() {
    let (Some(areas), Some(grid)) =
        (shared("US5WA22M_areas.geojson"), shared("US5WA22M_depth_25m_utm10n.asc"))
    else {
        return;
    };
    let grid = Grid::from_ascii(&grid, &declared(GridKind::Depth, "EPSG:32610"), &Reading::whole()).unwrap();
    let chart = tacoma(&areas, 3000.0);
    let raster = Raster::covering(&square(2900.0), 10.0).unwrap();
    let placed = Placed::new(&grid, chart.plane());
    let cells: Vec<GridCell> = grid.cells().collect();
    for least in [0.0, 1.8, 5.4, 9.1] {
        let obstacles = Obstacles::new(&chart, raster, least, 0.0).unwrap();
        let deep =
            |i: usize, j: usize| matches!(cells[j * grid.columns + i], GridCell::Depth(d) if d >= least);
        let [mut shoal, mut missed, mut inner, mut extra] = [0; 4];
        for (i, j) in placed.cells(raster) {
            // The grid has the least depth at the cell's centre, and no data wherever the cell touches land.
            let no_data = cells[j * grid.columns + i] == GridCell::Missing;
            let points = placed.samples((i, j), if no_data { 11 } else { 1 }, 0.0);
            let any = points.iter().any(|p| blocked(&obstacles, p));
            let around = || (i - 2..=i + 2).flat_map(|a| (j - 2..=j + 2).map(move |b| (a, b)));
            if !deep(i, j) {
                shoal += 1;
                missed += usize::from(!any);
            } else if around().all(|(a, b)| deep(a, b)) {
                inner += 1;
                extra += usize::from(any);
            }
        }
        println!("{least} m: {shoal} bad cells, {missed} missed; {inner} deep cells inside, {extra} blocked");
        assert!(shoal > 10_000 && inner > 1000);
        assert_eq!((missed, extra), (0, 0));
    }
}

#[test]
fn borders_of_the_tacoma_depth_areas_are_shared() {
    let Some(areas) = shared("US5WA22M_areas.geojson") else { return };
    let chart = tacoma(&areas, 3000.0);
    let raster = Raster::covering(&square(2900.0), 10.0).unwrap();
    let all_water = Obstacles::new(&chart, raster, -100.0, 0.0).unwrap();
    let cells = || (0..raster.nx).flat_map(|c| (0..raster.ny).map(move |r| (c, r)));
    // The whole area is charted, so a cell is uncharted only where neighbours do not share their border.
    let uncharted = cells().filter(|(c, r)| all_water.causes(*c, *r).has(Causes::UNCHARTED)).count();
    let free = cells().filter(|(c, r)| !all_water.is_blocked(*c, *r)).count();
    assert_eq!(uncharted, 0);
    assert!(free > 100_000, "{free}");
}

#[test]
fn the_turku_archipelago_passes_and_is_rasterized_whole() {
    let Some(text) = shared("turku_archipelago_land_gshhg_f.geojson") else { return };
    let layer = land(&text);
    assert_eq!(layer.areas.len(), 2148);
    let plane = Plane::new(22.1, 60.2).unwrap();
    let chart = Chart::new(plane, square(34_000.0), &[Layer::Polygons(layer)], None).unwrap();
    let raster = Raster::covering(&square(27_000.0), 100.0).unwrap();
    let obstacles = Obstacles::new(&chart, raster, 0.0, 200.0).unwrap();
    let share = obstacles.blocked().iter().filter(|b| **b).count() as f64 / (raster.nx * raster.ny) as f64;
    assert!((0.3..0.95).contains(&share), "{share}");
}
