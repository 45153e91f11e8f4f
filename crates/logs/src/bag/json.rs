//! Messages in JSON.

use refusal::foreign;
use serde_json::Value;

use crate::bag::effort::Effort;
use crate::bag::fields::{Step, Wrong};

/// How many times as many bytes a message takes as values.
const VALUES: usize = 16;

/// Puts the numbers at `paths` of the message `data` into `row`, and notes which paths were found.
pub(crate) fn decode(
    data: &[u8],
    paths: &mut [(Vec<Step>, bool)],
    row: &mut [f64],
    effort: &Effort,
) -> Result<(), Wrong> {
    let most = effort.largest / VALUES;
    if data.len() > most {
        return Err((format!("{} bytes", data.len()), format!("at most {most} in JSON")));
    }
    let message: Value = serde_json::from_slice(data)
        .map_err(|error| (foreign(&error.to_string()), "a message in JSON".to_owned()))?;
    for ((path, found), cell) in paths.iter_mut().zip(row) {
        let Some(value) = path.iter().try_fold(&message, step) else { continue };
        *found = true;
        *cell = match value {
            Value::Number(number) => number.as_f64().unwrap_or(f64::NAN),
            Value::Bool(is) => f64::from(u8::from(*is)),
            Value::Null => f64::NAN,
            other => return Err((format!("`{}`", foreign(&other.to_string())), "a number".to_owned())),
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
