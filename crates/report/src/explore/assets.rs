//! The script and the style of the page, and the libraries that it has where they are needed.

pub(super) const SCRIPT: &str = include_str!("../../assets/explore.js");
pub(super) const STYLE: &str = include_str!("../../assets/explore.css");

/// What draws a panel.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Library {
    /// uPlot 1.6.32.
    Plots,
    /// Leaflet 1.9.4.
    Maps,
}

impl Library {
    /// The library with its license.
    pub(super) fn script(self) -> String {
        let [license, code] = match self {
            Self::Plots => [
                include_str!("../../assets/vendor/uplot/LICENSE"),
                include_str!("../../assets/vendor/uplot/uPlot.iife.min.js"),
            ],
            Self::Maps => [
                include_str!("../../assets/vendor/leaflet/LICENSE"),
                include_str!("../../assets/vendor/leaflet/leaflet.js"),
            ],
        };
        format!("/*\n{license}\n*/\n{}", without(code, "sourceMappingURL"))
    }

    /// Its style, without the pictures of controls that the page does not have.
    pub(super) fn style(self) -> String {
        let text = match self {
            Self::Plots => include_str!("../../assets/vendor/uplot/uPlot.min.css"),
            Self::Maps => include_str!("../../assets/vendor/leaflet/leaflet.css"),
        };
        without(text, "url(")
    }
}

/// `text` without the lines that have `word`.
fn without(text: &str, word: &str) -> String {
    text.lines().filter(|line| !line.contains(word)).flat_map(|line| [line, "\n"]).collect()
}
