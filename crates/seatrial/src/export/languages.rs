//! The model as a Python module, as a function file for MATLAB and Octave, and as C99.

use super::portable::{Channel, Portable, TemplateEntry};
use super::ship::{Language, Ship};
use super::target::{Syntax, TextFile};
use super::text::{comment, fill, number, quoted, single};

/// A line of text for each of `all`.
fn lines<T>(all: &[T], line: impl Fn(&T) -> String) -> String {
    all.iter().map(line).collect()
}

/// Unit and meaning, for a comment.
fn said(unit: &str, meaning: &str) -> String {
    comment(&format!("[{unit}] {meaning}"))
}

impl Portable {
    /// File and digest that it was made from.
    fn made_from(&self) -> String {
        format!("{}, {}", self.origin.file, self.origin.digest)
    }

    /// The identifiers of channels and parameters, with their units.
    fn identifiers_with_units(&self) -> impl Iterator<Item = (&String, &String)> {
        let channels = self.channels.iter().map(|channel| (&channel.identifier, &channel.unit));
        channels.chain(self.parameters.iter().map(|parameter| (&parameter.identifier, &parameter.unit)))
    }

    /// The gains of the states by terms, for a template.
    fn gains(&self, syntax: &Syntax) -> [TemplateEntry; 3] {
        [("surge", 0), ("sway", 1), ("yaw", 2)].map(|(name, d)| (name, syntax.gain(self, d)))
    }

    /// The routines of `ship`, the forces of the model.
    fn routines(&self, ship: &Ship, language: Language, syntax: &Syntax, unpack: &str) -> String {
        let parameter = |i: usize| (syntax.parameter)(self, &self.parameters[i].identifier);
        ship.text(language, &parameter, &self.identifiers(), unpack)
    }
}

const PYTHON: Syntax =
    Syntax { modulus: "abs", parameter: |_, name| format!("p[\"{name}\"]"), between: "\n        + " };

