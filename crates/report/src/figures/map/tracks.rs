use super::input::{Contour, Map, Track, TrackStyle};
use super::view::{View, simplified};
use super::{input, view};
use crate::figures::svg::{Look, Path, Sheet};

/// Tolerance of a line [px].
const TOLERANCE: f64 = 0.06;
/// The same for one of many realizations.
const COARSE: f64 = 0.25;
/// Maximum number of realizations that are drawn.
pub(crate) const MOST_REALIZATIONS: usize = 200;

/// Draws the tracks: realizations below, then basic moves, run-ins, and maneuvers on top.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, map: &Map) {
    let styled = |style| map.tracks.iter().filter(move |track| track.style == style);
    let sheaf = chosen(&styled(TrackStyle::Realization).collect::<Vec<_>>());
    let look = input::realization(sheaf.len());
    sheaf.iter().for_each(|track| sheet.path(&path(view, track, COARSE), look));
    for (style, look, halo) in [
        (TrackStyle::Basic, input::BASIC, input::halo(3.6)),
        (TrackStyle::RunIn, input::RUN_IN, input::halo(2.4)),
    ] {
        let paths: Vec<Path> = styled(style).map(|track| path(view, track, TOLERANCE)).collect();
        paths.iter().for_each(|path| sheet.path(path, halo));
        paths.iter().for_each(|path| sheet.path(path, look));
    }
    map.tracks.iter().for_each(|track| maneuver(sheet, view, map, track));
}

/// Outlines of corridors and of areas.
pub(crate) fn outlines(sheet: &mut Sheet, view: &View, rings: &[Vec<[f64; 2]>], look: Look) {
    let mut path = Path::default();
    rings.iter().for_each(|ring| path.ring(&view::ring(view, &view.placed(ring))));
    sheet.path(&path, look);
}

/// Depth contours; their values are drawn with the soundings.
pub(crate) fn contours(sheet: &mut Sheet, view: &View, contours: &[Contour]) {
    let mut path = Path::default();
    for contour in contours {
        let parts = view::line(view, &view.placed(&contour.line));
        parts.iter().for_each(|part| path.line(&simplified(part, COARSE)));
    }
    sheet.path(&path, input::CONTOUR);
}

/// A maneuver with its name as a title.
fn maneuver(sheet: &mut Sheet, view: &View, map: &Map, track: &Track) {
    let TrackStyle::Maneuver(index) = track.style else { return };
    let (name, _) = &map.maneuvers[index];
    let title = track.number.map_or_else(|| name.clone(), |number| format!("{number}: {name}"));
    let (line, within) = input::maneuver(index);
    let path = path(view, track, TOLERANCE);
    sheet.titled(&title, |sheet| {
        let looks: [Option<Look>; 3] = [Some(input::halo(input::MANEUVER + 2.0)), Some(line), within];
        looks.into_iter().flatten().for_each(|look| sheet.path(&path, look));
    });
}

fn path(view: &View, track: &Track, tolerance: f64) -> Path {
    let mut path = Path::default();
    for part in view::line(view, &view.placed(&track.points)) {
        path.line(&simplified(&part, tolerance));
    }
    path
}

/// The tracks to draw, evenly chosen up to the maximum.
fn chosen<'a>(tracks: &[&'a Track]) -> Vec<&'a Track> {
    let (count, drawn) = (tracks.len(), tracks.len().min(MOST_REALIZATIONS));
    (0..drawn).map(|k| tracks[k * count / drawn]).collect()
}
