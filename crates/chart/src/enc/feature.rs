//! Objects of a cell, with their positions.

use std::collections::BTreeMap;

use crate::enc::{Invalid, class_name};

/// An object: its class, position and attributes.
#[derive(Clone, Debug, PartialEq)]
pub struct Feature {
    /// Code of its class, see [`crate::enc::class_name`].
    pub class: u16,
    /// Its unique id in all editions: producer, number, subdivision.
    pub id: String,
    /// Its attributes, by code, see [`crate::enc::attribute`]; as text, empty where unknown.
    pub attributes: BTreeMap<u16, String>,
    /// Its position.
    pub geometry: Geometry,
    /// The stated quality of its positions (QUAPOS), if any.
    pub position_quality: Vec<u8>,
}

/// The position of an object: longitude and latitude \[deg\].
#[derive(Clone, Debug, PartialEq)]
pub enum Geometry {
    /// None: a statement about other objects.
    None,
    /// At points.
    Points(Vec<[f64; 2]>),
    /// Longitude, latitude, and depth \[m, positive down\].
    Soundings(Vec<[f64; 3]>),
    /// Along lines.
    Lines(Vec<Vec<[f64; 2]>>),
    /// Within polygons.
    Area(Vec<Polygon>),
}

impl Geometry {
    /// Number of places in it.
    pub fn places(&self) -> u64 {
        let all = match self {
            Self::None => 0,
            Self::Points(points) => points.len(),
            Self::Soundings(points) => points.len(),
            Self::Lines(lines) => lines.iter().map(Vec::len).sum(),
            Self::Area(polygons) => polygons.iter().flatten().map(Vec::len).sum(),
        };
        all as u64
    }
}

/// Closed rings: the outer one, then its holes.
pub type Polygon = Vec<Vec<[f64; 2]>>;

impl Feature {
    /// Its class and id, for messages.
    pub fn named(&self) -> String {
        match class_name(self.class) {
            Some(name) => format!("{name} {}", self.id),
            None => format!("class {} {}", self.class, self.id),
        }
    }

    /// An attribute that is a number; `None` where it is unknown.
    ///
    /// # Errors
    /// An attribute that is not a finite number.
    pub fn number(&self, (code, name): (u16, &str)) -> Result<Option<f64>, Invalid> {
        let Some(text) = self.attributes.get(&code).map(|text| text.trim()).filter(|text| !text.is_empty())
        else {
            return Ok(None);
        };
        match text.parse::<f64>().ok().filter(|v| v.is_finite()) {
            Some(value) => Ok(Some(value)),
            None => Err(Invalid::new(
                format!("{}, `{name}`", self.named()),
                format!("`{text}`"),
                "a number",
                "report it to the chart's producer",
            )),
        }
    }

    /// The numbers of an attribute that is a list, such as `7,14`; empty if it is unknown.
    pub fn list(&self, (code, _): (u16, &str)) -> Vec<u16> {
        let text = self.attributes.get(&code).map_or("", String::as_str);
        text.split(',').filter_map(|part| part.trim().parse().ok()).collect()
    }
}
