use super::look::{Colours, Lettering, Look};
use super::path::Path;
use super::units::{Point, finite, units};

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
    use super::*;
    use crate::figures::svg::{Anchor, Paint};

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
