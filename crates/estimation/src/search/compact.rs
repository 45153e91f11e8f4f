use numerics::least_squares::{Ending, Expansion};
use numerics::statistics::spread;
use numerics::{add_outer, dependent_columns, dot, times};
use regression::pooled::Part;
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use ship::engine::Compiled;
use ship::model::Model;

use super::nested::{Fitted, Folds, Study, minimum, widened};
use super::problem::WindowProblem;
use super::{Laid, Recording, limit, scores, together};
use crate::pooled::{Delivered, RecordingConstant, covered};

const REFIT: Ending = Ending { steps: 2, enough: 0.03, damping: 1e-6 };
const JUDGED: Ending = Ending { steps: 12, enough: 0.01, ..REFIT };
const BEFORE: usize = 3;
const PATIENCE: usize = 12;
const NONE: f64 = 1e-4;

/// A number of terms and how folds that are left out are followed with that many.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(deny_unknown_fields)]
pub struct SizeScore {
    /// Number of terms, constants among them.
    pub terms: u64,
    /// The term that was added last.
    pub added: String,
    /// Mean loss of the folds left out, by a quadratic model of the errors.
    pub loss: f64,
    /// How far it lies above the least.
    pub excess: f64,
    /// Standard error of that, by fold.
    pub standard_error: f64,
}

pub(crate) struct Compact {
    pub sizes: Vec<SizeScore>,
    pub places: Vec<usize>,
}

struct Size {
    places: Vec<usize>,
    added: usize,
    losses: Vec<f64>,
}

impl Size {
    fn total(&self) -> f64 {
        self.losses.iter().sum()
    }
}

impl Study<'_> {
    /// The fewest terms whose loss on left-out folds is within a standard error of the least; base terms stay. Only
    /// recordings of `folds` are used. `None` if nothing can be fitted.
    pub fn compact(&self, base: &[f64], folds: &Folds, ridge: f64) -> Option<Compact> {
        let wide = widened(self.base, self.library, base);
        let sizes = self.forward(folds, self.base_places(), &wide, ridge);
        let best = sizes.iter().min_by(|a, b| a.total().total_cmp(&b.total()))?;
        let names: Vec<&str> = self.library.parameter_names().collect();
        let errors: f64 = folds.iter().flatten().map(|r| r.errors()).sum();
        let scores: Vec<SizeScore> = sizes
            .iter()
            .map(|size| {
                let more: Vec<f64> = size.losses.iter().zip(&best.losses).map(|(a, b)| a - b).collect();
                SizeScore {
                    terms: size.places.len() as u64,
                    added: names[size.added].to_owned(),
                    loss: size.total() / errors,
                    excess: more.iter().sum::<f64>() / errors,
                    standard_error: spread(&more).unwrap_or(0.0) * (more.len() as f64).sqrt() / errors,
                }
            })
            .collect();
        let chosen = scores.iter().position(|size| size.excess <= size.standard_error)?;
        let places = sizes[chosen].places.clone();
        Some(Compact { sizes: scores, places })
    }

    /// The model of the terms at `places`, fitted to all of `folds`.
    pub fn fitted(&self, places: &[usize], base: &[f64], folds: &Folds, ridge: f64) -> Option<Fitted> {
        let recordings: Vec<&Recording> = folds.iter().flatten().copied().collect();
        let model = subset(self.library, places);
        let wide = widened(self.base, self.library, base);
        let start: Vec<f64> = places.iter().map(|i| wide[*i]).collect();
        let known: Vec<bool> = places.iter().map(|i| self.known()[*i]).collect();
        let problem = WindowProblem::new(&model, &recordings, self.rate_hz).by_effect(&start, &known);
        let beta = minimum(&problem, problem.beta(&start), ridge, JUDGED)?;
        problem.look(&beta)?;
        let theta = problem.theta(&beta);
        Some(Fitted { model, theta })
    }

    /// Forward selection: adds the terms of least loss on left-out folds, by quadratic models renewed every few terms.
    fn forward(&self, folds: &Folds, start: Vec<usize>, theta: &[f64], ridge: f64) -> Vec<Size> {
        let all: Vec<&Recording> = folds.iter().flatten().copied().collect();
        let whole = WindowProblem::new(self.library, &all, self.rate_hz).by_effect(theta, &self.known());
        let (mut places, mut beta) = (start, whole.beta(theta));
        let mut sizes: Vec<Size> = Vec::new();
        let mut best = (f64::INFINITY, 0);
        while places.len() < whole.sizes.len() && sizes.len() <= best.1 + PATIENCE {
            let model = subset(self.library, &places);
            let scales = places.iter().map(|i| whole.sizes[*i]).collect();
            let problem = WindowProblem::new(&model, &all, self.rate_hz).sized(scales);
            let from: Vec<f64> = places.iter().map(|i| beta[*i]).collect();
            let Some(fitted) = minimum(&problem, from, ridge, REFIT) else { break };
            beta = vec![0.0; whole.sizes.len()];
            places.iter().zip(&fitted).for_each(|(i, b)| beta[*i] = *b);
            let expand = |fold| {
                let problem = whole.only(fold);
                Some((problem.errors(), problem.expansion(&beta)?))
            };
            let Some(linearised) = folds.iter().map(|fold| expand(fold)).collect::<Option<Vec<_>>>() else {
                break;
            };
            let held = whole.at_bound(&beta);
            for _ in 0..BEFORE {
                let Some(size) = addition(&linearised, &places, &beta, &held, ridge) else { return sizes };
                places = size.places.clone();
                if size.total() < best.0 * (1.0 - NONE) {
                    best = (size.total(), sizes.len() + 1);
                }
                sizes.push(size);
            }
        }
        sizes
    }
}

