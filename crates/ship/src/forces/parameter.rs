/// A free parameter: an element of θ, in the system that it was written in.
#[derive(Clone, Debug, PartialEq)]
pub struct Parameter {
    /// That of a term, or `component.key`.
    pub name: String,
    /// Its unit; `1` in the prime system.
    pub unit: String,
    /// Its value before any estimate.
    pub nominal: f64,
    /// Its true value, where known.
    pub value: Option<f64>,
    /// Standard deviation of its prior.
    pub prior: Option<f64>,
    /// Bounds of its estimates; infinite at an open end.
    pub bounds: [f64; 2],
    /// Factor from θ to SI units: ρ, length, draught and speed of the prime system, or 1.
    pub scale: f64,
    /// Its SI unit, whatever it was written in.
    pub si_unit: String,
    /// What one of the prime system is in SI units, if the number can be written in it.
    pub prime: Option<f64>,
}
