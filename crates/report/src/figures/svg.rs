//! The SVG writer: elements on a sheet, in pixels, in their shortest form.
//!
//! Coordinates are whole tenths of a pixel; values that are not finite are omitted.

use crate::figures::palette::{INK, Rgb, hex};

/// A point of the drawing, in its own pixels: x to the right, y down.
pub(crate) type Point = (f64, f64);

/// Units of the SVG per pixel: whole numbers are short.
const FINENESS: f64 = 10.0;
/// Coordinates are clipped at this many pixels.
const FARTHEST: f64 = 1e6;

/// Whole units of the SVG.
pub(crate) fn units(pixels: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "clamped to a range that fits")]
    let units = (pixels.clamp(-FARTHEST, FARTHEST) * FINENESS).round() as i64;
    units
}

/// Whether a point can be drawn.
fn finite(point: &Point) -> bool {
    point.0.is_finite() && point.1.is_finite()
}

/// A colour with its opacity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    rgb: Rgb,
    opacity: f64,
}

impl Paint {
    pub(crate) const fn solid(rgb: Rgb) -> Self {
        Self { rgb, opacity: 1.0 }
    }

    pub(crate) const fn ink(opacity: f64) -> Self {
        Self { rgb: INK, opacity }
    }

    pub(crate) const fn faded(self, opacity: f64) -> Self {
        Self { rgb: self.rgb, opacity }
    }

    /// An attribute of colour, with its opacity if it is not 1.
    fn attribute(self, name: &str, colours: Colours) -> String {
        let opacity = match self.opacity {
            opacity if opacity < 1.0 => format!(" {name}-opacity=\"{opacity}\""),
            _ => String::new(),
        };
        let colour = match colours {
            // Ink follows the page in any case.
            _ if self.rgb == INK => "currentColor".to_owned(),
            Colours::Restyled => hex(self.rgb),
            Colours::Kept => hex(self.rgb).to_lowercase(),
        };
        format!(" {name}=\"{colour}\"{opacity}")
    }
}

/// How colours behave on a page with a dark background.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Colours {
    /// The page may restyle them: written in capital letters, `#0072B2`, which its rules match.
    Restyled,
    /// They are kept: written in small letters, which no rule matches.
    Kept,
}

/// Fill and stroke of a shape. Widths in pixels.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct Look {
    fill: Option<Paint>,
    stroke: Option<(Paint, f64)>,
    dash: Option<(f64, f64)>,
}

impl Look {
    pub(crate) const fn filled(fill: Paint) -> Self {
        Self { fill: Some(fill), stroke: None, dash: None }
    }

    pub(crate) const fn drawn(paint: Paint, width: f64) -> Self {
        Self { fill: None, stroke: Some((paint, width)), dash: None }
    }

    pub(crate) const fn outlined(self, paint: Paint, width: f64) -> Self {
        Self { stroke: Some((paint, width)), ..self }
    }

    /// `on` pixels drawn, `off` pixels omitted.
    pub(crate) const fn dashed(self, on: f64, off: f64) -> Self {
        Self { dash: Some((on, off)), ..self }
    }

    fn attributes(self, colours: Colours) -> String {
        let mut text = match self.fill {
            None => " fill=\"none\"".to_owned(),
            Some(paint) => paint.attribute("fill", colours),
        };
        if let Some((paint, width)) = self.stroke {
            text += &format!("{} stroke-width=\"{}\"", paint.attribute("stroke", colours), units(width));
        }
        if let Some((on, off)) = self.dash {
            let flat = "stroke-linecap=\"butt\"";
            text += &format!(" {flat} stroke-dasharray=\"{} {}\"", units(on), units(off));
        }
        text
    }
}

/// Filled.
impl From<Paint> for Look {
    fn from(paint: Paint) -> Self {
        Self::filled(paint)
    }
}

/// Drawn with a pen of this width \[px\].
impl From<(Paint, f64)> for Look {
    fn from((paint, width): (Paint, f64)) -> Self {
        Self::drawn(paint, width)
    }
}

/// Horizontal alignment of a text at its point. Vertically it is centred.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// The style of a text. Sizes in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lettering {
    size: f64,
    anchor: Anchor,
    paint: Paint,
    bold: bool,
    upwards: bool,
}

