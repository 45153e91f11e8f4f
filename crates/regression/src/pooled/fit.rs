use numerics::{product, times, transposed};
use refusal::listed;
use ship::model::{Degree, DegreeOfFreedom};

use crate::solve::Normal;
use crate::{MeanRemoval, Sums};

/// How parts are pooled into one estimate.
#[derive(Clone, Copy, Debug)]
pub struct Options<'a> {
    /// No intercept, one per part (*batch*), or one for all (*complete*).
    pub removal: MeanRemoval,
    /// Regularisation towards a nominal model.
    pub prior: Option<Prior<'a>>,
    /// Largest condition index (see [`Diagnosis`]) that is accepted; infinite: any that can be solved. A prior
    /// determines every direction.
    pub most: f64,
}

/// Tikhonov regularisation: the estimate minimises ‖Âx − b̂‖² + s² ‖x − x₀‖², Â being the normal matrix with each row and
/// column divided by the root sum of squares of its centred instrument and regressor (its entries are correlations), x the
/// parameters times those of their regressors, x₀ the nominal ones.
#[derive(Clone, Copy, Debug)]
pub struct Prior<'a> {
    /// s: 0 is none, 0.03 mild; at infinity the estimate is the nominal model.
    pub strength: f64,
    /// The nominal parameters: surge, sway, yaw.
    pub nominal: &'a [f64],
}

/// The outcome for one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct DegreeFit {
    /// Whether there is an estimate, and if not, why.
    pub status: Status,
    /// The estimate.
    pub solution: Option<Solution>,
}

/// Whether a degree of freedom is identified.
#[derive(Clone, Debug, PartialEq)]
pub enum Status {
    /// It is.
    Identified,
    /// No more samples than unknowns.
    TooShort,
    /// This parameter's regressor or instrument is constant, or the matrix singular to rounding.
    NotExcited(usize),
    /// Collinear beyond [`Options::most`].
    Collinear(Diagnosis),
    /// Every parameter is at a bound.
    Bounded,
    /// A search was requested and found no model.
    Unfound,
}

/// An estimate of one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Solution {
    /// θ̂.
    pub theta: Vec<f64>,
    /// G with θ̂ = θ₀ + G (b − A θ₀), p × p row-major: A⁻¹ without a prior.
    pub gain: Vec<f64>,
    /// The intercept over all parts; 0 without one, the mean over the samples of all with one per part.
    pub intercept: f64,
}

/// θ̂ of surge, sway and yaw together, and their intercepts; `None` unless all have an estimate.
pub fn joined(solutions: [Option<&Solution>; 3]) -> Option<(Vec<f64>, [f64; 3])> {
    let [Some(surge), Some(sway), Some(yaw)] = solutions else { return None };
    let all = [surge, sway, yaw];
    Some((all.map(|s| s.theta.as_slice()).concat(), all.map(|s| s.intercept)))
}

/// θ̂ and G, or the parameter that is not excited.
pub(super) fn solve(normal: &Normal, prior: Option<(f64, &[f64])>) -> Result<(Vec<f64>, Vec<f64>), usize> {
    let Some((strength, nominal)) = prior.filter(|(strength, _)| *strength > 0.0) else {
        return normal.solve();
    };
    let p = normal.b.len();
    let scaled = normal.regular_scaled();
    // (ÂᵀÂ + s² I) X = Âᵀ, then the scales are undone.
    let mut gain = transposed(p, &scaled);
    let mut square = product(p, &gain, &scaled);
    (0..p).for_each(|i| square[i * p + i] += strength * strength);
    numerics::solve(p, &mut square, &mut gain).ok_or(0_usize)?;
    for (k, entry) in gain.iter_mut().enumerate() {
        let size = normal.phi[k / p] * normal.zeta[k % p];
        *entry = if size > 0.0 { *entry / size } else { 0.0 };
    }
    let predicted = times(&normal.a, nominal);
    let missing: Vec<f64> = normal.b.iter().zip(predicted).map(|(b, predicted)| b - predicted).collect();
    let moved = times(&gain, &missing);
    Ok((nominal.iter().zip(moved).map(|(nominal, moved)| nominal + moved).collect(), gain))
}

