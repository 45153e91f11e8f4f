//! The model on other recordings over time, with its bands.

use maud::html;
use serde_json::{Value, json};
use study::documents::Traced;

use super::assets::Library;
use super::embedded::{number, numbers, stride};
use super::panel::Panel;
use crate::study::Study;

/// Samples beyond this many are not in the page.
const MOST: usize = 12_000;

/// Measured and simulated motion of every window; `None` in a study without.
pub(super) fn panel(study: &Study) -> Option<Panel> {
    let (found, rows) = study.measured.as_ref()?.compared.as_ref()?;
    let windows = rows.chunk_by(|a, b| a.source == b.source && a.window == b.window);
    let every = stride(rows.len(), MOST);
    let windows: Vec<Value> = windows.map(|own| window(own, every)).collect();
    let verdict = found.statements.first();
    let about = html! {
        @if let Some(verdict) = verdict { p { (crate::parts::coded(verdict)) } }
        p {
            "Measured in the colour of the text, simulated in blue with its 95 % band. "
            "Drag to zoom; all three plots have the same time."
        }
        @if every > 1 { p.note { "One of every " (every) " samples is in this page; the file has all." } }
    };
    (!rows.is_empty()).then(|| Panel {
        id: "time".to_owned(),
        title: "Measured and simulated".to_owned(),
        about,
        data: json!({"kind": "time", "windows": windows}),
        library: Library::Plots,
    })
}

fn window(rows: &[Traced], every: usize) -> Value {
    let rows = || rows.iter().step_by(every);
    let all = |of: &dyn Fn(&Traced, usize) -> Option<f64>| -> Value {
        (0..3).map(|d| rows().map(|row| number(of(row, d))).collect::<Value>()).collect()
    };
    let first = rows().next();
    json!({
        "source": first.map(|row| row.source.as_str()),
        "window": first.map(|row| row.window + 1),
        "t": numbers(rows().map(|row| row.t)),
        "measured": all(&|row, d| Some(row.measured[d])),
        "simulated": all(&|row, d| Some(row.simulated[d])),
        "half": all(&|row, d| row.half[d]),
    })
}
