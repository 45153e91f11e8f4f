//! GDAL's metadata of a GeoTIFF: scale, offset and unit of its numbers.

use std::collections::BTreeMap;
use std::io::{Read, Seek};

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};
use tiff::TiffError;
use tiff::decoder::Decoder;
use tiff::decoder::ifd::Value;
use tiff::tags::Tag;

use crate::crs::{DepthUnit, unknown};
use crate::{Crs, GridKind, Invalid};

/// Items of the first band and of the whole file, by their roles, or by name if they have none.
#[derive(Debug, Default, PartialEq)]
pub struct TiffMetadata {
    roles: BTreeMap<String, String>,
    names: BTreeMap<String, String>,
}

impl TiffMetadata {
    /// Of the text of the tag; empty where there is none.
    pub fn read(text: &str) -> Result<Self, Invalid> {
        let mut metadata = Self::default();
        let mut reader = Reader::from_str(text.trim_matches(['\0', ' ', '\n']));
        let (mut item, mut value) = (None, String::new());
        loop {
            match reader.read_event().map_err(|e| damaged(&e.to_string()))? {
                Event::Start(start) if start.name().as_ref() == "Item" => {
                    item = Some(Item::of(&start)?);
                    value.clear();
                }
                Event::Text(text) => value += &text,
                Event::End(_) => {
                    if let Some(item) = item.take() {
                        metadata.take(item, value.trim());
                    }
                }
                Event::Eof if item.is_some() => return Err(damaged("no end of an item")),
                Event::Eof => return Ok(metadata),
                _ => {}
            }
        }
    }

    fn take(&mut self, item: Item, value: &str) {
        if item.sample.is_some_and(|sample| sample != "0") {
            return;
        }
        let (all, key) = match item.role {
            Some(role) => (&mut self.roles, role),
            None => (&mut self.names, item.name),
        };
        all.insert(key.to_ascii_lowercase(), value.to_owned());
    }

    /// The number of a role.
    pub fn number(&self, role: &str) -> Result<Option<f64>, Invalid> {
        let Some(text) = self.roles.get(role) else { return Ok(None) };
        match text.parse::<f64>() {
            Ok(number) => Ok(Some(number)),
            Err(_) => {
                let quoted = format!("`{}`", refusal::foreign(text));
                Err(Invalid::new(
                    format!("GDAL_METADATA, {role}"),
                    quoted,
                    "a number",
                    "correct it in the file",
                ))
            }
        }
    }

    /// The unit of the numbers.
    pub fn unit(&self) -> Result<Option<DepthUnit>, Invalid> {
        let text = self.roles.get("unittype").or_else(|| self.names.get("units"));
        DepthUnit::stated("UNITTYPE", text.map(String::as_str))
    }

    /// The vertical datum, where it is an item.
    pub fn datum(&self) -> Option<String> {
        let text = ["vertical_datum", "vertical datum", "verticaldatum"]
            .iter()
            .find_map(|key| self.names.get(*key))?;
        (!text.is_empty()).then(|| refusal::foreign(text))
    }

    /// Refuses numbers that are declared as the other kind.
    pub fn check_direction(&self, kind: GridKind) -> Result<(), Invalid> {
        let text = |name: &str| self.names.get(name).map(String::as_str);
        Direction::check(kind, text("positive"), text("standard_name"))
    }
}

struct Item {
    name: String,
    role: Option<String>,
    sample: Option<String>,
}

impl Item {
    fn of(start: &BytesStart) -> Result<Self, Invalid> {
        let attribute = |name: &str| -> Result<Option<String>, Invalid> {
            let attribute = start.try_get_attribute(name).map_err(|e| damaged(&e.to_string()))?;
            let text = attribute.map(|attribute| attribute.value.trim().to_owned());
            Ok(text.filter(|text| !text.is_empty()))
        };
        let name = attribute("name")?.unwrap_or_default();
        Ok(Self { name, role: attribute("role")?, sample: attribute("sample")? })
    }
}

fn damaged(why: &str) -> Invalid {
    Invalid::new(
        "GDAL_METADATA",
        refusal::foreign(why),
        "XML as GDAL writes it",
        "write the file again, for instance with `gdal_translate`",
    )
}

/// Which way numbers grow.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Direction {
    /// Heights.
    Up,
    /// Depths.
    Down,
}

