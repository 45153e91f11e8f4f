use std::fmt::Display;

use plotters::prelude::{DrawingBackend, SVGBackend};
use plotters::style::text_anchor::{HPos, Pos, VPos};
use plotters::style::{
    Color, FontFamily, FontStyle, FontTransform, IntoTextStyle, RGBAColor, ShapeStyle, TextStyle,
};

use crate::figures::FigureError;
use crate::figures::palette::{INK, Rgb};

/// A point of the drawing, in its own pixels: x to the right, y down.
pub(crate) type Point = (f64, f64);

/// Units of the SVG per pixel of the drawing: the library rounds coordinates to whole units.
const FINENESS: f64 = 10.0;
/// Beyond this many pixels a coordinate is cut, so that it fits the library's integers.
const FARTHEST: f64 = 1e6;
/// The library divides font sizes by this.
const FONT_FACTOR: f64 = 1.24;

/// A colour with its opacity.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Paint {
    pub(crate) rgb: Rgb,
    pub(crate) opacity: f64,
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

    fn color(self) -> RGBAColor {
        let (r, g, b) = self.rgb;
        RGBAColor(r, g, b, self.opacity)
    }
}

/// Where a text stands against its point, horizontally. Vertically it is centred.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Anchor {
    Start,
    Middle,
    End,
}

/// How a text looks. Sizes in pixels.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Lettering {
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    pub(crate) paint: Paint,
    pub(crate) bold: bool,
    pub(crate) upwards: bool,
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
}

/// Draws `width` × `height` pixels by calling `paint`, and returns the SVG with `label` as its accessible name.
pub(crate) fn drawn(
    width: f64,
    height: f64,
    label: &str,
    paint: impl FnOnce(&mut Canvas<'_>),
) -> Result<String, FigureError> {
    let mut svg = String::new();
    let size = (units(width).unsigned_abs(), units(height).unsigned_abs());
    let mut canvas = Canvas { backend: SVGBackend::with_string(&mut svg, size), failure: None };
    paint(&mut canvas);
    canvas.close()?;
    Ok(scalable(&svg, size, label))
}

/// A surface to draw on. The first failure is kept and reported at the end.
pub(crate) struct Canvas<'a> {
    backend: SVGBackend<'a>,
    failure: Option<FigureError>,
}

impl Canvas<'_> {
    pub(crate) fn line(&mut self, from: Point, to: Point, paint: Paint, width: f64) {
        self.path(&[from, to], paint, width);
    }

    /// A polyline; points that are not finite are left out.
    pub(crate) fn path(&mut self, points: &[Point], paint: Paint, width: f64) {
        let style = stroke(paint, width);
        let points = placed(points);
        if points.len() > 1 {
            let result = self.backend.draw_path(points, &style);
            self.note(result);
        }
    }

    /// A filled rectangle between two opposite corners.
    pub(crate) fn bar(&mut self, corner: Point, opposite: Point, paint: Paint) {
        let low = (corner.0.min(opposite.0), corner.1.min(opposite.1));
        let high = (corner.0.max(opposite.0), corner.1.max(opposite.1));
        if let [low, high] = placed(&[low, high])[..] {
            let result = self.backend.draw_rect(low, high, &paint.color().filled(), true);
            self.note(result);
        }
    }

    /// The border of a rectangle between two opposite corners.
    pub(crate) fn frame(&mut self, corner: Point, opposite: Point, paint: Paint, width: f64) {
        let (x0, y0) = corner;
        let (x1, y1) = opposite;
        self.path(&[(x0, y0), (x1, y0), (x1, y1), (x0, y1), (x0, y0)], paint, width);
    }

    pub(crate) fn dot(&mut self, centre: Point, radius: f64, paint: Paint) {
        if let [centre] = placed(&[centre])[..] {
            let radius = units(radius).unsigned_abs();
            let result = self.backend.draw_circle(centre, radius, &paint.color().filled(), true);
            self.note(result);
        }
    }

    pub(crate) fn ring(&mut self, centre: Point, radius: f64, paint: Paint, width: f64) {
        if let [centre] = placed(&[centre])[..] {
            let radius = units(radius).unsigned_abs();
            let result = self.backend.draw_circle(centre, radius, &stroke(paint, width), false);
            self.note(result);
        }
    }

    pub(crate) fn text(&mut self, text: &str, at: Point, lettering: Lettering) {
        let Some(&at) = placed(&[at]).first() else { return };
        let style = text_style(lettering);
        let result = self.backend.draw_text(text, &style, at);
        self.note(result);
    }

    fn note<E: Display>(&mut self, result: Result<(), E>) {
        if let (Err(error), None) = (result, &self.failure) {
            self.failure = Some(FigureError::new(error));
        }
    }

    fn close(mut self) -> Result<(), FigureError> {
        let result = self.backend.present();
        self.note(result);
        self.failure.take().map_or(Ok(()), Err)
    }
}

fn stroke(paint: Paint, width: f64) -> ShapeStyle {
    paint.color().stroke_width(units(width).unsigned_abs())
}

fn text_style(lettering: Lettering) -> TextStyle<'static> {
    let horizontal = match lettering.anchor {
        Anchor::Start => HPos::Left,
        Anchor::Middle => HPos::Center,
        Anchor::End => HPos::Right,
    };
    let size = lettering.size * FINENESS * FONT_FACTOR;
    let weight = if lettering.bold { FontStyle::Bold } else { FontStyle::Normal };
    let turn = if lettering.upwards { FontTransform::Rotate270 } else { FontTransform::None };
    let plain = (FontFamily::SansSerif, size, weight).into_text_style(&(1, 1));
    let mut style = plain.transform(turn).pos(Pos::new(horizontal, VPos::Center));
    style.color = lettering.paint.color().to_backend_color();
    style
}

fn units(pixels: f64) -> i32 {
    #[expect(clippy::cast_possible_truncation, reason = "clamped to a range that fits")]
    let units = (pixels.clamp(-FARTHEST, FARTHEST) * FINENESS).round() as i32;
    units
}

fn placed(points: &[Point]) -> Vec<(i32, i32)> {
    let finite = points.iter().filter(|(x, y)| x.is_finite() && y.is_finite());
    finite.map(|&(x, y)| (units(x), units(y))).collect()
}

/// Takes the fixed size off the opening tag, names the drawing, and lets ink follow the page.
fn scalable(svg: &str, size: (u32, u32), label: &str) -> String {
    let fixed = format!("<svg width=\"{}\" height=\"{}\" ", size.0, size.1);
    let open = format!("<svg role=\"img\" aria-label=\"{}\" stroke-linejoin=\"round\" ", escaped(label));
    svg.replacen(&fixed, &open, 1).replace("\"#000000\"", "\"currentColor\"")
}

pub(crate) fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn points_that_are_not_finite_are_left_out() {
        let points = [(f64::NAN, 1.0), (1.0, 2.0), (0.0, f64::INFINITY), (1e12, -3.04)];
        assert_eq!(placed(&points), [(10, 20), (10_000_000, -30)]);
    }
}
