//! The model as C99.

use crate::export::equation::Syntax;
use crate::export::portable::{Parameter, Portable, Range};
use crate::export::ship::Language;
use crate::export::target::TextFile;
use crate::export::template::fill;
use crate::export::text::{comment, number, quoted};

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