impl Direction {
    /// Refuses numbers whose attributes `positive` and `standard_name` contradict `kind`.
    ///
    /// # Errors
    /// Names the attribute.
    pub fn check(kind: GridKind, positive: Option<&str>, name: Option<&str>) -> Result<(), Invalid> {
        let (declared_as, declared, other) = match kind {
            GridKind::LandMask => return Ok(()),
            GridKind::Depth => (Self::Down, "depth", "elevation"),
            GridKind::Elevation => (Self::Up, "elevation", "depth"),
        };
        let refuse = |thing: &str, text: &str, expected: &str| {
            let stated = format!("`{}`, of a grid declared as `{declared}`", refusal::foreign(text));
            let remedy = format!("declare it as `{other}`, or correct the file");
            Err(Invalid::new(thing, stated, expected, remedy))
        };
        if let Some(text) = positive.map(str::trim).filter(|text| !text.is_empty()) {
            match text.to_ascii_lowercase().as_str() {
                "up" if declared_as == Self::Up => {}
                "down" if declared_as == Self::Down => {}
                _ => return refuse("`positive`", text, "`up` of elevations, `down` of depths"),
            }
        }
        match name.and_then(|name| Some((name, Self::named(name)?))) {
            Some((name, direction)) if direction != declared_as => {
                refuse("`standard_name`", name, "the name of what is declared")
            }
            _ => Ok(()),
        }
    }

    /// By the standard names of CF.
    fn named(name: &str) -> Option<Self> {
        let name = name.trim().to_ascii_lowercase();
        if name == "depth" || name.starts_with("depth_below") || name.starts_with("sea_floor_depth_below") {
            return Some(Self::Down);
        }
        let heights = ["height", "altitude", "surface_altitude", "bedrock_altitude", "ground_level_altitude"];
        let above = ["height_above_mean_sea_level", "height_above_geo", "height_above_reference_ellipsoid"];
        let is_height = heights.contains(&name.as_str()) || above.iter().any(|start| name.starts_with(start));
        is_height.then_some(Self::Up)
    }
}

/// Most bytes of a text in a tag.
pub(crate) const LONGEST_TEXT: f64 = (1 << 20) as f64;

const EXPORT: &str = "export it again, for instance with `gdal_translate -co COMPRESS=DEFLATE`";

/// How a value relates to its pixel, the geographic and the projected CRS.
const RASTER_TYPE: u16 = 1025;
const GEOGRAPHIC: u16 = 2048;
const PROJECTED: u16 = 3072;
/// The vertical CRS, its name, its datum and its unit.
const VERTICAL: u16 = 4096;
const VERTICAL_CITATION: u16 = 4097;
const VERTICAL_DATUM: u16 = 4098;
const VERTICAL_UNIT: u16 = 4099;
/// A value of `RASTER_TYPE`: coordinates and value belong to the pixel's centre.
const PIXEL_IS_POINT: u16 = 2;
/// The code of a CRS without one.
const USER_DEFINED: u16 = 32767;

/// Vertical EPSG systems in international feet, and in US survey feet.
const IN_FEET: [u16; 7] = [5614, 6130, 6131, 6132, 8050, 8051, 8228];
const IN_SURVEY_FEET: [u16; 6] = [5702, 6358, 6359, 6360, 8052, 8053];

/// The GeoKey directory: a header, then key, place, count and value; and the texts that it refers to.
pub(crate) struct Keys {
    directory: Vec<u16>,
    texts: String,
}

impl Keys {
    pub fn read<R: Read + Seek>(decoder: &mut Decoder<R>) -> Result<Self, Invalid> {
        let directory = decoder.find_tag_unsigned_vec(Tag::GeoKeyDirectoryTag).map_err(refuse)?;
        let texts = short_tag(decoder, Tag::GeoAsciiParamsTag)?;
        let texts = texts.and_then(|texts| texts.into_string().ok()).unwrap_or_default();
        Ok(Self { directory: directory.unwrap_or_default(), texts })
    }

    /// Place, count and value of a key.
    fn entry(&self, key: u16) -> Option<[u16; 3]> {
        let entries = self.directory.get(4..)?.chunks_exact(4);
        entries.filter(|entry| entry[0] == key).map(|entry| [entry[1], entry[2], entry[3]]).next()
    }

    /// The value of a key that is stored in the directory itself.
    fn value(&self, key: u16) -> Option<u16> {
        self.entry(key).filter(|[place, ..]| *place == 0).map(|[_, _, value]| value)
    }

