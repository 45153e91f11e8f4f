//! The model as a Python module.

use crate::export::equation::Syntax;
use crate::export::portable::{Channel, Portable};
use crate::export::ship::Language;
use crate::export::target::TextFile;
use crate::export::template::fill;
use crate::export::text::{comment, number, quoted};

const SYNTAX: Syntax =
    Syntax { modulus: "abs", parameter: |_, name| format!("p[\"{name}\"]"), between: "\n        + " };

impl Portable {
    /// The module.
    pub(crate) fn python(&self) -> TextFile {
        let text = fill(
            include_str!("templates/model.py"),
            &[
                ("base", self.base.clone()),
                ("header", self.marked_header("# ")),
                ("vessel", quoted(&self.vessel)),
                ("made_from", quoted(&format!("{}, {}", self.origin.file, self.origin.digest))),
                ("rate", number(self.rate_hz)),
                ("states", names(self.states())),
                ("inputs", names(self.inputs())),
                ("parameters", self.python_parameters()),
                ("standard_errors", self.python_errors()),
                ("units", self.python_units()),
                ("names", self.python_names()),
                ("ranges", self.python_ranges()),
                ("ranges_are", self.ranges_are().to_owned()),
                ("rate_holds", self.rate_holds().to_owned()),
                (
                    "imports",
                    if self.ship.is_some() { "atan2, cos, exp, sin, sqrt" } else { "cos, sin" }.to_owned(),
                ),
                ("arrays", self.python_arrays().to_owned()),
                ("functions", self.python_functions()),
            ],
        );
        (format!("{}.py", self.base), text)
    }

    /// What parameters and states may be.
    fn python_arrays(&self) -> &'static str {
        match self.ship {
            Some(_) => "Other parameters: ship.step(x, row, {**ship.PARAMETERS, \"name\": 1.0}).",
            None => {
                "Other parameters: ship.step(x, row, {**ship.PARAMETERS, \"name\": 1.0}). States and inputs may be arrays of numpy, an \
                 entry a\nship."
            }
        }
    }

    /// The step, and what it is made of.
    fn python_functions(&self) -> String {
        let unpack = self.python_unpack();
        if let Some(ship) = &self.ship {
            let parameter = |i: usize| (SYNTAX.parameter)(self, &self.parameters[i].identifier);
            let routines = ship.text(Language::Python, &parameter, &self.identifiers(), &unpack);
            return fill(
                include_str!("templates/ship.py"),
                &[("steps", ship.steps.to_string()), ("routines", routines)],
            );
        }
        let gain = |d: usize| SYNTAX.gain(self, d);
        let (weights, [step, sample]) = self.steps();
        let values =
            [("unpack", unpack), ("surge", gain(0)), ("sway", gain(1)), ("yaw", gain(2)), step, sample];
        let paced = weights.map(|own| fill(include_str!("templates/paced.py"), &[own]));
        fill(include_str!("templates/terms.py"), &values) + &paced.unwrap_or_default()
    }

    fn python_parameters(&self) -> String {
        let line = |parameter: &crate::export::Parameter| {
            let (value, meaning) =
                (number(parameter.value), comment(&format!("[{}] {}", parameter.unit, parameter.meaning)));
            format!("    \"{}\": {value},  # {meaning}\n", parameter.identifier)
        };
        self.parameters.iter().map(line).collect()
    }

    fn python_errors(&self) -> String {
        let line = |parameter: &crate::export::Parameter| {
            let error = parameter.standard_error.map_or("None".to_owned(), number);
            format!("    \"{}\": {error},\n", parameter.identifier)
        };
        self.parameters.iter().map(line).collect()
    }

    fn python_units(&self) -> String {
        let channels = self.channels.iter().map(|channel| (&channel.identifier, &channel.unit));
        let all =
            channels.chain(self.parameters.iter().map(|parameter| (&parameter.identifier, &parameter.unit)));
        all.map(|(name, unit)| format!("    \"{name}\": {},\n", quoted(unit))).collect()
    }

    fn python_names(&self) -> String {
        let all = self.renamed();
        all.iter().map(|(own, name)| format!("    \"{own}\": {},\n", quoted(name))).collect()
    }

    fn python_ranges(&self) -> String {
        let line = |range: &crate::export::Range| {
            let name = &self.channels[range.channel].identifier;
            format!("    \"{name}\": ({}, {}),\n", number(range.low), number(range.high))
        };
        self.ranges.iter().map(line).collect()
    }

    /// Assigns channels to their names within a step.
    fn python_unpack(&self) -> String {
        let all = |channels: &[Channel]| {
            let names: Vec<&str> = channels.iter().map(|own| own.identifier.as_str()).collect();
            if let [only] = names.as_slice() { format!("({only},)") } else { names.join(", ") }
        };
        let inputs = all(self.inputs());
        let inputs = if inputs.is_empty() { String::new() } else { format!("    {inputs} = inputs\n") };
        let derived = SYNTAX.derived(self).into_iter();
        let derived: String = derived.map(|(name, value)| format!("    {name} = {value}\n")).collect();
        format!("    {} = state\n{inputs}{derived}", all(self.states()))
    }
}

fn names(channels: &[Channel]) -> String {
    let line = |channel: &Channel| {
        let meaning = comment(&format!("[{}] {}", channel.unit, channel.meaning));
        format!("    \"{}\",  # {meaning}\n", channel.identifier)
    };
    channels.iter().map(line).collect()
}