/// `places` with the term of the least loss on left-out folds; parameters `held` at a bound stay there.
fn addition(
    folds: &[(f64, Expansion)],
    places: &[usize],
    beta: &[f64],
    held: &[bool],
    ridge: f64,
) -> Option<Size> {
    let p = beta.len();
    let moving: Vec<usize> = places.iter().copied().filter(|i| !held[*i]).collect();
    let mut candidates: Vec<Size> = (0..p)
        .filter(|i| !places.contains(i))
        .map(|added| Size { places: Vec::new(), added, losses: Vec::with_capacity(folds.len()) })
        .collect();
    for (fold, linearised_fold) in folds.iter().enumerate() {
        let others = Others::new(folds, fold, &moving, beta, ridge)?;
        for size in &mut candidates {
            size.losses.push(others.loss(linearised_fold, &moving, size.added));
        }
    }
    let mut best = candidates.into_iter().min_by(|a, b| a.total().total_cmp(&b.total()))?;
    best.places = [places, &[best.added]].concat();
    best.places.sort_unstable();
    Some(best)
}

/// All folds but one: their curvature H with the ridge, and the solution with the present terms.
struct Others {
    p: usize,
    curvature: Vec<f64>,
    descent: Vec<f64>,
    inverse: Vec<f64>,
    step: Vec<f64>,
}

impl Others {
    fn new(
        folds: &[(f64, Expansion)],
        fold: usize,
        places: &[usize],
        beta: &[f64],
        ridge: f64,
    ) -> Option<Self> {
        let (p, m) = (beta.len(), places.len());
        let (mut curvature, mut descent) = (vec![0.0; p * p], vec![0.0; p]);
        for (_, (errors, loss)) in folds.iter().enumerate().filter(|(i, _)| *i != fold) {
            curvature.iter_mut().zip(&loss.normal).for_each(|(sum, entry)| *sum += errors * entry);
            descent.iter_mut().zip(&loss.gradient).for_each(|(sum, entry)| *sum += errors * entry);
            (0..p).for_each(|i| curvature[i * p + i] += errors * ridge);
            descent.iter_mut().zip(beta).for_each(|(sum, beta)| *sum -= errors * ridge * beta);
        }
        let mut matrix: Vec<f64> = (0..m * m).map(|k| curvature[places[k / m] * p + places[k % m]]).collect();
        let mut inverse = vec![0.0; m * m];
        numerics::inverse(m, &mut matrix, &mut inverse)?;
        let right: Vec<f64> = places.iter().map(|i| descent[*i]).collect();
        let step = times(&inverse, &right);
        Some(Self { p, curvature, descent, inverse, step })
    }