    /// The EPSG code of a key, if it has one.
    fn code(&self, key: u16) -> Option<u16> {
        self.value(key).filter(|code| *code != 0 && *code != USER_DEFINED)
    }

    /// The text of a key.
    fn text(&self, key: u16) -> Option<String> {
        let [place, count, start] = self.entry(key)?;
        let range = usize::from(start)..usize::from(start) + usize::from(count);
        let text = self.texts.get(range).filter(|_| place == 34737)?.trim_matches(['|', '\0', ' ']);
        (!text.is_empty()).then(|| refusal::foreign(text))
    }

    /// Whether coordinates are those of the centres of cells.
    pub fn is_point(&self) -> bool {
        self.value(RASTER_TYPE) == Some(PIXEL_IS_POINT)
    }

    /// The vertical datum, by the name and the code of its system.
    pub fn datum(&self) -> Option<String> {
        let code = self.code(VERTICAL).map(|code| format!("EPSG:{code}"));
        let code = code.or_else(|| self.code(VERTICAL_DATUM).map(|code| format!("datum EPSG:{code}")));
        match (self.text(VERTICAL_CITATION), code) {
            (Some(name), Some(code)) => Some(format!("{name} ({code})")),
            (name, code) => name.or(code),
        }
    }

    /// The unit of the vertical CRS.
    pub fn unit(&self) -> Result<Option<DepthUnit>, Invalid> {
        let stated = match self.value(VERTICAL_UNIT).filter(|code| *code != 0) {
            None => None,
            Some(code) => match DepthUnit::of_epsg(code) {
                None => return Err(unknown("VerticalUnitsGeoKey", &code.to_string())),
                unit => unit,
            },
        };
        let of_system = match self.code(VERTICAL) {
            Some(code) if IN_FEET.contains(&code) => Some(DepthUnit::Foot),
            Some(code) if IN_SURVEY_FEET.contains(&code) => Some(DepthUnit::SurveyFoot),
            _ => None,
        };
        match (stated, of_system) {
            (Some(stated), Some(system)) if stated != system => Err(Invalid::new(
                "VerticalUnitsGeoKey",
                format!("`{}`", stated.name()),
                format!("`{}`, the unit of the vertical system", system.name()),
                "correct one of them in the file",
            )),
            _ => Ok(stated.or(of_system)),
        }
    }

    /// The CRS that the file states, or the declared one.
    pub fn crs(&self, declared: Option<&Crs>) -> Result<Crs, Invalid> {
        let stated = [PROJECTED, GEOGRAPHIC].into_iter().find_map(|key| self.code(key));
        match (stated, declared) {
            (None, None) => Err(Crs::undeclared()),
            (None, Some(declared)) => Ok(declared.clone()),
            (Some(code), None) => Crs::new(&format!("EPSG:{code}")),
            (Some(code), Some(declared)) => {
                let (code, name) = (format!("EPSG:{code}"), declared.name());
                let near =
                    || Crs::new(&code).is_ok_and(|stated| stated.is_near_wgs84()) && declared.is_near_wgs84();
                if name.eq_ignore_ascii_case(&code) || name.starts_with('+') || near() {
                    return Ok(declared.clone());
                }
                let expected = format!("{code}, as the file says");
                Err(Invalid::new("`crs`", name, expected, "remove `crs`, or correct the file"))
            }
        }
    }
}

/// The value of a tag that is a text. The library prints a line of its own about one that is too long.
pub(crate) fn short_tag<R: Read + Seek>(
    decoder: &mut Decoder<R>,
    tag: Tag,
) -> Result<Option<Value>, Invalid> {
    let bytes = decoder.image_ifd().find_entry(tag).map_or(0, |entry| entry.count());
    if bytes > LONGEST_TEXT as u64 {
        let (thing, text) = (format!("GeoTIFF, tag {}", tag.to_u16()), format!("a text of {bytes} bytes"));
        return Err(Invalid::new(thing, text, format!("at most {LONGEST_TEXT}"), EXPORT));
    }
    decoder.find_tag(tag).map_err(refuse)
}

/// The refusal of a file for an error of the library.
pub(crate) fn refuse(error: TiffError) -> Invalid {
    Invalid::new("GeoTIFF", error.to_string(), "a whole GeoTIFF, uncompressed or with LZW or deflate", EXPORT)
}
