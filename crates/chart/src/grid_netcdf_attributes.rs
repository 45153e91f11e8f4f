//! What the attributes of a NetCDF variable say of its numbers, by the conventions of CF.

use netcdf_reader::masked::MaskParams;
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

/// What is said of the numbers of `variable`, whose signs are as `_Unsigned` says.
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

/// The vertical datum, where it is named.
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

/// A variable in a message.
pub(crate) fn named(variable: &NcVariable) -> String {
    format!("variable `{}`", refusal::foreign(variable.name()))
}

struct Attributes<'f>(&'f NcVariable);

impl Attributes<'_> {
    fn text(&self, name: &str) -> Option<String> {
        self.0.attribute(name)?.value.as_string()
    }

    /// A number, where there is such an attribute; refused where it is none.
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

    /// Numbers that stand for no data, and the range of those that do not, as they stand in the file.
    fn missing(&self) -> Result<(Vec<f64>, [f64; 2]), Invalid> {
        for name in ["_FillValue", "missing_value", "valid_min", "valid_max"] {
            self.numbers(name)?;
        }
        if let Some(range) = self.numbers("valid_range")?.filter(|range| range.len() != 2) {
            let thing = format!("`valid_range` of {}", named(self.0));
            let found = format!("{} numbers", range.len());
            return Err(Invalid::new(thing, found, "two of them", "correct the attribute in the file"));
        }
        let mut missing = Vec::new();
        let mut valid = [f64::NEG_INFINITY, f64::INFINITY];
        if let Some(mask) = MaskParams::from_variable(self.0) {
            missing.extend(mask.fill_value);
            missing.extend(mask.missing_values);
            valid = [mask.valid_min.unwrap_or(valid[0]), mask.valid_max.unwrap_or(valid[1])];
        }
        if self.0.attribute("_FillValue").is_none() {
            missing.extend(self.usual_fill());
        }
        Ok((missing, valid))
    }

    /// What the library writes where nothing was written, of types that have room for it.
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
        Some(SignParams::from_variable(self.0).map_or(value, |sign| sign.reinterpret(value)))
    }
}