    /// Loss of a fold, of so many `errors`, with the terms at `places` and `added`, by the bordered inverse.
    fn loss(&self, (errors, fold_loss): &(f64, Expansion), places: &[usize], added: usize) -> f64 {
        let p = self.p;
        let border: Vec<f64> = places.iter().map(|i| self.curvature[i * p + added]).collect();
        let moved = times(&self.inverse, &border);
        let schur = self.curvature[added * p + added] - dot(&border, &moved);
        let step = (self.descent[added] - dot(&border, &self.step)) / schur;
        let step = if step.is_finite() { step } else { 0.0 };
        let Expansion { cost, normal: curvature, gradient: descent, .. } = fold_loss;
        let mut loss = cost + step * (curvature[added * p + added] * step - 2.0 * descent[added]);
        let change: Vec<f64> = self.step.iter().zip(&moved).map(|(a, b)| a - b * step).collect();
        for (i, change_i) in places.iter().zip(&change) {
            let row = &curvature[i * p..(i + 1) * p];
            let along: f64 = places.iter().zip(&change).map(|(j, change)| row[*j] * change).sum();
            loss += change_i * (along + 2.0 * row[added] * step - 2.0 * descent[*i]);
        }
        errors * loss
    }
}

fn subset(library: &Model, places: &[usize]) -> Model {
    selected(library, |_, _, parameter| places.contains(&parameter))
}

/// `library` without those terms beyond `base` that are 0 in every sample.
pub(crate) fn without_zeros(base: &Model, library: &Model, recordings: &[Recording]) -> Model {
    let mut compiled = Compiled::new(library, &vec![0.0; library.parameters()]);
    let mut used = vec![false; library.parameters()];
    each(recordings, library.exogenous(), |_, state, exogenous, _| {
        compiled.look(state, exogenous, None);
        used.iter_mut().enumerate().for_each(|(i, used)| *used |= compiled.term(i) != 0.0);
    });
    selected(library, |d, i, parameter| i < base.degrees[d].terms.len() || used[parameter])
}

/// `library` with the terms that are `kept`, by degree of freedom, place in it, and index of the parameter.
fn selected(library: &Model, kept: impl Fn(usize, usize, usize) -> bool) -> Model {
    let (mut model, layout) = (library.clone(), library.layout());
    for (d, degree) in model.degrees.iter_mut().enumerate() {
        let first = layout.degree(d).start;
        let places: Vec<usize> = (0..degree.terms.len()).filter(|i| kept(d, *i, first + i)).collect();
        degree.terms = places.iter().map(|i| degree.terms[*i].clone()).collect();
        degree.parameters = places.iter().map(|i| degree.parameters[*i].clone()).collect();
    }
    model
}

/// Calls `look` with the index of the recording, the state, the inputs and the state's increment of every sample.
fn each(recordings: &[Recording], width: usize, mut look: impl FnMut(usize, [f64; 3], &[f64], [f64; 3])) {
    for (i, recording) in recordings.iter().enumerate() {
        for part in &recording.whole {
            let states = part.measured.as_chunks::<3>().0;
            let inputs = part.exogenous.chunks_exact(width.max(1));
            for ((now, next), inputs) in states.iter().zip(&states[1..]).zip(inputs) {
                look(i, *now, inputs, [0, 1, 2].map(|d: usize| next[d] - now[d]));
            }
        }
    }
}

/// A term is a combination of those before it, up to rounding, if the rest of its square is below this share.
const COMBINED: f64 = 1e-10;

