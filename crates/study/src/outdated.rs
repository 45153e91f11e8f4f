//! Documents whose files in the study are not what they were made of any more.

use std::collections::{BTreeMap, BTreeSet};
use std::path::Path;

use chart::{Bounds, Plane};
use files::{Digest, Error, Inspected, Provenance, budget};

use crate::files::{read_ingest, read_plan};
use crate::ingest_file::recordings::find;
use crate::plan::{ChartsError, Means, read_charts};
use crate::{invalid, refuse};

/// Digests of inputs by their roles, now; `None` if it is not known where they are.
type Now = Option<BTreeMap<String, Digest>>;

/// Files that the document or table `found` at `path` was made of and that are not so in the folder `study`, one line each.
pub(crate) fn outdated(path: &Path, found: &Inspected, study: &Path) -> Vec<String> {
    let made = &found.provenance;
    let now = match found.schema.split('/').next() {
        Some("plan") => of_plan(path, made, study),
        Some("ingest") => of_logs(study),
        // What was made of these has their roles.
        _ => Ok(Some(made.inputs.clone())),
    };
    let mut now = match now {
        Ok(Some(now)) => now,
        Ok(None) => return Vec::new(),
        Err(error) => return vec![error.to_string()],
    };
    // Tables of a dictionary have names relative to the study; what is not there is elsewhere.
    let tables = made.inputs.keys().filter_map(|role| Some((role, role.strip_prefix("inputs:")?)));
    now.extend(
        tables.filter_map(|(role, name)| Some((role.clone(), Digest::of_file(study.join(name)).ok()?))),
    );
    // With values that were replaced on the command line, the digest is of what was read instead.
    let is_changed = |role: &str| made.settings.contains_key("set") && ["plan", "config"].contains(&role);
    let kinds = ["chart:", "tide", "log:"];
    let before = made.inputs.keys().filter(|role| kinds.iter().any(|kind| role.starts_with(kind)));
    let roles: BTreeSet<&String> = before.chain(now.keys()).collect();
    let differs = |role: &&String| !is_changed(role) && made.inputs.get(*role) != now.get(*role);
    let fault = |role: &String| {
        let found = match (made.inputs.get(role), now.get(role)) {
            (Some(_), Some(_)) => "another content in the study",
            (Some(_), None) => "no such file in the study",
            _ => "it in the study, where it was not",
        };
        refuse(path, role, found, "the files that this was made of", "run its stage again").to_string()
    };
    roles.into_iter().filter(differs).map(fault).collect()
}

/// The files of the plan at `path`: plan.toml, or that called as the plan or its folder.
fn of_plan(path: &Path, made: &Provenance, study: &Path) -> Result<Now, Error> {
    let own = [path.file_stem(), path.parent().and_then(Path::file_name)].into_iter().flatten();
    let mut names = own.map(|name| name.to_string_lossy().into_owned());
    let name = names.find(|name| name.starts_with("plan-")).unwrap_or_else(|| "plan".to_owned());
    let file = study.join(format!("{name}.toml"));
    if !file.is_file() {
        return Ok(None);
    }
    let mut now = Provenance::default();
    let config = read_plan(&file, &mut now)?;
    // The charts of another plan.toml say nothing.
    if made.inputs.get("plan") != now.inputs.get("plan") && !made.settings.contains_key("set") {
        let charts = made.inputs.iter().filter(|(role, _)| *role != "plan");
        now.inputs.extend(charts.map(|(role, digest)| (role.clone(), *digest)));
        return Ok(Some(now.inputs));
    }
    let plane = Plane::new(config.start.longitude_deg, config.start.latitude_deg);
    let plane = plane.map_err(|wrong| invalid(&file, &wrong))?;
    let bounds = Bounds::new([-50.0; 2], [50.0; 2]).map_err(|wrong| invalid(&file, &wrong))?;
    let means = Means { area: (&plane, &bounds), budget: budget(), keep_going: &|| true };
    match read_charts(&file, &config, &means, &mut now) {
        Err(ChartsError::Refused(error)) => return Err(error),
        Err(ChartsError::OutOfTime) | Ok(_) => {}
    }
    if let Some(tide) = &config.tide {
        now.inputs.insert("tide".to_owned(), Digest::of_file(study.join(&tide.file))?);
    }
    Ok(Some(now.inputs))
}

/// ingest.toml and the logs that it names, in the folder `logs` of the study or the study itself.
fn of_logs(study: &Path) -> Result<Now, Error> {
    let file = study.join("ingest.toml");
    if !file.is_file() {
        return Ok(None);
    }
    let mut now = Provenance::default();
    let config = read_ingest(&file, &mut now)?;
    let naming = config.naming().map_err(|wrong| invalid(&file, &wrong))?;
    let folders = [study.join("logs"), study.to_owned()];
    let Some(folder) = folders.iter().find(|folder| find(&config, &naming, &file, folder).is_ok()) else {
        return Ok(None);
    };
    for name in find(&config, &naming, &file, folder)?.iter().flat_map(|own| own.files.iter().flatten()) {
        now.inputs.insert(format!("log:{name}"), Digest::of_file(folder.join(name))?);
    }
    Ok(Some(now.inputs))
}
