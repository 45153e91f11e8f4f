//! The model as a Python module.

use crate::equation::Syntax;
use crate::portable::{Channel, Portable};
use crate::target::TextFile;
use crate::template::fill;
use crate::text::{comment, number, quoted};

const SYNTAX: Syntax =
    Syntax { modulus: "abs", parameter: |_, name| format!("p[\"{name}\"]"), between: "\n        + " };

impl Portable {
    /// The module.
    pub(crate) fn python(&self) -> TextFile {
        let gain = |d: usize| SYNTAX.gain(self, d);
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
                ("unpack", self.python_unpack()),
                ("surge", gain(0)),
                ("sway", gain(1)),
                ("yaw", gain(2)),
            ],
        );
        (format!("{}.py", self.base), text)
    }

    fn python_parameters(&self) -> String {
        let line = |own: &crate::Parameter| {
            let (value, meaning) = (number(own.value), comment(&format!("[{}] {}", own.unit, own.meaning)));
            format!("    \"{}\": {value},  # {meaning}\n", own.identifier)
        };
        self.parameters.iter().map(line).collect()
    }

    fn python_errors(&self) -> String {
        let line = |own: &crate::Parameter| {
            let error = own.standard_error.map_or("None".to_owned(), number);
            format!("    \"{}\": {error},\n", own.identifier)
        };
        self.parameters.iter().map(line).collect()
    }

    fn python_units(&self) -> String {
        let channels = self.channels.iter().map(|own| (&own.identifier, &own.unit));
        let all = channels.chain(self.parameters.iter().map(|own| (&own.identifier, &own.unit)));
        all.map(|(name, unit)| format!("    \"{name}\": {},\n", quoted(unit))).collect()
    }

    fn python_names(&self) -> String {
        let all = self.renamed();
        all.iter().map(|(own, name)| format!("    \"{own}\": {},\n", quoted(name))).collect()
    }

    fn python_ranges(&self) -> String {
        let line = |own: &crate::Range| {
            let name = &self.channels[own.channel].identifier;
            format!("    \"{name}\": ({}, {}),\n", number(own.low), number(own.high))
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
    let line = |own: &Channel| {
        let meaning = comment(&format!("[{}] {}", own.unit, own.meaning));
        format!("    \"{}\",  # {meaning}\n", own.identifier)
    };
    channels.iter().map(line).collect()
}
