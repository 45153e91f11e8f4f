use std::str::FromStr;

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
        self.is_all() || (named && self.maneuver.as_ref().is_none_or(|own| own == maneuver))
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
