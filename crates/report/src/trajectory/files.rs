//! Collects a planned trajectory: `plan.json`, its variants, their maps, and the simulated trials of it.

use std::path::Path;

use files::{Digest, Error, Loaded, exists};

use crate::loader::Loader;
use crate::planned_trial::{PlannedTrial, map};
use crate::study::Trajectory;
use study::documents::PlanDocument;

/// The files that `plan` writes next to `plan.json`.
const ADDITIONAL: [(&str, &str); 5] = [
    ("track.parquet", "planned trajectory, every sample"),
    ("track.geojson", "planned track, for charts"),
    ("route.rtz", "route for the bridge"),
    ("route.gpx", "route and track for receivers"),
    ("route.plan", "route for ground stations of autopilots"),
];

/// The trajectory that the study plans; `None` if there is neither `plan.toml` nor `plan.json`.
pub(crate) fn trajectory(loader: &mut Loader) -> Result<Option<Trajectory>, Error> {
    let config = loader.sources.study.join("plan.toml");
    if exists(&config) {
        loader.note("plan.toml", "chart, lattice, safety, counts, start and goal", Digest::of_file(&config)?);
    } else if !exists(loader.sources.results.join("plan.json")) {
        return Ok(None);
    }
    let main = planned(loader, "")?;
    let mut variants = Vec::new();
    for name in folders(&loader.sources.results)? {
        variants.extend(planned(loader, &name)?);
    }
    Ok(Some(Trajectory {
        main,
        variants,
        estimate: loader.document("planned/estimate.json", "estimates of the simulated planned trials")?,
        validation: loader.document("planned/validation.json", "errors of the simulated planned trials")?,
    }))
}

/// Names of the folders `plan-*`, by the first number in them and by name.
fn folders(results: &Path) -> Result<Vec<String>, Error> {
    let fails = |e| Error::io(results, "list", e);
    let mut names = Vec::new();
    files::observe_names(results, "plan-*");
    for entry in std::fs::read_dir(results).map_err(fails)? {
        let entry = entry.map_err(fails)?;
        let name = entry.file_name().into_string().unwrap_or_default();
        if name.starts_with("plan-") && entry.path().is_dir() {
            names.push(name);
        }
    }
    names.sort_by_key(|name| (number(name), name.clone()));
    Ok(names)
}

/// The first number in a name: 4 of `plan-4-headings`.
fn number(name: &str) -> Option<u64> {
    name.split(|c: char| !c.is_ascii_digit()).find_map(|digits| digits.parse().ok())
}

/// The plan in folder `name` of the results; the study's own if it is empty.
fn planned(loader: &mut Loader, name: &str) -> Result<Option<PlannedTrial>, Error> {
    let within = |file: &str| if name.is_empty() { file.to_owned() } else { format!("{name}/{file}") };
    let what = if name.is_empty() { "planned trajectory" } else { "the same trial planned otherwise" };
    let Some(loaded) = loader.loaded::<PlanDocument>(&within("plan.json"), what)? else { return Ok(None) };
    let stale = stale(loader, name, &loaded);
    let (map, document) = map(loader, &within("map"))?;
    if name.is_empty() {
        for (file, what) in ADDITIONAL {
            let path = loader.sources.results.join(file);
            if exists(&path) {
                loader.note(file, what, Digest::of_file(&path)?);
            }
        }
    }
    charts(loader, &loaded);
    Ok(Some(PlannedTrial { name: name.to_owned(), plan: loaded.data, map, document, stale }))
}

/// The charts of the plan, by their names in it; each once.
fn charts(loader: &mut Loader, loaded: &Loaded<PlanDocument>) {
    for (role, digest) in &loaded.provenance.inputs {
        let Some(name) = role.strip_prefix("chart:") else { continue };
        let digest = digest.to_string();
        if loader.files.iter().all(|(known, _, other)| (known.as_str(), other) != (name, &digest)) {
            loader.files.push((name.to_owned(), "chart that was planned on".to_owned(), digest));
        }
    }
}

/// Files of the study that differ from those that the plan was made from.
fn stale(loader: &Loader, name: &str, loaded: &Loaded<PlanDocument>) -> Vec<String> {
    let config = if name.is_empty() { "plan.toml".to_owned() } else { format!("{name}.toml") };
    let roles = [
        ("vessel", "vessel.toml"),
        ("plan", config.as_str()),
        ("trajectories", "dictionary.parquet"),
        ("design", "design.json"),
    ];
    let differs = |(role, file): &(&str, &str)| {
        let Some(used) = loaded.provenance.inputs.get(*role) else { return false };
        let noted = loader.files.iter().find(|(known, ..)| known == file).map(|(.., digest)| digest.clone());
        let join = loader.sources.study.join(file);
        let found = noted.or_else(|| Digest::of_file(join).ok().map(|digest| digest.to_string()));
        found.is_some_and(|found| found != used.to_string())
    };
    roles.iter().filter(|role| differs(role)).map(|(_, file)| (*file).to_owned()).collect()
}
