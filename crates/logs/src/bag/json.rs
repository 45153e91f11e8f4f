//! Messages in JSON.

use serde_json::Value;

use super::fields::{Step, Wrong};

/// Puts the numbers at `paths` of the message `data` into `row`, and notes which were found.
pub(super) fn decode(data: &[u8], paths: &mut [(Vec<Step>, bool)], row: &mut [f64]) -> Result<(), Wrong> {
    let message: Value =
        serde_json::from_slice(data).map_err(|error| (error.to_string(), "a message in JSON".to_owned()))?;
    for ((path, found), cell) in paths.iter_mut().zip(row) {
        let Some(value) = path.iter().try_fold(&message, step) else { continue };
        *found = true;
        *cell = match value {
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN),
            Value::Bool(is) => f64::from(u8::from(*is)),
            Value::Null => f64::NAN,
            other => return Err((format!("`{other}`"), "a number".to_owned())),
        };
    }
    Ok(())
}

fn step<'a>(value: &'a Value, step: &Step) -> Option<&'a Value> {
    match step {
        Step::Name(name) => value.get(name),
        Step::Index(i) => value.get(i),
    }
}
