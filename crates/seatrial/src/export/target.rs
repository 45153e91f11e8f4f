//! The targets of an export.

use refusal::Invalid;
use ship::model::{DerivedChannel, Factor, Function, RateChange};

use crate::export::Portable;
use crate::export::portable::Summand;
use crate::export::text::{comment, number, wrapped};

/// Another tool's language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One module of the standard library alone.
    Python,
    /// C99: a header, a source, a program that goes from CSV to CSV.
    C,
    /// One function file for MATLAB and Octave.
    Matlab,
    /// A Functional Mock-up Unit.
    Fmu,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Python, Self::C, Self::Matlab, Self::Fmu];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        ["python", "c", "matlab", "fmu"][self as usize]
    }

    /// In a line.
    pub fn description(self) -> &'static str {
        [
            "A Python module; needs nothing but Python, takes numpy's arrays too",
            "C99: header, source, and a program from CSV to CSV",
            "A function file for MATLAB and Octave",
            "A Functional Mock-up Unit: FMI 2.0, co-simulation, with its C source",
        ][self as usize]
    }
}

/// A file's name and text.
pub(crate) type TextFile = (String, String);

impl Portable {
    /// The names of the files of `target`, the main file first.
    pub fn file_names(&self, target: Target) -> Vec<String> {
        match target {
            Target::Fmu => vec![format!("{}.fmu", self.base)],
            _ => self.texts(target).into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// The contents of these files, in the same order; a unit contains the `library` built from its sources,
    /// if there is one.
    ///
    /// # Errors
    /// A unit that is too long for an archive.
    pub fn files(&self, target: Target, library: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, Invalid> {
        match target {
            Target::Fmu => Ok(vec![self.unit(library)?]),
            _ => Ok(self.texts(target).into_iter().map(|(_, text)| text.into_bytes()).collect()),
        }
    }

    fn texts(&self, target: Target) -> Vec<TextFile> {
        match target {
            Target::Python => vec![self.python()],
            Target::C => self.c(),
            Target::Matlab => vec![self.matlab()],
            Target::Fmu => self.unit_sources(),
        }
    }
}

/// Where the expressions of a language differ from the others'.
pub struct Syntax {
    /// The function for the modulus.
    pub modulus: &'static str,
    /// A parameter, from its identifier.
    pub parameter: fn(&Portable, &str) -> String,
    /// Separator between two summands.
    pub between: &'static str,
}

impl Syntax {
    /// The computed channels that some equation uses: identifier and expression.
    pub fn derived<'m>(&self, model: &'m Portable) -> Vec<(&'m str, String)> {
        let used = model.used();
        let needed = model.derived.iter().filter(|channel| used.contains(&channel.variable));
        let expression = |derived: &'m DerivedChannel| {
            let written = derived.formula.written(|function, source| {
                self.function(function, &model.channels[derived.sources[source]].identifier)
            });
            (model.channels[derived.variable].identifier.as_str(), written)
        };
        needed.map(expression).collect()
    }

    fn function(&self, function: Function, name: &str) -> String {
        let modulus = format!("{}({name})", self.modulus);
        match function {
            Function::Itself => name.to_owned(),
            Function::Modulus => modulus,
            Function::PositivePart => format!("(0.5 * ({name} + {modulus}))"),
            Function::NegativePart => format!("(0.5 * ({name} - {modulus}))"),
            Function::Sine => format!("sin({name})"),
            Function::Cosine => format!("cos({name})"),
        }
    }

    /// The increment of degree of freedom `d` of `model` in a step. Products and sums are in the order of
    /// [`ship::engine::Compiled::step`].
    pub fn gain(&self, model: &Portable, d: usize) -> String {
        let summands: Vec<String> = model.equations[d].iter().map(|s| self.summand(model, s)).collect();
        summands.join(self.between)
    }

    fn summand(&self, model: &Portable, summand: &Summand) -> String {
        let parameter = (self.parameter)(model, &model.parameters[summand.parameter].identifier);
        match summand.products.as_slice() {
            [] => parameter,
            [(factors, None)] if factors.len() == 1 => {
                format!("{parameter} * {}", self.product(model, factors, None))
            }
            products => {
                let each = products.iter().map(|(factors, c)| self.product(model, factors, *c));
                format!("{parameter} * ({})", each.collect::<Vec<_>>().join(" + "))
            }
        }
    }

    fn product(&self, model: &Portable, factors: &[Factor], coefficient: Option<f64>) -> String {
        let factor = |factor: &Factor| {
            let name = &model.channels[factor.variable].identifier;
            if factor.modulus { format!("{}({name})", self.modulus) } else { name.clone() }
        };
        let written = factors.iter().map(factor).chain(coefficient.map(number));
        written.collect::<Vec<_>>().join(" * ")
    }
}

/// Characters in a line of a comment.
const WIDTH: usize = 110;

impl Portable {
    /// The lines of the comment at the top of a file.
    pub(crate) fn header(&self) -> Vec<String> {
        let origin = &self.origin;
        let mut said = vec![
            format!("Manoeuvring model of {}, written by {}.", self.vessel, origin.producer),
            format!("Made from {}, {}; the values are its {}.", origin.file, origin.digest, origin.values),
            self.time(),
            format!(
                "States: u, v [m/s] along x (forward) and y (starboard), r [rad/s] about z (down), in body axes. {}",
                self.current()
            ),
        ];
        said.extend(self.late.iter().map(|late| format!("Inputs are as they act: {late}.")));
        said.push(match self.ranges.is_empty() {
            true => "Its range of validity is not known: within_ranges is true everywhere.".to_owned(),
            false => format!("Its range of validity is {}.", self.ranges_are()),
        });
        said.extend(self.tied.iter().map(|tied| {
            format!(
                "{} is {} times {}, and part of the term of that.",
                tied.name,
                number(tied.factor),
                tied.to
            )
        }));
        if self.ship.is_some() {
            said.push("A number `key` of `component` is called component_key here.".to_owned());
        }
        let renamed = self.unlike();
        said.extend(renamed.iter().map(|(identifier, name)| format!("{name} is called {identifier} here.")));
        said.extend(self.parts.iter().map(|part| format!("{part}.")));
        said.extend(self.notes.iter().map(|note| format!("Note: {note}.")));
        said.iter().flat_map(|line| wrapped(&comment(line), WIDTH)).collect()
    }

