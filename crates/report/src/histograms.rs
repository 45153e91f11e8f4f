use maud::{Markup, html};

use crate::figures::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};

use super::number::{exact, percent};
use super::parts::Figures;

const BINS: usize = 50;

/// A figure of histograms of one error, a panel per design.
#[derive(Clone, Copy)]
pub(super) struct ErrorFigure<'a> {
    file: &'a str,
    title: &'a str,
    caption: &'a str,
    limit: f64,
    bound: Option<f64>,
    width: f64,
}

/// The errors of one design.
pub(super) struct DesignErrors<'a> {
    pub(super) design: &'a str,
    /// One per run; none for a run without a value.
    pub(super) values: Vec<Option<f64>>,
    /// Share of the runs below the bound.
    pub(super) below: Option<f64>,
}

impl<'a> ErrorFigure<'a> {
    /// For half of the page, in `<file>.svg`: `title` says what and in which unit, and the axis ends at `limit`.
    pub(super) const fn half(file: &'a str, title: &'a str, limit: f64) -> Self {
        Self { file, title, caption: title, limit, bound: None, width: 460.0 }
    }

    /// As [`ErrorFigure::half`], for a third of the page.
    pub(super) const fn third(file: &'a str, title: &'a str, limit: f64) -> Self {
        Self { width: 360.0, ..Self::half(file, title, limit) }
    }

    /// With a caption of its own.
    pub(super) const fn captioned(self, caption: &'a str) -> Self {
        Self { caption, ..self }
    }

    /// With a line below which a run counts as good.
    pub(super) const fn bounded(self, bound: Option<f64>) -> Self {
        Self { bound, ..self }
    }

    /// Draws and places the figure; the caption accounts for what no bar shows.
    pub(super) fn place(&self, designs: &[DesignErrors<'_>], figures: &mut Figures) -> Markup {
        let Self { title, limit, bound, width, .. } = *self;
        let note = |share: Option<f64>| bound.zip(share).map(|(bound, share)| below(share, bound));
        let panels: Vec<HistogramPanel<'_>> = (0..)
            .zip(designs)
            .map(|(colour, DesignErrors { design, values, below })| HistogramPanel {
                label: design,
                values,
                note: note(*below),
                colour,
            })
            .collect();
        let drawing = histogram_pair(&HistogramAxis { title, limit, bins: BINS, bound, width }, &panels);
        let told: Vec<String> = designs.iter().map(|own| self.left_out(own)).collect();
        let caption = html! {
            b { (self.caption) }
            " Values at or above " (exact(limit)) " are truncated into the last bar (" (told.join("; ")) ")."
        };
        figures.place(self.file, drawing, &caption)
    }

    /// What the last bar holds and what no bar shows: `optimized: 3 of 500 runs truncated, 0 without a value`.
    fn left_out(&self, own: &DesignErrors<'_>) -> String {
        let counted = Histogram::new(&own.values, self.limit, BINS);
        let (runs, Histogram { beyond, missing, .. }) = (counted.runs(), &counted);
        format!("{}: {beyond} of {runs} runs truncated, {missing} without a value", own.design)
    }
}

/// `98.6 % below 5`.
fn below(share: f64, bound: f64) -> String {
    format!("{} below {}", percent(share), exact(bound))
}
