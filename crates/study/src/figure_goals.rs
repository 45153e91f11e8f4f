//! Figures of merit that a design is for, from `merit.json`.

use std::collections::BTreeMap;
use std::path::Path;
use std::str::FromStr;

use design::WeightedFigure;
use files::{Error, Provenance, STUDY_ROLES, read_document};
use refusal::Invalid;
use trial::moments::Moments;

use crate::documents::{FigureMerit, MeritDocument};
use crate::invalid;

/// A figure of this size or less, in its unit, is zero: no error is relative to it.
const ZERO: f64 = 1e-6;

/// A figure of merit that a design may be for; distances in metres.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureGoal {
    /// The maneuver.
    pub maneuver: String,
    /// Its name.
    pub name: String,
    /// What it is.
    pub what: String,
    /// Its unit.
    pub unit: String,
    /// Value, derivatives by parameter in the order of the moments, and weight.
    pub figure: WeightedFigure,
    /// The standard error that is wanted.
    pub wanted: Option<f64>,
}

/// The figures of a `merit.json` for the parameters of moments.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureGoals {
    /// Those with slopes, in the order of the file, each with a weight of 1.
    pub goals: Vec<FigureGoal>,
    /// The parameters that they were differentiated at, in the order of the moments; none is 0.
    pub parameters: Vec<f64>,
    /// Why others are left out, or have no weight.
    pub left_out: Vec<String>,
    /// Length of the ship \[m\].
    length_m: f64,
}

impl FigureGoals {
    /// Reads the figures of the `merit.json` at `path` as an input; it may be of another dictionary than the moments.
    ///
    /// # Errors
    /// As [`FigureGoals::new`]; a file that is refused, or was made of another vessel's.
    pub fn read(path: &Path, moments: &Moments, provenance: &mut Provenance) -> Result<Self, Error> {
        let loaded = read_document::<MeritDocument>(path)?;
        let goals = Self::new(&loaded.data, moments).map_err(|e| invalid(path, &e))?;
        let mut from = loaded.provenance;
        let others: Vec<&str> = STUDY_ROLES.into_iter().filter(|role| *role != "vessel").collect();
        from.forget(&others);
        provenance.made("figures", path, loaded.digest, &from)?;
        Ok(goals)
    }

    /// The figures of `document` for the parameters of `moments`.
    ///
    /// # Errors
    /// Figures without slopes, of another vessel, or of other parameters.
    pub fn new(document: &MeritDocument, moments: &Moments) -> Result<Self, Invalid> {
        let again = "run `validate merit --slopes` with the vessel of the moments";
        if document.vessel != moments.vessel {
            let [found, expected] = [&document.vessel, &moments.vessel].map(|name| format!("`{name}`"));
            return Err(Invalid::new("`data.vessel`", found, expected + ", as in the moments", again));
        }
        let Some(at) = &document.slopes_at else {
            let expected = "the parameters that the figures' slopes were computed at";
            return Err(Invalid::new("`data.slopes_at`", "none", expected, again));
        };
        let names: Vec<&String> = moments.degrees.iter().flat_map(|degree| &degree.parameters).collect();
        let parameters = by_parameter(&at.parameters, &names, "`data.slopes_at.parameters`")?;
        if let Some((name, value)) = names.iter().zip(&parameters).find(|(_, value)| **value == 0.0) {
            let thing = format!("`data.slopes_at.parameters.{name}`");
            return Err(Invalid::new(thing, value.to_string(), "a value other than 0", again));
        }
        let mut goals =
            Self { goals: Vec::new(), parameters, left_out: Vec::new(), length_m: document.length_m };
        for maneuver in &document.maneuvers {
            for figure in &maneuver.figures {
                goals.add(&maneuver.name, figure, &names)?;
            }
        }
        match goals.goals.is_empty() {
            true => Err(Invalid::new("`data.maneuvers`", "no figure with slopes", "at least one", again)),
            false => Ok(goals),
        }
    }

    fn add(&mut self, maneuver: &str, figure: &FigureMerit, names: &[&String]) -> Result<(), Invalid> {
        let place = format!("{maneuver}/{}", figure.name);
        let Some(slopes) = &figure.slopes else {
            let why = figure.without_slopes.as_deref().unwrap_or("it has no slopes");
            self.left_out.push(format!("{place} is left out: {why}."));
            return Ok(());
        };
        let mut slopes = by_parameter(slopes, names, &format!("slopes of `{place}`"))?;
        let (scale, unit) = match figure.unit.as_str() {
            "L" => (self.length_m, "m"),
            unit => (1.0, unit),
        };
        slopes.iter_mut().for_each(|slope| *slope *= scale);
        self.goals.push(FigureGoal {
            maneuver: maneuver.to_owned(),
            name: figure.name.clone(),
            what: figure.what.clone(),
            unit: unit.to_owned(),
            figure: WeightedFigure { value: scale * figure.value, slopes, weight: 1.0 },
            wanted: None,
        });
        Ok(())
    }

