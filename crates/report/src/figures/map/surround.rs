use super::input;
use super::input::Graticule;
use super::view::{NOTE, View};
use crate::figures::axis::round_step;
use crate::figures::svg::{Anchor, Lettering, Look, Paint, Path, Point, Sheet};
use crate::figures::text;

/// Space below the frame for labels, scale bar and north arrow [px].
pub(crate) const FOOT: f64 = 56.0;
/// Height of a warning [px].
const WARNING: f64 = 22.0;
const TICK: f64 = 5.0;
const BAR: f64 = 5.0;
/// Least share of the frame's width of a scale bar.
const LEAST_SHARE: f64 = 0.16;

/// Fine lines across the map.
pub(crate) fn graticule(sheet: &mut Sheet, view: &View, graticule: &Graticule) {
    let (low, high) = (view.corner, view.opposite);
    let mut path = Path::default();
    for (x, _) in columns(view, graticule) {
        path.line(&[(x, low.1), (x, high.1)]);
    }
    for (y, _) in rows(view, graticule) {
        path.line(&[(low.0, y), (high.0, y)]);
    }
    sheet.path(&path, Look::drawn(input::DARK.faded(0.16), 0.6));
}

/// The frame with its labels, and below it the scale bar and the north arrow.
pub(crate) fn draw(sheet: &mut Sheet, view: &View, graticule: &Graticule) {
    let (low, high) = (view.corner, view.opposite);
    sheet.bar(low, high, Look::drawn(input::DARK, 1.3));
    labels(sheet, view, graticule);
    scale_bar(sheet, view, high.1 + 38.0);
    north_arrow(sheet, (high.0 - 9.0, high.1 + 38.0));
}

/// A prominent line across the top of the map.
pub(crate) fn warning(sheet: &mut Sheet, view: &View, warning: &str) {
    let (left, right) = (view.corner.0, view.opposite.0);
    sheet.bar(view.corner, (right, view.corner.1 + WARNING), Look::filled(input::DANGER));
    let letters = Lettering::new(NOTE, Anchor::Middle).painted(input::WHITE).bold();
    sheet.text(warning, (0.5 * (left + right), view.corner.1 + 0.5 * WARNING), letters);
}

/// Pixels of the labels below the frame.
fn columns<'a>(view: &View, graticule: &'a Graticule) -> Vec<(f64, &'a str)> {
    within(&graticule.x, (view.corner.0, view.opposite.0), |x| view.place([x, 0.0]).0)
}

/// Pixels of the labels left of it.
fn rows<'a>(view: &View, graticule: &'a Graticule) -> Vec<(f64, &'a str)> {
    within(&graticule.y, (view.corner.1, view.opposite.1), |y| view.place([0.0, y]).1)
}

fn within(labels: &[(f64, String)], (low, high): (f64, f64), pixel: impl Fn(f64) -> f64) -> Vec<(f64, &str)> {
    let placed = labels.iter().map(|(at, label)| (pixel(*at), label.as_str()));
    placed.filter(|(at, _)| (low..=high).contains(at)).collect()
}

/// Ticks outwards, each with its label if that does not overlap the last one or leave the frame.
fn labels(sheet: &mut Sheet, view: &View, graticule: &Graticule) {
    let (low, high) = (view.corner, view.opposite);
    let tick = Look::drawn(Paint::ink(0.6), 1.0);
    let letters = Lettering::new(NOTE, Anchor::Middle).painted(Paint::ink(0.75));
    let mut free = Free::new(low.0 - 20.0, high.0 + 4.0);
    for (x, label) in columns(view, graticule) {
        sheet.line((x, high.1), (x, high.1 + TICK), tick);
        if free.take(x, label) {
            sheet.text(label, (x, high.1 + 14.0), letters);
        }
    }
    let mut free = Free::new(low.1 - 4.0, high.1 + 12.0);
    for (y, label) in rows(view, graticule) {
        sheet.line((low.0 - TICK, y), (low.0, y), tick);
        if free.take(y, label) {
            sheet.text(label, (low.0 - 14.0, y), letters.upwards());
        }
    }
}

/// Free space along one side of the frame.
struct Free {
    low: f64,
    high: f64,
    taken: Vec<(f64, f64)>,
}

impl Free {
    fn new(low: f64, high: f64) -> Self {
        Self { low, high, taken: Vec::new() }
    }

    /// Takes the space of a label centred at `at`, if it is free.
    fn take(&mut self, at: f64, label: &str) -> bool {
        let half = 0.5 * text::width(label, NOTE);
        let (from, to) = (at - half, at + half);
        let apart = |&(low, high): &(f64, f64)| to + 8.0 < low || high + 8.0 < from;
        let free = from >= self.low && to <= self.high && self.taken.iter().all(apart);
        if free {
            self.taken.push((from, to));
        }
        free
    }
}

/// A bar of a round length, in alternating parts.
fn scale_bar(sheet: &mut Sheet, view: &View, y: f64) {
    let (left, right) = (view.corner.0, view.opposite.0);
    let metres = round_step(LEAST_SHARE * (right - left) / view.scale);
    let width = metres * view.scale;
    let label = length(metres);
    sheet.titled(&format!("scale: {label}"), |sheet| {
        sheet.bar((left, y), (left + width, y + BAR), Look::drawn(Paint::ink(1.0), 0.8));
        let parts = if is_five(metres) { 5 } else { 4 };
        for part in (0..parts).step_by(2) {
            let at = |k: i32| left + width * f64::from(k) / f64::from(parts);
            sheet.bar((at(part), y), (at(part + 1), y + BAR), Look::filled(Paint::ink(1.0)));
        }
        let letters = Lettering::new(NOTE, Anchor::Start).painted(Paint::ink(0.85));
        sheet.text(&label, (left + width + 8.0, y + 0.5 * BAR), letters);
    });
}

/// Whether a round number begins with a five.
fn is_five(round: f64) -> bool {
    (libm::log10(round).rem_euclid(1.0) - libm::log10(5f64)).abs() < 1e-6
}

/// A round length in metres or kilometres.
fn length(metres: f64) -> String {
    if metres < 1000.0 {
        return format!("{} m", text::number(metres, metres));
    }
    let kilometres = metres / 1000.0;
    format!("{} km", text::number(kilometres, kilometres))
}

/// An arrow around `at`, with its letter.
fn north_arrow(sheet: &mut Sheet, (x, y): Point) {
    sheet.titled("north is up", |sheet| {
        let mut dark = Path::default();
        dark.ring(&[(x, y - 9.0), (x, y + 6.0), (x - 6.0, y + 11.0)]);
        let mut light = Path::default();
        light.ring(&[(x, y - 9.0), (x + 6.0, y + 11.0), (x, y + 6.0)]);
        sheet.path(&dark, Look::filled(Paint::ink(1.0)).outlined(Paint::ink(1.0), 1.0));
        sheet.path(&light, Look::drawn(Paint::ink(1.0), 1.0));
        sheet.text(
            "N",
            (x - 18.0, y + 2.0),
            Lettering::new(NOTE, Anchor::Middle).painted(Paint::ink(0.85)).bold(),
        );
    });
}
