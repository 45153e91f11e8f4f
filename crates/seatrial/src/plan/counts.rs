//! Which pieces, how often: from the design's shares or as `plan.toml` says.

use std::path::Path;

use trial::Piece;
use vessel::{Invalid, Vessel, nearest};

use super::config::{ManeuverUse, PlanFile};
use crate::failure::Failure;
use study::documents::DesignDocument;
use vessel::Run;

/// A piece with the number of its uses.
#[derive(Clone, Debug)]
pub(super) struct Wanted {
    pub piece: Piece,
    pub count: u32,
}

/// The pieces of the maneuvers that `config` names (without any, of those that the design uses) with their counts.
pub(super) fn wanted(
    config_file: &Path,
    config: &PlanFile,
    vessel: &Vessel,
    dictionary: (&Path, &[Run]),
    design: Option<(&Path, &DesignDocument)>,
) -> Result<Vec<Wanted>, Failure> {
    let named = match (config.maneuver.is_empty(), design) {
        (false, _) => config.maneuver.clone(),
        (true, Some((_, design))) => of_design(design),
        (true, None) => {
            return Err(Failure::refuse(
                config_file,
                "[[maneuver]]",
                "none, and no design",
                "maneuvers with their counts, or a design that has shares",
                "add [[maneuver]] tables, or give --design",
            ));
        }
    };
    let mut all: Vec<Wanted> = Vec::new();
    for maneuver in &named {
        if trial::BASIC_MOVES.contains(&maneuver.name.as_str()) {
            let thing = format!("maneuver `{}`", maneuver.name);
            let expected = "a name that is no basic move's";
            let remedy = "rename it in the dictionary, and here";
            return Err(Failure::refuse(config_file, &thing, "the name of a basic move", expected, remedy));
        }
        if all.iter().any(|w| w.piece.maneuver == maneuver.name) {
            let thing = format!("maneuver `{}`", maneuver.name);
            return Err(Failure::refuse(
                config_file,
                &thing,
                "it twice",
                "every maneuver once",
                "remove one",
            ));
        }
        let piece = piece(vessel, dictionary, maneuver).map_err(|e| Failure::invalid(config_file, &e))?;
        let count = match maneuver.count {
            Some(count) => count,
            None => count_of(config_file, config, vessel, &piece, design)?,
        };
        if count > 0 {
            all.push(Wanted { piece, count });
        }
    }
    if all.is_empty() {
        let found = "no maneuver that is used at least once";
        let remedy = "raise a `count`, lengthen `informative_s` or shorten `piece_s`";
        return Err(Failure::refuse(config_file, "counts", found, "at least one use", remedy));
    }
    Ok(all)
}

fn of_design(design: &DesignDocument) -> Vec<ManeuverUse> {
    let used = design.order.iter().filter(|name| design.shares.get(*name).is_some_and(|w| *w > 0.0));
    used.map(|name| ManeuverUse { name: name.clone(), count: None, piece_s: None }).collect()
}

fn piece(vessel: &Vessel, dictionary: (&Path, &[Run]), wanted: &ManeuverUse) -> Result<Piece, Invalid> {
    let names = || dictionary.1.iter().map(|run| run.segments[0].maneuver.as_str());
    let Some(run) = dictionary.1.iter().find(|run| run.segments[0].maneuver == wanted.name) else {
        let near = nearest(&wanted.name, names()).unwrap_or_default();
        return Err(Invalid::new(
            format!("maneuver `{}`", wanted.name),
            "a count without a maneuver of that name",
            format!("a maneuver of {}: {}", dictionary.0.display(), names().collect::<Vec<_>>().join(", ")),
            format!("did you mean `{near}`?"),
        ));
    };
    let (width, all) = (vessel.model.inputs, vessel.model.exogenous());
    let inputs: Vec<f64> = run.exogenous.chunks_exact(all).flat_map(|row| row[..width].to_vec()).collect();
    let target = wanted.piece_s.map(|s| vessel.samples(s));
    Piece::cut(&wanted.name, run.initial[0], &inputs, width, target)
}

/// n_q = N_q / N′_q to the nearest, N_q = share × time.
fn count_of(
    config_file: &Path,
    config: &PlanFile,
    vessel: &Vessel,
    piece: &Piece,
    design: Option<(&Path, &DesignDocument)>,
) -> Result<u32, Failure> {
    let thing = format!("maneuver `{}`", piece.maneuver);
    let refuse = |found: &str, remedy: &str| {
        Err(Failure::refuse(
            config_file,
            &thing,
            found,
            "a `count`, or a design's share of `informative_s`",
            remedy,
        ))
    };
    let Some((design_file, design)) = design else {
        return refuse("no `count` and no design", "add `count` or give --design");
    };
    let Some(time) = config.informative_s else {
        return refuse("no `count` and no `informative_s`", "add one of them");
    };
    let Some(share) = design.shares.get(&piece.maneuver) else {
        let has = design.order.iter().map(String::as_str).collect::<Vec<_>>().join(", ");
        return Err(Failure::refuse(
            design_file,
            "`data.shares`",
            &format!("no share of maneuver `{}`", piece.maneuver),
            &format!("one of every maneuver without `count` in {}; it has {has}", config_file.display()),
            "make the design again from this dictionary, or give the maneuver a `count`",
        ));
    };
    Ok((share * time * vessel.sample_rate_hz / piece.samples as f64).round().min(1e6) as u32)
}
