//! Data as it stands in the page.

use serde_json::{Value, json};
use study::documents::MapLine;

/// JSON that no tag can end.
pub(super) fn script(data: &Value) -> String {
    data.to_string().replace('<', "\\u003c")
}

/// `value` with five significant digits; null if it is missing or not finite.
pub(super) fn number(value: impl Into<Option<f64>>) -> Value {
    let short = |value: f64| format!("{value:.4e}").parse::<f64>().ok();
    value.into().filter(|value| value.is_finite()).and_then(short).map_or(Value::Null, Value::from)
}

/// The numbers of a column.
pub(super) fn numbers(values: impl Iterator<Item = f64>) -> Value {
    values.map(number).collect()
}

/// The places of a line in tenths of a metre: the first east and north, then differences to the place before.
pub(super) fn line(map_line: &MapLine) -> Value {
    let mut last = [0; 2];
    let places = map_line.east_m.iter().zip(&map_line.north_m);
    let steps = places.flat_map(|(east, north)| {
        let place = [tenths(*east), tenths(*north)];
        let step = [place[0] - last[0], place[1] - last[1]];
        last = place;
        step
    });
    steps.collect::<Vec<i64>>().into()
}

#[expect(clippy::cast_possible_truncation, reason = "a map is smaller than the Earth")]
fn tenths(metres: f64) -> i64 {
    (10.0 * metres).round() as i64
}

/// The head of a column of a table; `kind` is `text`, `number` or `clock`.
pub(super) fn column(name: &str, unit: &str, kind: &str) -> Value {
    json!({"name": name, "unit": unit, "kind": kind})
}

/// One of so many elements is kept that at most `most` remain.
pub(super) fn stride(all: usize, most: usize) -> usize {
    all.div_ceil(most).max(1)
}
