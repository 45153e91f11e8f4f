//! A chart with a planned or simulated trial on it. Coordinates in metres, x east, y north.
//!
//! The map is independent of ships and projections: it draws polygons, cells, lines and marks in a frame, with equal
//! scales along both axes, and explains every class it drew in a legend. It keeps its light colours on a dark page;
//! only the surrounding text follows the page.

mod areas;
mod input;
mod legend;
mod margins;
mod numbers;
mod spots;
mod surround;
mod tracks;
mod view;

use refusal::Invalid;

use crate::figures::svg::{self, Colours, Sheet};

pub use input::{
    Area, Cells, Class, Contour, Frame, Graticule, Map, Margin, Purpose, Raster, Spot, Symbol, Track,
    TrackStyle, Tube,
};

use legend::Legend;
use view::{LABEL, View, WIDTH};

/// Name of the legend's group.
const LEGEND: &str = "Legend";

/// A drawing of [`map_figure`] and its legend, as separate SVG elements; `None` if it is not such a drawing.
pub fn parted(svg: &str) -> Option<[String; 2]> {
    let (map, legend) = svg.split_once(&format!("<g aria-label=\"{LEGEND}\">"))?;
    let (legend, after) = legend.rsplit_once("</g>")?;
    let (before, rest) = svg.split_once("viewBox=\"0 0 ")?;
    let (size, rest) = rest.split_once('"')?;
    let (attributes, _) = rest.split_once('>')?;
    let wide = svg::units(WIDTH);
    let left = size.split(' ').next()?.parse::<i64>().ok()? - wide;
    let part = |from: i64, width: i64, body: &str| {
        let places = body.split(" y=\"").skip(1);
        let lowest = places.filter_map(|after| after.split('"').next()?.parse::<i64>().ok()).max()?;
        let height = lowest + svg::units(LABEL);
        Some(format!("{before}viewBox=\"{from} 0 {width} {height}\"{attributes}>{body}{after}"))
    };
    Some([part(0, wide, map.split_once('>')?.1)?, part(wide, left, legend)?])
}

/// Draws `map` as one SVG element that scales to the width of its container.
///
/// From below: cells, areas of water (the shoalest above), margins, no-go areas, land, graticule, charted points and
/// names, tube and corridors, tracks, hulls, goal and start, step numbers. The legend is next to the map, in a
/// separate group. Coordinates are exact to a tenth of a pixel of a drawing 560 pixels wide. Cells finer than a
/// pixel, and cells with borders too long for a small file, are merged in blocks that show their most dangerous
/// class. Coordinates are finite, a raster has a value per cell, and tracks name maneuvers that the map declares.
///
/// ```
/// use report::figures::map::{Map, Track, TrackStyle, map_figure};
/// let track = Track { style: TrackStyle::Basic, points: vec![[100.0, 200.0], [900.0, 700.0]], number: None };
/// let map = Map { title: "Transit".to_owned(), tracks: vec![track], ..Map::default() };
/// let svg = map_figure(&map)?;
/// assert!(svg.contains("<title>Transit</title>") && svg.contains(">basic move</text>"));
/// # Ok::<(), refusal::Invalid>(())
/// ```
///
/// # Errors
/// A frame without area, an absurdly large or a very long one.
pub fn map_figure(map: &Map) -> Result<String, Invalid> {
    let view = View::new(&map.frame)?;
    let mut sheet = Sheet::new(Colours::Kept);
    draw(&mut sheet, &view, map);
    surround::draw(&mut sheet, &view, &map.graticule);
    map.warning.iter().for_each(|warning| surround::warning(&mut sheet, &view, warning));
    let legend = Legend::new(map);
    sheet.labelled(LEGEND, |sheet| legend.draw(sheet));
    Ok(whole(map, &sheet, (view.opposite.1 + surround::FOOT).max(legend.height())))
}

fn draw(sheet: &mut Sheet, view: &View, map: &Map) {
    sheet.bar(view.corner, view.opposite, input::background(map.uncharted));
    if let Some(cells) = &map.cells {
        areas::draw(sheet, view, cells, &map.depth_limits_m);
    }
    areas::water(sheet, view, map);
    tracks::contours(sheet, view, &map.contours);
    map.margins.iter().for_each(|margin| margins::draw(sheet, view, margin));
    areas::obstacles(sheet, view, map);
    surround::graticule(sheet, view, &map.graticule);
    spots::draw(sheet, view, map);
    map.tube.iter().for_each(|tube| margins::tube(sheet, view, tube));
    tracks::outlines(sheet, view, std::slice::from_ref(&map.edge), input::EDGE);
    tracks::outlines(sheet, view, &map.speed_limits, input::SPEED_LIMIT);
    tracks::outlines(sheet, view, &map.corridors, input::CORRIDOR);
    tracks::draw(sheet, view, map);
    spots::hulls(sheet, view, &map.hulls);
    spots::ends(sheet, view, map);
    numbers::draw(sheet, view, map);
}

fn whole(map: &Map, sheet: &Sheet, height: f64) -> String {
    let attributes =
        format!(" stroke-linecap=\"round\" font-family=\"sans-serif\" font-size=\"{}\"", svg::units(LABEL));
    let (title, described) = (Sheet::written(&map.title), Sheet::written(&map.description));
    let head = format!("<title>{title}</title>\n<desc>{described}</desc>\n");
    sheet.svg((WIDTH + legend::WIDTH, height), &map.title, &attributes, &head)
}
