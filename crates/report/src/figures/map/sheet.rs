use super::path::Path;
use crate::figures::canvas::{Anchor, Paint, Point, escaped};
use crate::figures::palette::{INK, Rgb};

/// Units of the SVG per pixel: whole numbers are short.
const FINENESS: f64 = 10.0;
const FARTHEST: f64 = 1e6;

/// Whole units of the SVG.
pub(crate) fn units(pixels: f64) -> i64 {
    #[expect(clippy::cast_possible_truncation, reason = "clamped to a range that fits")]
    let units = (pixels.clamp(-FARTHEST, FARTHEST) * FINENESS).round() as i64;
    units
}

/// `text` without the characters that XML cannot hold.
pub(crate) fn printable(text: &str) -> String {
    let held = |c: &char| !c.is_control() && !matches!(c, '\u{FFFE}' | '\u{FFFF}');
    text.chars().map(|c| if matches!(c, '\n' | '\t') { ' ' } else { c }).filter(held).collect()
}

/// How a shape is painted. Widths in pixels.
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

    /// `on` pixels drawn, `off` pixels left out.
    pub(crate) const fn dashed(self, on: f64, off: f64) -> Self {
        Self { dash: Some((on, off)), ..self }
    }

    fn attributes(self) -> String {
        let mut text = match self.fill {
            None => " fill=\"none\"".to_owned(),
            Some(paint) => painted("fill", paint),
        };
        if let Some((paint, width)) = self.stroke {
            text += &format!("{} stroke-width=\"{}\"", painted("stroke", paint), units(width));
        }
        if let Some((on, off)) = self.dash {
            let flat = "stroke-linecap=\"butt\"";
            text += &format!(" {flat} stroke-dasharray=\"{} {}\"", units(on), units(off));
        }
        text
    }
}

/// An attribute of colour, with its opacity where it is not whole.
fn painted(attribute: &str, paint: Paint) -> String {
    let opacity = match paint.opacity {
        opacity if opacity < 1.0 => format!(" {attribute}-opacity=\"{opacity}\""),
        _ => String::new(),
    };
    format!(" {attribute}=\"{}\"{opacity}", colour(paint.rgb))
}

/// Ink follows the page. Other colours are in small letters, which no page's rules for dark backgrounds match.
fn colour((r, g, b): Rgb) -> String {
    if (r, g, b) == INK { "currentColor".to_owned() } else { format!("#{r:02x}{g:02x}{b:02x}") }
}

/// How a text looks. It is centred vertically on its point.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Letters {
    pub(crate) size: f64,
    pub(crate) anchor: Anchor,
    pub(crate) paint: Paint,
    pub(crate) bold: bool,
    pub(crate) upwards: bool,
}

impl Letters {
    pub(crate) const fn new(size: f64, anchor: Anchor, paint: Paint) -> Self {
        Self { size, anchor, paint, bold: false, upwards: false }
    }

    pub(crate) const fn bold(self) -> Self {
        Self { bold: true, ..self }
    }

    pub(crate) const fn upwards(self) -> Self {
        Self { upwards: true, ..self }
    }
}

/// SVG elements, one below the other. Positions and sizes in pixels.
#[derive(Default)]
pub(crate) struct Sheet {
    body: String,
}

impl Sheet {
    pub(crate) fn body(&self) -> &str {
        &self.body
    }

    /// What `draw` draws, as one group with a title.
    pub(crate) fn titled(&mut self, title: &str, draw: impl FnOnce(&mut Self)) {
        self.body += &format!("<g><title>{}</title>\n", escaped(&printable(title)));
        draw(self);
        self.body += "</g>\n";
    }

    pub(crate) fn path(&mut self, path: &Path, look: Look) {
        if !path.data().is_empty() {
            self.body += &format!("<path d=\"{}\"{}/>\n", path.data(), look.attributes());
        }
    }

    pub(crate) fn line(&mut self, from: Point, to: Point, look: Look) {
        let mut path = Path::default();
        path.line(&[from, to]);
        self.path(&path, look);
    }

    pub(crate) fn bar(&mut self, corner: Point, opposite: Point, look: Look) {
        let (x, y) = (units(corner.0), units(corner.1));
        let (width, height) = (units(opposite.0) - x, units(opposite.1) - y);
        let place = format!("x=\"{x}\" y=\"{y}\" width=\"{width}\" height=\"{height}\"");
        self.body += &format!("<rect {place}{}/>\n", look.attributes());
    }

    pub(crate) fn disc(&mut self, centre: Point, radius: f64, look: Look) {
        let (x, y, r) = (units(centre.0), units(centre.1), units(radius));
        self.body += &format!("<circle cx=\"{x}\" cy=\"{y}\" r=\"{r}\"{}/>\n", look.attributes());
    }

    pub(crate) fn text(&mut self, text: &str, at: Point, letters: Letters) {
        let (x, y, size) = (units(at.0), units(at.1), units(letters.size));
        let anchor = match letters.anchor {
            Anchor::Start => "",
            Anchor::Middle => " text-anchor=\"middle\"",
            Anchor::End => " text-anchor=\"end\"",
        };
        let weight = if letters.bold { " font-weight=\"bold\"" } else { "" };
        let turn =
            if letters.upwards { format!(" transform=\"rotate(-90 {x} {y})\"") } else { String::new() };
        self.body += &format!(
            "<text x=\"{x}\" y=\"{y}\" dy=\"0.35em\" font-size=\"{size}\"{anchor}{weight}{turn}{}>{}</text>\n",
            painted("fill", letters.paint),
            escaped(&printable(text))
        );
    }
}
