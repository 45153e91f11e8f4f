//! The table of trajectories: one row per sample, N + 1 rows per run of N samples.

mod read;
mod write;

use std::collections::BTreeSet;

use files::{ColumnSpec, Kind, Provenance, TableSchema};
use serde_json::json;
use ship::model::{DegreeOfFreedom, DerivedChannel, Model};
use trial::campaign::Maneuvers;

pub use read::{KeptRuns, TrajectoryReader, rate_of, refuse_shard};
pub use write::{BlockBuilder, MeasuredBlock, rows_per_block};

/// The setting of a dictionary's table that says which maneuvers react.
const REACTING: &str = "reacting";

/// The maneuvers of a dictionary whose commands depend on the ship's motion.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reacting {
    /// Names of those that are written by hand.
    names: BTreeSet<String>,
    /// All runs from this number on.
    generated_from: Option<usize>,
}

impl Reacting {
    /// Those of `maneuvers`.
    pub fn of(maneuvers: &Maneuvers) -> Self {
        let (names, generated_from) = maneuvers.which_react();
        Self { names: names.into_iter().collect(), generated_from }
    }

    /// Those that the table of `provenance` was written with.
    pub fn noted(provenance: &Provenance) -> Self {
        let Some(setting) = provenance.settings.get(REACTING) else { return Self::default() };
        let names = setting["maneuvers"].as_array().into_iter().flatten();
        Self {
            names: names.filter_map(|name| Some(name.as_str()?.to_owned())).collect(),
            generated_from: setting["generated_from"].as_u64().map(|from| from as usize),
        }
    }

    /// Notes them, if there are any.
    pub fn note(&self, provenance: &mut Provenance) {
        if *self != Self::default() {
            let setting = json!({"maneuvers": self.names, "generated_from": self.generated_from});
            provenance.settings.insert(REACTING.into(), setting);
        }
    }

    /// Whether run number `run`, of `maneuver`, is one of them.
    pub fn has(&self, maneuver: &str, run: i32) -> bool {
        let generated = |from: usize| usize::try_from(run).is_ok_and(|run| run >= from);
        self.names.contains(maneuver) || self.generated_from.is_some_and(generated)
    }
}

refusal::choices! {
    /// What data are labelled as where they are not those of a real ship.
    pub enum DataLabel {
        /// Made of simulated logs.
        SimulatedLogs = "simulated logs",
    }
}

impl DataLabel {
    /// Adds the label to `provenance`.
    pub fn label(self, provenance: &mut Provenance) {
        provenance.settings.insert("data".into(), self.to_string().into());
    }
}

/// Adds the label of simulated logs to `provenance` if one of these designs has it. Runs of simulated logs have the
/// label as the name of their design.
pub fn label<'a>(designs: impl IntoIterator<Item = &'a str>, provenance: &mut Provenance) {
    let simulated = DataLabel::SimulatedLogs.to_string();
    if designs.into_iter().any(|design| design == simulated) {
        DataLabel::SimulatedLogs.label(provenance);
    }
}

/// Schema id of trajectories.
pub const ID: &str = "trajectories";
/// Version of the schema.
pub const VERSION: u32 = 1;

/// The setting of a dictionary's table that says what its maneuvers reached, by name.
pub const REACHED: &str = "reached";

/// Least bytes of a row of simulated runs in a file: its true and measured states, and its pose, which hardly
/// compress.
pub const LEAST_ROW_BYTES: f64 = 72.0;

/// Rows per second that a thread simulates and encodes, order of magnitude: the paper's campaign on a server of 2024
/// (0.22 s for 800,000).
pub const SIMULATED_PER_SECOND: f64 = 4e6;

/// The column of what is commanded of `input`.
fn commanded(input: &str) -> String {
    format!("command_{input}")
}