/// Parameters whose terms are combinations of earlier ones of their degree of freedom in every sample.
pub(crate) fn combined(model: &Model, recordings: &[Recording]) -> Vec<String> {
    let mut compiled = Compiled::new(model, &vec![0.0; model.parameters()]);
    let layout = model.layout();
    let mut squares: Vec<Vec<f64>> = (0..3).map(|d| vec![0.0; layout.terms(d).len().pow(2)]).collect();
    each(recordings, model.exogenous(), |_, state, exogenous, _| {
        compiled.look(state, exogenous, None);
        for (d, sums) in squares.iter_mut().enumerate() {
            let terms: Vec<f64> = layout.terms(d).map(|i| compiled.term(i)).collect();
            add_outer(sums, &terms, &terms);
        }
    });
    let names = (0..3).flat_map(|d| {
        dependent_columns(layout.terms(d).len(), &squares[d], COMBINED)
            .into_iter()
            .map(move |i| model.degrees[d].parameters[i].clone())
    });
    names.collect()
}

pub(crate) fn without_intercepts(lifted: &Model) -> Model {
    let mut model = lifted.clone();
    for degree in model.degrees.iter_mut().filter(|degree| degree.intercept) {
        degree.terms.pop();
        degree.parameters.pop();
        degree.intercept = false;
    }
    model
}

/// The model of `fitted`, whose structure without intercepts is `structure`.
pub(crate) fn delivered(bare: &Model, fit: &Fitted, recordings: &[Recording], parts: &[Part]) -> Delivered {
    let Fitted { model: lifted, theta: parameters } = fit;
    let layout = lifted.layout();
    let (theta, intercepts) = (layout.theta(parameters), layout.intercepts(parameters));
    let (increment_std, constants) = gained(bare, recordings, &theta);
    let all: Vec<&Recording> = recordings.iter().collect();
    let followed = scores(lifted, parameters, &all, Laid::SideBySide, limit(&all));
    Delivered {
        theta,
        constant: [0, 1, 2].map(|d| bare.constant[d] + intercepts[d]),
        // After a ridge or a selection of terms no standard errors are valid.
        covariance: None,
        least_squares: None,
        increment_std,
        output_rmse: together(followed.iter()).rmse(),
        recordings: constants,
        surroundings: Vec::new(),
        covered: covered(bare, parts),
    }
}

/// The residuals of the increments: their standard deviations over all recordings, and their means per recording.
fn gained(structure: &Model, recordings: &[Recording], theta: &[f64]) -> ([f64; 3], Vec<RecordingConstant>) {
    let model = Model { constant: [0.0; 3], ..structure.clone() };
    let mut compiled = Compiled::new(&model, theta);
    let (mut sums, mut squares) = (vec![([0.0; 3], 0.0_f64); recordings.len()], [0.0; 3]);
    each(recordings, model.exogenous(), |i, state, exogenous, increment| {
        compiled.look(state, exogenous, None);
        let modelled = compiled.increments();
        sums[i].1 += 1.0;
        for d in 0..3 {
            let left = increment[d] - modelled[d];
            sums[i].0[d] += left;
            squares[d] += left * left;
        }
    });
    let n = sums.iter().map(|(_, n)| n).sum::<f64>().max(1.0);
    let std = |d: usize| {
        let mean = sums.iter().map(|(sum, _)| sum[d]).sum::<f64>() / n;
        (squares[d] / n - mean * mean).max(0.0).sqrt()
    };
    let constant = |(recording, (sum, n)): (&Recording, &([f64; 3], f64))| {
        let [constant_u, constant_v, constant_r] = sum.map(|sum| sum / n.max(1.0));
        let (source, samples) = (recording.name.clone(), *n as u64);
        RecordingConstant { source, samples, constant_u, constant_v, constant_r }
    };
    ([0, 1, 2].map(std), recordings.iter().zip(&sums).map(constant).collect())
}
