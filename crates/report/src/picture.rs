//! Pictures for pages: a plan's map above histograms, tracks of standard maneuvers.

use study::documents::MeritDocument;

use super::merit::first_tracks;

/// Width and height of the map, of histograms of three designs, and the gap between, in units of the picture.
const MAP: [u32; 2] = [1140, 760];
const HISTOGRAM: [u32; 2] = [560, 670];
const GAP: u32 = 20;

/// `map` above, `histograms` side by side below, on white: whole `<svg>` elements as this crate draws them.
pub fn picture(map: &str, histograms: &[&str; 2]) -> String {
    let (width, height) = (MAP[0] + 2 * GAP, MAP[1] + HISTOGRAM[1] + 3 * GAP);
    let below = MAP[1] + 2 * GAP;
    let placed = [
        placed(map, [GAP, GAP], MAP),
        placed(histograms[0], [GAP, below], HISTOGRAM),
        placed(histograms[1], [2 * GAP + HISTOGRAM[0], below], HISTOGRAM),
    ];
    format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {width} {height}\" color=\"#1d242b\">\n\
        <rect width=\"{width}\" height=\"{height}\" fill=\"#ffffff\"/>\n{}</svg>\n",
        placed.concat()
    )
}

/// The track of the first maneuver of each kind, on white.
pub fn maneuvers_picture(found: &MeritDocument) -> String {
    let tracks = first_tracks(found);
    let white = |tag: &str| format!("{tag} color=\"#1d242b\" style=\"background: #ffffff\" ");
    tracks.replacen("<svg ", &white("<svg"), 1) + "\n"
}

/// `figure` at a position and size; its `viewBox` scales it.
fn placed(figure: &str, at: [u32; 2], size: [u32; 2]) -> String {
    let place = format!("<svg x=\"{}\" y=\"{}\" width=\"{}\" height=\"{}\" ", at[0], at[1], size[0], size[1]);
    figure.trim_end().replacen("<svg ", &place, 1) + "\n"
}
