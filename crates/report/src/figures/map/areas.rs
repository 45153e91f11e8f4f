use super::input::{Area, Class, Map};
use super::simplify::simplified;
use super::view::View;
use super::{clip, colours};
use crate::figures::svg::{Look, Path, Point, Sheet};

/// Tolerance of a border \[px\].
const TOLERANCE: f64 = 0.08;

/// Number of shades of depth.
pub(crate) fn bands(limits: &[f64]) -> usize {
    limits.len() + 1
}

/// Shade of a least depth, 0 for the shoalest.
pub(crate) fn band(least_m: f64, limits: &[f64]) -> usize {
    limits.iter().filter(|&&limit| least_m >= limit).count()
}

/// Draws charted water, one path per shade, the shoaler above the deeper.
pub(crate) fn water(sheet: &mut Sheet, view: &View, map: &Map) {
    let limits = &map.depth_limits_m;
    let bands = bands(limits);
    for shade in (0..bands).rev() {
        let own = |class| matches!(class, Class::Depth { least_m } if band(least_m, limits) == shade);
        class(sheet, view, map, own, colours::depth(shade, bands));
    }
}

/// Draws forbidden water, and land above it.
pub(crate) fn obstacles(sheet: &mut Sheet, view: &View, map: &Map) {
    class(sheet, view, map, |class| class == Class::NoGo, colours::NO_GO);
    class(sheet, view, map, |class| class == Class::Land, colours::LAND);
}

fn class(sheet: &mut Sheet, view: &View, map: &Map, own: impl Fn(Class) -> bool, look: Look) {
    let mut path = Path::default();
    map.areas.iter().filter(|area| own(area.class)).for_each(|area| add(&mut path, view, area));
    sheet.path(&path, look);
}

/// Adds an area, outer ring counter-clockwise and holes clockwise, so that overlapping areas do not cancel.
fn add(path: &mut Path, view: &View, area: &Area) {
    path.ring(&border(view, &area.ring, true));
    area.holes.iter().for_each(|hole| path.ring(&border(view, hole, false)));
}

fn border(view: &View, ring: &[[f64; 2]], outer: bool) -> Vec<Point> {
    let mut ring = view.placed(ring);
    if (doubled_area(&ring) < 0.0) != outer {
        ring.reverse();
    }
    let mut inside = clip::ring(view, &ring);
    inside.extend(inside.first().copied());
    simplified(&inside, TOLERANCE)
}

/// Positive if the ring runs clockwise on the sheet.
fn doubled_area(ring: &[Point]) -> f64 {
    let next = ring.iter().cycle().skip(1);
    ring.iter().zip(next).map(|(a, b)| a.0 * b.1 - b.0 * a.1).sum()
}
