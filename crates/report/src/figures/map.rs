//! A chart with a planned or simulated trial on it. Coordinates in metres, x east, y north.
//!
//! The map is independent of ships and projections: it draws polygons, cells, lines and marks in a frame, with equal
//! scales along both axes, and explains every class it drew in a legend. It keeps its light colours on a dark page;
//! only the surrounding text follows the page.

mod areas;
mod input;
mod legend;
mod spots;
mod view;

use legend::Legend;
use refusal::Invalid;
use view::{LABEL, NOTE, View, WIDTH};

use crate::figures::axis::round_step;
use crate::figures::svg::{self, Anchor, Colours, Lettering, Look, Paint, Path, Point, Sheet};
use crate::figures::text;

pub use input::{
    Cells, ChartedArea, Class, Contour, Frame, Graticule, Map, Margin, PlottedTrack, Purpose, Raster, Spot,
    Symbol, TrackStyle, Tube,
};

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
/// use report::figures::map::{Map, PlottedTrack, TrackStyle, map_figure};
/// let track = PlottedTrack { style: TrackStyle::Basic, points: vec![[100.0, 200.0], [900.0, 700.0]], number: None };
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
    draw_surround(&mut sheet, &view, &map.graticule);
    map.warning.iter().for_each(|warning| self::warning(&mut sheet, &view, warning));
    let legend = Legend::new(map);
    sheet.labelled(LEGEND, |sheet| legend.draw(sheet));
    Ok(whole(map, &sheet, (view.opposite.1 + FOOT).max(legend.height())))
}

fn draw(sheet: &mut Sheet, view: &View, map: &Map) {
    sheet.bar(view.corner, view.opposite, input::background(map.uncharted));
    if let Some(cells) = &map.cells {
        areas::draw(sheet, view, cells, &map.depth_limits_m);
    }
    areas::water(sheet, view, map);
    areas::contours(sheet, view, &map.contours);
    map.margins.iter().for_each(|margin| areas::draw_margin(sheet, view, margin));
    areas::obstacles(sheet, view, map);
    graticule(sheet, view, &map.graticule);
    spots::draw(sheet, view, map);
    map.tube.iter().for_each(|tube| areas::tube(sheet, view, tube));
    areas::draw_outlines(sheet, view, std::slice::from_ref(&map.edge), input::EDGE);
    areas::draw_outlines(sheet, view, &map.speed_limits, input::SPEED_LIMIT);
    areas::draw_outlines(sheet, view, &map.corridors, input::CORRIDOR);
    areas::draw_lines(sheet, view, &map.aborts, input::ABORT);
    areas::draw_tracks(sheet, view, map);
    areas::draw_outlines(sheet, view, &map.hulls, input::HULL);
    spots::ends(sheet, view, map);
    spots::draw_numbers(sheet, view, map);
}

fn whole(map: &Map, sheet: &Sheet, height: f64) -> String {
    let attributes =
        format!(" stroke-linecap=\"round\" font-family=\"sans-serif\" font-size=\"{}\"", svg::units(LABEL));
    let (title, described) = (Sheet::written(&map.title), Sheet::written(&map.description));
    let head = format!("<title>{title}</title>\n<desc>{described}</desc>\n");
    sheet.svg((WIDTH + legend::WIDTH, height), &map.title, &attributes, &head)
}

/// Space below the frame for labels, scale bar and north arrow [px].
const FOOT: f64 = 56.0;
/// Height of a warning [px].
const WARNING: f64 = 22.0;
const TICK: f64 = 5.0;
const BAR: f64 = 5.0;
/// Least share of the frame's width of a scale bar.
const LEAST_SHARE: f64 = 0.16;

/// Fine lines across the map.
fn graticule(sheet: &mut Sheet, view: &View, graticule: &Graticule) {
    let (low, high) = (view.corner, view.opposite);
    let mut path = Path::default();
    for (x, _) in columns(view, graticule) {
        path.line(&[(x, low.1), (x, high.1)]);
    }
    for (y, _) in rows(view, graticule) {
        path.line(&[(low.0, y), (high.0, y)]);
    }
    sheet.path(&path, Look::drawn(input::DARK.faded(0.16), 0.6));
}

/// The frame with its labels, and below it the scale bar and the north arrow.
fn draw_surround(sheet: &mut Sheet, view: &View, graticule: &Graticule) {
    let (low, high) = (view.corner, view.opposite);
    sheet.bar(low, high, Look::drawn(input::DARK, 1.3));
    labels(sheet, view, graticule);
    scale_bar(sheet, view, high.1 + 38.0);
    north_arrow(sheet, (high.0 - 9.0, high.1 + 38.0));
}

/// A prominent line across the top of the map.
fn warning(sheet: &mut Sheet, view: &View, warning: &str) {
    let (left, right) = (view.corner.0, view.opposite.0);
    sheet.bar(view.corner, (right, view.corner.1 + WARNING), Look::filled(input::DANGER));
    let letters = Lettering::new(NOTE, Anchor::Middle).painted(input::WHITE).bold();
    sheet.text(warning, (0.5 * (left + right), view.corner.1 + 0.5 * WARNING), letters);
}

