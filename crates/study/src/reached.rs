use files::Provenance;
use refusal::Invalid;
use serde_json::json;
use trial::campaign::{Maneuvers, Reached};

use crate::trajectories::{REACHED, Reacting};

/// Notes what the `maneuvers` of a dictionary reached, in words, and which of them react.
///
/// # Errors
/// The first that misses what it is called, with the number of others, unless that is allowed.
pub fn note_reached(
    maneuvers: &Maneuvers,
    reached: &[Reached],
    is_allowed: bool,
    provenance: &mut Provenance,
) -> Result<(), Invalid> {
    let missed: Vec<Invalid> = reached.iter().filter_map(Reached::missed).collect();
    if let Some(first) = missed.first().filter(|_| !is_allowed) {
        let others = match missed.len() - 1 {
            0 => String::new(),
            others => format!(" (and {others} more maneuvers miss theirs)"),
        };
        return Err(Invalid { expected: format!("{}{others}", first.expected), ..first.clone() });
    }
    let words = reached.iter().filter_map(|own| Some((own.maneuver.clone(), json!(own.words()?))));
    let words: serde_json::Map<_, _> = words.collect();
    if !words.is_empty() {
        provenance.settings.insert(REACHED.into(), words.into());
    }
    Reacting::of(maneuvers).note(provenance);
    Ok(())
}