impl Lettering {
    pub(crate) const fn new(size: f64, anchor: Anchor) -> Self {
        Self { size, anchor, paint: Paint::ink(0.85), bold: false, upwards: false }
    }

    pub(crate) const fn painted(self, paint: Paint) -> Self {
        Self { paint, ..self }
    }

    pub(crate) const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub(crate) const fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }

    /// The attributes of a text at a place given in units.
    fn attributes(self, (x, y): (i64, i64), colours: Colours) -> String {
        let anchor = match self.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if self.bold { " font-weight=\"bold\"" } else { "" };
        let turn = if self.upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        let paint = self.paint.attribute("fill", colours);
        format!(" dy=\"0.35em\" font-size=\"{}\"{anchor}{weight}{turn}{paint}", units(self.size))
    }
}

/// The `d` of a path: whole units of the sheet, relative steps, in their shortest form.
#[derive(Default)]
pub(crate) struct Path(String);

impl Path {
    /// A polyline; nothing with less than two points.
    pub(crate) fn line(&mut self, points: &[Point]) {
        if points.len() > 1 {
            self.steps(points);
        }
    }

    /// A closed ring; one too small for the sheet becomes a dot.
    pub(crate) fn ring(&mut self, points: &[Point]) {
        if !points.is_empty() {
            self.steps(points);
            self.0.push('z');
        }
    }

    pub(crate) fn data(&self) -> &str {
        &self.0
    }

    fn steps(&mut self, points: &[Point]) {
        let mut last: Option<(i64, i64)> = None;
        let mut relative = false;
        for point in points {
            let now = (units(point.0), units(point.1));
            match last {
                None => self.0.push_str(&format!("M{} {}", now.0, now.1)),
                Some(before) if before == now => continue,
                Some(before) => {
                    self.0.push_str(if relative { "" } else { "l" });
                    self.step(now.0 - before.0, relative);
                    self.step(now.1 - before.1, true);
                    relative = true;
                }
            }
            last = Some(now);
        }
        if !relative {
            self.0.push_str("h1");
        }
    }

    fn step(&mut self, by: i64, apart: bool) {
        let space = if apart && by >= 0 { " " } else { "" };
        self.0.push_str(&format!("{space}{by}"));
    }
}

/// SVG elements, one below the other. Positions and sizes in pixels.
pub(crate) struct Sheet {
    body: String,
    colours: Colours,
}

impl Sheet {
    pub(crate) fn new(colours: Colours) -> Self {
        Self { body: String::new(), colours }
    }

    /// A figure of `width` × `height` pixels that `draw` draws, with colours that follow the page; `label` is its
    /// accessible name.
    pub(crate) fn figure(width: f64, height: f64, label: &str, draw: impl FnOnce(&mut Self)) -> String {
        let mut sheet = Self::new(Colours::Restyled);
        draw(&mut sheet);
        sheet.svg((width, height), label, " font-family=\"sans-serif\"", "")
    }

    /// The drawing as one SVG of `width` × `height` pixels that scales to the width of its container. `label` is its
    /// accessible name; `attributes` of the root begin with a space; `head` precedes everything else.
    pub(crate) fn svg(&self, size: (f64, f64), label: &str, attributes: &str, head: &str) -> String {
        format!(
            "<svg role=\"img\" aria-label=\"{}\" stroke-linejoin=\"round\"{attributes} \
             viewBox=\"0 0 {} {}\" xmlns=\"http://www.w3.org/2000/svg\">\n{head}{}</svg>\n",
            Self::written(label),
            units(size.0),
            units(size.1),
            self.body
        )
    }

    /// `text` escaped for tags and attributes, without the characters that XML does not allow.
    pub(crate) fn written(text: &str) -> String {
        let held = |c: &char| !c.is_control() && !matches!(c, '\u{FFFE}' | '\u{FFFF}');
        let spaced = text.chars().map(|c| if matches!(c, '\n' | '\t') { ' ' } else { c });
        let text: String = spaced.filter(held).collect();
        text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
    }

    /// The drawing of `draw` as a group with the name `label`.
    pub(crate) fn labelled(&mut self, label: &str, draw: impl FnOnce(&mut Self)) {
        self.body += &format!("<g aria-label=\"{}\">\n", Self::written(label));
        draw(self);
        self.body += "</g>\n";
    }

