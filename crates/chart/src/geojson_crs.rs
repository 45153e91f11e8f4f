//! The CRS of a GeoJSON file: RFC 7946 has none but WGS84, and older files name equivalent ones.

use geojson::{JsonObject, JsonValue};

use crate::{Crs, Invalid};

/// Refuses a member `crs` unless its coordinates are longitudes and latitudes within a metre or two of WGS84.
pub(crate) fn check_member(members: Option<&JsonObject>) -> Result<(), Invalid> {
    let Some(crs) = members.and_then(|m| m.get("crs")).filter(|c| !c.is_null()) else { return Ok(()) };
    let name = crs.pointer("/properties/name").and_then(JsonValue::as_str).map(str::to_owned);
    // The draft of 2008 has an EPSG code.
    let code =
        || crs.pointer("/properties/code").map(|code| format!("EPSG:{}", code.to_string().replace('"', "")));
    let is_near = |name: String| Crs::new(&name).is_ok_and(|crs| crs.is_near_wgs84());
    if name.or_else(code).is_some_and(is_near) {
        return Ok(());
    }
    Err(mixed("`crs` member", format!("`{}`", refusal::foreign(&crs.to_string()))))
}

/// The refusal of coordinates in another system than the layer's.
pub(crate) fn mixed(thing: impl Into<String>, found: impl Into<String>) -> Invalid {
    Invalid::new(
        thing,
        format!("{} (projected coordinates in a WGS84 layer: mixed CRS)", found.into()),
        "longitude within ±180 and latitude within ±90, WGS84",
        "transform the file, for instance with `ogr2ogr -t_srs EPSG:4326`",
    )
}
