use std::f64::consts::TAU;

use super::input::{Map, TrackStyle};
use super::view::View;
use super::{input, spots};
use crate::figures::svg::{Anchor, Lettering, Look, Point, Sheet};

/// Radius of a number's disc [px].
const DISC: f64 = 8.0;
const DIGITS: f64 = 11.5;
const DOT: f64 = 2.4;
/// Distances of a number from its step to try, the nearest first [px].
const DISTANCES: [f64; 3] = [14.0, 21.0, 30.0];
const DIRECTIONS: u32 = 16;
/// Side of a square of the clutter's raster [px].
const SQUARE: f64 = 3.0;

/// Numbers of the steps near their first points, at the positions that cover least.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, map: &Map) {
    let mut taken = Taken::new(view, map);
    let numbered = map.tracks.iter().filter_map(|track| Some((track, track.number?)));
    for (track, number) in numbered {
        let Some(from) = spots::placed(view, track.points.first().copied()) else { continue };
        let at = taken.place(view, from);
        let paint = match track.style {
            TrackStyle::Maneuver(index) => input::maneuver_paint(index),
            _ => input::DARK,
        };
        sheet.line(from, at, Look::drawn(input::DARK, 0.8));
        sheet.disc(from, DOT, Look::filled(input::DARK));
        sheet.disc(at, DISC, Look::filled(input::WHITE).outlined(paint, 1.8));
        let size = if number < 100 { DIGITS } else { 0.75 * DIGITS };
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
        let ends = [(map.start, spots::START), (map.goal, spots::GOAL)];
        let discs = ends.into_iter().filter_map(|(at, radius)| Some((spots::placed(view, at)?, radius)));
        let mut taken = Self { corner, wide, squares: vec![false; wide * high], discs: discs.collect() };
        let lines = map.tracks.iter().filter(|track| track.style != TrackStyle::Realization);
        lines.for_each(|track| taken.cover(view, &view.placed(&track.points)));
        let steps = map.tracks.iter().filter(|track| track.number.is_some());
        let dots = steps.filter_map(|track| spots::placed(view, track.points.first().copied()));
        taken.discs.extend(dots.map(|at| (at, DOT)));
        taken
    }

    /// Marks the squares that a line runs through.
    fn cover(&mut self, view: &View, points: &[Point]) {
        for part in super::view::line(view, points) {
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
