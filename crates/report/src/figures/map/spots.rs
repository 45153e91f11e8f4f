//! Soundings, dangers and names, as space allows.

use std::f64::consts::TAU;

use crate::figures::map::input::{self, Contour, Map, Spot, Symbol, TrackStyle};
use crate::figures::map::view::{self, View};
use crate::figures::svg::{Anchor, Lettering, Look, Point, Sheet};
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
fn placed(view: &View, at: Option<[f64; 2]>) -> Option<Point> {
    at.map(|at| view.place(at)).filter(|&at| view.holds(at, 0.0))
}

/// Radius of a number's disc [px].
const DISC: f64 = 8.0;
const NUMBER_DIGITS: f64 = 11.5;
const DOT: f64 = 2.4;
/// Distances of a number from its step to try, the nearest first [px].
const DISTANCES: [f64; 3] = [14.0, 21.0, 30.0];
const DIRECTIONS: u32 = 16;
/// Side of a square of the clutter's raster [px].
const SQUARE: f64 = 3.0;

/// Numbers of the steps near their first points, at the positions that cover least.
pub(crate) fn draw_numbers(sheet: &mut Sheet, view: &View, map: &Map) {
    let mut taken = Taken::new(view, map);
    let numbered = map.tracks.iter().filter_map(|track| Some((track, track.number?)));
    for (track, number) in numbered {
        let Some(from) = placed(view, track.points.first().copied()) else { continue };
        let at = taken.place(view, from);
        let paint = match track.style {
            TrackStyle::Maneuver(index) => input::maneuver_paint(index),
            _ => input::DARK,
        };
        sheet.line(from, at, Look::drawn(input::DARK, 0.8));
        sheet.disc(from, DOT, Look::filled(input::DARK));
        sheet.disc(at, DISC, Look::filled(input::WHITE).outlined(paint, 1.8));
        let size = if number < 100 { NUMBER_DIGITS } else { 0.75 * NUMBER_DIGITS };
        let letters = Lettering::new(size, Anchor::Middle).painted(input::DARK).bold();
        sheet.text(&number.to_string(), at, letters);
    }
}

/// The squares that the map's lines, marks and numbers cover.
struct Taken {
    corner: Point,
    wide: usize,
    squares: Vec<bool>,
    discs: Vec<(Point, f64)>,
}

impl Taken {
    fn new(view: &View, map: &Map) -> Self {
        let (corner, opposite) = (view.corner, view.opposite);
        let wide = square(opposite.0 - corner.0) + 1;
        let high = square(opposite.1 - corner.1) + 1;
        let ends = [(map.start, START), (map.goal, GOAL)];
        let discs = ends.into_iter().filter_map(|(at, radius)| Some((placed(view, at)?, radius)));
        let mut taken = Self { corner, wide, squares: vec![false; wide * high], discs: discs.collect() };
        let lines = map.tracks.iter().filter(|track| track.style != TrackStyle::Realization);
        lines.for_each(|track| taken.cover(view, &view.placed(&track.points)));
        let steps = map.tracks.iter().filter(|track| track.number.is_some());
        let dots = steps.filter_map(|track| placed(view, track.points.first().copied()));
        taken.discs.extend(dots.map(|at| (at, DOT)));
        taken
    }

    /// Marks the squares that a line runs through.
    fn cover(&mut self, view: &View, points: &[Point]) {
        for part in view::line(view, points) {
            for pair in part.windows(2) {
                let (from, to) = (pair[0], pair[1]);
                let steps = square(libm::hypot(to.0 - from.0, to.1 - from.1)) + 1;
                for step in 0..=steps {
                    let share = step as f64 / steps as f64;
                    let at = (from.0 + share * (to.0 - from.0), from.1 + share * (to.1 - from.1));
                    let index = self.index(at);
                    if let Some(square) = self.squares.get_mut(index) {
                        *square = true;
                    }
                }
            }
        }
    }

    fn index(&self, at: Point) -> usize {
        square(at.1 - self.corner.1) * self.wide + square(at.0 - self.corner.0)
    }

    /// The best position for a number of a step at `from`, which is then marked as covered.
    fn place(&mut self, view: &View, from: Point) -> Point {
        let angles = (0..DIRECTIONS).map(|k| TAU * f64::from(k) / f64::from(DIRECTIONS));
        let places = DISTANCES.into_iter().flat_map(|distance| {
            angles.clone().map(move |angle| {
                (from.0 + distance * libm::sin(angle), from.1 - distance * libm::cos(angle))
            })
        });
        let inside = places.filter(|&at| view.holds(at, DISC + 2.0));
        let best = inside.min_by(|&a, &b| self.cost(from, a).total_cmp(&self.cost(from, b)));
        let at = best.unwrap_or(from);
        self.discs.push((at, DISC));
        at
    }

    /// The cost of a number at `at`: what it would cover, and its distance.
    fn cost(&self, from: Point, at: Point) -> f64 {
        let near =
            |&&(disc, radius): &&(Point, f64)| distance(disc, at) < radius + DISC + 2.0 && disc != from;
        let discs = self.discs.iter().filter(near).count();
        30.0 * discs as f64 + self.clutter(at) as f64 + 0.12 * distance(from, at)
    }

    fn clutter(&self, at: Point) -> usize {
        let offsets = (-3..=3).map(|k| f64::from(k) * SQUARE);
        let around = offsets.clone().flat_map(|dx| offsets.clone().map(move |dy| (dx, dy)));
        let near = around.filter(|(dx, dy)| libm::hypot(*dx, *dy) <= DISC + 1.0);
        near.filter(|(dx, dy)| self.squares.get(self.index((at.0 + dx, at.1 + dy))) == Some(&true)).count()
    }
}

/// Number of whole squares in a distance.
fn square(distance: f64) -> usize {
    #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a distance on the sheet")]
    let squares = (distance.max(0.0) / SQUARE) as usize;
    squares
}

fn distance(a: Point, b: Point) -> f64 {
    libm::hypot(a.0 - b.0, a.1 - b.1)
}
