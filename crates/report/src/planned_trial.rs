//! A planned trial with its drawing.

use files::{Digest, Error, Work, budget, exists, read};
use refusal::Invalid;
use study::documents::{
    MapArea, MapCellClass, MapCells, MapClass, MapContour, MapDocument, MapFrame, MapLine, MapMargin,
    MapPlace, MapRaster, MapRuns, MapSpot, MapTrack, MapTrackKind, PlanDocument,
};

use crate::figures::map as figure;
use crate::loader::{Loader, document_at};

/// Approximate bytes per cell of a map while it is drawn.
const CELL_BYTES: f64 = 24.0;

/// A plan with its map.
#[derive(Clone, Debug)]
pub struct PlannedTrial {
    /// Name of its folder, `plan-4-headings`; empty for the study's own plan.
    pub name: String,
    /// `plan.json`.
    pub plan: PlanDocument,
    /// The map: drawn from `map.json`, or `map.svg`, free of scripts and links.
    pub map: Option<String>,
    /// What `map.json` has; absent beside a plan without one.
    pub document: Option<MapDocument>,
    /// Files of this study that differ from those that the plan was made from.
    pub stale: Vec<String>,
}

/// The map `name` of the results, drawn from its document, else read as a drawing, and notes the file; `None` if
/// there is neither. The document comes with it.
pub(crate) fn map(loader: &mut Loader, name: &str) -> Result<(Option<String>, Option<MapDocument>), Error> {
    let (drawn, document) = drawn(loader, &format!("{name}.json"))?.unzip();
    let name = format!("{name}.svg");
    let path = loader.sources.results.join(&name);
    if !exists(&path) {
        return Ok((drawn, document));
    }
    let bytes = read(&path)?;
    loader.note(&name, "map of the plan", Digest::of_bytes(&bytes));
    if drawn.is_some() {
        return Ok((drawn, document));
    }
    let text = String::from_utf8(bytes).map_err(|_| "bytes that are not UTF-8".to_owned());
    let checked = text.and_then(|text| refused(&text).map_or(Ok(text), Err));
    let svg = checked.map_err(|fault| {
        let expected = "a drawing of shapes and text, without scripts, styles or links";
        study::refuse(&path, "map", &fault, expected, "run `plan` again, or remove the file")
    })?;
    Ok((Some(svg), None))
}

/// Draws the document `name`, and notes the file; `None` if there is no such file.
fn drawn(loader: &mut Loader, name: &str) -> Result<Option<(String, MapDocument)>, Error> {
    let path = loader.sources.results.join(name);
    let Some(loaded) = document_at::<MapDocument>(path.clone())? else { return Ok(None) };
    let cells = loaded.data.raster_cells();
    let (size, remedy) = (format!("{cells} cells"), "run `plan` again with a coarser raster");
    let work = Work { file: &path, thing: "`raster`", found: &size, remedy };
    budget().memory(work, CELL_BYTES * cells)?;
    let svg = plan_map(&loaded.data).map_err(|invalid| Error::invalid(&path, invalid))?;
    loader.note(name, "what the map of the plan shows", loaded.digest);
    Ok(Some((svg, loaded.data)))
}

// `map.svg` comes from a file and is put on the page unchanged, so it may contain only shapes and text.

/// The allowed elements of a map: those that this crate writes.
const ELEMENTS: [&str; 8] = ["svg", "g", "title", "desc", "path", "rect", "circle", "text"];
/// The allowed attributes: none of them loads, links, runs or names anything.
const ATTRIBUTES: &str = "aria-label cx cy d dy fill fill-opacity font-family font-size font-weight height r role stroke \
     stroke-dasharray stroke-linecap stroke-linejoin stroke-opacity stroke-width text-anchor transform viewBox width x y";
const NAMESPACE: &str = "http://www.w3.org/2000/svg";

/// The reason to refuse `svg`; `None` if it is one plain drawing with balanced tags.
fn refused(svg: &str) -> Option<String> {
    if !svg.starts_with("<svg ") || !svg.trim_end().ends_with("</svg>") {
        return Some("text that is not one <svg> element".to_owned());
    }
    let mut open: Vec<&str> = Vec::new();
    for (index, piece) in svg.split('<').skip(1).enumerate() {
        if index > 0 && open.is_empty() {
            return Some("more than one element".to_owned());
        }
        let tag = piece.split_once('>').map(|(tag, _)| tag);
        let step = tag.map_or(Err("a tag that is not closed".to_owned()), |tag| enter(tag, &mut open));
        if let Err(fault) = step {
            return Some(fault);
        }
    }
    open.last().map(|name| format!("<{name}> without its end"))
}

/// Processes one tag.
fn enter<'a>(tag: &'a str, open: &mut Vec<&'a str>) -> Result<(), String> {
    if let Some(name) = tag.strip_prefix('/') {
        return if open.pop() == Some(name) { Ok(()) } else { Err(format!("</{name}> out of place")) };
    }
    let (tag, closed) = tag.strip_suffix('/').map_or((tag, false), |tag| (tag, true));
    let (name, attributes) = tag.split_once(' ').unwrap_or((tag, ""));
    if !ELEMENTS.contains(&name) {
        return Err(format!("<{name}>"));
    }
    check(attributes).map_err(|fault| format!("{fault} in <{name}>"))?;
    open.extend((!closed).then_some(name));
    Ok(())
}

