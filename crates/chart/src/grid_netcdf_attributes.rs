//! The attributes of a NetCDF variable that describe its numbers, by the CF conventions.

use netcdf_reader::unpack::SignParams;
use netcdf_reader::{NcFile, NcType, NcVariable};

use crate::depth_unit::DepthUnit;
use crate::direction::Direction;
use crate::grid_packing::Packing;
use crate::{GridKind, Invalid};

/// Attributes that name a vertical datum, of the variable, of its mapping or of the file.
const DATUMS: [&str; 7] = [
    "vertical_datum",
    "vertical_datum_name",
    "geopotential_datum_name",
    "geoid_name",
    "vertical_crs",
    "datum",
    "geospatial_bounds_vertical_crs",
];

/// The declared meaning of the numbers of `variable`, whose signedness follows `_Unsigned`.
pub(crate) fn packing(file: &NcFile, variable: &NcVariable, kind: GridKind) -> Result<Packing, Invalid> {
    let own = Attributes(variable);
    Direction::check(kind, own.text("positive").as_deref(), own.text("standard_name").as_deref())?;
    let unit = match kind {
        GridKind::LandMask => None,
        _ => DepthUnit::stated(&format!("`units` of {}", named(variable)), own.text("units").as_deref())?,
    };
    let (missing, valid) = own.missing()?;
    let scale = own.number("scale_factor")?.unwrap_or(1.0);
    let offset = own.number("add_offset")?.unwrap_or(0.0);
    Ok(Packing { scale, offset, unit, datum: datum(file, variable), missing, valid })
}

/// The vertical datum, if it is named.
fn datum(file: &NcFile, variable: &NcVariable) -> Option<String> {
    let own = Attributes(variable);
    let mapping = own.text("grid_mapping").and_then(|name| file.variable(name.trim()).ok());
    let whole = |name: &str| file.global_attribute(name).ok().and_then(|own| own.value.as_string());
    let named = |name: &&str| {
        let of_mapping = || Attributes(mapping?).text(name);
        own.text(name).or_else(of_mapping).or_else(|| whole(name))
    };
    let text = DATUMS.iter().find_map(named)?;
    let text = refusal::foreign(text.trim());
    (!text.is_empty()).then_some(text)
}

/// How messages name a variable.
pub(crate) fn named(variable: &NcVariable) -> String {
    format!("variable `{}`", refusal::foreign(variable.name()))
}

struct Attributes<'f>(&'f NcVariable);

impl Attributes<'_> {
    fn text(&self, name: &str) -> Option<String> {
        self.0.attribute(name)?.value.as_string()
    }

    /// The attribute as a number, if there is one; refused where it is not a number.
    fn number(&self, name: &str) -> Result<Option<f64>, Invalid> {
        Ok(self.numbers(name)?.and_then(|all| all.first().copied()))
    }

    fn numbers(&self, name: &str) -> Result<Option<Vec<f64>>, Invalid> {
        let Some(attribute) = self.0.attribute(name) else { return Ok(None) };
        if let Some(all) = attribute.value.as_f64_vec().filter(|all| !all.is_empty()) {
            return Ok(Some(all));
        }
        // Some programs write numbers as text.
        let text = attribute.value.as_string().unwrap_or_default();
        let words = text.split(|c: char| c.is_whitespace() || c == ',').filter(|word| !word.is_empty());
        match words.map(str::parse).collect::<Result<Vec<f64>, _>>() {
            Ok(all) if !all.is_empty() => Ok(Some(all)),
            _ => {
                let found = format!("`{}`", refusal::foreign(&text));
                let thing = format!("`{name}` of {}", named(self.0));
                Err(Invalid::new(thing, found, "a number", "correct the attribute in the file"))
            }
        }
    }

    /// Numbers that mean no data, and the range of valid ones, as stored in the file.
    fn missing(&self) -> Result<(Vec<f64>, [f64; 2]), Invalid> {
        let numbers = |name: &str| -> Result<Option<Vec<f64>>, Invalid> {
            Ok(self.numbers(name)?.map(|all| all.into_iter().map(|value| self.as_stored(value)).collect()))
        };
        let first = |name: &str| Ok(numbers(name)?.and_then(|all| all.first().copied()));
        let mut missing =
            numbers("_FillValue")?.or_else(|| Some(vec![self.usual_fill()?])).unwrap_or_default();
        missing.extend(numbers("missing_value")?.into_iter().flatten());
        let least = first("valid_min")?.unwrap_or(f64::NEG_INFINITY);
        let most = first("valid_max")?.unwrap_or(f64::INFINITY);
        match numbers("valid_range")?.as_deref() {
            None => Ok((missing, [least, most])),
            Some([least, most]) => Ok((missing, [*least, *most])),
            Some(range) => {
                let thing = format!("`valid_range` of {}", named(self.0));
                let found = format!("{} numbers", range.len());
                Err(Invalid::new(thing, found, "two of them", "correct the attribute in the file"))
            }
        }
    }

    /// A number of an attribute in the variable's own type and signedness.
    fn as_stored(&self, value: f64) -> f64 {
        let value = if *self.0.dtype() == NcType::Float { f64::from(value as f32) } else { value };
        SignParams::from_variable(self.0).map_or(value, |sign| sign.reinterpret(value))
    }

    /// The library's default fill value, for types that have one.
    fn usual_fill(&self) -> Option<f64> {
        let value = match self.0.dtype() {
            NcType::Short => -32767.0,
            NcType::UShort => 65535.0,
            NcType::Int => -2_147_483_647.0,
            NcType::UInt => 4_294_967_295.0,
            NcType::Float => f64::from(9.969_21e36_f32),
            NcType::Double => 9.969_209_968_386_869e36,
            _ => return None,
        };
        Some(self.as_stored(value))
    }
}
