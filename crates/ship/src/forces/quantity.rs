/// A number of a ship in SI units.
#[derive(Clone, Debug, PartialEq)]
pub struct Quantity {
    /// That of a term's parameter, or `component.key`.
    pub name: String,
    /// Its SI unit.
    pub unit: String,
    /// Its value.
    pub value: f64,
    /// Whether the ship's description has it; else the value is the default.
    pub stated: bool,
    /// Where it comes from.
    pub source: QuantitySource,
}

/// Where a number of a ship comes from.
#[derive(Clone, Debug, PartialEq)]
pub enum QuantitySource {
    /// It is known.
    Known,
    /// It is the free parameter with this index.
    Free(usize),
    /// It is a free number times a factor, both in SI units.
    Tied {
        /// The name of the free number.
        to: String,
        /// The factor.
        factor: f64,
    },
}