    /// The drawing of `draw` as a group with a title.
    pub(crate) fn titled(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        self.body += &format!("<g><title>{}</title>\n", Self::written(title));
        draw(self);
        self.body += "</g>\n";
    }

    pub(crate) fn path(&mut self, path: &Path, look: impl Into<Look>) {
        if !path.data().is_empty() {
            let look = self.attributes(look);
            self.body += &format!("<path d=\"{}\"{look}/>\n", path.data());
        }
    }

    /// Points that are not finite are omitted.
    pub(crate) fn polyline(&mut self, points: &[Point], look: impl Into<Look>) {
        let points: Vec<Point> = points.iter().copied().filter(finite).collect();
        let mut path = Path::default();
        path.line(&points);
        self.path(&path, look);
    }

    pub(crate) fn line(&mut self, from: Point, to: Point, look: impl Into<Look>) {
        self.polyline(&[from, to], look);
    }

    /// A rectangle between two opposite corners.
    pub(crate) fn bar(&mut self, corner: Point, opposite: Point, look: impl Into<Look>) {
        if !finite(&corner) || !finite(&opposite) {
            return;
        }
        let (x, y) = (units(corner.0.min(opposite.0)), units(corner.1.min(opposite.1)));
        let (width, height) = (units(corner.0.max(opposite.0)) - x, units(corner.1.max(opposite.1)) - y);
        let look = self.attributes(look);
        self.body += &format!("<rect x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"{look}/>\n");
    }

    pub(crate) fn disc(&mut self, centre: Point, radius: f64, look: impl Into<Look>) {
        if finite(&centre) {
            let (x, y, r) = (units(centre.0), units(centre.1), units(radius));
            let look = self.attributes(look);
            self.body += &format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{look}/>\n");
        }
    }

    pub(crate) fn text(&mut self, text: &str, at: Point, lettering: Lettering) {
        if finite(&at) {
            let (x, y) = (units(at.0), units(at.1));
            let attributes = lettering.attributes((x, y), self.colours);
            self.body += &format!("<text x=\"{x}\" y=\"{y}\"{attributes}>{}</text>\n", Self::written(text));
        }
    }

    fn attributes(&self, look: impl Into<Look>) -> String {
        look.into().attributes(self.colours)
    }
}

#[cfg(test)]
mod tests {
    use super::{Anchor, Paint, *};

    #[test]
    fn steps_are_relative_and_short() {
        let mut path = Path::default();
        path.line(&[(1.0, 2.0), (1.5, 1.0), (1.5, 1.0), (0.0, 3.0)]);
        path.ring(&[(7.0, 7.0), (7.01, 7.01)]);
        path.line(&[(9.0, 9.0)]);
        assert_eq!(path.data(), "M10 20l5-10-15 20M70 70h1z");
    }

    #[test]
    fn what_is_not_finite_is_left_out() {
        let mut sheet = Sheet::new(Colours::Restyled);
        let pen = (Paint::ink(1.0), 1.0);
        sheet.polyline(&[(f64::NAN, 1.0), (1.0, 2.0), (0.0, f64::INFINITY), (1e12, -3.04)], pen);
        sheet.bar((0.0, f64::NAN), (1.0, 1.0), pen);
        sheet.disc((f64::INFINITY, 0.0), 1.0, pen);
        sheet.text("here", (0.0, f64::NAN), Lettering::new(12.0, Anchor::Start));
        assert!(sheet.body.starts_with("<path d=\"M10 20l9999990-50\""), "{}", sheet.body);
        assert_eq!(sheet.body.matches('<').count(), 1);
    }

    #[test]
    fn colours_are_kept_or_follow_the_page() {
        let drawn = |colours| {
            let mut sheet = Sheet::new(colours);
            sheet.bar((2.0, 3.0), (1.0, 1.0), Paint::solid((0xAB, 0, 1)).faded(0.5));
            sheet.body
        };
        let place = "<rect x=\"10\" y=\"10\" width=\"10\" height=\"20\"";
        assert_eq!(drawn(Colours::Restyled), format!("{place} fill=\"#AB0001\" fill-opacity=\"0.5\"/>\n"));
        assert_eq!(drawn(Colours::Kept), format!("{place} fill=\"#ab0001\" fill-opacity=\"0.5\"/>\n"));
    }
}
