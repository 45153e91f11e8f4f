use crate::pooled::{Delivered, RecordingConstant, covered};
use numerics::{add_outer, dependent_columns};
use regression::pooled::Part;
use ship::engine::Compiled;
use ship::model::Model;

use crate::search::nested::Fitted;
use crate::search::problem::limit;
use crate::search::recording::{Laid, Recording};
use crate::search::scores::{scores, together};

/// `library` without those terms beyond `base` that are 0 in every sample.
pub(crate) fn without_zeros(base: &Model, library: &Model, recordings: &[Recording]) -> Model {
    let mut compiled = Compiled::new(library, &vec![0.0; library.parameters()]);
    let mut used = vec![false; library.parameters()];
    each(recordings, library.exogenous(), |_, state, exogenous, _| {
        compiled.look(state, exogenous, None);
        used.iter_mut().enumerate().for_each(|(i, used)| *used |= compiled.term(i) != 0.0);
    });
    let mut model = library.clone();
    let layout = library.layout();
    for (d, degree) in model.degrees.iter_mut().enumerate() {
        let first = layout.degree(d).start;
        let kept = |i: usize| i < base.degrees[d].terms.len() || used[first + i];
        degree.terms = keep(&degree.terms, kept);
        degree.parameters = keep(&degree.parameters, kept);
    }
    model
}

fn keep<T: Clone>(all: &[T], kept: impl Fn(usize) -> bool) -> Vec<T> {
    all.iter().enumerate().filter(|(i, _)| kept(*i)).map(|(_, own)| own.clone()).collect()
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

/// Names of the parameters of `model` whose terms are combinations of earlier terms of their degree of freedom in
/// every sample, so that no recording can distinguish them.
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
    let found = (0..3).flat_map(|d| {
        dependent_columns(layout.terms(d).len(), &squares[d], COMBINED)
            .into_iter()
            .map(move |i| model.degrees[d].parameters[i].clone())
    });
    found.collect()
}

/// `lifted` without its intercepts.
pub(crate) fn without_intercepts(lifted: &Model) -> Model {
    let mut model = lifted.clone();
    for degree in model.degrees.iter_mut().filter(|degree| degree.intercept) {
        degree.terms.pop();
        degree.parameters.pop();
        degree.intercept = false;
    }
    model
}

/// The model `found`, whose structure without intercepts is `structure`.
pub(crate) fn delivered(
    structure: &Model,
    found: &Fitted,
    recordings: &[Recording],
    parts: &[Part],
) -> Delivered {
    let Fitted { model: lifted, theta: parameters } = found;
    let layout = lifted.layout();
    let (theta, intercepts) = (layout.theta(parameters), layout.intercepts(parameters));
    let (increment_std, constants) = gained(structure, recordings, &theta);
    let all: Vec<&Recording> = recordings.iter().collect();
    let followed = scores(lifted, parameters, &all, Laid::SideBySide, limit(&all));
    Delivered {
        theta,
        constant: [0, 1, 2].map(|d| structure.constant[d] + intercepts[d]),
        // After a ridge or a selection of terms no standard errors are valid.
        covariance: None,
        least_squares: None,
        increment_std,
        output_rmse: together(followed.iter()).rmse(),
        recordings: constants,
        surroundings: Vec::new(),
        covered: covered(structure, parts),
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