    /// Sets the weights as stated, the later over the earlier. Without any, figures with a wanted error count relative to that,
    /// or all. A figure of zero has no weight unless it is named.
    ///
    /// # Errors
    /// An unknown figure; a weight for a figure of zero; no weight above 0.
    pub fn weigh(&mut self, weights: &[FigureWeight]) -> Result<(), Invalid> {
        if weights.is_empty() {
            self.weigh_wanted();
        }
        for stated in weights {
            for index in self.named("--weight", &stated.name)? {
                let goal = &mut self.goals[index];
                goal.figure.weight = stated.weight;
                if is_zero(goal) && stated.weight > 0.0 && !stated.name.is_all() {
                    let thing = format!("--weight {}", stated.name.text());
                    let given = format!("{} of {}", goal.figure.value, goal.maneuver);
                    let expected = "a figure other than 0, which its error is relative to";
                    return Err(Invalid::new(thing, given, expected, "leave it out"));
                }
            }
        }
        for goal in self.goals.iter_mut().filter(|goal| is_zero(goal) && goal.figure.weight > 0.0) {
            goal.figure.weight = 0.0;
            let said = format!(
                "{}/{} is 0 and has no weight: no error is relative to it.",
                goal.maneuver, goal.name
            );
            self.left_out.push(said);
        }
        if self.goals.iter().all(|goal| goal.figure.weight == 0.0) {
            let remedy = "leave one of them out";
            return Err(Invalid::new("--weight", "0 for every figure", "one above 0", remedy));
        }
        Ok(())
    }

    /// Weighs the figures with a wanted error, if there are such, by variance/wanted², and no others; the largest weight is 1.
    fn weigh_wanted(&mut self) {
        let of = |goal: &FigureGoal| goal.wanted.map(|wanted| (goal.figure.value / wanted).powi(2));
        let largest = self.goals.iter().filter_map(of).fold(0.0, f64::max);
        for goal in self.goals.iter_mut().filter(|_| largest > 0.0) {
            goal.figure.weight = of(goal).unwrap_or(0.0) / largest;
        }
    }

    /// Sets the standard errors that are wanted of figures.
    ///
    /// # Errors
    /// An unknown figure; a unit that is not the figure's.
    pub fn want(&mut self, accuracy: &[StatedAccuracy]) -> Result<(), Invalid> {
        for stated in accuracy {
            let StatedAccuracy::Figure(stated) = stated else { continue };
            for index in self.named("--accuracy", &stated.name)? {
                let length_m = self.length_m;
                let goal = &mut self.goals[index];
                let factor = match (goal.unit.as_str(), stated.unit.as_str()) {
                    (known, unit) if known == unit => 1.0,
                    ("m", "L") => length_m,
                    ("deg", "°") => 1.0,
                    ("1", "") => 1.0,
                    (known, unit) => {
                        let given = if unit.is_empty() { "no unit".into() } else { format!("`{unit}`") };
                        let expected = if known == "m" { "m, or L (ship lengths)" } else { known };
                        let thing = format!("--accuracy {}", stated.name.text());
                        return Err(Invalid::new(thing, given, expected, "correct the unit"));
                    }
                };
                goal.wanted = Some(factor * stated.error);
            }
        }
        Ok(())
    }

    /// The places of the figures of this name.
    fn named(&self, flag: &str, name: &FigureName) -> Result<Vec<usize>, Invalid> {
        let all = self.goals.iter().enumerate();
        let places = all.filter(|(_, goal)| name.matches(&goal.maneuver, &goal.name));
        let places: Vec<usize> = places.map(|(index, _)| index).collect();
        if !places.is_empty() {
            return Ok(places);
        }
        let mut known: Vec<&str> = Vec::new();
        for goal in
            self.goals.iter().filter(|g| !name.text().contains('/') || name.text().contains(&g.maneuver))
        {
            if !known.contains(&goal.name.as_str()) {
                known.push(&goal.name);
            }
        }
        Err(Invalid::unknown(flag, name.text(), known))
    }

    /// The figures as a criterion has them.
    pub fn weighted(&self) -> Vec<WeightedFigure> {
        self.goals.iter().map(|goal| goal.figure.clone()).collect()
    }

    /// The slopes of every figure, by parameter.
    pub fn slopes(&self) -> Vec<Vec<f64>> {
        self.goals.iter().map(|goal| goal.figure.slopes.clone()).collect()
    }

    /// Slopes and error of the figures with a wanted one.
    pub fn wanted(&self) -> Vec<(Vec<f64>, f64)> {
        self.goals.iter().filter_map(|goal| Some((goal.figure.slopes.clone(), goal.wanted?))).collect()
    }
}

