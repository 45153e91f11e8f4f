use std::collections::BTreeSet;

use files::Provenance;
use serde_json::json;
use trial::campaign::Maneuvers;

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
        let Some(found) = provenance.settings.get(REACTING) else { return Self::default() };
        let names = found["maneuvers"].as_array().into_iter().flatten();
        Self {
            names: names.filter_map(|name| Some(name.as_str()?.to_owned())).collect(),
            generated_from: found["generated_from"].as_u64().map(|from| from as usize),
        }
    }

    /// Notes them, if there are any.
    pub fn note(&self, provenance: &mut Provenance) {
        if *self != Self::default() {
            let found = json!({"maneuvers": self.names, "generated_from": self.generated_from});
            provenance.settings.insert(REACTING.into(), found);
        }
    }

    /// Whether run number `run`, of `maneuver`, is one of them.
    pub fn has(&self, maneuver: &str, run: i32) -> bool {
        let generated = |from: usize| usize::try_from(run).is_ok_and(|run| run >= from);
        self.names.contains(maneuver) || self.generated_from.is_some_and(generated)
    }
}