    /// The length of its steps, in words.
    fn time(&self) -> String {
        let (seconds, rate) = (number(1.0 / self.rate_hz), self.rate_hz);
        let step = number(1.0 / self.own_rate_hz());
        let sums = "Discrete in time: in a step the states gain the sums below. They hold for steps of";
        match (&self.ship, self.pace) {
            (None, RateChange::Repeated(count)) => {
                format!("{sums} {step} s; here, a step of {seconds} s ({rate} Hz) is {count} of them.")
            }
            (None, RateChange::Divided { by, order }) => format!(
                "{sums} {step} s; here, a step of {seconds} s ({rate} Hz) is a part of them, by Newton's forward formula of order {order} for \
                 1/{by} of a step."
            ),
            (Some(ship), _) => format!(
                "Forces in continuous time: a step of {seconds} s ({rate} Hz) is {} of Runge and Kutta's method of order 4.",
                if ship.steps == 1 { "one".to_owned() } else { ship.steps.to_string() }
            ),
            (None, RateChange::Own) => format!(
                "Discrete in time: it holds for steps of {seconds} s ({rate} Hz) and for no others. In a step the states gain the \
                 sums below."
            ),
        }
    }

    /// How it is stepped in a current.
    fn current(&self) -> &'static str {
        match self.ship {
            Some(_) => {
                "In a current, step from (state - c), where c is the current in body axes; then add it in the body axes at the end of \
                 the step: it keeps its course over the earth."
            }
            None => "In a current c, in body axes too, the next state is c plus the step from (state - c).",
        }
    }

    /// [`Portable::header`] with `mark` in front of every line.
    pub(crate) fn marked_header(&self, mark: &str) -> String {
        self.header().iter().map(|line| format!("{mark}{line}\n")).collect()
    }
}
