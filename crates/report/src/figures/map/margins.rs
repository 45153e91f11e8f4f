use super::areas::Ranks;
use super::input::{Margin, Purpose, Raster, Tube};
use super::view::View;
use super::{input, view};
use crate::figures::svg::{Path, Sheet};

/// Maximum number of characters of a margin.
const MOST_CHARACTERS: usize = 120_000;
/// Least distance between lines of the hatching [px].
const APART: f64 = 4.5;

/// Draws a margin: pale red for transit, hatched for trial.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, margin: &Margin) {
    let Some((cells, border)) = bordered(view, &margin.grid, &margin.blocked) else { return };
    if margin.purpose == Purpose::Trial {
        sheet.path(&hatching(view, &cells), input::HATCH);
    }
    sheet.path(&border, input::margin(margin.purpose));
}

/// Draws the area swept by hulls.
pub(crate) fn tube(sheet: &mut Sheet, view: &View, tube: &Tube) {
    if let Some((_, border)) = bordered(view, &tube.grid, &tube.swept) {
        sheet.path(&border, input::TUBE);
    }
}

/// Cells, merged until their border is short enough, and that border.
fn bordered(view: &View, grid: &Raster, set: &[bool]) -> Option<(Ranks, Path)> {
    let mut cells = Ranks::new(view, grid, |cell| u8::from(set[cell]))?;
    let mut border = cells.border(view, 1..);
    while border.data().len() > MOST_CHARACTERS && cells.size() != (1, 1) {
        cells = cells.merged(2);
        border = cells.border(view, 1..);
    }
    Some((cells, border))
}

/// Diagonals of the cells on every n-th diagonal of the grid, each run of cells as one line.
fn hatching(view: &View, cells: &Ranks) -> Path {
    let (nx, ny) = cells.size();
    let pitch = cells.pitch(view) * std::f64::consts::FRAC_1_SQRT_2;
    #[expect(
        clippy::cast_possible_truncation,
        clippy::cast_sign_loss,
        reason = "positive, and the cast saturates"
    )]
    let every = (APART / pitch).ceil().max(1.0) as usize;
    let mut path = Path::default();
    for diagonal in (0..nx + ny).step_by(every) {
        let (i, j) = (diagonal.saturating_sub(ny), ny.saturating_sub(diagonal));
        runs(cells, (i, j)).into_iter().for_each(|(from, to)| {
            let ends = (cells.vertex(view, from), cells.vertex(view, to));
            if let Some((from, to)) = view::segment(view, ends.0, ends.1) {
                path.line(&[from, to]);
            }
        });
    }
    path
}

type Run = ((usize, usize), (usize, usize));

/// First and end vertex of every run of blocked cells on the diagonal from vertex `start` to the north-east.
fn runs(cells: &Ranks, start: (usize, usize)) -> Vec<Run> {
    let (nx, ny) = cells.size();
    let length = (nx - start.0.min(nx)).min(ny - start.1.min(ny));
    let vertex = |step: usize| (start.0 + step, start.1 + step);
    let blocked = |step: usize| step < length && cells.at(start.0 + step, start.1 + step) > 0;
    let starts = (0..length).filter(|&step| blocked(step) && (step == 0 || !blocked(step - 1)));
    let end = |from: usize| (from..=length).find(|&step| !blocked(step)).unwrap_or(length);
    starts.map(|from| (vertex(from), vertex(end(from)))).collect()
}
