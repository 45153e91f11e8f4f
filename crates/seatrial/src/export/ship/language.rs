//! Routines as text of the languages.

use super::expression::{Expression, Function, Line, Operation, Routine};
use crate::export::text::{comment, number, wrapped};

/// Characters of an expression in a line; sums that are longer have a line for each summand.
const WIDTH: usize = 96;

/// A language of the generated code.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Language {
    Python,
    C,
    Matlab,
}

/// How values of the model are written in a language.
pub(crate) struct Names<'a> {
    /// A parameter, by the index of its quantity.
    pub parameter: &'a dyn Fn(usize) -> String,
    /// The identifiers of the model's variables.
    pub channels: &'a [String],
}

/// How tightly an expression is bound.
fn level(expression: &Expression) -> u8 {
    match expression {
        Expression::Binary(Operation::Sum | Operation::Difference, _) => 1,
        Expression::Binary(..) => 2,
        _ => 3,
    }
}

/// The summands of a sum, in order.
fn summands(expression: &Expression) -> Vec<&Expression> {
    match expression {
        Expression::Binary(Operation::Sum, both) => {
            let mut all = summands(&both[0]);
            all.push(&both[1]);
            all
        }
        _ => vec![expression],
    }
}

impl Language {
    fn function(self, function: Function) -> &'static str {
        match function {
            Function::Modulus if self == Self::C => "fabs",
            Function::Modulus => "abs",
            Function::SquareRoot => "sqrt",
            Function::Exponential => "exp",
            Function::Sine => "sin",
            Function::Cosine => "cos",
            Function::Angle => "atan2",
            Function::Root => "root",
            Function::Sign => "sign",
            Function::IfPositive => "if_positive",
        }
    }

    /// The functions that the language does not have, where `ship` needs them.
    pub fn helpers(self, used: &[Function]) -> String {
        let helpers = [
            (
                Function::IfPositive,
                "`then` where x is above 0, else `other`.",
                ["x", "then", "other"].as_slice(),
            ),
            (Function::Root, "The square root, 0 below 0.", &["x"]),
            (Function::Sign, "-1, 0 or 1.", &["x"]),
        ];
        let needed = |helper: &&(Function, _, _)| used.contains(&helper.0);
        helpers
            .iter()
            .filter(needed)
            .map(|(function, says, formals)| self.helper(*function, says, formals))
            .collect()
    }

    fn helper(self, function: Function, says: &str, formals: &[&str]) -> String {
        let name = self.function(function);
        match self {
            Self::Python => {
                let value = match function {
                    Function::IfPositive => "then if x > 0.0 else other",
                    Function::Root => "sqrt(x) if x > 0.0 else 0.0",
                    _ => "(x > 0.0) - (x < 0.0)",
                };
                format!(
                    "def {name}({}):\n    \"\"\"{says}\"\"\"\n    return {value}\n\n\n",
                    formals.join(", ")
                )
            }
            Self::C => {
                let value = match function {
                    Function::IfPositive => "x > 0.0 ? then : other",
                    Function::Root => "x > 0.0 ? sqrt(x) : 0.0",
                    _ => "(x > 0.0) - (x < 0.0)",
                };
                let formals: Vec<String> = formals.iter().map(|formal| format!("double {formal}")).collect();
                format!(
                    "/* {says} */\nstatic double {name}({})\n{{\n    return {value};\n}}\n\n",
                    formals.join(", ")
                )
            }
            Self::Matlab => {
                let value = match function {
                    Function::IfPositive => "value = other;\nif x > 0\n    value = then;\nend",
                    Function::Root => "value = sqrt(max(x, 0));",
                    _ => return String::new(),
                };
                format!("function value = {name}({})\n% {says}\n{value}\nend\n\n", formals.join(", "))
            }
        }
    }

    /// A value.
    pub fn value(self, expression: &Expression, names: &Names) -> String {
        match expression {
            Expression::Number(value) => number(*value),
            Expression::Quantity(i) => (names.parameter)(*i),
            Expression::Channel(i) => names.channels[*i].clone(),
            Expression::Name(name) => name.clone(),
            Expression::Item(name, i) if self == Self::Matlab => format!("{name}({})", i + 1),
            Expression::Item(name, i) => format!("{name}[{i}]"),
            Expression::Call(function, all) => {
                let all: Vec<String> = all.iter().map(|argument| self.value(argument, names)).collect();
                format!("{}({})", self.function(*function), all.join(", "))
            }
            Expression::Binary(operation, both) => {
                let sign = ["+", "-", "*", "/"][*operation as usize];
                let bound = level(expression);
                // Sums and products are computed from left to right, as the program does.
                let inner = |expression: &Expression, least: u8| {
                    let text = self.value(expression, names);
                    if level(expression) < least { format!("({text})") } else { text }
                };
                format!("{} {sign} {}", inner(&both[0], bound), inner(&both[1], bound + 1))
            }
        }
    }

    /// A value that is assigned, over several lines if it is a long sum.
    fn assigned(self, expression: &Expression, names: &Names, indent: &str) -> String {
        let text = self.value(expression, names);
        if text.len() <= WIDTH {
            return text;
        }
        let all: Vec<String> = summands(expression)
            .into_iter()
            .map(|summand| {
                if level(summand) < 2 {
                    format!("({})", self.value(summand, names))
                } else {
                    self.value(summand, names)
                }
            })
            .collect();
        match self {
            Self::Python => {
                format!("(\n{indent}    {}\n{indent})", all.join(&format!("\n{indent}    + ")))
            }
            Self::C => all.join(&format!("\n{indent}    + ")),
            Self::Matlab => all.join(&format!(" ...\n{indent}    + ")),
        }
    }

    fn lines(self, lines: &[Line], names: &Names, indent: &str) -> String {
        lines.iter().map(|line| self.line(line, names, indent)).collect()
    }

    fn line(self, line: &Line, names: &Names, indent: &str) -> String {
        match line {
            Line::Let(name, value, says) => {
                let value = self.assigned(value, names, indent);
                match self {
                    Self::Python => format!("{indent}{name} = {value}  # {says}\n"),
                    Self::C => format!("{indent}const double {name} = {value}; /* {says} */\n"),
                    Self::Matlab => format!("{indent}{name} = {value};  % {says}\n"),
                }
            }
            Line::Results { name, routine, arguments, count, parameters } => {
                let mut all: Vec<String> = arguments.iter().map(|a| self.value(a, names)).collect();
                if *parameters {
                    all.insert(0, "p".to_owned());
                }
                match self {
                    Self::Python => format!("{indent}{name} = {routine}({})\n", all.join(", ")),
                    Self::Matlab => format!("{indent}{name} = {routine}({});\n", all.join(", ")),
                    Self::C => {
                        all.push(name.clone());
                        format!("{indent}double {name}[{count}];\n{indent}{routine}({});\n", all.join(", "))
                    }
                }
            }
            Line::Sum(name) => match self {
                Self::Python => format!("{indent}{name} = 0.0\n"),
                Self::C => format!("{indent}double {name} = 0.0;\n"),
                Self::Matlab => format!("{indent}{name} = 0;\n"),
            },
            Line::Grow(name, value) => {
                let value = self.value(value, names);
                match self {
                    Self::Python => format!("{indent}{name} += {value}\n"),
                    Self::C => format!("{indent}{name} += {value};\n"),
                    Self::Matlab => format!("{indent}{name} = {name} + {value};\n"),
                }
            }
            Line::Repeat(count, lines) => {
                let inner = self.lines(lines, names, &format!("{indent}    "));
                match self {
                    Self::Python => format!("{indent}for i in range({count}):\n{inner}"),
                    Self::C => format!("{indent}for (int i = 0; i < {count}; i++) {{\n{inner}{indent}}}\n"),
                    Self::Matlab => format!("{indent}for i = 0:{}\n{inner}{indent}end\n", count - 1),
                }
            }
        }
    }

    /// A routine with its results.
    pub fn routine(self, routine: &Routine, names: &Names) -> String {
        let formals: Vec<&str> = routine.arguments.iter().map(|(name, _)| name.as_str()).collect();
        let parameters = if routine.has_parameters() { ["p"].as_slice() } else { &[] };
        let formals: Vec<&str> = parameters.iter().copied().chain(formals).collect();
        self.function_text(routine, &formals, "", names)
    }

    /// The routine from state and inputs to accelerations; `unpack` names what it takes of them.
    pub fn accelerations(self, routine: &Routine, unpack: &str, names: &Names) -> String {
        let formals = match self {
            Self::Python => ["state", "inputs", "p"],
            _ => ["state", "input", "p"],
        };
        self.function_text(routine, &formals, unpack, names)
    }

    fn function_text(self, routine: &Routine, formals: &[&str], unpack: &str, names: &Names) -> String {
        let name = &routine.name;
        let results: Vec<String> = routine.results.iter().map(|result| self.value(result, names)).collect();
        let said = wrapped(&comment(&routine.comment), 100);
        match self {
            Self::Python => {
                let (said, lines) = (said.join("\n    "), self.lines(&routine.lines, names, "    "));
                let results = results.join(",\n        ");
                format!(
                    "def {name}({}):\n    \"\"\"{said}\"\"\"\n{unpack}{lines}    return (\n        {results},\n    )\n\n\n",
                    formals.join(", ")
                )
            }
            Self::Matlab => {
                let (said, lines) = (said.join("\n% "), self.lines(&routine.lines, names, ""));
                let results = results.join(", ...\n    ");
                format!(
                    "function out = {name}({})\n% {said}\n{unpack}{lines}out = [{results}];\nend\n\n",
                    formals.join(", ")
                )
            }
            Self::C => {
                let formal = |argument: &&str| match *argument {
                    "p" | "state" | "input" => format!("const double *{argument}"),
                    _ => format!("double {argument}"),
                };
                let mut formals: Vec<String> = formals.iter().map(formal).collect();
                formals.push("double *out".to_owned());
                let (said, lines) = (said.join("\n * "), self.lines(&routine.lines, names, "    "));
                let results: String = results
                    .iter()
                    .enumerate()
                    .map(|(i, result)| format!("    out[{i}] = {result};\n"))
                    .collect();
                format!(
                    "/* {said} */\nstatic void {name}({})\n{{\n{unpack}{lines}{results}}}\n\n",
                    formals.join(", ")
                )
            }
        }
    }
}
