//! The pieces and their counts: from the design's shares or as the task states.

use refusal::Invalid;
use ship::engine::Run;

use super::error::VoyageError;
use super::task::{Brief, ManeuverUse, Shares};
use crate::BASIC_MOVES;
use trial::Piece;

/// Most uses of a maneuver that a share may lead to.
const MOST_USES: f64 = 1e6;

/// A piece with the number of its uses.
#[derive(Clone, Debug)]
pub struct Wanted {
    /// The piece that is run as one use.
    pub piece: Piece,
    /// How often.
    pub count: u32,
}

impl Brief {
    /// The pieces of the maneuvers that the task names (by default of those in the design) with their counts.
    pub(super) fn wanted(&self) -> Result<Vec<Wanted>, VoyageError> {
        let mut all: Vec<Wanted> = Vec::new();
        for maneuver in &self.named()? {
            check_name(&maneuver.name, &all)?;
            let piece = self.piece(maneuver)?;
            let count = maneuver.count.map_or_else(|| self.count(&piece), Ok)?;
            if count > 0 {
                all.push(Wanted { piece, count });
            }
        }
        if all.is_empty() {
            let found = "no maneuver that is used at least once";
            let remedy = "raise a `count`, lengthen `informative_s` or shorten `piece_s`";
            return Err(Invalid::new("counts", found, "at least one use", remedy).into());
        }
        Ok(all)
    }

    /// The maneuvers that the task names; those of the design where it names none.
    ///
    /// # Errors
    /// Neither names nor a design.
    pub fn named(&self) -> Result<Vec<ManeuverUse>, Invalid> {
        match (&self.task.maneuvers[..], &self.design) {
            ([], Some(design)) => Ok(design.used()),
            ([], None) => Err(Invalid::new(
                "[[maneuver]]",
                "none, and no design",
                "maneuvers with their counts, or a design that has shares",
                "add [[maneuver]] tables, or give --design",
            )),
            (named, _) => Ok(named.to_vec()),
        }
    }

    /// The run of a maneuver in the dictionary.
    pub fn run(&self, name: &str) -> Option<&Run> {
        self.dictionary.iter().find(|run| run.segments[0].maneuver == name)
    }

    fn piece(&self, wanted: &ManeuverUse) -> Result<Piece, VoyageError> {
        let names = || self.dictionary.iter().map(|run| run.segments[0].maneuver.clone());
        let Some(run) = self.run(&wanted.name) else {
            return Err(VoyageError::UnknownManeuver { name: wanted.name.clone(), known: names().collect() });
        };
        let target = wanted.piece_s.map(|s| self.vessel.samples(s));
        let helm = self.programs.get(&wanted.name).cloned();
        let whole = Piece { helm, ..Piece::whole(&self.vessel, run) };
        Ok(whole.cut(target)?.timed(&self.vessel)?)
    }

    /// n_q = N_q / N′_q, rounded, with N_q = share × time.
    fn count(&self, piece: &Piece) -> Result<u32, VoyageError> {
        let refuse = |found: &str, remedy: &str| {
            let thing = format!("maneuver `{}`", piece.maneuver);
            Err(Invalid::new(thing, found, "a `count`, or a design's share of `informative_s`", remedy)
                .into())
        };
        let Some(design) = &self.design else {
            return refuse("no `count` and no design", "add `count` or give --design");
        };
        let Some(time) = self.task.informative_s else {
            return refuse("no `count` and no `informative_s`", "add one of them");
        };
        let Some(share) = design.share.get(&piece.maneuver) else {
            let (maneuver, known) = (piece.maneuver.clone(), design.order.clone());
            return Err(VoyageError::NoShare { maneuver, known });
        };
        let uses = share * time * self.vessel.sample_rate_hz / piece.samples as f64;
        Ok(uses.round().min(MOST_USES) as u32)
    }
}

impl Shares {
    /// The maneuvers with a share in the design.
    fn used(&self) -> Vec<ManeuverUse> {
        let used = self.order.iter().filter(|name| self.share.get(*name).is_some_and(|w| *w > 0.0));
        used.map(|name| ManeuverUse { name: name.clone(), count: None, piece_s: None }).collect()
    }
}

fn check_name(name: &str, earlier: &[Wanted]) -> Result<(), Invalid> {
    let thing = || format!("maneuver `{name}`");
    if BASIC_MOVES.contains(&name) {
        let expected = "a name that is no basic move's";
        let remedy = "rename it in the dictionary, and here";
        return Err(Invalid::new(thing(), "the name of a basic move", expected, remedy));
    }
    match earlier.iter().any(|w| w.piece.maneuver == name) {
        true => Err(Invalid::new(thing(), "it twice", "every maneuver once", "remove one")),
        false => Ok(()),
    }
}
