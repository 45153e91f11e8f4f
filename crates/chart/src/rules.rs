//! What objects of an electronic chart mean to a trial, class by class: one table.

use std::collections::BTreeMap;

use enc::attribute::{RESTRN, VERCCL, VERCLR, VERCSA};
use enc::{Feature, class, class_name};
use serde::{Deserialize, Serialize};

use crate::{DANGER_M, Invalid};

/// How far around a point or line the danger reaches whose position is doubtful, unreliable, reported or estimated \[m\]: the
/// accuracy of zones of confidence C.
pub const DOUBTFUL_M: f64 = 500.0;
/// How well a chart shows a place: half a millimetre at its compilation scale \[m\].
const DRAWN_M: f64 = 0.5e-3;
/// Qualities of positions (QUAPOS) that are good enough for [`DANGER_M`]: surveyed, approximate (within 30 m), precisely
/// known, calculated.
const GOOD: [u8; 4] = [1, 4, 10, 11];
/// Restrictions (RESTRN) that close an area: entry prohibited, entry restricted, to be avoided.
const CLOSED: [u16; 3] = [7, 8, 14];
/// Restrictions that leave it to ships that pass: no wake, stopping prohibited, speed restricted.
const PASSING: [u16; 3] = [13, 25, 27];

/// What objects of a class do to a trial.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord, Deserialize, Serialize)]
#[serde(rename_all = "kebab-case")]
pub enum Treatment {
    /// Nothing.
    Ignore,
    /// Informative maneuvers keep out; getting about does not.
    ManeuversAvoid,
    /// The ship keeps out.
    Avoid,
}

/// By what an object is judged.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Judged {
    /// It charts water of a least depth (DRVAL1).
    Depth,
    /// It is an obstacle unless the depth over it (VALSOU) is known and enough, and water stands over it (WATLEV).
    Danger,
    /// So is every sounding.
    Sounding,
    /// It is an obstacle where its depth (VALDCO) is too little.
    Contour,
    /// It is solid or afloat.
    Solid,
    /// It is an obstacle unless the clearance under it is known and the ship's air draught less.
    Clearance,
    /// By where it is, and what is restricted there (RESTRN).
    Place,
    /// It says where there are data (CATCOV).
    Coverage,
}

/// What a class means where nothing else is said.
#[derive(Clone, Copy, Debug)]
pub struct Rule {
    /// Acronyms of the classes.
    pub classes: &'static [&'static str],
    /// By what their objects are judged.
    pub judged: Judged,
    /// What they do.
    pub treatment: Treatment,
}

const fn rule(classes: &'static [&'static str], judged: Judged, treatment: Treatment) -> Rule {
    Rule { classes, judged, treatment }
}

/// The rules. Standard classes that none of them names are ignored: aids on land, names, lights, what matters to anchors and
/// nets only.
pub const RULES: [Rule; 15] = [
    rule(&["DEPARE", "DRGARE"], Judged::Depth, Treatment::Avoid),
    rule(&["OBSTRN", "WRECKS", "UWTROC"], Judged::Danger, Treatment::Avoid),
    rule(&["SOUNDG"], Judged::Sounding, Treatment::Avoid),
    rule(&["DEPCNT"], Judged::Contour, Treatment::Ignore),
    rule(
        &["LNDARE", "PONTON", "HULKES", "FLODOC", "SLCONS", "DRYDOC", "CAUSWY"],
        Judged::Solid,
        Treatment::Avoid,
    ),
    rule(
        &["DAMCON", "GATCON", "PYLONS", "OFSPLF", "PILPNT", "MORFAC", "OILBAR"],
        Judged::Solid,
        Treatment::Avoid,
    ),
    rule(
        &["FSHFAC", "MARCUL", "LOGPON", "ICEARE", "OSPARE", "LITFLT", "LITVES"],
        Judged::Solid,
        Treatment::Avoid,
    ),
    rule(&["BOYCAR", "BOYINB", "BOYISD", "BOYLAT", "BOYSAW", "BOYSPP"], Judged::Solid, Treatment::Avoid),
    rule(&["BCNCAR", "BCNISD", "BCNLAT", "BCNSAW", "BCNSPP"], Judged::Solid, Treatment::Avoid),
    rule(&["COALNE"], Judged::Solid, Treatment::Ignore),
    rule(&["BRIDGE", "CBLOHD", "PIPOHD", "CONVYR"], Judged::Clearance, Treatment::Avoid),
    rule(&["UNSARE", "RESARE", "TSEZNE", "NEWOBJ"], Judged::Place, Treatment::Avoid),
    rule(
        &[
            "FAIRWY", "TSSLPT", "TSSRON", "TSSCRS", "TSSBND", "TSELNE", "ISTZNE", "PRCARE", "DWRTPT",
            "TWRTPT", "ACHARE", "ACHBRT", "PILBOP", "MIPARE", "SUBTLN", "SPLARE", "CTNARE",
        ],
        Judged::Place,
        Treatment::ManeuversAvoid,
    ),
    rule(
        &[
            "CBLARE", "CBLSUB", "PIPARE", "PIPSOL", "DMPGRD", "FSHGRD", "FERYRT", "ICNARE", "TESARE",
            "EXEZNE", "FSHZNE",
        ],
        Judged::Place,
        Treatment::Ignore,
    ),
    rule(&["M_COVR"], Judged::Coverage, Treatment::Ignore),
];

