use super::areas::{band, bands};
use super::colours;
use super::grid::Ranks;
use super::input::{Cells, Class};
use super::view::View;
use crate::figures::svg::{Look, Path, Sheet};

/// Maximum number of characters of all cells.
const MOST_CHARACTERS: usize = 300_000;

/// Draws the cells: those of every shade together with all more dangerous ones, then the next shade on top, so that
/// there is no seam between two.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, cells: &Cells, limits: &[f64]) {
    let rank = |cell: usize| cells.classes[cell].map_or(0, |class| rank(class, limits));
    let Some(mut ranks) = Ranks::new(view, &cells.grid, rank) else { return };
    let mut layers = layers(view, &ranks, limits);
    while layers.iter().map(|(path, _)| path.data().len()).sum::<usize>() > MOST_CHARACTERS
        && ranks.size() != (1, 1)
    {
        ranks = ranks.merged(2);
        layers = self::layers(view, &ranks, limits);
    }
    layers.iter().for_each(|(path, look)| sheet.path(path, *look));
}

/// Deepest water 1, shoalest as many as there are bands, then no-go, then land.
fn rank(class: Class, limits: &[f64]) -> u8 {
    let bands = bands(limits);
    let rank = match class {
        Class::Depth { least_m } => bands - band(least_m, limits),
        Class::NoGo => bands + 1,
        Class::Land => bands + 2,
    };
    u8::try_from(rank).unwrap_or(u8::MAX)
}

fn layers(view: &View, ranks: &Ranks, limits: &[f64]) -> Vec<(Path, Look)> {
    let bands = bands(limits);
    let shades = u8::try_from(bands).unwrap_or(u8::MAX - 2);
    let water = (1..=shades).map(|rank| (rank, u8::MAX, colours::depth(bands - usize::from(rank), bands)));
    let danger = [(shades + 1, shades + 1, colours::NO_GO), (shades + 2, shades + 2, colours::LAND)];
    let present = water.chain(danger).filter(|(rank, ..)| ranks.holds(*rank));
    present.map(|(rank, last, look)| (ranks.border(view, rank..=last), look)).collect()
}
