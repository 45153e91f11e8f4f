use maud::{Markup, html};
use ship::engine::{Pose, track};
use study::documents::Traced;

use super::parts::Figures;
use crate::figures::{Track, TrackLine, palette, tracks};

/// Recordings beyond this many are not drawn.
const MOST: usize = 24;

/// A gapless section of a recording: the measured track, and a simulated one for every window.
#[derive(Default)]
struct Sailed<'a> {
    source: &'a str,
    /// The last row measured.
    last: Option<&'a Traced>,
    measured: Vec<Pose>,
    simulated: Vec<Vec<Pose>>,
}

/// Measured and simulated tracks of every recording, whose rows are grouped by `windows`.
pub(super) fn sailed(windows: &[&[Traced]], figures: &mut Figures) -> Markup {
    let mut all: Vec<Sailed> = Vec::new();
    for window in windows {
        match all.last_mut().filter(|sailed| sailed.continues_with(window)) {
            Some(sailed) => sailed.add(window),
            None => {
                let mut sailed = Sailed { source: &window[0].source, ..Sailed::default() };
                sailed.add(window);
                all.push(sailed);
            }
        }
    }
    let drawn = &all[..all.len().min(MOST)];
    let axes: Vec<Vec<[Vec<f64>; 2]>> = drawn.iter().map(Sailed::axes).collect();
    let cells: Vec<Track> = drawn.iter().zip(&axes).map(|(sailed, axes)| cell(sailed.source, axes)).collect();
    let caption = html! {
        b { "Tracks as measured (black) and simulated (blue), seen from above." }
        " All at one scale, both axes alike; up is the heading at the start (the dot), right is starboard. No positions are \
         compared: both tracks follow from speeds and yaw rate, summed up from the same start, each window's simulated one \
         from where the measured one then was."
        @if drawn.len() < all.len() { " The first " (drawn.len()) " of " (all.len()) "." }
    };
    figures.place_wide("compared-tracks", tracks(&cells), &caption)
}

fn cell<'a>(name: &'a str, axes: &'a [[Vec<f64>; 2]]) -> Track<'a> {
    let colour = |i: usize| (i > 0).then_some(palette::BLUE);
    let lines = axes.iter().enumerate().map(|(i, [x, y])| TrackLine { x, y, colour: colour(i) });
    Track { name, lines: lines.collect() }
}

impl<'a> Sailed<'a> {
    /// Whether `window` continues this section.
    fn continues_with(&self, window: &[Traced]) -> bool {
        let last = self.last.map(|row| row.measured);
        self.source == window[0].source && last == Some(window[0].measured)
    }

    fn add(&mut self, window: &'a [Traced]) {
        let start = self.measured.pop().unwrap_or_default();
        self.measured.extend(followed(start, window, |row| row.measured));
        self.simulated.push(followed(start, window, |row| row.simulated));
        self.last = window.last();
    }

    /// x and y of the measured track, then of the simulated ones.
    fn axes(&self) -> Vec<[Vec<f64>; 2]> {
        let axes = |poses: &Vec<Pose>| {
            [poses.iter().map(|pose| pose.x).collect(), poses.iter().map(|pose| pose.y).collect()]
        };
        std::iter::once(&self.measured).chain(&self.simulated).map(axes).collect()
    }
}

/// Poses over `window` from `start`, with these velocities.
fn followed(start: Pose, window: &[Traced], velocities: impl Fn(&Traced) -> [f64; 3]) -> Vec<Pose> {
    let states: Vec<f64> = window.iter().flat_map(velocities).collect();
    let step = window.get(1).map_or(1.0, |row| row.t - window[0].t);
    let (sin, cos) = libm::sincos(start.psi);
    let placed = |pose: Pose| Pose {
        x: start.x + cos * pose.x - sin * pose.y,
        y: start.y + sin * pose.x + cos * pose.y,
        psi: start.psi + pose.psi,
    };
    track(&states, 1.0 / step).into_iter().map(placed).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn rows(window: i32, from: usize, samples: usize) -> Vec<Traced> {
        let row = |k: usize| Traced {
            source: "turn".to_owned(),
            window,
            t: 0.5 * (k - from) as f64,
            measured: [1.0 + 0.01 * k as f64, 0.1, 0.2],
            simulated: [1.0 + 0.01 * k as f64, 0.1, 0.2],
            half: [None; 3],
        };
        (from..=from + samples).map(row).collect()
    }

    #[test]
    fn law_windows_that_follow_each_other_give_the_track_of_the_whole() {
        let (whole, first, second) = (rows(0, 0, 40), rows(0, 0, 25), rows(1, 25, 15));
        let mut joined = Sailed { source: "turn", ..Sailed::default() };
        joined.add(&first);
        assert!(joined.continues_with(&second) && !joined.continues_with(&whole));
        joined.add(&second);
        let alone = followed(Pose::default(), &whole, |row| row.measured);
        assert_eq!(joined.measured.len(), alone.len());
        for (a, b) in joined.measured.iter().zip(&alone) {
            assert!((a.x - b.x).abs() < 1e-12 && (a.y - b.y).abs() < 1e-12, "{a:?} {b:?}");
        }
        // A model without error follows the measured track.
        let end = joined.simulated[1].last().unwrap();
        assert!((end.x - alone[40].x).abs() < 1e-12 && (end.psi - alone[40].psi).abs() < 1e-12);
    }
}
