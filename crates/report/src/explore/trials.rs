//! A dot per trial, a row per trial.

use maud::{Markup, html};
use serde_json::{Value, json};
use study::scores;
use study::selection;

use super::assets::Library;
use super::{Panel, column, number, stride};
use crate::study::Study;

/// Trials beyond this many are not in the page.
const MOST: usize = 10_000;

/// Simulated trials by their scores, and picks of sub-experiments by their errors.
pub(super) fn panels(study: &Study) -> Vec<Panel> {
    let scored = study.scores.as_ref().filter(|rows| !rows.is_empty()).map(|rows| scored(rows));
    let picked = study
        .selection
        .as_ref()
        .filter(|selection| !selection.rows.is_empty())
        .map(|selection| picked(&selection.rows));
    scored.into_iter().chain(picked).collect()
}

fn scored(rows: &[scores::Row]) -> Panel {
    let columns = [
        column("design", "", "text"),
        column("run", "", "number"),
        column("status", "", "text"),
        column("parameter error", "1", "number"),
        column("RMSE u", "m/s", "number"),
        column("RMSE v", "m/s", "number"),
        column("RMSE r", "rad/s", "number"),
        column("simulation error", "", "number"),
    ];
    let row = |row: &scores::Row| {
        let [u, v, r] = row.rmse.map(number);
        let [parameter, simulation] = [row.parameter_error, row.simulation_error].map(number);
        json!([row.design, row.run, row.status.name(), parameter, u, v, r, simulation])
    };
    panel("trials", "Trials", &columns, rows, row, [3, 7])
}

fn picked(rows: &[selection::Row]) -> Panel {
    let columns = [
        column("design", "", "text"),
        column("realization", "", "number"),
        column("status", "", "text"),
        column("error norm", "1", "number"),
        column("RMSE u", "m/s", "number"),
        column("RMSE v", "m/s", "number"),
        column("RMSE r", "rad/s", "number"),
        column("error norm, left out", "1", "number"),
    ];
    let row = |row: &selection::Row| {
        let [u, v, r] = row.rmse.map_or([const { Value::Null }; 3], |rmse| rmse.map(number));
        let [norm, left_out] = [row.error_norm, row.left_out_norm].map(number);
        json!([row.design, row.number, row.status.name(), norm, u, v, r, left_out])
    };
    panel("picks", "Selected sub-experiments", &columns, rows, row, [3, 7])
}

/// Dots at the columns `axes`, in a colour per design, the first column.
fn panel<R>(
    id: &str,
    title: &str,
    columns: &[Value],
    rows: &[R],
    row: impl Fn(&R) -> Value,
    axes: [usize; 2],
) -> Panel {
    let every = stride(rows.len(), MOST);
    let shown: Vec<Value> = rows.iter().step_by(every).map(row).collect();
    Panel {
        id: id.to_owned(),
        title: title.to_owned(),
        about: about(rows.len(), every),
        data: json!({"kind": "dots", "columns": columns, "rows": shown, "axes": axes, "group": 0}),
        library: Library::Plots,
    }
}

fn about(all: usize, every: usize) -> Markup {
    html! {
        p {
            "Each dot is one of " (all) " trials. Drag over dots to keep them in the table, or type limits. "
            "Click a row to find its dot."
        }
        @if every > 1 { p.note { "One of every " (every) " trials is in this page; the file has all." } }
    }
}
