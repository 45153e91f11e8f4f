//! Units of depths and heights, as files and users write them.

use schemars::JsonSchema;
use serde::Deserialize;

use crate::Invalid;

/// A unit of depths and heights.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Deserialize, JsonSchema)]
pub enum DepthUnit {
    /// Metres.
    #[serde(rename = "m")]
    Metre,
    /// Tenths of a metre.
    #[serde(rename = "dm")]
    Decimetre,
    /// Hundredths of a metre.
    #[serde(rename = "cm")]
    Centimetre,
    /// Thousandths of a metre.
    #[serde(rename = "mm")]
    Millimetre,
    /// Thousands of metres.
    #[serde(rename = "km")]
    Kilometre,
    /// International feet of 0.3048 m.
    #[serde(rename = "ft")]
    Foot,
    /// Feet of the surveys of the United States, 1200/3937 m.
    #[serde(rename = "us-ft")]
    SurveyFoot,
    /// Fathoms of six international feet.
    #[serde(rename = "fathom")]
    Fathom,
}

/// A unit: its name in `plan.toml`, its length in metres, its EPSG code (0 if unknown), and other spellings
/// in files, in lower case without spaces.
type About = (DepthUnit, &'static str, f64, u16, &'static [&'static str]);

const ALL: [About; 8] = [
    (DepthUnit::Metre, "m", 1.0, 9001, &["metre", "metres", "meter", "meters"]),
    (DepthUnit::Decimetre, "dm", 0.1, 0, &["decimetre", "decimetres", "decimeter", "decimeters"]),
    (DepthUnit::Centimetre, "cm", 0.01, 1033, &["centimetre", "centimetres", "centimeter", "centimeters"]),
    (DepthUnit::Millimetre, "mm", 0.001, 1025, &["millimetre", "millimetres", "millimeter", "millimeters"]),
    (DepthUnit::Kilometre, "km", 1000.0, 9036, &["kilometre", "kilometres", "kilometer", "kilometers"]),
    (DepthUnit::Foot, "ft", 0.3048, 9002, &["foot", "feet", "internationalfoot", "internationalfeet"]),
    (
        DepthUnit::SurveyFoot,
        "us-ft",
        1200.0 / 3937.0,
        9003,
        &[
            "ussurveyfoot",
            "ussurveyfeet",
            "surveyfoot",
            "surveyfeet",
            "usft",
            "usfoot",
            "usfeet",
            "ftus",
            "footus",
        ],
    ),
    (DepthUnit::Fathom, "fathom", 1.8288, 9014, &["fathoms", "fath", "fth", "ftm"]),
];

/// The origin of a unit.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum UnitFrom {
    /// The file states it.
    File,
    /// `depth_unit` states it.
    Declared,
    /// Not stated: metres are assumed.
    Assumed,
}

impl DepthUnit {
    fn about(self) -> &'static About {
        &ALL[self as usize]
    }

    /// As in `plan.toml`.
    pub fn name(self) -> &'static str {
        self.about().1
    }

    /// Its length \[m\].
    pub fn metres(self) -> f64 {
        self.about().2
    }

    /// The unit that a file spells `text`, regardless of case and plural.
    pub fn of_text(text: &str) -> Option<Self> {
        let parts = text.trim().split([' ', '_', '-', '.']);
        let word = parts.collect::<String>().to_ascii_lowercase();
        let is_it = |own: &&About| own.1.replace('-', "") == word || own.4.contains(&word.as_str());
        ALL.iter().find(is_it).map(|own| own.0)
    }

    /// The unit of an EPSG code.
    pub(crate) fn of_epsg(code: u16) -> Option<Self> {
        ALL.iter().find(|own| code > 0 && own.3 == code).map(|own| own.0)
    }

    /// The unit that a file states as `text`, if it does. `thing` names the statement in messages.
    pub(crate) fn stated(thing: &str, text: Option<&str>) -> Result<Option<Self>, Invalid> {
        let Some(text) = text.map(str::trim).filter(|text| !text.is_empty()) else { return Ok(None) };
        Self::of_text(text).map(Some).ok_or_else(|| unknown(thing, text))
    }

    /// The unit of a chart, and its origin: what the file states and what `depth_unit` declares must agree.
    ///
    /// # Errors
    /// Two units.
    pub fn agreed(stated: Option<Self>, declared: Option<Self>) -> Result<(Self, UnitFrom), Invalid> {
        match (stated, declared) {
            (Some(stated), Some(declared)) if stated != declared => Err(Invalid::new(
                "`depth_unit`",
                format!("`{}`", declared.name()),
                format!("`{}`, as the file says", stated.name()),
                "remove `depth_unit`, or correct the unit in the file",
            )),
            (Some(stated), _) => Ok((stated, UnitFrom::File)),
            (None, Some(declared)) => Ok((declared, UnitFrom::Declared)),
            (None, None) => Ok((Self::Metre, UnitFrom::Assumed)),
        }
    }
}

/// The refusal of an unknown unit in a file.
pub(crate) fn unknown(thing: &str, text: &str) -> Invalid {
    let names: Vec<&str> = ALL.iter().map(|own| own.1).collect();
    Invalid::new(
        thing,
        format!("`{}`", refusal::foreign(text)),
        format!("a unit of depths: {}", names.join(", ")),
        "convert the depths to metres, or correct the unit in the file",
    )
}
