//! Systems of coordinates, and units of depths as files and users write them.

use std::fmt;

use proj4rs::Proj;
use proj4rs::transform::transform;
use schemars::JsonSchema;
use serde::Deserialize;

use crate::Invalid;

const KNOWN: &str = "WGS84, `EPSG:` with the code of a system (such as EPSG:32635, EPSG:3067, EPSG:25832, EPSG:3857), or a `+proj=` string";

/// The coordinate reference system of a grid.
///
/// ETRS89, NAD83 and WGS84 are treated as equal (they differ by a metre or two); other datums are transformed
/// with the parameters of their definition, to a few metres. Datum grids (`+nadgrids`) are not read.
#[derive(Clone)]
pub struct Crs {
    name: String,
    definition: String,
    projection: Box<Proj>,
    wgs84: Box<Proj>,
}

impl fmt::Debug for Crs {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "Crs({})", self.name)
    }
}

impl Crs {
    /// `WGS84` (longitude, latitude in degrees), `EPSG:` and a code, or a PROJ string. Eastings and
    /// longitudes come first, regardless of the order in EPSG.
    ///
    /// # Errors
    /// Any other name; an unknown code, or one of an unknown projection.
    pub fn new(name: &str) -> Result<Self, Invalid> {
        let refuse = |why: &str| {
            Invalid::new(
                format!("CRS `{name}`"),
                why,
                KNOWN,
                "name one of these, or transform the file first",
            )
        };
        let text = definition(name.trim()).ok_or_else(|| refuse("an unknown name"))?;
        // `@null` means no grid, as in EPSG:3857.
        let grids = text.replace("+nadgrids=@null", "");
        if grids.contains("nadgrids") || text.contains("geocent") {
            return Err(refuse("datum grids or geocentric coordinates"));
        }
        let projection = Proj::from_proj_string(&text).map_err(|e| refuse(&e.to_string()))?;
        let wgs84 =
            Proj::from_proj_string("+proj=longlat +datum=WGS84").map_err(|e| refuse(&e.to_string()))?;
        if !(projection.has_inverse() && projection.has_forward()) {
            return Err(refuse("a projection without inverse"));
        }
        let name = name.trim().to_owned();
        Ok(Self { name, definition: text, projection: Box::new(projection), wgs84: Box::new(wgs84) })
    }

    /// Whether coordinates are longitudes and latitudes, by definition within a metre or two of those of WGS84.
    pub fn is_near_wgs84(&self) -> bool {
        let value = |key: &str| self.value(key);
        let datum = value("datum");
        let is_near =
            |shift: &str| shift.split(',').all(|part| part.parse().is_ok_and(|v: f64| v.abs() <= 1.0));
        let named = matches!(datum, Some("WGS84" | "NAD83"));
        let alike = datum.is_none() && matches!(value("ellps"), Some("WGS84" | "GRS80"));
        self.is_geographic()
            && value("pm").is_none()
            && (named || alike)
            && value("towgs84").is_none_or(is_near)
    }

    /// The unit of heights, where the definition has one.
    pub(crate) fn vertical_unit(&self) -> Option<DepthUnit> {
        DepthUnit::of_text(self.value("vunits")?)
    }

    /// The value of a key of the definition.
    fn value(&self, key: &str) -> Option<&str> {
        let projection =
            |part: &'_ str| part.strip_prefix('+')?.strip_prefix(key)?.strip_prefix('=').map(str::len);
        let part = self.definition.split_whitespace().find(|part| projection(part).is_some())?;
        part.split_once('=').map(|(_, value)| value)
    }

    /// The name as given.
    pub fn name(&self) -> &str {
        &self.name
    }

    /// Whether coordinates are longitude and latitude in degrees.
    pub fn is_geographic(&self) -> bool {
        self.projection.is_latlong()
    }

