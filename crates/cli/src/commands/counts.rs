//! The number of sub-experiments of each maneuver that `validate selection` picks.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::Provenance;
use refusal::nearest;
use study::documents::DesignDocument;

use crate::failure::Failure;
use crate::inputs;

/// The number of sub-experiments of each maneuver to pick: from `--counts label=n`, or from `design.json`, and no
/// more than available.
///
/// # Errors
/// Usage: an invalid count, or one for an unknown maneuver. Refused: a design without counts; more than available.
pub fn counts(
    design: Option<&Path>,
    written: &[String],
    available: &BTreeMap<String, u64>,
    provenance: &mut Provenance,
) -> Result<BTreeMap<String, u64>, Failure> {
    let Some(path) = design else { return parsed(written, available) };
    let design: DesignDocument = inputs::document(path, "design", provenance)?;
    let Some(counts) = design.counts else {
        let remedy = "make it with `design --segments`, or name --counts";
        return Err(Failure::refuse(path, "counts", "none", "those of whole segments", remedy));
    };
    for (name, count) in counts.iter().filter(|(_, count)| **count > 0) {
        let there = available.get(name).copied().unwrap_or(0);
        if *count > there {
            let found = format!("{count} of `{name}`");
            let remedy = "bound the design by what there is, or name --counts";
            return Err(Failure::refuse(path, "counts", &found, &format!("at most {there}"), remedy));
        }
    }
    Ok(counts.into_iter().filter(|(_, count)| *count > 0).collect())
}

fn parsed(written: &[String], available: &BTreeMap<String, u64>) -> Result<BTreeMap<String, u64>, Failure> {
    let mut counts = BTreeMap::new();
    for text in written {
        let pair =
            text.rsplit_once('=').and_then(|(name, n)| Some((name.trim(), n.trim().parse::<u64>().ok()?)));
        let Some((name, count)) = pair else {
            return Err(Failure::Usage(format!(
                "--counts: found `{text}`, expected name=number; correct it"
            )));
        };
        let Some(there) = available.get(name) else {
            let near = nearest(name, available.keys().map(String::as_str)).unwrap_or_default();
            return Err(Failure::Usage(format!(
                "--counts: found maneuver `{name}`, expected one of the trajectories'; did you mean `{near}`?"
            )));
        };
        if count > *there {
            let found = format!("--counts: found {count} of `{name}`, expected at most {there}");
            return Err(Failure::Usage(format!("{found}; lower it")));
        }
        *counts.entry(name.to_owned()).or_default() += count;
    }
    if counts.values().sum::<u64>() == 0 {
        let found = "--counts: found none, expected name=number or --design";
        return Err(Failure::Usage(format!("{found}; name what to pick")));
    }
    Ok(counts)
}
