//! The model as a Python module.

use super::target::Syntax;
use super::text::fill;
use crate::export::portable::{Channel, Parameter, Portable, Range};
use crate::export::ship::Language;
use crate::export::target::TextFile;
use crate::export::text::{comment, number, quoted, single};

const PYTHON: Syntax =
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
            let parameter = |i: usize| (PYTHON.parameter)(self, &self.parameters[i].identifier);
            let routines = ship.text(Language::Python, &parameter, &self.identifiers(), &unpack);
            return fill(
                include_str!("templates/ship.py"),
                &[("steps", ship.steps.to_string()), ("routines", routines)],
            );
        }
        let gain = |d: usize| PYTHON.gain(self, d);
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
        let derived = PYTHON.derived(self).into_iter();
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

// The model as a function file for MATLAB and Octave.

const MATLAB: Syntax =
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
            let parameter = |i: usize| (MATLAB.parameter)(self, &self.parameters[i].identifier);
            let routines = ship.text(Language::Matlab, &parameter, &self.identifiers(), &unpack);
            let values =
                [("steps", ship.steps.to_string()), ("rate", number(self.rate_hz)), ("routines", routines)];
            return fill(include_str!("templates/ship.m"), &values);
        }
        let gain = |d: usize| MATLAB.gain(self, d);
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
        let derived = MATLAB.derived(self).into_iter();
        let derived = derived.map(|(name, value)| format!("{name} = {value};\n"));
        states.into_iter().chain(inputs).chain(derived).collect()
    }
}

// The model as C99.

const SYNTAX: Syntax = Syntax {
    modulus: "fabs",
    parameter: |model, name| format!("p[{}_P_{name}]", model.upper()),
    between: "\n        + ",
};

impl Portable {
    /// Prefix of macros and constants.
    pub(crate) fn upper(&self) -> String {
        self.base.to_uppercase()
    }

    /// Header, source, and a program from CSV to CSV.
    pub(crate) fn c(&self) -> Vec<TextFile> {
        let [header, source] = self.c_model();
        let values = [("base", self.base.clone()), ("BASE", self.upper()), ("header", self.c_header())];
        let text = fill(include_str!("templates/example.c"), &values);
        vec![source, header, (format!("{}_example.c", self.base), text)]
    }

    /// Header and source.
    pub(crate) fn c_model(&self) -> [TextFile; 2] {
        let values = [
            ("base", self.base.clone()),
            ("BASE", self.upper()),
            ("header", self.c_header()),
            ("vessel", quoted(&self.vessel)),
            ("made_from", quoted(&format!("{}, {}", self.origin.file, self.origin.digest))),
            ("rate", number(self.rate_hz)),
            ("input_count", self.inputs().len().to_string()),
            ("input_room", self.inputs().len().max(1).to_string()),
            ("parameter_count", self.parameters.len().to_string()),
            ("range_count", self.ranges.len().to_string()),
            ("range_capacity", self.ranges.len().max(1).to_string()),
            ("input_places", self.c_input_places()),
            ("parameter_places", self.c_parameter_places()),
            ("channels", self.c_channels()),
            ("parameters", self.c_parameters()),
            ("values", self.c_values()),
            ("ranges", self.c_ranges()),
            ("ranges_are", self.ranges_are().to_owned()),
            ("rate_holds", self.rate_holds().trim_end_matches('.').to_owned()),
            ("functions", self.c_functions()),
        ];
        [("h", include_str!("templates/model.h")), ("c", include_str!("templates/model.c"))]
            .map(|(extension, template)| (format!("{}.{extension}", self.base), fill(template, &values)))
    }

