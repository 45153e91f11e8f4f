use maud::{Markup, html};

use super::number::{or_dash, three};
use super::parts::Table;
use study::documents::{CriterionName, DesignDocument, DesignFigure, DesignFigures};

/// How well figures of merit will be known; nothing where the design has none.
pub(super) fn figure_errors(design: &DesignDocument) -> Markup {
    let Some(found) = &design.figures else { return html! {} };
    let weighted = design.criterion == CriterionName::Figures;
    html! {
        h3 { "How well will figures of merit be known?" }
        (table(found, weighted))
        p.note {
            "Standard errors after this experiment" (length(found.samples)) ", and after the D-optimal one of the same maneuvers \
             and time."
            @if weighted { " A figure without a weight may be known worse than there." }
        }
        @for said in &found.left_out { p.note { (said) } }
    }
}

fn length(samples: u64) -> String {
    match samples {
        1 => ", for one sample: that of N samples is √N times smaller".to_owned(),
        samples => format!(" of {samples} samples"),
    }
}

fn table(found: &DesignFigures, weighted: bool) -> Table<&DesignFigure> {
    let with_unit = |value: f64, figure: &DesignFigure| {
        let unit = if figure.unit == "1" { String::new() } else { figure.unit.replace("deg", "°") };
        format!("{} {unit}", three(value)).trim_end().to_owned()
    };
    let mut table = Table::of(&found.figures)
        .mark("unused", |figure| weighted && figure.weight == 0.0)
        .name("Maneuver", |figure| figure.maneuver.as_str())
        .text("Figure", |figure| figure.what.as_str())
        .number("Value", |figure| with_unit(figure.value, figure));
    if weighted {
        table = table.number("Weight", |figure| three(figure.weight));
    }
    if found.figures.iter().any(|figure| figure.wanted.is_some()) {
        table =
            table.number("Wanted", |figure| or_dash(figure.wanted.map(|wanted| with_unit(wanted, figure))));
    }
    table
        .number("Standard error", |figure| with_unit(figure.standard_error, figure))
        .number("D-optimal", |figure| or_dash(figure.d_optimal.map(|error| with_unit(error, figure))))
        .number("Ratio", |figure| or_dash(figure.ratio.map(three)))
}
