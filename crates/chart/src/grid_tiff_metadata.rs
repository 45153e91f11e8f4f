//! GDAL's metadata of a GeoTIFF: scale, offset and unit of its numbers.

use std::collections::BTreeMap;

use quick_xml::Reader;
use quick_xml::events::{BytesStart, Event};

use crate::depth_unit::DepthUnit;
use crate::direction::Direction;
use crate::{GridKind, Invalid};

/// Items of the first band and of the whole file, by their roles, or by name if they have none.
#[derive(Debug, Default, PartialEq)]
pub struct TiffMetadata {
    roles: BTreeMap<String, String>,
    names: BTreeMap<String, String>,
}

impl TiffMetadata {
    /// Of the text of the tag; empty where there is none.
    pub fn read(text: &str) -> Result<Self, Invalid> {
        let mut own = Self::default();
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
                        own.take(item, value.trim());
                    }
                }
                Event::Eof if item.is_some() => return Err(damaged("no end of an item")),
                Event::Eof => return Ok(own),
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
                let found = format!("`{}`", refusal::foreign(text));
                Err(Invalid::new(
                    format!("GDAL_METADATA, {role}"),
                    found,
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
            let own = start.try_get_attribute(name).map_err(|e| damaged(&e.to_string()))?;
            let text = own.map(|own| own.value.trim().to_owned());
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