    /// The step, and what it is made of.
    fn c_functions(&self) -> String {
        let unpack = self.c_unpack();
        let names = [("base", self.base.clone()), ("BASE", self.upper())];
        if let Some(ship) = &self.ship {
            let parameter = |i: usize| (SYNTAX.parameter)(self, &self.parameters[i].identifier);
            let unpack = unpack + "    (void)input;\n";
            let routines = ship.text(Language::C, &parameter, &self.identifiers(), &unpack);
            let own = [("steps", ship.steps.to_string()), ("routines", routines)];
            return fill(include_str!("templates/ship.c"), &[names, own].concat());
        }
        let gain = |d: usize| SYNTAX.gain(self, d);
        let (weights, _) = self.steps();
        let step = if weights.is_some() { "static void own_step" } else { "void {{base}}_step" };
        let step = ("step", step.replace("{{base}}", &self.base));
        let values = [("unpack", unpack), ("surge", gain(0)), ("sway", gain(1)), ("yaw", gain(2)), step];
        let paced =
            weights.map(|own| fill(include_str!("templates/paced.c"), &[&names[..], &[own]].concat()));
        fill(include_str!("templates/terms.c"), &[&names[..], &values].concat()) + &paced.unwrap_or_default()
    }

    pub(crate) fn c_header(&self) -> String {
        format!("/*\n{} */", self.marked_header(" * "))
    }

    fn c_input_places(&self) -> String {
        let line = |(i, own): (usize, &crate::export::Channel)| {
            let meaning = comment(&format!("[{}] {}", own.unit, own.meaning));
            format!("#define {}_I_{} {i} /* {meaning} */\n", self.upper(), own.identifier)
        };
        self.inputs().iter().enumerate().map(line).collect()
    }

    fn c_parameter_places(&self) -> String {
        let line = |(i, own): (usize, &Parameter)| {
            let meaning = comment(&format!("[{}] {}", own.unit, own.meaning));
            format!("#define {}_P_{} {i} /* {meaning} */\n", self.upper(), own.identifier)
        };
        self.parameters.iter().enumerate().map(line).collect()
    }

    fn c_channels(&self) -> String {
        let line = |channel: &crate::export::Channel| {
            format!(
                "    {{{}, {}, {}}},\n",
                quoted(&channel.identifier),
                quoted(&channel.name),
                quoted(&channel.unit)
            )
        };
        self.given().iter().map(line).collect()
    }

    fn c_parameters(&self) -> String {
        let line = |parameter: &Parameter| {
            let (name, unit) = (quoted(&parameter.name), quoted(&parameter.unit));
            let (value, error) =
                (number(parameter.value), parameter.standard_error.map_or("-1.0".to_owned(), number));
            format!("    {{{}, {name}, {unit}, {value}, {error}}},\n", quoted(&parameter.identifier))
        };
        self.parameters.iter().map(line).collect()
    }

    fn c_values(&self) -> String {
        self.parameters.iter().map(|parameter| format!("    {},\n", number(parameter.value))).collect()
    }

    fn c_ranges(&self) -> String {
        let line = |range: &Range| {
            format!("    {{{}, {}, {}}},\n", range.channel, number(range.low), number(range.high))
        };
        let nothing = "    {0, 0.0, 0.0},\n".to_owned();
        if self.ranges.is_empty() { nothing } else { self.ranges.iter().map(line).collect() }
    }

    /// Assigns channels to their names within a step.
    fn c_unpack(&self) -> String {
        let used = self.used();
        let channels = self.given().iter().enumerate();
        let line = |(place, own): (usize, &crate::export::Channel)| {
            let from = if place < 3 { format!("state[{place}]") } else { format!("input[{}]", place - 3) };
            format!("    const double {} = {from}; /* [{}] */\n", own.identifier, comment(&own.unit))
        };
        let state = |name: &str| self.ship.as_ref().is_none_or(|own| own.takes_state(name));
        let given = channels
            .filter(|(place, own)| if *place < 3 { state(&own.name) } else { used.contains(place) })
            .map(line);
        let derived = SYNTAX.derived(self).into_iter();
        given.chain(derived.map(|(name, value)| format!("    const double {name} = {value};\n"))).collect()
    }
}
