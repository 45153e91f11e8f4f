use identification::pooled::{Diagnosis, PartDiverged, Status};
use vessel::{Degree, DegreeOfFreedom};

/// Entries of a weakest direction below this share of its largest are not named.
const NAMED: f64 = 0.3;
/// A regressor whose centred size is below this share of its size hardly varies.
const HARDLY: f64 = 0.2;

/// The weakest direction of `degree` in words: which terms cannot be told from which.
pub fn weakest(d: DegreeOfFreedom, degree: &Degree, diagnosis: &Diagnosis) -> String {
    let largest = diagnosis.direction.iter().fold(0.0_f64, |most, x| most.max(x.abs()));
    let involved = |i: &usize| diagnosis.direction.get(*i).is_some_and(|x| x.abs() >= NAMED * largest);
    let parameters: Vec<usize> = (0..degree.parameters.len()).filter(involved).collect();
    let mut names: Vec<String> = parameters.iter().map(|i| format!("`{}`", degree.parameters[*i])).collect();
    let still: Vec<usize> = parameters.iter().copied().filter(|i| diagnosis.variation[*i] < HARDLY).collect();
    if involved(&degree.parameters.len()) || still.len() == parameters.len() && !still.is_empty() {
        names.push("the intercept".to_owned());
    }
    let told = format!("{} cannot be told apart", listed(&names));
    if still.is_empty() {
        let terms: Vec<String> = parameters.iter().map(|i| format!("`{}`", degree.terms[*i].text)).collect();
        return format!("{}: {} go together: {told}", d.name(), listed(&terms));
    }
    let varies =
        |i: &usize| format!("`{}` by {:.1} %", degree.terms[*i].text, 100.0 * diagnosis.variation[*i]);
    let varying: Vec<String> = still.iter().map(varies).collect();
    format!("{}: hardly varies: {}: {told}", d.name(), listed(&varying))
}

/// Why degree of freedom `d` has no estimate.
pub fn unidentified(d: DegreeOfFreedom, degree: &Degree, status: &Status) -> Option<String> {
    match status {
        Status::Identified => None,
        Status::TooShort => Some(format!("{}: no more samples than unknowns", d.name())),
        Status::NotExcited(parameter) => Some(format!(
            "{}: `{}` is not excited: its term `{}` does not vary by itself",
            d.name(),
            degree.parameters.get(*parameter).map_or("", String::as_str),
            degree.terms.get(*parameter).map_or("", |t| t.text.as_str()),
        )),
        Status::Collinear(diagnosis) => Some(format!(
            "{} (condition index {:.0}, from {:.0} on collinear)",
            weakest(d, degree, diagnosis),
            diagnosis.index,
            identification::pooled::COLLINEAR
        )),
    }
}

/// That a nominal simulation diverged.
pub fn lost_instruments(label: &str, source: &str, diverged: PartDiverged) -> String {
    format!(
        "instruments: the nominal simulation over `{label}` of {source} diverges at sample {} in {}",
        diverged.at.sample,
        DegreeOfFreedom::ALL[diverged.at.state].name()
    )
}

/// `a`, `a and b`, `a, b and c`.
pub fn listed(items: &[String]) -> String {
    match items {
        [] => String::new(),
        [one] => one.clone(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}
