//! A diagnosis in words.

use refusal::listed;
use ship::model::{Degree, DegreeOfFreedom};

use super::diagnosis::{COLLINEAR, Diagnosis};
use super::fit::Status;

/// Entries of a weakest direction below this share of its largest are not named.
const NAMED: f64 = 0.3;
/// A regressor hardly varies if its centred size is below this share of its size.
const HARDLY: f64 = 0.2;

/// The parameters in a weakest direction.
struct Involved {
    /// Regressors that hardly vary, those of inputs alone first.
    still: Vec<usize>,
    /// The others.
    varying: Vec<usize>,
    /// Whether the intercept is part of it.
    intercept: bool,
}

impl Involved {
    fn new(degree: &Degree, diagnosis: &Diagnosis) -> Self {
        let p = degree.parameters.len();
        let largest = diagnosis.direction.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
        let named = |i: usize| diagnosis.direction.get(i).is_some_and(|x| x.abs() >= NAMED * largest);
        let input = |i: usize| degree.terms[i].products().flatten().all(|f| f.variable >= 3);
        let hardly = |i: &usize| diagnosis.variation[*i] < HARDLY;
        // A term 1 is the intercept itself.
        let constant = degree.constant();
        let (mut still, mut varying): (Vec<usize>, Vec<usize>) = (0..p)
            .filter(|i| constant != Some(*i) && (named(*i) || hardly(i) && input(*i)))
            .partition(hardly);
        still.sort_by_key(|i| !input(*i));
        let own = constant.is_some_and(named);
        let intercept = named(p) || own || varying.is_empty() && !still.is_empty();
        if still.is_empty() && varying.is_empty() {
            varying.extend(constant.filter(|_| own));
        }
        Self { still, varying, intercept }
    }
}

/// The weakest direction of `degree` in words: which terms cannot be distinguished. `constant` names logged channels
/// that never vary.
pub fn weakest(d: DegreeOfFreedom, degree: &Degree, diagnosis: &Diagnosis, constant: &[String]) -> String {
    let about = Involved::new(degree, diagnosis);
    let beyond = diagnosis.index > COLLINEAR;
    let term = |i: &usize| format!("`{}`", degree.terms[*i].text);
    if about.still.is_empty() || !about.intercept {
        let all: Vec<usize> = about.still.iter().chain(&about.varying).copied().collect();
        let terms: Vec<String> = all.iter().map(term).collect();
        let mut names: Vec<String> = all.iter().map(|i| format!("`{}`", degree.parameters[*i])).collect();
        names.extend(about.intercept.then(|| "the intercept".to_owned()));
        let verdict = if beyond { "cannot be told apart" } else { "are hardest to tell apart" };
        return format!("{}: {} go together: {} {verdict}", d.name(), listed(&terms), listed(&names));
    }
    let mut terms = Vec::new();
    for i in &about.still {
        let varies = format!("by {:.1} %", 100.0 * diagnosis.variation[*i]);
        terms.push(match (terms.is_empty(), constant) {
            (true, []) => format!("{} (hardly varies, {varies})", term(i)),
            (true, names) => {
                format!("{} (hardly varies, {varies}; constant: {})", term(i), listed(names))
            }
            (false, _) => format!("{} ({varies})", term(i)),
        });
    }
    terms.extend(about.varying.iter().map(term));
    let verdict = if beyond { "cannot be told" } else { "are hardest to tell" };
    format!("{}: {} {verdict} from the intercept", d.name(), listed(&terms))
}

/// The parameter that [`weakest`] names first.
pub fn first_named(degree: &Degree, diagnosis: &Diagnosis) -> usize {
    let about = Involved::new(degree, diagnosis);
    about.still.first().or(about.varying.first()).copied().unwrap_or(diagnosis.weakest)
}

/// [`weakest`] with its condition index.
pub fn collinear(d: DegreeOfFreedom, degree: &Degree, diagnosis: &Diagnosis, constant: &[String]) -> String {
    let direction = weakest(d, degree, diagnosis, constant);
    let index = match diagnosis.index {
        index if index.is_finite() => format!("{index:.0}"),
        _ => "beyond all numbers".to_owned(),
    };
    format!("{direction} (condition index {index}, from {COLLINEAR:.0} on collinear)")
}

/// Why degree of freedom `d` has no estimate.
pub fn unidentified(
    d: DegreeOfFreedom,
    degree: &Degree,
    status: &Status,
    constant: &[String],
) -> Option<String> {
    match status {
        Status::Identified => None,
        Status::TooShort => Some(format!("{}: no more samples than unknowns", d.name())),
        Status::NotExcited(parameter) => Some(format!(
            "{}: `{}` is not excited: its term `{}` does not vary by itself",
            d.name(),
            degree.parameters.get(*parameter).map_or("", String::as_str),
            degree.terms.get(*parameter).map_or("", |t| t.text.as_str()),
        )),
        Status::Bounded => Some(excluded(d, degree)),
        Status::Unfound => Some(format!("{}: the search for an estimate led nowhere", d.name())),
        Status::Collinear(diagnosis) => Some(collinear(d, degree, diagnosis, constant)),
    }
}

/// Says that the bounds of `degree` leave no estimate.
pub fn excluded(d: DegreeOfFreedom, degree: &Degree) -> String {
    let bound = |(i, [low, high]): (&usize, &[f64; 2])| {
        format!("`{}` between {low} and {high}", degree.parameters[*i])
    };
    let bounds: Vec<String> = degree.bounds.iter().map(bound).collect();
    format!(
        "{}: the bounds exclude every estimate: {} end at a bound, all of them",
        d.name(),
        listed(&bounds)
    )
}
