use numerics::statistics::log_chi_square_tail;
use numerics::{LANES, Lane};
use refusal::listed;
use ship::engine::Compiled;
use ship::model::{Degree, DegreeOfFreedom, Model, Term, Variable};

use super::verdict::{Absent, Suspect, sign_remedy};

/// Terms of surge to second order: even under exchange of port and starboard. Those of third order are too similar.
const EVEN: [&str; 5] = ["u", "u |u|", "v r", "v^2", "r^2"];
/// Terms of sway and yaw: odd.
const ODD: [&str; 8] = ["v", "r", "u v", "u r", "v |v|", "r |r|", "v |r|", "|v| r"];

/// An effect on the states other than a term, with a column in each degree of freedom.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Effect {
    /// Inputs act later by a first-order lag.
    Lag,
    /// Inputs act a sample later.
    Delay,
    /// A steady current in earth axes: north and east.
    Current(usize),
}

impl Effect {
    pub const ALL: [Self; 4] = [Self::Lag, Self::Delay, Self::Current(0), Self::Current(1)];

    fn channel(self, d: usize) -> String {
        let name = match self {
            Self::Lag => "lag",
            Self::Delay => "delay",
            Self::Current(axis) => ["north", "east"][axis],
        };
        format!("_{name}_{}", DegreeOfFreedom::ALL[d].name())
    }
}

#[derive(Clone, Debug)]
pub(super) struct CandidateEffect {
    pub kind: Suspect,
    pub degree: Option<DegreeOfFreedom>,
    /// Its name: `r |r|`, `lag`, `current`.
    pub name: String,
    pub unit: String,
    /// What is zero in the model: per unknown the columns that act together.
    pub unknowns: Vec<Vec<usize>>,
}

impl CandidateEffect {
    /// The name of its degree of freedom.
    pub fn place(&self) -> Option<&'static str> {
        self.degree.map(DegreeOfFreedom::name)
    }
}

/// The model with all candidates as further terms, whose parameters are zero.
#[derive(Clone, Debug)]
pub(super) struct Lifted {
    /// The terms of the model, then the others, degree by degree; channels of effects follow its own.
    pub model: Model,
    /// Indices of the parameters of the original among those of `model`.
    pub known: Vec<usize>,
    pub others: Vec<usize>,
    pub candidates: Vec<CandidateEffect>,
}

impl Lifted {
    /// Of `model`, with the effects' channels appended to its own.
    pub fn new(model: &Model) -> Self {
        let mut lifted = model.clone();
        for effect in Effect::ALL {
            let channels = (0..3).map(|d| Variable { name: effect.channel(d), unit: String::new() });
            lifted.variables.extend(channels);
        }
        let names: Vec<String> = lifted.variables.iter().map(|v| v.name.clone()).collect();
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        let (mut known, mut others, mut candidates) = (Vec::new(), Vec::new(), Vec::new());
        let mut effects = Effect::ALL.map(|_| Vec::new());
        let mut place = 0;
        for (degree, lifted_degree) in DegreeOfFreedom::ALL.into_iter().zip(&mut lifted.degrees) {
            known.extend(place..place + lifted_degree.terms.len());
            place += lifted_degree.terms.len();
            for (name, term) in absent(model, degree, &names) {
                let (unit, unknowns) = (model.unit(degree, &term), vec![vec![others.len()]]);
                let kind = Suspect::Term;
                candidates.push(CandidateEffect { kind, degree: Some(degree), unit, name, unknowns });
                push(lifted_degree, term, &mut others, &mut place);
            }
            for (effect, columns) in Effect::ALL.into_iter().zip(&mut effects) {
                let Ok(term) = Term::parse(&effect.channel(degree as usize), &names) else { continue };
                columns.push(others.len());
                push(lifted_degree, term, &mut others, &mut place);
            }
        }
        let [lag, delay, north, east] = effects;
        let mut add = |kind, name: &str, unit: &str, unknowns: Vec<Vec<usize>>| {
            let (name, unit) = (name.to_owned(), unit.to_owned());
            candidates.push(CandidateEffect { kind, degree: None, name, unit, unknowns });
        };
        if model.inputs > 0 {
            add(Suspect::Late, "lag of the inputs", "s", vec![lag]);
            add(Suspect::Late, "delay of the inputs", "samples", vec![delay]);
        }
        add(Suspect::Current, "current", "m/s", vec![north, east]);
        Self { model: lifted, known, others, candidates }
    }

    /// Parameters of `model` from those of the original.
    pub fn parameters<X: Copy>(&self, known: &[X], zero: X) -> Vec<X> {
        let mut all = vec![zero; self.model.parameters()];
        self.known.iter().zip(known).for_each(|(place, value)| all[*place] = *value);
        all
    }
}

fn push(degree: &mut Degree, term: Term, others: &mut Vec<usize>, place: &mut usize) {
    degree.parameters.push(term.text.clone());
    degree.terms.push(term);
    others.push(*place);
    *place += 1;
}

