use maud::{Markup, html};

use crate::figures::{Histogram, HistogramAxis, HistogramPanel, histogram_pair};

use super::number::exact;
use super::parts::Figures;

/// A figure of histograms of one error, a panel per design.
#[derive(Clone, Copy)]
pub(super) struct ErrorFigure<'a> {
    file: &'a str,
    caption: &'a str,
    axis: HistogramAxis<'a>,
}

impl<'a> ErrorFigure<'a> {
    /// For half of the page, in `<file>.svg`: `title` has quantity and unit, and the axis ends at `limit`.
    pub(super) const fn half(file: &'a str, title: &'a str, limit: f64) -> Self {
        let axis = HistogramAxis { title, limit, bins: 50, bound: None, width: 460.0 };
        Self { file, caption: title, axis }
    }

    /// For a third of the page each: the errors in surge, sway and yaw rate.
    pub(super) fn thirds(files: [&'a str; 3], [u, v, r]: [f64; 3]) -> [Self; 3] {
        let third = |file, title, limit| {
            let half = Self::half(file, title, limit);
            Self { axis: HistogramAxis { width: 360.0, ..half.axis }, ..half }
        };
        [
            third(files[0], "RMSE in surge [m/s]", u),
            third(files[1], "RMSE in sway [m/s]", v),
            third(files[2], "RMSE in yaw rate [rad/s]", r),
        ]
    }

    /// Sets a caption.
    pub(super) const fn captioned(self, caption: &'a str) -> Self {
        Self { caption, ..self }
    }

    /// Adds a line below which a run counts as good.
    pub(super) const fn bounded(self, bound: Option<f64>) -> Self {
        Self { axis: HistogramAxis { bound, ..self.axis }, ..self }
    }

    /// Draws and places the figure; the caption accounts for runs that no bar shows.
    pub(super) fn place(&self, panels: &[HistogramPanel<'_>], figures: &mut Figures) -> Markup {
        let left_out: Vec<String> = panels.iter().map(|panel| self.left_out(panel)).collect();
        let caption = html! {
            b { (self.caption) }
            " Values at or above " (exact(self.axis.limit)) " are truncated into the last bar (" (left_out.join("; ")) ")."
        };
        figures.place(self.file, histogram_pair(&self.axis, panels), &caption)
    }

    /// The runs in the last bar and those that no bar shows: `optimized: 3 of 500 runs truncated, 0 without a value`.
    fn left_out(&self, panel: &HistogramPanel<'_>) -> String {
        let counted = Histogram::new(&panel.values, self.axis.limit, self.axis.bins);
        let (runs, Histogram { beyond, missing, .. }) = (counted.runs(), &counted);
        format!("{}: {beyond} of {runs} runs truncated, {missing} without a value", panel.label)
    }
}
