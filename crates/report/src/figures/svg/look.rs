use super::units::units;
use crate::figures::palette::{INK, Rgb, hex};

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
    pub(super) fn attribute(self, name: &str, colours: Colours) -> String {
        let opacity = match self.opacity {
            opacity if opacity < 1.0 => format!(" {name}-opacity=\"{opacity}\""),
            _ => String::new(),
        };
        format!(" {name}=\"{}\"{opacity}", colours.written(self.rgb))
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

impl Colours {
    /// Ink follows the page in any case.
    fn written(self, rgb: Rgb) -> String {
        match self {
            _ if rgb == INK => "currentColor".to_owned(),
            Self::Restyled => hex(rgb),
            Self::Kept => hex(rgb).to_lowercase(),
        }
    }
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

    pub(super) fn attributes(self, colours: Colours) -> String {
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
    pub(super) fn attributes(self, (x, y): (i64, i64), colours: Colours) -> String {
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