/// Terms of the library that `degree` of `model` lacks, and logged channels that no term has.
fn absent(model: &Model, degree: DegreeOfFreedom, names: &[&str]) -> Vec<(String, Term)> {
    let terms = &model.degrees[degree as usize].terms;
    let texts: &[&str] = if degree == DegreeOfFreedom::Surge { &EVEN } else { &ODD };
    let texts = texts.iter().copied().chain(unused(model).map(|variable| names[variable]));
    let parsed = texts.filter_map(|text| Some((text.to_owned(), Term::parse(text, names).ok()?)));
    let sorted = |term: &Term| {
        let mut factors: Vec<(usize, bool)> = term.factors.iter().map(|f| (f.variable, f.modulus)).collect();
        factors.sort_unstable();
        factors
    };
    // Fixed and tied terms are tested too: they may be fixed or tied wrongly.
    let has = |term: &Term| terms.iter().any(|known| known.tied.is_empty() && sorted(known) == sorted(term));
    parsed.filter(|(_, term)| !has(term)).collect()
}

/// Channels that neither a term nor a derived channel has. Those of [`Effect`], which follow, are none.
fn unused(model: &Model) -> impl Iterator<Item = usize> + '_ {
    let of_terms = |variable: usize| {
        let mut factors =
            model.degrees.iter().flat_map(|degree| &degree.terms).flat_map(|term| &term.factors);
        factors.any(|factor| factor.variable == variable)
    };
    let derived = move |variable: usize| {
        model
            .derived
            .iter()
            .any(|channel| channel.variable == variable || channel.sources.contains(&variable))
    };
    let is_effect = |variable: usize| model.variables[variable].name.starts_with('_');
    let logged = 3..model.variables.len();
    logged.filter(move |variable| !of_terms(*variable) && !derived(*variable) && !is_effect(*variable))
}

/// The lag that is tested \[samples\]: the effects of shorter and longer ones are similar.
const LAG: f64 = 4.0;

/// Inputs and measured disturbances followed by the channels of [`Effect::ALL`], N × (exogenous + 12).
///
/// `states`: as predicted, (N+1) × 3. An effect on the states is their derivative by inputs or water, along them.
pub(super) fn with_effects(
    model: &Model,
    parameters: &[Lane],
    states: &[Lane],
    exogenous: &[Lane],
    rate_hz: f64,
) -> Vec<Lane> {
    let width = model.exogenous();
    let mut compiled = Compiled::new(model, parameters);
    let mut gradients = vec![[Lane::ZERO; 3]; model.variables.len()];
    let mut heading = Lane::ZERO;
    let mut lagged: Vec<Lane> = exogenous[..model.inputs].to_vec();
    let keep = Lane::splat(libm::exp(-1.0 / LAG));
    let per_second = Lane::splat(rate_hz / LAG);
    let mut out = Vec::with_capacity(exogenous.len() / width.max(1) * (width + 3 * Effect::ALL.len()));
    for (k, (row, state)) in exogenous.chunks_exact(width.max(1)).zip(states.as_chunks::<3>().0).enumerate() {
        compiled.look(*state, row, None);
        compiled.gradients(&mut gradients);
        let before = if k > 0 { &exogenous[(k - 1) * width..k * width] } else { row };
        let (cos, sin) = turned(&heading);
        // Derivatives by the water's velocity are minus those by the vessel's.
        let along = |d: usize| Lane::ZERO - gradients[0][d];
        let across = |d: usize| Lane::ZERO - gradients[1][d];
        out.extend_from_slice(row);
        for effect in Effect::ALL {
            out.extend((0..3).map(|d| match effect {
                Effect::Lag => per_second * sum(model.inputs, |i| gradients[3 + i][d] * (lagged[i] - row[i])),
                Effect::Delay => sum(model.inputs, |i| gradients[3 + i][d] * (before[i] - row[i])),
                Effect::Current(0) => along(d) * cos - across(d) * sin,
                Effect::Current(_) => along(d) * sin + across(d) * cos,
            }));
        }
        for (lagged, input) in lagged.iter_mut().zip(row) {
            *lagged = keep * *lagged + (Lane::ONE - keep) * *input;
        }
        heading += Lane::splat(1.0 / rate_hz) * state[2];
    }
    out
}

fn sum(count: usize, of: impl Fn(usize) -> Lane) -> Lane {
    let mut sum = Lane::ZERO;
    (0..count).for_each(|i| sum += of(i));
    sum
}

fn turned(heading: &Lane) -> (Lane, Lane) {
    let (mut cos, mut sin) = (Lane::ZERO, Lane::ZERO);
    for lane in 0..LANES {
        (sin[lane], cos[lane]) = libm::sincos(heading[lane]);
    }
    (cos, sin)
}

// Channels that act with the opposite sign: a fit follows such a recording as well, so nominal values are to tell.

/// Standard errors that an estimate must be away from zero for its sign to count …
const FAR: f64 = 5.0;
/// … and those that the nominal value must be away from it.
const NOMINAL: f64 = 3.0;

