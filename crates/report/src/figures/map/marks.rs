use super::input::Map;
use super::view::View;
use super::{clip, colours};
use crate::figures::svg::{Path, Point, Sheet};

/// Radius of the start's disc [px]: smaller than the goal's, so that both are visible if the trial ends at its start.
pub(crate) const START: f64 = 5.0;
/// Radius of the goal's disc [px].
pub(crate) const GOAL: f64 = 8.0;

/// Outlines of the hull.
pub(crate) fn hulls(sheet: &mut Sheet, view: &View, hulls: &[Vec<[f64; 2]>]) {
    let mut path = Path::default();
    hulls.iter().for_each(|hull| path.ring(&clip::ring(view, &view.placed(hull))));
    sheet.path(&path, colours::HULL);
}

/// Goal and start, if they are in the frame.
pub(crate) fn ends(sheet: &mut Sheet, view: &View, map: &Map) {
    for (at, radius, look, title) in
        [(map.goal, GOAL, colours::GOAL, "goal"), (map.start, START, colours::START, "start")]
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
