//! The model as a function file for MATLAB and Octave.

use crate::export::equation::Syntax;
use crate::export::portable::{Parameter, Portable, Range};
use crate::export::ship::Language;
use crate::export::target::TextFile;
use crate::export::template::fill;
use crate::export::text::{comment, number, single};

const SYNTAX: Syntax =
    Syntax { modulus: "abs", parameter: |_, name| format!("p.{name}"), between: " ...\n    + " };

impl Portable {
    /// The function file.
    pub(crate) fn matlab(&self) -> TextFile {
        let list = |channels: &[crate::export::Channel]| {
            channels.iter().map(|channel| single(&channel.identifier)).collect::<Vec<_>>().join(", ")
        };
        let text = fill(
            include_str!("templates/model.m"),
            &[
                ("base", self.base.clone()),
                ("header", self.marked_header("%   ")),
                ("vessel", single(&self.vessel)),
                ("made_from", single(&format!("{}, {}", self.origin.file, self.origin.digest))),
                ("rate", number(self.rate_hz)),
                ("states", list(self.states())),
                ("inputs", list(self.inputs())),
                ("parameters", self.matlab_parameters()),
                ("units", self.matlab_units()),
                ("names", self.matlab_names()),
                ("ranges", self.matlab_ranges()),
                ("ranges_are", self.ranges_are().to_owned()),
                ("rate_holds", self.rate_holds().trim_end_matches('.').to_lowercase()),
                ("functions", self.matlab_functions()),
            ],
        );
        (format!("{}.m", self.base), text)
    }

    /// The step, and what it is made of.
    fn matlab_functions(&self) -> String {
        let unpack = self.matlab_unpack();
        if let Some(ship) = &self.ship {
            let parameter = |i: usize| (SYNTAX.parameter)(self, &self.parameters[i].identifier);
            let routines = ship.text(Language::Matlab, &parameter, &self.identifiers(), &unpack);
            let values =
                [("steps", ship.steps.to_string()), ("rate", number(self.rate_hz)), ("routines", routines)];
            return fill(include_str!("templates/ship.m"), &values);
        }
        let gain = |d: usize| SYNTAX.gain(self, d);
        let (weights, [step, sample]) = self.steps();
        let values =
            [("unpack", unpack), ("surge", gain(0)), ("sway", gain(1)), ("yaw", gain(2)), step, sample];
        let paced = weights.map(|own| fill(include_str!("templates/paced.m"), &[own]));
        fill(include_str!("templates/terms.m"), &values) + &paced.unwrap_or_default()
    }

    fn matlab_parameters(&self) -> String {
        let line = |parameter: &Parameter| {
            let (name, meaning) =
                (&parameter.identifier, comment(&format!("[{}] {}", parameter.unit, parameter.meaning)));
            let (value, error) =
                (number(parameter.value), parameter.standard_error.map_or("NaN".to_owned(), number));
            format!(
                "model.parameters.{name} = {value};  % {meaning}\nmodel.standard_errors.{name} = {error};\n"
            )
        };
        self.parameters.iter().map(line).collect()
    }

    fn matlab_units(&self) -> String {
        let channels = self.channels.iter().map(|channel| (&channel.identifier, &channel.unit));
        let all =
            channels.chain(self.parameters.iter().map(|parameter| (&parameter.identifier, &parameter.unit)));
        all.map(|(name, unit)| format!("model.units.{name} = {};\n", single(unit))).collect()
    }

    fn matlab_names(&self) -> String {
        let all = self.renamed();
        all.iter().map(|(own, name)| format!("model.names.{own} = {};\n", single(name))).collect()
    }

    fn matlab_ranges(&self) -> String {
        let line = |range: &Range| {
            let name = &self.channels[range.channel].identifier;
            format!("model.ranges.{name} = [{}, {}];\n", number(range.low), number(range.high))
        };
        self.ranges.iter().map(line).collect()
    }

    /// Assigns channels to their names within a step.
    fn matlab_unpack(&self) -> String {
        let states = ["u = state(1);\n", "v = state(2);\n", "r = state(3);\n"].map(str::to_owned);
        let used = self.used();
        let inputs = self.inputs().iter().enumerate().filter(|(i, _)| used.contains(&(i + 3)));
        let inputs = inputs.map(|(i, own)| format!("{} = input({});\n", own.identifier, i + 1));
        let derived = SYNTAX.derived(self).into_iter();
        let derived = derived.map(|(name, value)| format!("{name} = {value};\n"));
        states.into_iter().chain(inputs).chain(derived).collect()
    }
}