/// A parameter whose sign counts: its place, name, nominal value, and estimate with its standard error.
type SignCounted<'a> = (usize, &'a str, f64, [f64; 2]);

/// The test of each logged channel and sensor: how many times as the `nominal` values say it acts, by the parameters that its
/// sign would turn. It is wrong if all of them are turned, and most of those that are turned are among them. `estimates` are
/// those of the parameters of `model` with their standard errors, where both are known.
pub(crate) fn signs(model: &Model, nominal: &[f64], estimates: &[Option<[f64; 2]>]) -> Vec<Absent> {
    let counted = counted(model, nominal, estimates);
    let turned = counted.iter().filter(|one| is_turned(one)).count();
    let variables = || (3..model.variables.len() - model.derived.len()).chain(0..3);
    let group = |variable: usize| counted.iter().filter(move |(i, ..)| turns(model, variable, *i)).collect();
    let groups: Vec<(usize, Vec<&SignCounted>)> =
        variables().map(|variable| (variable, group(variable))).collect();
    let tested = || groups.iter().filter(|(_, group)| !group.is_empty());
    let wrong =
        tested().find(|(_, group)| group.iter().all(|one| is_turned(one)) && 2 * group.len() > turned);
    let test = |(variable, group): &(usize, Vec<&SignCounted>)| {
        let name = &model.variables[*variable].name;
        let channel = if *variable < 3 { format!("y_{name}") } else { name.clone() };
        let sum = |of: &dyn Fn(f64, [f64; 2]) -> f64| {
            group.iter().map(|(.., m, estimate)| of(*m, *estimate)).sum::<f64>()
        };
        let square = sum(&|nominal, [_, error]| (nominal / error).powi(2));
        let times = sum(&|nominal, [estimate, error]| nominal * estimate / (error * error)) / square;
        // At most, however the estimates are correlated.
        let error = sum(&|nominal, [_, error]| (nominal / error).abs()) / square;
        let log_p = if times < 0.0 { log_chi_square_tail((times / error).powi(2), 1) } else { 0.0 };
        let parameters: Vec<String> = group.iter().map(|(_, name, ..)| format!("`{name}`")).collect();
        Absent {
            kind: Suspect::Sign,
            name: format!("`{channel}` acts with the opposite sign"),
            unit: format!("times the nominal {}", listed(&parameters)),
            visible_from: None,
            candidate: wrong.is_some_and(|(wrong, _)| wrong == variable),
            remedy: Some(sign_remedy(&channel)),
            ..Absent::scored(
                vec![times],
                vec![error],
                log_p,
                (tested().count() as f64 * libm::exp(log_p)).min(1.0),
            )
        }
    };
    let is_finite = |sign: &Absent| sign.value[0].is_finite() && sign.standard_error[0].is_finite();
    tested().map(test).filter(is_finite).collect()
}

/// The sign that is wrong by `nominal` values, else the estimates with another sign than these, in words; see [`signs`].
pub fn against_nominal(model: &Model, nominal: &[f64], estimates: &[Option<[f64; 2]>]) -> Option<String> {
    if let Some(wrong) = signs(model, nominal, estimates).into_iter().find(|sign| sign.candidate) {
        return Some(wrong.sentence());
    }
    let turned = counted(model, nominal, estimates).into_iter().filter(is_turned);
    let each = |(_, name, nominal, [estimate, error]): SignCounted| {
        format!("`{name}` {estimate:.3e} ± {error:.1e}, nominal {nominal:.3e}")
    };
    let all: Vec<String> = turned.map(each).collect();
    (!all.is_empty()).then(|| format!("estimates with another sign than the nominal value: {}", listed(&all)))
}

fn counted<'a>(model: &'a Model, nominal: &[f64], estimates: &[Option<[f64; 2]>]) -> Vec<SignCounted<'a>> {
    let parameters = model.parameter_names().zip(nominal).zip(estimates).enumerate();
    let known = parameters.filter_map(|(i, ((name, nominal), known))| Some((i, name, *nominal, (*known)?)));
    known
        .filter(|(.., nominal, [estimate, error])| {
            *error > 0.0 && estimate.abs() > FAR * error && nominal.abs() > NOMINAL * error
        })
        .collect()
}

fn is_turned((.., nominal, [estimate, _]): &SignCounted) -> bool {
    estimate * nominal < 0.0
}

/// Whether a turn of the sign of `variable` turns parameter `i`.
fn turns(model: &Model, variable: usize, i: usize) -> bool {
    let mut terms =
        (0..).zip(&model.degrees).flat_map(|(d, degree)| degree.terms.iter().map(move |term| (d, term)));
    terms.nth(i).is_some_and(|(d, term): (usize, _)| {
        let factors = term.factors.iter().filter(|f| f.variable == variable && !f.modulus).count();
        (factors + usize::from(d == variable)) % 2 == 1
    })
}
