//! Times of loading charts and finding obstacles: `cargo run --release -p chart --example chart_times --
//! <folder of charts>`.

use std::path::Path;
use std::time::Instant;

use chart::{
    Bounds, Chart, Crs, Filter, Footprint, Grid, GridDeclaration, GridKind, Layer, LayerKind, Obstacles,
    Plane, PolygonLayer, Raster, Reading,
};

type Failure = Box<dyn std::error::Error>;

fn main() -> Result<(), Failure> {
    let folder = std::env::args().nth(1).ok_or("name the folder of charts")?;
    let folder = Path::new(&folder);
    land(&folder.join("helsinki_land_gshhg_f.geojson"), (24.97, 60.13), [5000.0, 5000.0], 25.0)?;
    land(&folder.join("turku_archipelago_land_gshhg_f.geojson"), (22.1, 60.2), [28000.0, 33500.0], 50.0)?;
    tacoma(folder)?;
    footprint()?;
    Ok(())
}

fn land(path: &Path, origin: (f64, f64), half: [f64; 2], cell_m: f64) -> Result<(), Failure> {
    let text = std::fs::read_to_string(path)?;
    let load = || -> Result<Chart, Failure> {
        let layer = PolygonLayer::from_geojson(&text, &LayerKind::Land, None)?;
        let area = Bounds::new(half.map(|v| -v - 200.0), half.map(|v| v + 200.0))?;
        Ok(Chart::new(Plane::new(origin.0, origin.1)?, area, &[Layer::Polygons(layer)], None)?)
    };
    report(path, &load, half, cell_m)
}

fn tacoma(folder: &Path) -> Result<(), Failure> {
    let origin = (-122.43, 47.28);
    let half = [3000.0, 3000.0];
    let area = Bounds::new(half.map(|v| -v - 200.0), half.map(|v| v + 200.0))?;
    let path = folder.join("US5WA22M_areas.geojson");
    let text = std::fs::read_to_string(&path)?;
    let load = || -> Result<Chart, Failure> {
        let of = |values: &[&str]| Filter {
            property: "objl".to_owned(),
            values: values.iter().map(|v| (*v).to_owned()).collect(),
        };
        let depth = LayerKind::Depth { least: "DRVAL1".to_owned() };
        let depths = PolygonLayer::from_geojson(&text, &depth, Some(&of(&["DEPARE", "DRGARE"])))?;
        let solid = of(&["LNDARE", "PONTON", "HULKES"]);
        let land = PolygonLayer::from_geojson(&text, &LayerKind::Land, Some(&solid))?;
        let layers = [Layer::Polygons(depths), Layer::Polygons(land)];
        Ok(Chart::new(Plane::new(origin.0, origin.1)?, area, &layers, None)?)
    };
    report(&path, &load, half, 25.0)?;
    let path = folder.join("US5WA22M_depth_25m_utm10n.asc");
    let text = std::fs::read_to_string(&path)?;
    let load = || -> Result<Chart, Failure> {
        let declared = GridDeclaration {
            kind: GridKind::Depth,
            crs: Some(Crs::new("EPSG:32610")?),
            unit: None,
            open_sea: false,
        };
        let grid = Grid::from_ascii(&text, &declared, &Reading::whole())?;
        Ok(Chart::new(Plane::new(origin.0, origin.1)?, area, &[Layer::Grid(grid)], None)?)
    };
    report(&path, &load, half, 25.0)
}

fn report(
    path: &Path,
    load: &dyn Fn() -> Result<Chart, Failure>,
    half: [f64; 2],
    cell_m: f64,
) -> Result<(), Failure> {
    let start = Instant::now();
    let chart = load()?;
    let loaded = start.elapsed();
    let raster = Raster::covering(&Bounds::new(half.map(|v| -v), half)?, cell_m)?;
    let start = Instant::now();
    let obstacles = Obstacles::new(&chart, raster, 3.0, 100.0)?;
    let found = start.elapsed();
    let cells = raster.nx * raster.ny;
    let blocked = obstacles.blocked().iter().filter(|b| **b).count();
    println!(
        "{}: {} polygons kept, read and placed in {:.1} ms; {} × {} cells in {:.1} ms, {:.1} % blocked",
        path.file_name().unwrap_or_default().to_string_lossy(),
        chart.polygons().len(),
        loaded.as_secs_f64() * 1e3,
        raster.nx,
        raster.ny,
        found.as_secs_f64() * 1e3,
        100.0 * blocked as f64 / cells as f64
    );
    Ok(())
}

fn footprint() -> Result<(), Failure> {
    let hull = [[60.0, 0.0], [40.0, 10.0], [-60.0, 10.0], [-60.0, -10.0], [40.0, -10.0]];
    let pose = |i: u32| {
        let t = f64::from(i) / 300.0;
        (500.0 * t, 800.0 * t * t, 1.5 * t)
    };
    let poses: Vec<_> = (0..=300).map(pose).collect();
    let start = Instant::now();
    let footprint = Footprint::swept(&hull, &poses, 25.0)?;
    let time = start.elapsed();
    println!(
        "footprint of 301 poses at 25 m: {} runs in {:.2} ms",
        footprint.runs().len(),
        time.as_secs_f64() * 1e3
    );
    Ok(())
}