    /// Longitude and latitude (WGS84) \[deg\] of coordinates in this system.
    ///
    /// # Errors
    /// A place outside the projection's domain.
    pub fn to_geographic(&self, [x, y]: [f64; 2]) -> Result<(f64, f64), Invalid> {
        let mut point = if self.is_geographic() { (x.to_radians(), y.to_radians()) } else { (x, y) };
        let done = transform(&self.projection, &self.wgs84, &mut point);
        let lon_lat = (point.0.to_degrees(), point.1.to_degrees());
        match done {
            Ok(()) if lon_lat.0.is_finite() && lon_lat.1.abs() <= 90.0 => Ok(lon_lat),
            _ => Err(self.outside(&format!("coordinates {x}, {y}"))),
        }
    }

    /// Coordinates in this system of a longitude and latitude (WGS84) \[deg\].
    ///
    /// # Errors
    /// A place outside the projection's domain.
    pub fn to_own(&self, lon_deg: f64, lat_deg: f64) -> Result<[f64; 2], Invalid> {
        let mut point = (lon_deg.to_radians(), lat_deg.to_radians());
        let done = transform(&self.wgs84, &self.projection, &mut point);
        let scale = if self.is_geographic() { 1f64.to_degrees() } else { 1.0 };
        match done {
            Ok(()) if point.0.is_finite() && point.1.is_finite() => Ok([point.0 * scale, point.1 * scale]),
            _ => Err(self.outside(&format!("longitude {lon_deg}, latitude {lat_deg}"))),
        }
    }

    /// The refusal of a file whose coordinate system is unknown.
    pub(crate) fn undeclared() -> Invalid {
        let remedy = "add `crs = \"EPSG:…\"` to its [[chart]]";
        Invalid::new("`crs`", "none", "the system of the grid's coordinates", remedy)
    }

    fn outside(&self, found: &str) -> Invalid {
        Invalid::new(
            format!("CRS `{}`", self.name),
            found,
            "a place within the projection's domain",
            "check that the file is in this CRS and that the area is right",
        )
    }
}

fn definition(name: &str) -> Option<String> {
    if name.starts_with("+proj=") {
        return Some(name.to_owned());
    }
    let (authority, code) = parts(name);
    if authority.is_empty() && matches!(code.to_ascii_uppercase().as_str(), "WGS84" | "CRS84" | "CRS84H") {
        return Some("+proj=longlat +datum=WGS84".to_owned());
    }
    if authority == "OGC" && code.eq_ignore_ascii_case("CRS83") {
        return Some("+proj=longlat +datum=NAD83".to_owned());
    }
    if authority != "EPSG" {
        return None;
    }
    crs_definitions::from_code(code.parse().ok()?).map(|known| known.proj4.to_owned())
}

/// Authority, in capitals, and code of a name such as `EPSG:4326`, `urn:ogc:def:crs:EPSG::4326` or
/// `http://www.opengis.net/def/crs/EPSG/0/4326`; OGC's own codes of longitude and latitude have no authority.
fn parts(name: &str) -> (String, &str) {
    let words: Vec<&str> =
        name.split([':', '/', '#']).map(str::trim).filter(|word| !word.is_empty()).collect();
    let code = words.last().copied().unwrap_or_default();
    let is_ogc = code.to_ascii_uppercase().starts_with("CRS84");
    let of = |authority: &&&str| ["EPSG", "OGC"].contains(&authority.to_ascii_uppercase().as_str());
    let authority = words.iter().rev().skip(1).find(of).filter(|_| !is_ogc);
    (authority.map_or_else(String::new, |word| word.to_ascii_uppercase()), code)
}

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
        let is_it = |unit: &&About| unit.1.replace('-', "") == word || unit.4.contains(&word.as_str());
        ALL.iter().find(is_it).map(|unit| unit.0)
    }

    /// The unit of an EPSG code.
    pub(crate) fn of_epsg(code: u16) -> Option<Self> {
        ALL.iter().find(|unit| code > 0 && unit.3 == code).map(|unit| unit.0)
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
    let names: Vec<&str> = ALL.iter().map(|unit| unit.1).collect();
    Invalid::new(
        thing,
        format!("`{}`", refusal::foreign(text)),
        format!("a unit of depths: {}", names.join(", ")),
        "convert the depths to metres, or correct the unit in the file",
    )
}