/// Pixels of the labels below the frame.
fn columns<'a>(view: &View, graticule: &'a Graticule) -> Vec<(f64, &'a str)> {
    within(&graticule.x, (view.corner.0, view.opposite.0), |x| view.place([x, 0.0]).0)
}

/// Pixels of the labels left of it.
fn rows<'a>(view: &View, graticule: &'a Graticule) -> Vec<(f64, &'a str)> {
    within(&graticule.y, (view.corner.1, view.opposite.1), |y| view.place([0.0, y]).1)
}

fn within(labels: &[(f64, String)], (low, high): (f64, f64), pixel: impl Fn(f64) -> f64) -> Vec<(f64, &str)> {
    let placed = labels.iter().map(|(at, label)| (pixel(*at), label.as_str()));
    placed.filter(|(at, _)| (low..=high).contains(at)).collect()
}

/// Ticks outwards, each with its label if that does not overlap the last one or leave the frame.
fn labels(sheet: &mut Sheet, view: &View, graticule: &Graticule) {
    let (low, high) = (view.corner, view.opposite);
    let tick = Look::drawn(Paint::ink(0.6), 1.0);
    let letters = Lettering::new(NOTE, Anchor::Middle).painted(Paint::ink(0.75));
    let mut free = Free::new(low.0 - 20.0, high.0 + 4.0);
    for (x, label) in columns(view, graticule) {
        sheet.line((x, high.1), (x, high.1 + TICK), tick);
        if free.take(x, label) {
            sheet.text(label, (x, high.1 + 14.0), letters);
        }
    }
    let mut free = Free::new(low.1 - 4.0, high.1 + 12.0);
    for (y, label) in rows(view, graticule) {
        sheet.line((low.0 - TICK, y), (low.0, y), tick);
        if free.take(y, label) {
            sheet.text(label, (low.0 - 14.0, y), letters.upwards());
        }
    }
}

/// Free space along one side of the frame.
struct Free {
    low: f64,
    high: f64,
    taken: Vec<(f64, f64)>,
}

impl Free {
    fn new(low: f64, high: f64) -> Self {
        Self { low, high, taken: Vec::new() }
    }

    /// Takes the space of a label centred at `at`, if it is free.
    fn take(&mut self, at: f64, label: &str) -> bool {
        let half = 0.5 * text::width(label, NOTE);
        let (from, to) = (at - half, at + half);
        let apart = |&(low, high): &(f64, f64)| to + 8.0 < low || high + 8.0 < from;
        let free = from >= self.low && to <= self.high && self.taken.iter().all(apart);
        if free {
            self.taken.push((from, to));
        }
        free
    }
}

/// A bar of a round length, in alternating parts.
fn scale_bar(sheet: &mut Sheet, view: &View, y: f64) {
    let (left, right) = (view.corner.0, view.opposite.0);
    let metres = round_step(LEAST_SHARE * (right - left) / view.scale);
    let width = metres * view.scale;
    let label = length(metres);
    sheet.titled(&format!("scale: {label}"), |sheet| {
        sheet.bar((left, y), (left + width, y + BAR), Look::drawn(Paint::ink(1.0), 0.8));
        let parts = if is_five(metres) { 5 } else { 4 };
        for part in (0..parts).step_by(2) {
            let at = |k: i32| left + width * f64::from(k) / f64::from(parts);
            sheet.bar((at(part), y), (at(part + 1), y + BAR), Look::filled(Paint::ink(1.0)));
        }
        let letters = Lettering::new(NOTE, Anchor::Start).painted(Paint::ink(0.85));
        sheet.text(&label, (left + width + 8.0, y + 0.5 * BAR), letters);
    });
}

/// Whether a round number begins with a five.
fn is_five(round: f64) -> bool {
    (libm::log10(round).rem_euclid(1.0) - libm::log10(5f64)).abs() < 1e-6
}

/// A round length in metres or kilometres.
fn length(metres: f64) -> String {
    let (length, unit) = if metres < 1000.0 { (metres, "m") } else { (metres / 1000.0, "km") };
    format!("{} {unit}", text::number(length, length))
}

/// An arrow around `at`, with its letter.
fn north_arrow(sheet: &mut Sheet, (x, y): Point) {
    sheet.titled("north is up", |sheet| {
        let mut dark = Path::default();
        dark.ring(&[(x, y - 9.0), (x, y + 6.0), (x - 6.0, y + 11.0)]);
        let mut light = Path::default();
        light.ring(&[(x, y - 9.0), (x + 6.0, y + 11.0), (x, y + 6.0)]);
        sheet.path(&dark, Look::filled(Paint::ink(1.0)).outlined(Paint::ink(1.0), 1.0));
        sheet.path(&light, Look::drawn(Paint::ink(1.0), 1.0));
        let letter = Lettering::new(NOTE, Anchor::Middle).painted(Paint::ink(0.85)).bold();
        sheet.text("N", (x - 18.0, y + 2.0), letter);
    });
}
