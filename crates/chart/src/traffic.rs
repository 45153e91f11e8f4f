//! Objects that the crew has to know about, and where the traffic has a direction: lanes, zones that separate them, ways for one direction.

use std::f64::consts::{FRAC_PI_2, FRAC_PI_4, PI};

use crate::enc::{CATZOC, Feature, ORIENT, TRAFIC, class_name};
use crate::{Called, Invalid};

/// Largest angle between a course and a direction that it follows \[rad\].
const ALONG_RAD: f64 = FRAC_PI_4;
/// Inbound, outbound and one-way (TRAFIC).
const ONE_WAY: [u16; 3] = [1, 2, 3];

/// What the traffic of a place asks of a course (COLREG, rule 10; bearings are true \[rad\]).
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Traffic {
    /// A lane: along its direction, or across it.
    Lane(f64),
    /// A way for one direction: not against it.
    OneWay(f64),
    /// A zone that separates lanes of a direction: across only; not at all, if no lane is known.
    Zone(Option<f64>),
}

/// Classes that the crew has to know about where the ship passes them, besides those with traffic: whom to call, what lies on the ground,
/// where others meet.
const NOTED: [&str; 22] = [
    "PILBOP", "RDOCAL", "CBLSUB", "CBLARE", "PIPSOL", "PIPARE", "SPLARE", "DMPGRD", "CTNARE", "MIPARE",
    "SUBTLN", "FERYRT", "FAIRWY", "ISTZNE", "PRCARE", "DWRTPT", "TWRTPT", "TSSLPT", "TSSRON", "TSSCRS",
    "ACHARE", "ACHBRT",
];

/// What an object is called that the crew has to know about, whether or not its traffic has a direction.
pub(crate) fn label(feature: &Feature) -> Option<Called> {
    match class_name(feature.class)? {
        "M_QUAL" => {
            let category = *feature.list(CATZOC).first()?;
            let letter = ZONES.get(usize::from(category).checked_sub(1)?)?;
            Some(Called { name: Some((*letter).into()), ..Called::plain("zone of confidence") })
        }
        name => NOTED.contains(&name).then(|| Called::object(feature, None)),
    }
}

/// Zones of confidence, by the codes of CATZOC.
const ZONES: [&str; 6] = ["A1", "A2", "B", "C", "D", "not assessed"];

impl Traffic {
    /// The traffic of an object; `None` for one without a direction, such as the part of a lane where others join it.
    ///
    /// # Errors
    /// A direction that is no bearing.
    pub(crate) fn of(feature: &Feature) -> Result<Option<Self>, Invalid> {
        let name = class_name(feature.class).unwrap_or_default();
        let is_one_way = || feature.list(TRAFIC).iter().any(|way| ONE_WAY.contains(way));
        let new = match name {
            "TSEZNE" => return Ok(Some(Self::Zone(None))),
            "TSSLPT" => Self::Lane,
            "RCTLPT" => Self::OneWay,
            "RCRTCL" | "RECTRC" | "DWRTPT" | "DWRTCL" if is_one_way() => Self::OneWay,
            _ => return Ok(None),
        };
        let Some(towards_deg) = feature.number(ORIENT)? else { return Ok(None) };
        if (0.0..=360.0).contains(&towards_deg) {
            return Ok(Some(new(towards_deg.to_radians())));
        }
        let remedy =
            format!("report it to the chart's producer, and keep out: `rules = {{ {name} = \"avoid\" }}`");
        let thing = format!("{}, `{}`", feature.named(), ORIENT.1);
        Err(Invalid::new(thing, format!("{towards_deg}"), "a bearing from 0 to 360°", remedy))
    }

    /// Whether a ship may sail such a course there \[rad\]; across means within `crossing_rad` of a right angle.
    pub fn admits(self, course_rad: f64, crossing_rad: f64) -> bool {
        let off = |towards: f64| libm::remainder(course_rad - towards, 2.0 * PI).abs();
        let crosses = |towards: f64| (off(towards) - FRAC_PI_2).abs() <= crossing_rad;
        match self {
            Self::Lane(towards) => off(towards) <= ALONG_RAD || crosses(towards),
            Self::OneWay(towards) => off(towards) < PI - ALONG_RAD,
            Self::Zone(towards) => towards.is_some_and(crosses),
        }
    }
}
