//! `map.svg`: the plan on its chart, from `map.json`.

use refusal::Invalid;
use study::documents::{
    MapArea, MapCellClass, MapCells, MapClass, MapDocument, MapLine, MapMargin, MapPlace, MapPurpose,
    MapRaster, MapRuns, MapSpot, MapSymbol, MapTrack, MapTrackKind,
};

use crate::figures::map as figure;

/// The map as SVG.
///
/// # Errors
/// Those of [`figure::map_figure`].
pub fn plan_map(document: &MapDocument) -> Result<String, Invalid> {
    figure::map_figure(&map(document))
}

fn map(document: &MapDocument) -> figure::Map {
    let own = document.frame;
    let names: Vec<&String> = document.counts.keys().collect();
    figure::Map {
        title: if document.safe { "Planned trial" } else { "Planned trial, unsafe" }.to_owned(),
        description: document.statement.clone(),
        warning: (!document.safe).then(|| "Unsafe: the plan fails its own check".to_owned()),
        frame: figure::Frame { west: own.west_m, south: own.south_m, east: own.east_m, north: own.north_m },
        uncharted: !document.uncharted_is_water,
        depth_limits_m: document.depth_limits_m.clone(),
        cells: document.cells.as_ref().map(cells),
        areas: document.areas.iter().filter_map(area).collect(),
        contours: document
            .contours
            .iter()
            .map(|contour| figure::Contour { depth_m: contour.depth_m, line: points(&contour.line) })
            .collect(),
        margins: document.margins.iter().map(margin).collect(),
        maneuvers: document.counts.iter().map(|(name, count)| (name.clone(), *count)).collect(),
        spots: document.spots.iter().map(spot).collect(),
        names: document.names.iter().map(|name| (place(name.place), name.name.clone())).collect(),
        tube: document.swept.as_ref().map(|swept| figure::Tube {
            grid: raster(&swept.raster),
            swept: set(&swept.runs),
            vessels: swept.vessels,
        }),
        corridors: document.corridors.iter().map(points).collect(),
        edge: document.edge.as_ref().map(points).unwrap_or_default(),
        speed_limits: document.speed_limits.iter().map(points).collect(),
        tracks: document.tracks.iter().map(|own| track(own, &names)).collect(),
        hulls: document.hulls.iter().map(points).collect(),
        start: document.start.map(place),
        goal: document.goal.map(place),
        graticule: figure::Graticule {
            x: document
                .meridians
                .iter()
                .map(|meridian| (meridian.east_m, label(meridian.longitude_deg, ["E", "W"])))
                .collect(),
            y: document
                .parallels
                .iter()
                .map(|parallel| (parallel.north_m, label(parallel.latitude_deg, ["N", "S"])))
                .collect(),
        },
    }
}

fn place(own: MapPlace) -> [f64; 2] {
    [own.east_m, own.north_m]
}

fn points(line: &MapLine) -> Vec<[f64; 2]> {
    line.east_m.iter().zip(&line.north_m).map(|(east, north)| [*east, *north]).collect()
}

fn raster(map_raster: &MapRaster) -> figure::Raster {
    let [nx, ny] = [map_raster.columns, map_raster.rows].map(|count| count as usize);
    figure::Raster { origin: [map_raster.west_m, map_raster.south_m], cell_m: map_raster.cell_m, nx, ny }
}

/// For each cell whether it is in the set.
fn set(runs: &MapRuns) -> Vec<bool> {
    let runs = runs.0.iter().enumerate();
    runs.flat_map(|(index, run)| std::iter::repeat_n(index % 2 == 1, *run as usize)).collect()
}

fn class(class: MapClass, least_m: Option<f64>) -> Option<figure::Class> {
    match class {
        MapClass::Land => Some(figure::Class::Land),
        MapClass::NoGo => Some(figure::Class::NoGo),
        MapClass::Depth => Some(figure::Class::Depth { least_m: least_m? }),
    }
}

fn cells(map_cells: &MapCells) -> figure::Cells {
    let grid = raster(&map_cells.raster);
    let mut classes = vec![None; grid.nx * grid.ny];
    for MapCellClass { class: name, least_m, runs } in &map_cells.classes {
        let cells = classes.iter_mut().zip(set(runs)).filter(|(_, is_in)| *is_in);
        cells.for_each(|(cell, _)| *cell = class(*name, *least_m));
    }
    figure::Cells { grid, classes }
}

fn area(map_area: &MapArea) -> Option<figure::Area> {
    let mut rings = map_area.rings.iter().map(points);
    Some(figure::Area {
        class: class(map_area.class, map_area.least_m)?,
        ring: rings.next()?,
        holes: rings.collect(),
    })
}

fn margin(map_margin: &MapMargin) -> figure::Margin {
    let purpose = match map_margin.purpose {
        MapPurpose::Trial => figure::Purpose::Trial,
        MapPurpose::Transit => figure::Purpose::Transit,
    };
    figure::Margin { purpose, grid: raster(&map_margin.raster), blocked: set(&map_margin.runs) }
}

fn spot(map_spot: &MapSpot) -> figure::Spot {
    let symbol = match map_spot.symbol {
        MapSymbol::Sounding => figure::Symbol::Sounding,
        MapSymbol::Danger => figure::Symbol::Danger,
    };
    figure::Spot {
        at: place(map_spot.place),
        symbol,
        depth_m: map_spot.depth_m,
        title: map_spot.title.clone(),
    }
}

/// A track in the colour of its maneuver among `names`.
fn track(own: &MapTrack, names: &[&String]) -> figure::Track {
    let maneuver = names.iter().position(|name| own.maneuver.as_ref() == Some(name));
    let style = match (own.kind, maneuver) {
        (MapTrackKind::Maneuver, Some(maneuver)) => figure::TrackStyle::Maneuver(maneuver),
        (MapTrackKind::RunIn, _) => figure::TrackStyle::RunIn,
        _ => figure::TrackStyle::Basic,
    };
    figure::Track { style, points: points(&own.line), number: own.number }
}

/// Degrees and minutes to a tenth.
pub(crate) fn label(degrees: f64, names: [&str; 2]) -> String {
    let minutes = (degrees.abs() * 600.0).round() / 10.0;
    let (whole, rest) = ((minutes / 60.0).floor(), minutes % 60.0);
    format!("{whole:.0}° {rest:.1}′ {}", names[usize::from(degrees < 0.0)])
}
