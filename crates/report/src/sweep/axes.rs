//! Labels of the axes of a sweep, and the cells along them.

use serde_json::Value;
use study::documents::{SweepAxis, SweepDocument, SweptCell};

use crate::figures::Places;

/// A value in plain notation.
pub(super) fn written(value: &Value) -> String {
    match value {
        Value::String(text) => text.clone(),
        Value::Object(fields) => fields
            .iter()
            .map(|(key, value)| format!("{key} {}", written(value)))
            .collect::<Vec<_>>()
            .join(", "),
        Value::Array(values) => values.iter().map(written).collect::<Vec<_>>().join(" "),
        other => other.to_string(),
    }
}

/// The positions of the values of `axis`.
pub(super) fn places(axis: &SweepAxis) -> Places {
    let numbers: Option<Vec<f64>> = axis.values.iter().map(Value::as_f64).collect();
    Places::new(axis.key.clone(), axis.values.iter().map(written).collect(), numbers.as_deref())
}

/// `campaign.seed 1, campaign.duration_s 60`: the coordinates of a cell, without the axes of `but`.
pub(super) fn place(sweep: &SweepDocument, at: &[usize], but: &[usize]) -> String {
    let one = |(i, (axis, place)): (usize, (&SweepAxis, &usize))| {
        (!but.contains(&i)).then(|| {
            let value = axis.values.get(*place).map_or_else(String::new, written);
            format!("{} {value}", short(sweep, &axis.key))
        })
    };
    sweep.axes.iter().zip(at).enumerate().filter_map(one).collect::<Vec<_>>().join(", ")
}

/// The last part of a dotted key, or the whole of it where another axis has the same.
pub(super) fn short<'a>(sweep: &SweepDocument, key: &'a str) -> &'a str {
    let last = |key: &'_ str| key.rsplit('.').next().unwrap_or_default().to_owned();
    let same = sweep.axes.iter().filter(|axis| last(&axis.key) == last(key)).count();
    if same > 1 { key } else { key.rsplit('.').next().unwrap_or(key) }
}

/// The cells, in groups that differ only on the axes of `along`.
pub(super) fn along<'a>(sweep: &'a SweepDocument, along: &[usize]) -> Vec<Vec<&'a SweptCell>> {
    let rest = |cell: &SweptCell| {
        cell.at
            .iter()
            .enumerate()
            .filter(|(i, _)| !along.contains(i))
            .map(|(_, place)| *place)
            .collect::<Vec<_>>()
    };
    let mut groups: Vec<(Vec<usize>, Vec<&SweptCell>)> = Vec::new();
    for cell in &sweep.cells {
        let key = rest(cell);
        match groups.iter_mut().find(|(known, _)| *known == key) {
            Some((_, group)) => group.push(cell),
            None => groups.push((key, vec![cell])),
        }
    }
    groups.sort_by(|a, b| a.0.cmp(&b.0));
    groups.into_iter().map(|(_, group)| group).collect()
}