/// The columns of trajectories of one vessel.
#[derive(Clone, Debug, Default)]
pub struct Layout {
    /// Names and units of inputs, measured disturbances and derived channels, in the model's order.
    pub exogenous: Vec<(String, String)>,
    /// The definitions of the derived ones.
    pub derived: Vec<DerivedChannel>,
    /// How many of the above are inputs: the first.
    pub inputs: usize,
    /// Whether runs have instruments other than their inputs, and which inputs follow commands.
    pub reacting: maneuver::Reacting,
}

impl Layout {
    /// The columns for `model`.
    pub fn new(model: &Model) -> Self {
        let exogenous = model.variables[3..].iter().map(|v| (v.name.clone(), v.unit.clone())).collect();
        Self {
            exogenous,
            derived: model.derived.clone(),
            inputs: model.inputs,
            reacting: maneuver::Reacting::default(),
        }
    }

    /// With the inputs that instruments are simulated with and what is commanded, where those are not the inputs.
    #[must_use]
    pub fn reacting(self, reacting: &maneuver::Reacting) -> Self {
        Self { reacting: reacting.clone(), ..self }
    }

    /// The columns of the inputs that instruments are simulated with.
    pub fn of_instruments(&self) -> Vec<ColumnSpec> {
        let column = |(name, unit): &(String, String)| {
            ColumnSpec::new(format!("instrument_{name}"), unit, Kind::F64, true)
        };
        self.exogenous[..self.inputs].iter().map(column).collect()
    }

    /// The columns of what is commanded.
    pub fn of_commands(&self) -> Vec<ColumnSpec> {
        let column = |i: &usize| {
            let (name, unit) = &self.exogenous[*i];
            ColumnSpec::new(commanded(name), unit, Kind::F64, true)
        };
        self.reacting.followed.iter().map(column).collect()
    }

    /// Bytes of memory of a row while runs are simulated and their block is encoded.
    pub fn working_bytes(&self) -> f64 {
        8.0 * (3 * self.exogenous.len() + 24) as f64
    }

    /// Bytes of memory of a sample of a run after reading.
    pub fn run_bytes(&self) -> f64 {
        8.0 * (self.exogenous.len() + 3) as f64
    }

    /// The whole table, as simulated.
    pub fn schema(&self) -> TableSchema {
        let mut columns = self.required();
        let truth = DegreeOfFreedom::ALL.map(|d| ColumnSpec::new(d.state(), d.unit(), Kind::F64, false));
        let pose = [("x", "m"), ("y", "m"), ("psi", "rad")]
            .map(|(name, unit)| ColumnSpec::new(name, unit, Kind::F64, false));
        columns.extend(truth.into_iter().chain(pose));
        if self.reacting.tracks {
            columns.extend(self.of_instruments());
        }
        columns.extend(self.of_commands());
        TableSchema { id: ID, version: VERSION, columns }
    }

    /// The table of measured runs, without true states, but with `further` channels by name and unit.
    pub fn measured(&self, further: &[(String, String)]) -> TableSchema {
        let mut columns = self.required();
        columns.extend(further.iter().map(|(name, unit)| ColumnSpec::new(name, unit, Kind::F64, true)));
        TableSchema { id: ID, version: VERSION, columns }
    }

    /// The columns that every stage needs.
    pub fn required(&self) -> Vec<ColumnSpec> {
        let mut columns = vec![
            ColumnSpec::new("design", "1", Kind::Text, false),
            ColumnSpec::new("run", "1", Kind::I32, false),
            ColumnSpec::new("segment", "1", Kind::I32, false),
            ColumnSpec::new("maneuver", "1", Kind::Text, false),
            ColumnSpec::new("sample", "1", Kind::I32, false),
            ColumnSpec::new("t", "s", Kind::F64, false),
        ];
        columns.extend(self.exogenous.iter().map(|(n, u)| ColumnSpec::new(n, u, Kind::F64, true)));
        let measured = DegreeOfFreedom::ALL
            .map(|d| ColumnSpec::new(format!("y_{}", d.state()), d.unit(), Kind::F64, false));
        columns.extend(measured);
        columns
    }
}
