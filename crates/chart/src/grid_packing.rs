//! From the numbers in a grid file to metres.

use crate::depth_unit::{DepthUnit, UnitFrom};
use crate::{GridDeclaration, GridKind, Invalid};

/// Unit and datum of the depths or heights of a chart.
#[derive(Clone, Debug, PartialEq)]
pub struct Measured {
    /// The unit after scale and offset.
    pub unit: DepthUnit,
    /// The origin of the unit.
    pub unit_from: UnitFrom,
    /// Factor of the file's numbers.
    pub scale: f64,
    /// Added after scaling.
    pub offset: f64,
    /// The vertical datum, if the file states one.
    pub datum: Option<String>,
}

impl Measured {
    /// For a file that says nothing about its numbers.
    pub fn plainly(unit: DepthUnit, unit_from: UnitFrom) -> Self {
        Self { unit, unit_from, scale: 1.0, offset: 0.0, datum: None }
    }
}

/// How a file encodes its numbers.
#[derive(Clone, Debug)]
pub(crate) struct Packing {
    pub scale: f64,
    pub offset: f64,
    pub unit: Option<DepthUnit>,
    pub datum: Option<String>,
    /// The number in the file that means no data.
    pub missing: Option<f64>,
}

impl Default for Packing {
    fn default() -> Self {
        Self { scale: 1.0, offset: 0.0, unit: None, datum: None, missing: None }
    }
}

impl Packing {
    /// The measurement that file and declaration agree on; a land mask has no unit.
    pub fn measured(&self, declared: &GridDeclaration) -> Result<Measured, Invalid> {
        if !(self.scale.is_finite() && self.scale != 0.0 && self.offset.is_finite()) {
            let found = format!("{} and {}", self.scale, self.offset);
            let expected = "finite numbers, the scale not 0";
            return Err(Invalid::new("scale and offset", found, expected, "correct them in the file"));
        }
        let (unit, unit_from) = match declared.kind {
            GridKind::LandMask => (DepthUnit::Metre, UnitFrom::File),
            GridKind::Depth | GridKind::Elevation => {
                let crs = declared.crs.as_ref().and_then(|crs| crs.vertical_unit());
                let stated = match (self.unit, crs) {
                    (Some(own), Some(crs)) if own != crs => {
                        return Err(Invalid::new(
                            "`crs`",
                            format!("heights in `{}`", crs.name()),
                            format!("`{}`, as the file says", own.name()),
                            "name the horizontal system alone, or correct the file",
                        ));
                    }
                    (own, crs) => own.or(crs),
                };
                DepthUnit::agreed(stated, declared.unit)?
            }
        };
        let (scale, offset, datum) = (self.scale, self.offset, self.datum.clone());
        Ok(Measured { unit, unit_from, scale, offset, datum })
    }

    /// Decodes a number of the file, in units of `metres`, to metres (of a mask, unchanged) if it is data.
    pub fn number(&self, raw: f64, metres: f64) -> Option<f64> {
        let is_missing = raw.is_nan() || self.missing == Some(raw);
        (!is_missing).then_some((raw * self.scale + self.offset) * metres)
    }
}
