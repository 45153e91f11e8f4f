//! Soundings, dangers and names, as space allows.

use super::input::{self, Contour, Map, Spot, Symbol};
use super::view::{self, View};
use crate::figures::svg::{Anchor, Lettering, Look, Path, Point, Sheet};
use crate::figures::text;

/// Size of depths and names \[px\].
const DIGITS: f64 = 8.5;
const NAME: f64 = 10.5;
/// Radius of a danger's circle \[px\].
pub(crate) const CIRCLE: f64 = 4.2;
/// Half the side of its cross \[px\].
const CROSS: f64 = 2.2;
/// Depths up to this one are written with a tenth \[m\].
const TENTHS_M: f64 = 31.0;
/// Least number of corners of a contour that is labelled.
const LONG: usize = 12;
/// Maximum number of points that are drawn.
const MOST: usize = 400;

/// Draws the dangers, and the soundings between them, the shoalest first; then names.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, map: &Map) {
    let mut room = Room::default();
    let mut spots: Vec<(&Spot, Point)> =
        map.spots.iter().filter_map(|spot| Some((spot, placed(view, Some(spot.at))?))).collect();
    let rank = |spot: &Spot| (spot.symbol == Symbol::Sounding, spot.depth_m.unwrap_or(f64::NEG_INFINITY));
    spots.sort_by(|(a, _), (b, _)| {
        let (a, b) = (rank(a), rank(b));
        a.0.cmp(&b.0).then(a.1.total_cmp(&b.1))
    });
    let mut drawn = 0;
    for (spot, at) in spots {
        if drawn < MOST && one(sheet, view, spot, at, &mut room) {
            drawn += 1;
        }
    }
    map.contours.iter().for_each(|contour| value(sheet, view, contour, &mut room));
    for (at, name) in &map.names {
        let Some(at) = placed(view, Some(*at)) else { continue };
        let half = (0.5 * text::width(name, NAME), 0.6 * NAME);
        if view.holds(at, half.1)
            && view.holds((at.0 - half.0, at.1), 0.0)
            && view.holds((at.0 + half.0, at.1), 0.0)
            && room.take(at, half)
        {
            sheet.text(name, at, Lettering::new(NAME, Anchor::Middle).painted(input::DARK.faded(0.85)));
        }
    }
}

/// Draws a point if there is space for it.
fn one(sheet: &mut Sheet, view: &View, spot: &Spot, at: Point, room: &mut Room) -> bool {
    let depth = spot.depth_m.map(depth);
    let letters = |anchor| Lettering::new(DIGITS, anchor).painted(input::DEPTH_DIGITS);
    match spot.symbol {
        Symbol::Sounding => {
            let Some(depth) = depth else { return false };
            let half = (0.5 * text::width(&depth, DIGITS) + 3.0, 0.5 * DIGITS + 3.0);
            if !(view.holds(at, half.0) && room.take(at, half)) {
                return false;
            }
            sheet.text(&depth, at, letters(Anchor::Middle));
        }
        Symbol::Danger => {
            if !room.take(at, (CIRCLE, CIRCLE)) {
                return false;
            }
            sheet.titled(&spot.title, |sheet| danger(sheet, at));
            let right = (at.0 + CIRCLE + 2.0, at.1);
            let depth = depth.map(|depth| (0.5 * text::width(&depth, DIGITS), depth));
            if let Some((half, depth)) = depth
                && view.holds(right, 2.0 * half)
                && room.take((right.0 + half, right.1), (half, 0.5 * DIGITS))
            {
                sheet.text(&depth, right, letters(Anchor::Start));
            }
        }
    }
    true
}

/// The depth of a contour in the middle of its longest part, if there is space for it.
fn value(sheet: &mut Sheet, view: &View, contour: &Contour, room: &mut Room) {
    let parts = view::line(view, &view.placed(&contour.line));
    let Some((part, depth_m)) = parts.iter().max_by_key(|part| part.len()).zip(contour.depth_m) else {
        return;
    };
    let (value, at) = (depth(depth_m), part[part.len() / 2]);
    let half = (0.5 * text::width(&value, DIGITS) + 2.0, 0.5 * DIGITS + 2.0);
    if part.len() >= LONG && view.holds(at, half.0) && room.take(at, half) {
        sheet.text(&value, at, Lettering::new(DIGITS, Anchor::Middle).painted(input::CONTOUR_PAINT));
    }
}

/// A cross in a dotted circle.
pub(crate) fn danger(sheet: &mut Sheet, (x, y): Point) {
    sheet.disc((x, y), CIRCLE, input::DANGER_CIRCLE);
    let cross = Look::drawn(input::DARK, 1.0);
    sheet.line((x - CROSS, y), (x + CROSS, y), cross);
    sheet.line((x, y - CROSS), (x, y + CROSS), cross);
}

/// Metres, with a tenth for shallow depths.
fn depth(metres: f64) -> String {
    let value = if metres < TENTHS_M { (metres * 10.0).floor() / 10.0 } else { metres.floor() };
    text::signed(&value.to_string())
}

/// Boxes that are occupied.
#[derive(Default)]
struct Room {
    taken: Vec<(Point, Point)>,
}

impl Room {
    /// Takes the box around `at` that reaches `half` to each side, if it is free.
    fn take(&mut self, at: Point, half: Point) -> bool {
        let apart = |(other, wide): &(Point, Point)| {
            (other.0 - at.0).abs() >= wide.0 + half.0 || (other.1 - at.1).abs() >= wide.1 + half.1
        };
        let free = self.taken.iter().all(apart);
        if free {
            self.taken.push((at, half));
        }
        free
    }
}

/// Radius of the start's disc [px]: smaller than the goal's, so that both are visible if the trial ends at its start.
pub(crate) const START: f64 = 5.0;
/// Radius of the goal's disc [px].
pub(crate) const GOAL: f64 = 8.0;

/// Outlines of the hull.
pub(crate) fn hulls(sheet: &mut Sheet, view: &View, hulls: &[Vec<[f64; 2]>]) {
    let mut path = Path::default();
    hulls.iter().for_each(|hull| path.ring(&view::ring(view, &view.placed(hull))));
    sheet.path(&path, input::HULL);
}

/// Goal and start, if they are in the frame.
pub(crate) fn ends(sheet: &mut Sheet, view: &View, map: &Map) {
    for (at, radius, look, title) in
        [(map.goal, GOAL, input::GOAL, "goal"), (map.start, START, input::START, "start")]
    {
        if let Some(at) = placed(view, at) {
            sheet.titled(title, |sheet| sheet.disc(at, radius, look));
        }
    }
}

/// Pixel of a mark, if it is in the frame.
pub(crate) fn placed(view: &View, at: Option<[f64; 2]>) -> Option<Point> {
    at.map(|at| view.place(at)).filter(|&at| view.holds(at, 0.0))
}
