use ship::model::Vessel;

/// The ship that figures are measured by.
#[derive(Clone, Copy, Debug)]
pub struct Hull<'a> {
    /// The vessel, for its inputs.
    pub vessel: &'a Vessel,
    /// Length between perpendiculars \[m\].
    pub length_m: f64,
}

/// A figure of merit.
#[derive(Clone, Debug, PartialEq)]
pub struct Figure {
    /// Its name in files: `overshoot_1`.
    pub name: &'static str,
    /// What it is.
    pub what: &'static str,
    /// Its value, as it was measured.
    pub value: f64,
    /// The same without the current that the log shows.
    pub corrected: Option<f64>,
    /// Whether it is beside those that trials are designed for.
    pub is_aside: bool,
    /// Its unit: `deg`, `deg/s`, `m`, `L` (ship lengths), `s`, or the input's.
    pub unit: String,
    /// The greatest value that IMO MSC.137(76) allows, where it has one for this test.
    pub most: Option<f64>,
}

impl Figure {
    pub(super) fn new(name: &'static str, what: &'static str, value: f64, unit: &str) -> Self {
        Self { name, what, value, corrected: None, is_aside: false, unit: unit.to_owned(), most: None }
    }

    pub(super) fn aside(name: &'static str, what: &'static str, value: f64, unit: &str) -> Self {
        Self { is_aside: true, ..Self::new(name, what, value, unit) }
    }

    pub(super) fn at_most(self, most: Option<f64>) -> Self {
        Self { most, ..self }
    }

    /// Whether it meets its criterion; `None` without one.
    pub fn passes(&self) -> Option<bool> {
        self.most.map(|most| self.corrected.unwrap_or(self.value) <= most)
    }

    /// A figure of a spiral, in the unit of the helm's greatest input.
    pub(super) fn of_helm(name: &'static str, what: &'static str, value: f64, unit: &str) -> Self {
        match unit {
            "rad" => Self::new(name, what, value.to_degrees(), "deg"),
            unit => Self::new(name, what, value, unit),
        }
    }
}
