use refusal::Invalid;

use super::limit::Limit;
use crate::Omission;

/// Refuses a channel if more than the share `most` of its `values` are left out. `limit` is that of its
/// numbers.
pub(crate) fn check_share(
    channel: &str,
    values: u64,
    omitted: &[Omission],
    most: f64,
    limit: Option<&Limit>,
) -> Result<(), Invalid> {
    let own = || omitted.iter().filter(|omission| omission.channel == channel);
    let count: u64 = own().map(|omission| omission.count).sum();
    if count as f64 <= most * values as f64 {
        return Ok(());
    }
    let reasons: Vec<String> = own().map(|one| format!("{} {}", one.count, one.reason)).collect();
    let share = 100.0 * count as f64 / values as f64;
    let found = format!("{count} of {values} values left out ({share:.0} %): {}", reasons.join(", "));
    let within = limit.map(|Limit { numbers: [low, high], of }| {
        format!("; the column's numbers within {} to {}, {of}", five(*low), five(*high))
    });
    Err(Invalid::new(
        format!("channel `{channel}`"),
        found,
        format!("at most {} % left out{}", five(100.0 * most), within.unwrap_or_default()),
        "correct its `unit` or `scale`, set `valid` and `missing`, or raise its `max_omitted`",
    ))
}

/// A number with at most five digits.
fn five(number: f64) -> String {
    let digits = format!("{number:.4e}").parse::<f64>().unwrap_or(number);
    if digits.abs() < 1e7 { digits.to_string() } else { format!("{digits:e}") }
}
