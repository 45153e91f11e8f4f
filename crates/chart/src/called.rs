//! The names of charted things.

use std::fmt;
use std::sync::Arc;

use crate::enc::attribute::OBJNAM;
use crate::enc::{Feature, class_name};
use geojson::JsonObject;

/// Properties that hold a feature's name.
const NAMES: [&str; 3] = ["OBJNAM", "name", "NAME"];

/// Class, name and depth of a charted thing, printed as `WRECKS Träholm 4.2 m`.
#[derive(Clone, Debug, PartialEq)]
pub struct Called {
    /// Its kind: the acronym of its class, or a word.
    pub what: &'static str,
    /// Its own name.
    pub name: Option<Arc<str>>,
    /// The charted depth of it or over it \[m\].
    pub depth_m: Option<f64>,
}

impl Called {
    /// Something without a name.
    pub(crate) fn plain(what: &'static str) -> Self {
        Self { what, name: None, depth_m: None }
    }

    pub(crate) fn object(object: &Feature, depth_m: Option<f64>) -> Self {
        let name = object.attributes.get(&OBJNAM.0).map(|name| name.trim());
        let name = name.filter(|name| !name.is_empty()).map(Arc::from);
        Self { what: class_name(object.class).unwrap_or("object"), name, depth_m }
    }

    /// The name of a GeoJSON feature of kind `what`.
    pub(crate) fn feature(what: &'static str, properties: Option<&JsonObject>, depth_m: Option<f64>) -> Self {
        let name = |key: &&str| Some(properties?.get(*key)?.as_str()?.trim()).filter(|name| !name.is_empty());
        Self { what, name: NAMES.iter().find_map(name).map(Arc::from), depth_m }
    }
}

impl fmt::Display for Called {
    fn fmt(&self, out: &mut fmt::Formatter) -> fmt::Result {
        out.write_str(self.what)?;
        self.name.iter().try_for_each(|name| write!(out, " {name}"))?;
        self.depth_m.iter().try_for_each(|depth| write!(out, " {depth} m"))
    }
}