fn check(attributes: &str) -> Result<(), String> {
    let mut rest = attributes.trim();
    while !rest.is_empty() {
        let parts = rest.split_once("=\"").and_then(|(name, after)| Some((name, after.split_once('"')?)));
        let Some((name, (value, after))) = parts else {
            return Err("an attribute without quotes".to_owned());
        };
        let known =
            ATTRIBUTES.split(' ').any(|known| known == name) || (name == "xmlns" && value == NAMESPACE);
        if !known || value.to_ascii_lowercase().contains("url(") {
            return Err(format!("the attribute `{name}=\"{value}\"`"));
        }
        if !after.is_empty() && !after.starts_with(' ') {
            return Err("attributes that touch".to_owned());
        }
        rest = after.trim_start();
    }
    Ok(())
}

/// The map as SVG.
///
/// # Errors
/// Those of [`figure::map_figure`].
pub fn plan_map(document: &MapDocument) -> Result<String, Invalid> {
    figure::map_figure(&figure_of(document))
}

fn figure_of(document: &MapDocument) -> figure::Map {
    let MapFrame { west_m: west, south_m: south, east_m: east, north_m: north, .. } = document.frame;
    let names: Vec<&String> = document.counts.keys().collect();
    let contour =
        |contour: &MapContour| figure::Contour { depth_m: contour.depth_m, line: points(&contour.line) };
    let (meridians, parallels) = (document.meridians.iter(), document.parallels.iter());
    figure::Map {
        title: if document.safe { "Planned trial" } else { "Planned trial, unsafe" }.to_owned(),
        description: document.statement.clone(),
        warning: (!document.safe).then(|| "Unsafe: the plan fails its own check".to_owned()),
        frame: figure::Frame { west, south, east, north },
        uncharted: !document.uncharted_is_water,
        depth_limits_m: document.depth_limits_m.clone(),
        cells: document.cells.as_ref().map(cells),
        areas: document.areas.iter().filter_map(area).collect(),
        contours: document.contours.iter().map(contour).collect(),
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
        tracks: document.tracks.iter().map(|line| track(line, &names)).collect(),
        aborts: document.aborts.iter().map(points).collect(),
        hulls: document.hulls.iter().map(points).collect(),
        start: document.start.map(place),
        goal: document.goal.map(place),
        graticule: figure::Graticule {
            x: meridians.map(|line| (line.east_m, label(line.longitude_deg, ["E", "W"]))).collect(),
            y: parallels.map(|line| (line.north_m, label(line.latitude_deg, ["N", "S"]))).collect(),
        },
    }
}

fn place(place: MapPlace) -> [f64; 2] {
    [place.east_m, place.north_m]
}

fn points(line: &MapLine) -> Vec<[f64; 2]> {
    line.east_m.iter().zip(&line.north_m).map(|(east, north)| [*east, *north]).collect()
}

fn raster(raster: &MapRaster) -> figure::Raster {
    let [nx, ny] = [raster.columns, raster.rows].map(|count| count as usize);
    figure::Raster { origin: [raster.west_m, raster.south_m], cell_m: raster.cell_m, nx, ny }
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

fn cells(map: &MapCells) -> figure::Cells {
    let grid = raster(&map.raster);
    let mut classes = vec![None; grid.nx * grid.ny];
    for MapCellClass { class: name, least_m, runs } in &map.classes {
        let cells = classes.iter_mut().zip(set(runs)).filter(|(_, is_in)| *is_in);
        cells.for_each(|(cell, _)| *cell = class(*name, *least_m));
    }
    figure::Cells { grid, classes }
}

fn area(area: &MapArea) -> Option<figure::ChartedArea> {
    let mut rings = area.rings.iter().map(points);
    Some(figure::ChartedArea {
        class: class(area.class, area.least_m)?,
        ring: rings.next()?,
        holes: rings.collect(),
    })
}

fn margin(margin: &MapMargin) -> figure::Margin {
    let MapMargin { purpose, raster: grid, runs } = margin;
    figure::Margin { purpose: *purpose, grid: raster(grid), blocked: set(runs) }
}

fn spot(spot: &MapSpot) -> figure::Spot {
    let MapSpot { symbol, depth_m, .. } = *spot;
    figure::Spot { at: place(spot.place), symbol, depth_m, title: spot.title.clone() }
}

/// A track in the colour of its maneuver among `names`.
fn track(track: &MapTrack, names: &[&String]) -> figure::PlottedTrack {
    let maneuver = names.iter().position(|name| track.maneuver.as_ref() == Some(name));
    let style = match (track.kind, maneuver) {
        (MapTrackKind::Maneuver, Some(maneuver)) => figure::TrackStyle::Maneuver(maneuver),
        (MapTrackKind::RunIn, _) => figure::TrackStyle::RunIn,
        _ => figure::TrackStyle::Basic,
    };
    figure::PlottedTrack { style, points: points(&track.line), number: track.number }
}

/// Degrees and minutes to a tenth.
pub(crate) fn label(degrees: f64, names: [&str; 2]) -> String {
    let minutes = (degrees.abs() * 600.0).round() / 10.0;
    let (whole, rest) = ((minutes / 60.0).floor(), minutes % 60.0);
    format!("{whole:.0}° {rest:.1}′ {}", names[usize::from(degrees < 0.0)])
}
