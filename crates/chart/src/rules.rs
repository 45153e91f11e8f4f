//! The rules of classes with the changes of `plan.toml`, and their application to an object.

use std::collections::BTreeMap;

use crate::enc::attribute::{CATDIS, RESTRN, VERCCL, VERCLR, VERCSA};
use crate::enc::{Feature, Geometry, class, class_name};

use crate::classes::{Ignored, Judged, Treatment, is, judged, of_class};
use crate::land::Land;
use crate::{DANGER_M, Invalid};

/// Radius of the danger around a point or line whose position is doubtful, unreliable, reported or estimated
/// \[m\]: the accuracy of zone of confidence C.
pub const DOUBTFUL_M: f64 = 500.0;
/// Positional accuracy of a chart: half a millimetre at its compilation scale \[m\].
const DRAWN_M: f64 = 0.5e-3;
/// Qualities of positions (QUAPOS) that are good enough for [`DANGER_M`]: surveyed, approximate (within 30
/// m), precisely known, calculated.
const GOOD: [u8; 4] = [1, 4, 10, 11];
/// Restrictions (RESTRN) that close an area: entry prohibited, entry restricted, to be avoided.
const CLOSED: [u16; 3] = [7, 8, 14];
/// A distance mark that is not physically there (CATDIS).
const UNMARKED: u16 = 1;
/// Restrictions that do not concern passing ships: no wake, stopping prohibited, speed restricted.
const PASSING: [u16; 3] = [13, 25, 27];

/// Settings that change or complete the table.
#[derive(Clone, Debug, Default)]
pub struct Rules {
    /// Classes by their acronym (or code, if the standard has none) with another treatment.
    pub changed: BTreeMap<String, Treatment>,
    /// The ship's air draught, including the required clearance \[m\]; if unknown, no bridge is high enough.
    pub air_draught_m: Option<f64>,
    /// Radius of the danger around points and lines \[m\]; [`DANGER_M`] by default.
    pub radius_m: Option<f64>,
    /// The same where a position is doubtful \[m\]; [`DOUBTFUL_M`] by default.
    pub doubtful_radius_m: Option<f64>,
}

impl Rules {
    /// Refuses changes of unknown classes, and of depths and coverage, which are judged by `safety` alone.
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
            let sharp = matches!(judged(code), Judged::Danger | Judged::Sounding | Judged::Contour);
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

    /// The treatment of an object in view of `land`, and why it has no effect if it has none.
    ///
    /// # Errors
    /// A clearance that is not a number.
    pub(crate) fn treatment(&self, feature: &Feature, land: &Land) -> Result<(Treatment, Ignored), Invalid> {
        let named = class_name(feature.class).map_or_else(|| feature.class.to_string(), str::to_owned);
        if let Some(changed) = self.changed.get(&named) {
            return Ok(match *changed != Treatment::Ignore && self.is_passed_under(feature)? {
                true => (Treatment::Ignore, Ignored::PassedUnder),
                false => (*changed, Ignored::Rule),
            });
        }
        let restrictions = feature.list(RESTRN);
        let any = |of: &[u16]| restrictions.iter().any(|r| of.contains(r));
        let usual = of_class(feature.class).map_or(Treatment::Avoid, |rule| rule.treatment);
        let ignored = of_class(feature.class).map_or(Ignored::NoBody, |rule| rule.ignored);
        let ignore = |why: Ignored| Ok((Treatment::Ignore, why));
        match () {
            () if self.is_passed_under(feature)? => ignore(Ignored::PassedUnder),
            () if any(&CLOSED) => Ok((Treatment::Avoid, ignored)),
            // Of a restricted area only its restrictions are known to matter.
            () if named == "RESARE" && !restrictions.is_empty() => match any(&PASSING) {
                true => Ok((Treatment::ManeuversAvoid, ignored)),
                false => ignore(Ignored::Restriction),
            },
            () if is(feature.class, "DISMAR") && feature.list(CATDIS) == [UNMARKED] => {
                ignore(Ignored::Unmarked)
            }
            () if judged(feature.class).stands() && land.holds(&feature.geometry) => ignore(Ignored::OnLand),
            () if any(&PASSING) => Ok((usual.max(Treatment::ManeuversAvoid), ignored)),
            () => Ok((usual, ignored)),
        }
    }

    /// The radius of an object's points and lines, on a chart of 1 to `scale` \[m\]; that of a danger if the
    /// scale is unknown.
    pub fn radius_m(&self, feature: &Feature, scale: Option<u32>) -> f64 {
        let drawn_m = scale.map_or(DANGER_M, |scale| DRAWN_M * f64::from(scale));
        let by_itself = matches!(judged(feature.class), Judged::Danger | Judged::Sounding);
        let is_point = matches!(feature.geometry, Geometry::Points(_));
        if !(by_itself || (is_point && judged(feature.class).reaches())) {
            return drawn_m;
        }
        let good = feature.position_quality.iter().all(|quality| GOOD.contains(quality));
        let radius_m = match good {
            true => self.radius_m.unwrap_or(DANGER_M),
            false => self.doubtful_radius_m.unwrap_or(DOUBTFUL_M),
        };
        radius_m.max(drawn_m)
    }

    /// Whether an object has a clearance and the ship passes under it.
    fn is_passed_under(&self, feature: &Feature) -> Result<bool, Invalid> {
        if judged(feature.class) != Judged::Clearance {
            return Ok(false);
        }
        // Opening bridges count as closed.
        let mut least: Option<f64> = None;
        for attribute in [VERCLR, VERCCL, VERCSA] {
            let number = feature.number(attribute)?;
            least = least.into_iter().chain(number).reduce(f64::min);
        }
        Ok(self.air_draught_m.zip(least).is_some_and(|(ship, clear)| ship <= clear))
    }
}