/// What is asked of a chart besides the table.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    /// Classes by their acronym (or code, where the standard has none) that are treated otherwise.
    pub changed: BTreeMap<String, Treatment>,
    /// The ship's height above water, with what is to stay free over it \[m\]; unknown: no bridge is high enough.
    pub air_draught_m: Option<f64>,
    /// How far around its points and lines a danger reaches \[m\]; [`DANGER_M`] without it.
    pub radius_m: Option<f64>,
    /// The same where a position is doubtful \[m\]; [`DOUBTFUL_M`] without it.
    pub doubtful_radius_m: Option<f64>,
}

impl Rules {
    /// Refuses changes of what is no class, and of depths and coverage, which are judged by `safety` alone.
    ///
    /// # Errors
    /// Names the class.
    pub fn check(&self) -> Result<(), Invalid> {
        for (name, treatment) in &self.changed {
            let thing = format!("`rules.{name}`");
            let known = class(name).or_else(|| name.parse().ok().filter(|code| class_name(*code).is_none()));
            let Some(code) = known else {
                let names = (1..500).filter_map(class_name);
                return Err(Invalid {
                    expected: "an object class of S-57".into(),
                    ..Invalid::unknown(thing, name, names)
                });
            };
            let fixed = matches!(judged(code), Judged::Depth | Judged::Coverage);
            let sharp = !matches!(judged(code), Judged::Solid | Judged::Place | Judged::Clearance);
            let found = format!("{treatment:?}");
            if fixed {
                let remedy =
                    "leave it out: depths are judged by `safety.transit_depth_m` and `safety.trial_depth_m`";
                return Err(Invalid::new(thing, found, "no rule for depths and coverage", remedy));
            }
            if sharp && *treatment == Treatment::ManeuversAvoid {
                let remedy = "maneuvers have `safety.trial_depth_m` of their own";
                return Err(Invalid::new(thing, found, "`avoid` or `ignore`", remedy));
            }
        }
        Ok(())
    }

    /// What an object does.
    pub fn treatment(&self, feature: &Feature) -> Treatment {
        let named = class_name(feature.class).map_or_else(|| feature.class.to_string(), str::to_owned);
        if let Some(changed) = self.changed.get(&named) {
            return *changed;
        }
        let usual = usual(feature.class);
        let restrictions = feature.list(RESTRN);
        let any = |of: &[u16]| restrictions.iter().any(|r| of.contains(r));
        match () {
            () if any(&CLOSED) => Treatment::Avoid,
            // Of a restricted area nothing but its restrictions is known to matter.
            () if named == "RESARE" && !restrictions.is_empty() => match any(&PASSING) {
                true => Treatment::ManeuversAvoid,
                false => Treatment::Ignore,
            },
            () if any(&PASSING) => usual.max(Treatment::ManeuversAvoid),
            () => usual,
        }
    }

    /// How far around its points and lines an object reaches, on a chart of 1 to `scale` \[m\]; as far as a danger
    /// where that is not known.
    pub fn radius_m(&self, feature: &Feature, scale: Option<u32>) -> f64 {
        let drawn_m = scale.map_or(DANGER_M, |scale| DRAWN_M * f64::from(scale));
        if !matches!(judged(feature.class), Judged::Danger | Judged::Sounding) {
            return drawn_m;
        }
        let good = feature.position_quality.iter().all(|quality| GOOD.contains(quality));
        let asked = match good {
            true => self.radius_m.unwrap_or(DANGER_M),
            false => self.doubtful_radius_m.unwrap_or(DOUBTFUL_M),
        };
        asked.max(drawn_m)
    }

    /// Whether the ship passes under an object.
    ///
    /// # Errors
    /// A clearance that is no number.
    pub fn passes_under(&self, feature: &Feature) -> Result<bool, Invalid> {
        // Bridges that open are taken as closed.
        let mut least: Option<f64> = None;
        for attribute in [VERCLR, VERCCL, VERCSA] {
            let own = feature.number(attribute)?;
            least = least.into_iter().chain(own).reduce(f64::min);
        }
        Ok(self.air_draught_m.zip(least).is_some_and(|(ship, clear)| ship <= clear))
    }
}

/// By what a class is judged; one that the standard lacks, by its place.
pub(crate) fn judged(code: u16) -> Judged {
    of_class(code).map_or(Judged::Place, |rule| rule.judged)
}

/// What a class does: one that the standard lacks may be anything, so it is kept out of.
fn usual(code: u16) -> Treatment {
    let unknown = if class_name(code).is_none() { Treatment::Avoid } else { Treatment::Ignore };
    of_class(code).map_or(unknown, |rule| rule.treatment)
}

fn of_class(code: u16) -> Option<&'static Rule> {
    let name = class_name(code)?;
    RULES.iter().find(|rule| rule.classes.contains(&name))
}