/// Condition index above which columns count as collinear: Belsley, Kuh & Welsch, *Regression Diagnostics*, 1980. A
/// just identified instrumental-variable estimate has no moments: in such a direction it is noise.
pub const COLLINEAR: f64 = 30.0;

/// How well pooled parts determine one degree of freedom.
#[derive(Clone, Debug, PartialEq)]
pub struct Diagnosis {
    /// Condition number of the matrix of correlations between centred instruments and regressors, as in
    /// [`crate::Excitation`]; infinite where a direction is not excited.
    pub condition: f64,
    /// Condition index: square root of the condition number of the normal matrix with the intercept's row and column,
    /// each divided by the root sum of squares of its instrument and regressor, means left in. Above
    /// [`COLLINEAR`] the columns are collinear (with each other or with the intercept).
    pub index: f64,
    /// The weakest direction in these scaled parameters, unit length: p entries, and one for the intercept over all
    /// parts, if any.
    pub direction: Vec<f64>,
    /// Index of the parameter that dominates it.
    pub weakest: usize,
    /// Per regressor the root mean square after removing the mean over all parts, relative to that before: 0 for a constant.
    pub variation: Vec<f64>,
}

/// Diagnoses degree of freedom `d` with sums over the `whole` of the parts and their `normal` equations.
pub(super) fn diagnosed(whole: &Sums, normal: &Normal, removal: MeanRemoval, d: usize) -> Diagnosis {
    let degree = &whole.degrees[d];
    let p = degree.parameters();
    let size = |i: usize| {
        let of = |squares: &[f64]| if i < p { squares[i].sqrt() } else { (whole.samples as f64).sqrt() };
        [of(&degree.instrument_squares), of(&degree.regressor_squares)]
    };
    let lifted = removal == MeanRemoval::Complete && !degree.known.constant;
    let width = p + usize::from(lifted);
    let entry = |k: usize| {
        let (i, j) = (k / width, k % width);
        let plain = if lifted { degree.a[i * (p + 1) + j] } else { normal.a[i * p + j] };
        plain / (size(i)[0] * size(j)[1])
    };
    let scaled: Vec<f64> = (0..width * width).map(entry).collect();
    let mut diagnosis = unknown(p);
    diagnosis.condition = normal.excitation().condition;
    diagnosis.variation = variation(whole, d);
    match numerics::weakest(width, &scaled) {
        Some(weakest) => {
            diagnosis.index = (1.0 / weakest.ratio).sqrt();
            diagnosis.weakest = weakest.dominant(p);
            diagnosis.direction = weakest.direction;
        }
        None => diagnosis.weakest = normal.excitation().weakest,
    }
    diagnosis
}

pub(super) fn unknown(p: usize) -> Diagnosis {
    Diagnosis {
        condition: f64::INFINITY,
        index: f64::INFINITY,
        direction: vec![0.0; p],
        weakest: 0,
        variation: vec![0.0; p],
    }
}

fn variation(whole: &Sums, d: usize) -> Vec<f64> {
    let degree = &whole.degrees[d];
    let (p, n) = (degree.parameters(), whole.samples.max(1) as f64);
    let share = |i: usize| {
        let (mean, square) = (degree.a[p * (p + 1) + i] / n, degree.regressor_squares[i] / n);
        if square > 0.0 { (1.0 - mean * mean / square).max(0.0).sqrt() } else { 0.0 }
    };
    (0..p).map(share).collect()
}

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
        let is_named = constant.is_some_and(named);
        let intercept = named(p) || is_named || varying.is_empty() && !still.is_empty();
        if still.is_empty() && varying.is_empty() {
            varying.extend(constant.filter(|_| is_named));
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
