//! What numbers and units are made of, where ships of different size move at the same Froude number.

/// Powers of the water's density and of half lengths: a speed counts as the root of a length.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub(crate) struct Dimension {
    /// Power of the density.
    density: i32,
    /// Twice the power of the length.
    halves: i32,
}

/// Those of units.
const UNITS: [(&[&str], Dimension); 14] = [
    (&["", "1", "%", "rad", "deg", "°", "m/s²", "m/s^2"], Dimension::NONE),
    (&["s"], Dimension::of(0, 1)),
    (&["1/s", "rps", "Hz", "rpm", "1/min", "rad/s", "deg/s", "°/s"], Dimension::of(0, -1)),
    (&["1/s²", "1/s^2", "rad/s²", "rad/s^2"], Dimension::of(0, -2)),
    (&["m/s", "kn"], Dimension::SPEED),
    (&["m²/s²", "m^2/s^2"], Dimension::of(0, 2)),
    (&["m", "cm", "mm"], Dimension::of(0, 2)),
    (&["m²", "m^2"], Dimension::of(0, 4)),
    (&["m³", "m^3"], Dimension::of(0, 6)),
    (&["kg", "t"], Dimension::of(1, 6)),
    (&["N", "kN", "MN"], Dimension::FORCE),
    (&["N m", "kN m", "Nm", "kNm"], Dimension::of(1, 8)),
    (&["W", "kW", "MW"], Dimension::of(1, 7)),
    (&["Pa", "kPa", "bar"], Dimension::of(1, 2)),
];

impl Dimension {
    /// A pure number, an angle, an acceleration.
    pub const NONE: Self = Self::of(0, 0);
    /// A speed.
    pub const SPEED: Self = Self::of(0, 1);
    /// A turning rate.
    pub const RATE: Self = Self::of(0, -1);
    /// A time.
    pub const TIME: Self = Self::of(0, 1);
    /// A force.
    pub const FORCE: Self = Self::of(1, 6);

    const fn of(density: i32, halves: i32) -> Self {
        Self { density, halves }
    }

    /// The `power`th power of a length.
    pub const fn length(power: i32) -> Self {
        Self::of(0, 2 * power)
    }

    /// A mass times the `power`th power of a length.
    pub const fn mass(power: i32) -> Self {
        Self::of(1, 6 + 2 * power)
    }

    /// That of a unit, if it is known.
    pub fn of_unit(unit: &str) -> Option<Self> {
        UNITS.iter().find(|(units, _)| units.contains(&unit)).map(|(_, own)| *own)
    }

    /// This, times the `power`th power of another.
    pub fn times(self, other: Self, power: i32) -> Self {
        Self::of(self.density + power * other.density, self.halves + power * other.halves)
    }

    /// What one of a ship is of another, with `length` times the length in water of `density` times the density.
    pub fn factor(self, length: f64, density: f64) -> f64 {
        let whole = density.powi(self.density) * length.powi(self.halves.div_euclid(2));
        if self.halves.rem_euclid(2) == 1 { whole * length.sqrt() } else { whole }
    }
}