impl Portable {
    /// The module.
    pub(crate) fn python(&self) -> TextFile {
        let parameters = lines(&self.parameters, |parameter| {
            let (value, meaning) = (number(parameter.value), said(&parameter.unit, &parameter.meaning));
            format!("    \"{}\": {value},  # {meaning}\n", parameter.identifier)
        });
        let standard_errors = lines(&self.parameters, |parameter| {
            let error = parameter.standard_error.map_or("None".to_owned(), number);
            format!("    \"{}\": {error},\n", parameter.identifier)
        });
        let entry = |(name, text): (&String, &String)| format!("    \"{name}\": {},\n", quoted(text));
        let (units, renamed) = (self.identifiers_with_units().map(entry), self.renamed());
        let renamed = renamed.iter().map(entry);
        let ranges = lines(&self.ranges, |range| {
            let name = &self.channels[range.channel].identifier;
            format!("    \"{name}\": ({}, {}),\n", number(range.low), number(range.high))
        });
        let imports = if self.ship.is_some() { "atan2, cos, exp, sin, sqrt" } else { "cos, sin" };
        let text = fill(
            include_str!("templates/model.py"),
            &[
                ("base", self.base.clone()),
                ("header", self.marked_header("# ")),
                ("vessel", quoted(&self.vessel)),
                ("made_from", quoted(&self.made_from())),
                ("rate", number(self.rate_hz)),
                ("states", names(self.states())),
                ("inputs", names(self.inputs())),
                ("parameters", parameters),
                ("standard_errors", standard_errors),
                ("units", units.collect()),
                ("names", renamed.collect()),
                ("ranges", ranges),
                ("ranges_are", self.ranges_are().to_owned()),
                ("rate_holds", self.rate_holds().to_owned()),
                ("imports", imports.to_owned()),
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
            let routines = self.routines(ship, Language::Python, &PYTHON, &unpack);
            return fill(
                include_str!("templates/ship.py"),
                &[("steps", ship.steps.to_string()), ("routines", routines)],
            );
        }
        let (weights, [step, sample]) = self.steps();
        let values = [&[("unpack", unpack), step, sample][..], &self.gains(&PYTHON)].concat();
        let paced = weights.map(|entry| fill(include_str!("templates/paced.py"), &[entry]));
        fill(include_str!("templates/terms.py"), &values) + &paced.unwrap_or_default()
    }

    /// Assigns channels to their names within a step.
    fn python_unpack(&self) -> String {
        let all = |channels: &[Channel]| {
            let names: Vec<&str> = channels.iter().map(|channel| channel.identifier.as_str()).collect();
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
    lines(channels, |c| format!("    \"{}\",  # {}\n", c.identifier, said(&c.unit, &c.meaning)))
}

const MATLAB: Syntax =
    Syntax { modulus: "abs", parameter: |_, name| format!("p.{name}"), between: " ...\n    + " };

impl Portable {
    /// The function file.
    pub(crate) fn matlab(&self) -> TextFile {
        let parameters = lines(&self.parameters, |parameter| {
            let (name, value) = (&parameter.identifier, number(parameter.value));
            let meaning = said(&parameter.unit, &parameter.meaning);
            let error = parameter.standard_error.map_or("NaN".to_owned(), number);
            format!(
                "model.parameters.{name} = {value};  % {meaning}\nmodel.standard_errors.{name} = {error};\n"
            )
        });
        let units = self.identifiers_with_units();
        let units = units.map(|(name, unit)| format!("model.units.{name} = {};\n", single(unit)));
        let renamed = self.renamed();
        let renamed = renamed.iter().map(|(new, name)| format!("model.names.{new} = {};\n", single(name)));
        let ranges = lines(&self.ranges, |range| {
            let name = &self.channels[range.channel].identifier;
            format!("model.ranges.{name} = [{}, {}];\n", number(range.low), number(range.high))
        });
        let list = |channels: &[Channel]| {
            channels.iter().map(|channel| single(&channel.identifier)).collect::<Vec<_>>().join(", ")
        };
        let text = fill(
            include_str!("templates/model.m"),
            &[
                ("base", self.base.clone()),
                ("header", self.marked_header("%   ")),
                ("vessel", single(&self.vessel)),
                ("made_from", single(&self.made_from())),
                ("rate", number(self.rate_hz)),
                ("states", list(self.states())),
                ("inputs", list(self.inputs())),
                ("parameters", parameters),
                ("units", units.collect()),
                ("names", renamed.collect()),
                ("ranges", ranges),
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
            let routines = self.routines(ship, Language::Matlab, &MATLAB, &unpack);
            let values =
                [("steps", ship.steps.to_string()), ("rate", number(self.rate_hz)), ("routines", routines)];
            return fill(include_str!("templates/ship.m"), &values);
        }
        let (weights, [step, sample]) = self.steps();
        let values = [&[("unpack", unpack), step, sample][..], &self.gains(&MATLAB)].concat();
        let paced = weights.map(|entry| fill(include_str!("templates/paced.m"), &[entry]));
        fill(include_str!("templates/terms.m"), &values) + &paced.unwrap_or_default()
    }

    /// Assigns channels to their names within a step.
    fn matlab_unpack(&self) -> String {
        let states = ["u = state(1);\n", "v = state(2);\n", "r = state(3);\n"].map(str::to_owned);
        let used = self.used();
        let inputs = self.inputs().iter().enumerate().filter(|(i, _)| used.contains(&(i + 3)));
        let inputs = inputs.map(|(i, channel)| format!("{} = input({});\n", channel.identifier, i + 1));
        let derived = MATLAB.derived(self).into_iter();
        let derived = derived.map(|(name, value)| format!("{name} = {value};\n"));
        states.into_iter().chain(inputs).chain(derived).collect()
    }
}

const C99: Syntax = Syntax {
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
        let channels = lines(self.given(), |channel| {
            let texts = [&channel.identifier, &channel.name, &channel.unit].map(|text| quoted(text));
            format!("    {{{}}},\n", texts.join(", "))
        });
        let parameters = lines(&self.parameters, |parameter| {
            let texts = [&parameter.identifier, &parameter.name, &parameter.unit].map(|text| quoted(text));
            let error = parameter.standard_error.map_or("-1.0".to_owned(), number);
            format!("    {{{}, {}, {error}}},\n", texts.join(", "), number(parameter.value))
        });
        let inputs = self.inputs().iter().map(|input| [&input.identifier, &input.unit, &input.meaning]);
        let places = self.parameters.iter().map(|p| [&p.identifier, &p.unit, &p.meaning]);
        let values = [
            ("base", self.base.clone()),
            ("BASE", self.upper()),
            ("header", self.c_header()),
            ("vessel", quoted(&self.vessel)),
            ("made_from", quoted(&self.made_from())),
            ("rate", number(self.rate_hz)),
            ("input_count", self.inputs().len().to_string()),
            ("input_room", self.inputs().len().max(1).to_string()),
            ("parameter_count", self.parameters.len().to_string()),
            ("range_count", self.ranges.len().to_string()),
            ("range_capacity", self.ranges.len().max(1).to_string()),
            ("input_places", self.c_places("I", inputs)),
            ("parameter_places", self.c_places("P", places)),
            ("channels", channels),
            ("parameters", parameters),
            ("values", lines(&self.parameters, |parameter| format!("    {},\n", number(parameter.value)))),
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
            let unpack = unpack + "    (void)input;\n";
            let routines = self.routines(ship, Language::C, &C99, &unpack);
            let values = [("steps", ship.steps.to_string()), ("routines", routines)];
            return fill(include_str!("templates/ship.c"), &[names, values].concat());
        }
        let (weights, _) = self.steps();
        let step = if weights.is_some() { "static void own_step" } else { "void {{base}}_step" };
        let step = ("step", step.replace("{{base}}", &self.base));
        let values = [names.to_vec(), vec![("unpack", unpack), step], self.gains(&C99).to_vec()].concat();
        let paced = weights.map(|e| fill(include_str!("templates/paced.c"), &[&names[..], &[e]].concat()));
        fill(include_str!("templates/terms.c"), &values) + &paced.unwrap_or_default()
    }

    pub(crate) fn c_header(&self) -> String {
        format!("/*\n{} */", self.marked_header(" * "))
    }

    /// The places of inputs (`I`) or parameters (`P`): identifier, unit and meaning of each.
    fn c_places<'t>(&self, kind: &str, all: impl Iterator<Item = [&'t String; 3]>) -> String {
        let line = |(i, [name, unit, meaning]): (usize, [&String; 3])| {
            format!("#define {}_{kind}_{name} {i} /* {} */\n", self.upper(), said(unit, meaning))
        };
        all.enumerate().map(line).collect()
    }

    fn c_ranges(&self) -> String {
        if self.ranges.is_empty() {
            return "    {0, 0.0, 0.0},\n".to_owned();
        }
        lines(&self.ranges, |r| format!("    {{{}, {}, {}}},\n", r.channel, number(r.low), number(r.high)))
    }

    /// Assigns channels to their names within a step.
    fn c_unpack(&self) -> String {
        let used = self.used();
        let channels = self.given().iter().enumerate();
        let line = |(place, channel): (usize, &Channel)| {
            let from = if place < 3 { format!("state[{place}]") } else { format!("input[{}]", place - 3) };
            format!("    const double {} = {from}; /* [{}] */\n", channel.identifier, comment(&channel.unit))
        };
        let state = |name: &str| self.ship.as_ref().is_none_or(|ship| ship.takes_state(name));
        let given = channels
            .filter(|(place, channel)| if *place < 3 { state(&channel.name) } else { used.contains(place) })
            .map(line);
        let derived = C99.derived(self).into_iter();
        given.chain(derived.map(|(name, value)| format!("    const double {name} = {value};\n"))).collect()
    }
}