fn is_zero(goal: &FigureGoal) -> bool {
    goal.figure.value.abs() <= ZERO
}

/// One value of every parameter, in their order.
fn by_parameter(values: &BTreeMap<String, f64>, names: &[&String], thing: &str) -> Result<Vec<f64>, Invalid> {
    let refuse = |found: String| {
        let expected = "the parameters of the moments";
        Invalid::new(thing, found, expected, "run `validate merit --slopes` with the vessel of the moments")
    };
    if let Some(other) = values.keys().find(|name| !names.contains(name)) {
        return Err(refuse(format!("`{other}`")));
    }
    let of = |name: &&String| match values.get(*name) {
        Some(value) if value.is_finite() => Ok(*value),
        Some(value) => Err(refuse(format!("{value} of `{name}`"))),
        None => Err(refuse(format!("no `{name}`"))),
    };
    names.iter().map(of).collect()
}

/// A figure as it is named on the command line: `tactical_diameter`, `circle/tactical_diameter`, `overshoot` of all its
/// numbers, or `all`; hyphens stand for underscores in it.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureName {
    text: String,
    maneuver: Option<String>,
    figure: String,
}

impl FigureName {
    fn new(text: &str) -> Self {
        let (maneuver, figure) = match text.rsplit_once('/') {
            Some((maneuver, figure)) => (Some(maneuver.to_owned()), figure),
            None => (None, text),
        };
        Self { text: text.to_owned(), maneuver, figure: figure.replace('-', "_") }
    }

    /// As it was written.
    pub fn text(&self) -> &str {
        &self.text
    }

    /// Whether it stands for all figures.
    pub fn is_all(&self) -> bool {
        self.maneuver.is_none() && self.figure == "all"
    }

    /// Whether `figure` of `maneuver` is meant.
    pub fn matches(&self, maneuver: &str, figure: &str) -> bool {
        let numbered = |rest: &str| rest.strip_prefix('_').is_some_and(|n| n.parse::<u32>().is_ok());
        let named = figure.strip_prefix(&self.figure).is_some_and(|rest| rest.is_empty() || numbered(rest));
        self.is_all() || (named && self.maneuver.as_ref().is_none_or(|other| other == maneuver))
    }
}

/// `--weight FIGURE=NUMBER`.
#[derive(Clone, Debug, PartialEq)]
pub struct FigureWeight {
    /// The figure.
    pub name: FigureName,
    /// Its weight, 0 or more.
    pub weight: f64,
}

impl FromStr for FigureWeight {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let (name, number) =
            named(text).ok_or("found no `=`, expected figure=number, such as `advance=2`")?;
        match number.parse::<f64>() {
            Ok(weight) if (0.0..=1e9).contains(&weight) => Ok(Self { name, weight }),
            _ => Err(format!("found `{number}`, expected a number from 0 to 1e9; correct it")),
        }
    }
}

/// The value of `--accuracy`: a standard error that is wanted.
#[derive(Clone, Debug, PartialEq)]
pub enum StatedAccuracy {
    /// Relative to the parameters.
    Share(f64),
    /// Of a figure.
    Figure(WantedFigure),
}

impl StatedAccuracy {
    /// The standard error, if it is relative to the parameters.
    pub fn share(&self) -> Option<f64> {
        if let Self::Share(share) = self { Some(*share) } else { None }
    }
}

/// `FIGURE=NUMBER UNIT`.
#[derive(Clone, Debug, PartialEq)]
pub struct WantedFigure {
    /// The figure.
    pub name: FigureName,
    /// Its standard error, above 0, in `unit`.
    pub error: f64,
    /// The unit.
    pub unit: String,
}

impl FromStr for StatedAccuracy {
    type Err = String;

    fn from_str(text: &str) -> Result<Self, String> {
        let expected = "a number above 0, or a figure with one and its unit, such as `advance=2 m`";
        let number = |text: &str| match text.trim().parse::<f64>() {
            Ok(error) if error > 0.0 && error <= 1e9 => Ok(error),
            _ => Err(format!("found `{}`, expected {expected}; correct it", text.trim())),
        };
        let Some((name, rest)) = named(text) else { return number(text).map(Self::Share) };
        let digits = rest.trim_end_matches(|c: char| c.is_alphabetic() || "°/".contains(c));
        let (error, unit) = (number(digits)?, rest[digits.len()..].to_owned());
        Ok(Self::Figure(WantedFigure { name, error, unit }))
    }
}

fn named(text: &str) -> Option<(FigureName, &str)> {
    let (name, rest) = text.rsplit_once('=')?;
    Some((FigureName::new(name.trim()), rest.trim()))
}
