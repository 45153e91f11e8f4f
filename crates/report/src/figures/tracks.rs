use super::axis::{GRID, NOTE, note};
use super::traces::thinned;
use crate::figures::axis::{extent, round_step};
use crate::figures::palette::{INK, Rgb};
use crate::figures::svg::{Anchor, Paint, Point, Sheet};
use crate::figures::text;

/// One or several tracks in the plane, in one cell.
#[derive(Clone, Debug)]
pub struct Track<'a> {
    /// Name of the maneuver or recording.
    pub name: &'a str,
    /// Drawn in this order; the first begins at the dot.
    pub lines: Vec<TrackLine<'a>>,
}

/// One track.
#[derive(Clone, Copy, Debug)]
pub struct TrackLine<'a> {
    /// Position along the initial heading \[m\].
    pub x: &'a [f64],
    /// Position to starboard of it \[m\].
    pub y: &'a [f64],
    /// Its colour; `None` for ink.
    pub colour: Option<Rgb>,
}

const WIDTH: f64 = 960.0;
const NARROWEST: f64 = 150.0;
const TALLEST: f64 = 230.0;
const HEAD: f64 = 26.0;
const PAD: f64 = 10.0;
const LONGEST_NAME: usize = 24;
const LETTER: f64 = 6.6;

/// Plan views, all at the same scale: x upwards, y to the right, a dot at the start.
pub fn tracks(tracks: &[Track<'_>]) -> String {
    let cells = Cells::new(tracks);
    let rows = tracks.len().div_ceil(cells.columns);
    let height = rows as f64 * cells.cell.1 + 34.0;
    Sheet::figure(WIDTH, height, "Plan view of every maneuver", |sheet| {
        for (index, track) in tracks.iter().enumerate() {
            cells.draw(sheet, index, track);
        }
        cells.scale_bar(sheet, height - 16.0);
    })
}

/// Number of columns, size of the cells [px], and pixels per metre.
struct Cells {
    columns: usize,
    cell: (f64, f64),
    scale: f64,
}

impl Cells {
    fn new(tracks: &[Track<'_>]) -> Self {
        let length = |(low, high): (f64, f64)| high - low;
        let widest = tracks.iter().map(|track| length(track.across())).fold(1e-3, f64::max);
        let longest = tracks.iter().map(|track| length(track.along())).fold(1e-3, f64::max);
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a handful")]
        let most = (WIDTH / NARROWEST) as usize;
        let candidates = (1..=most.min(tracks.len().max(1))).map(|columns| {
            let room = WIDTH / columns as f64 - 2.0 * PAD;
            (columns, (room / widest).min(TALLEST / longest))
        });
        let best = candidates.max_by(|a, b| a.1.total_cmp(&b.1).then(a.0.cmp(&b.0)));
        let (columns, scale) = best.unwrap_or((1, 1.0));
        let cell = (WIDTH / columns as f64, HEAD + longest * scale + 3.0 * PAD);
        Self { columns, cell, scale }
    }

    fn draw(&self, sheet: &mut Sheet, index: usize, track: &Track<'_>) {
        let left = (index % self.columns) as f64 * self.cell.0;
        let top = (index / self.columns) as f64 * self.cell.1;
        sheet.bar((left + 3.0, top + 3.0), (left + self.cell.0 - 3.0, top + self.cell.1 - 3.0), (GRID, 1.0));
        sheet.text(&abridged(track.name, self.letters()), (left + PAD, top + 16.0), note(Anchor::Start));
        let centre = (left + 0.5 * self.cell.0, top + HEAD + 0.5 * (self.cell.1 - HEAD));
        for (i, line) in track.lines.iter().enumerate() {
            let points = self.placed(track, line, centre);
            let paint = Paint::solid(line.colour.unwrap_or(INK));
            sheet.polyline(&thinned(points.iter().copied(), 600), (paint, 1.8));
            let start = points.iter().find(|p| p.0.is_finite() && p.1.is_finite());
            if let Some(start) = start.filter(|_| i == 0) {
                sheet.disc(*start, 3.5, Paint::ink(0.9));
            }
        }
    }

    /// Maximum length of a name.
    fn letters(&self) -> usize {
        #[expect(clippy::cast_possible_truncation, clippy::cast_sign_loss, reason = "a handful")]
        let most = ((self.cell.0 - 2.0 * PAD) / LETTER) as usize;
        most.min(LONGEST_NAME)
    }

    /// Pixels of a line with the centre of the extent of all of `track` at `centre`.
    fn placed(&self, track: &Track<'_>, line: &TrackLine<'_>, centre: Point) -> Vec<Point> {
        let (north, east) = (middle(track.along()), middle(track.across()));
        let pairs = line.x.iter().zip(line.y);
        pairs
            .map(|(x, y)| (centre.0 + self.scale * (y - east), centre.1 - self.scale * (x - north)))
            .collect()
    }

    fn scale_bar(&self, sheet: &mut Sheet, y: f64) {
        let metres = round_step(0.5 * 100.0 / self.scale);
        let end = 4.0 + metres * self.scale;
        sheet.line((4.0, y), (end, y), (Paint::ink(0.8), 2.0));
        for x in [4.0, end] {
            sheet.line((x, y - 4.0), (x, y + 4.0), (Paint::ink(0.8), 1.4));
        }
        let label = format!("{} m", text::number(metres, metres));
        sheet.text(&label, (end + 0.7 * NOTE, y), note(Anchor::Start));
    }
}

impl Track<'_> {
    /// Least and largest x of all lines.
    fn along(&self) -> (f64, f64) {
        extent(self.lines.iter().flat_map(|line| line.x.iter().copied())).unwrap_or_default()
    }

    /// Least and largest y of all lines.
    fn across(&self) -> (f64, f64) {
        extent(self.lines.iter().flat_map(|line| line.y.iter().copied())).unwrap_or_default()
    }
}

/// `name` without its middle if it is longer than `most`: names of recordings often differ at their ends.
fn abridged(name: &str, most: usize) -> String {
    let letters: Vec<char> = name.chars().collect();
    if letters.len() <= most {
        return name.to_owned();
    }
    let (head, tail) = (most / 2, most.saturating_sub(most / 2 + 1));
    letters[..head].iter().chain(&['…']).chain(&letters[letters.len() - tail..]).collect()
}

fn middle((low, high): (f64, f64)) -> f64 {
    0.5 * (low + high)
}
