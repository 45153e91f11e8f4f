//! Derivatives of errors by candidates, along the windows as they were fitted.

use numerics::{Lane, vectorized};
use ship::forces::{Body, Channel, Dual, Factor, Forces, MOTION, TermSpec};

use crate::fitting::sums::{AT_ONCE, Derivatives, WindowSums, counted, follow_acting, only, start};
use crate::fitting::{Pass, Unfit, WindowGroup};

/// Up to [`AT_ONCE`] candidates whose derivatives are computed at once.
pub(crate) enum CandidateBlock {
    /// The ship with further terms, what each of her parameters is, and the number of the terms.
    Terms(Box<Forces>, Vec<Of>, usize),
    /// Inputs that act later, by their places in a row.
    Late(Vec<usize>),
}

/// What a parameter of a ship with further terms is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Of {
    Fitted(usize),
    Candidate(usize),
}

/// Sums of a window over the derivatives by a candidate, once the window's start is chosen best.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// Products with the derivatives by θ.
    pub across: Vec<f64>,
    pub square: f64,
    pub scores: Vec<f64>,
}

/// The unit of a candidate's number in SI, and what one of the prime system is, where it has one.
pub(crate) type Measure = (String, Option<f64>);

impl CandidateBlock {
    /// The ship `forces` with `products` as further terms of 0, and what each number is measured in.
    ///
    /// # Errors
    /// A product with a channel whose name no term can have.
    pub fn terms(
        forces: &Forces,
        products: &[ForceProduct],
        channels: &[Channel],
    ) -> Result<(Self, Vec<Measure>), Unfit> {
        let mut description = forces.description().clone();
        let name = |i: usize| format!("candidate {i}");
        for (i, product) in products.iter().enumerate() {
            let (parameter, term) = (name(i), product.text.clone());
            let spec = TermSpec { parameter, term, nominal: Some(0.0), ..TermSpec::default() };
            description.terms_mut()[product.degree].push(spec);
        }
        let more = Forces::new(&description, channels).map_err(|e| Unfit::Candidate(e.to_string()))?;
        let names: Vec<String> = (0..products.len()).map(name).collect();
        let of =
            |parameter: &ship::forces::Parameter| match names.iter().position(|name| *name == parameter.name)
            {
                Some(i) => Of::Candidate(i),
                None => Of::Fitted(
                    forces.parameters().iter().position(|old| old.name == parameter.name).unwrap_or(0),
                ),
            };
        let places: Vec<Of> = more.parameters().iter().map(of).collect();
        let measure = |i: usize| {
            let parameter = more.parameters().iter().find(|other| other.name == names[i]);
            let prime = parameter.and_then(|number| number.prime).filter(|_| products[i].scaled);
            (parameter.map_or(String::new(), |parameter| parameter.si_unit.clone()), prime)
        };
        let measures = (0..products.len()).map(measure).collect();
        Ok((Self::Terms(Box::new(more), places, products.len()), measures))
    }

    /// Number of candidates.
    pub fn count(&self) -> usize {
        match self {
            Self::Terms(_, _, count) => *count,
            Self::Late(inputs) => inputs.len(),
        }
    }
}

impl Pass<'_> {
    /// For each window of `group` the columns of all candidates, in order, with the sums of θ.
    pub(crate) fn columns(
        &self,
        group: &WindowGroup,
        (theta, starts): (&[f64], &[[f64; 3]]),
        blocks: &[CandidateBlock],
    ) -> Result<(Vec<WindowSums>, Vec<Vec<Column>>), Unfit> {
        let known = self.derivatives(group, theta, starts);
        let sums = self.sums_of(group, &known);
        let mut columns_by_window: Vec<Vec<Column>> = sums.iter().map(|_| Vec::new()).collect();
        for block in blocks {
            let slopes = self.by_candidates(group, (theta, starts), block);
            let all = self.products(&known, &slopes, block.count());
            for (lane, (window, window_sums)) in columns_by_window.iter_mut().zip(&sums).enumerate() {
                let columns = all.columns(lane, theta.len(), window_sums);
                window.extend(columns.ok_or_else(|| self.without_start(&group.windows[lane]))?);
            }
        }
        Ok((sums, columns_by_window))
    }

    /// Derivatives of the errors by the candidates of `block`: [`AT_ONCE`] for each error.
    fn by_candidates(
        &self,
        group: &WindowGroup,
        (theta, starts): (&[f64], &[[f64; 3]]),
        block: &CandidateBlock,
    ) -> Vec<[Lane; AT_ONCE]> {
        let begin = start(starts).map(Dual::constant);
        let mut slopes = vec![[Lane::ZERO; AT_ONCE]; 3 * (group.samples + 1)];
        let fitted: Vec<Lane> = theta.iter().map(|value| Lane::splat(*value)).collect();
        let acting = self.acting(group, &fitted);
        match block {
            CandidateBlock::Terms(more, places, _) => {
                let number = |place: &Of| match *place {
                    Of::Fitted(i) => Dual::constant(fitted[i]),
                    Of::Candidate(i) => Dual::unknown(Lane::ZERO, i),
                };
                let numbers: Vec<Dual<Lane, AT_ONCE>> = places.iter().map(number).collect();
                let body = more.body(&numbers);
                let input = |at: usize| Dual::constant(acting[at]);
                vectorized!(simulated(self, group, &body, begin, input, &mut slopes));
            }
            CandidateBlock::Late(inputs) => {
                let numbers: Vec<Dual<Lane, AT_ONCE>> = fitted.iter().map(|x| Dual::constant(*x)).collect();
                let body = self.forces.body(&numbers);
                let changes = self.changes(group, &acting, inputs);
                let input = |at: usize| {
                    let mut dual = Dual::constant(acting[at]);
                    if let Some(i) = inputs.iter().position(|input| *input == at % self.width) {
                        dual.tangents[i] = changes[i][at / self.width];
                    }
                    dual
                };
                vectorized!(simulated(self, group, &body, begin, input, &mut slopes));
            }
        }
        slopes
    }

    fn acting(&self, group: &WindowGroup, theta: &[Lane]) -> Vec<Lane> {
        if self.late {
            let body = self.forces.body(theta);
            return body.acting(&group.inputs, self.width, self.settings.sample_s);
        }
        group.inputs.clone()
    }

    /// By how much each of `inputs` changes for each second that it acts later, row by row: central differences.
    fn changes(&self, group: &WindowGroup, acting: &[Lane], inputs: &[usize]) -> Vec<Vec<Lane>> {
        let rows = group.before + group.samples + 1;
        let change = |input: usize, k: usize| {
            let [low, high] = [k.saturating_sub(1), (k + 1).min(rows - 1)];
            let seconds = (high - low).max(1) as f64 * self.settings.sample_s;
            (acting[low * self.width + input] - acting[high * self.width + input])
                * Lane::splat(1.0 / seconds)
        };
        inputs.iter().map(|input| (0..rows).map(|k| change(*input, k)).collect()).collect()
    }

    /// Sums of the candidates' derivatives `slopes`, with those that are `known` and with the errors.
    fn products(&self, known: &Derivatives, slopes: &[[Lane; AT_ONCE]], count: usize) -> ColumnSums {
        let unknowns = self.unknowns();
        let piece = 3 * self.settings.samples(self.settings.piece_s);
        let mut sums = ColumnSums {
            unknowns,
            across: vec![Lane::ZERO; count * unknowns],
            squares: vec![Lane::ZERO; count],
            gradients: vec![vec![Lane::ZERO; count]; slopes.len() / piece + 1],
        };
        vectorized!(sums.add(known, slopes, piece));
        sums
    }
}

struct ColumnSums {
    unknowns: usize,
    across: Vec<Lane>,
    squares: Vec<Lane>,
    gradients: Vec<Vec<Lane>>,
}

impl ColumnSums {
    #[inline(always)]
    fn add(&mut self, known: &Derivatives, slopes: &[[Lane; AT_ONCE]], piece: usize) {
        let rows = known.slopes.chunks_exact(self.unknowns).zip(&known.left).zip(slopes);
        for (k, ((row, error), tangents)) in rows.enumerate() {
            let gradient = &mut self.gradients[k / piece];
            for (i, tangent) in tangents.iter().enumerate().take(self.squares.len()) {
                gradient[i] += *tangent * *error;
                self.squares[i] += *tangent * *tangent;
                let sums = &mut self.across[i * self.unknowns..][..self.unknowns];
                for (sum, known) in sums.iter_mut().zip(row) {
                    *sum += *tangent * *known;
                }
            }
        }
    }

    /// The columns of the window in `lane`, whose sums are `window`; `None` where its start is not determined.
    fn columns(&self, lane: usize, n: usize, window: &WindowSums) -> Option<Vec<Column>> {
        let (starts, count) = (self.unknowns - n, self.squares.len());
        let known = |i: usize, j: usize| window.products[i * self.unknowns + j];
        let across = |i: usize, j: usize| self.across[i * self.unknowns + j][lane];
        // How the start would follow each candidate.
        let sides: Vec<f64> = (0..starts * count).map(|k| across(k % count, n + k / count)).collect();
        let follows = if starts > 0 { window.solved_by_start(n, 0.0, &sides)? } else { sides };
        let one = |i: usize| {
            let follows: Vec<f64> = (0..starts).map(|d| follows[d * count + i]).collect();
            let begins: Vec<f64> = (0..starts).map(|d| across(i, n + d)).collect();
            let square = self.squares[i][lane] - numerics::dot(&follows, &begins);
            let score = |piece: &Vec<f64>, gradient: &Vec<Lane>| {
                gradient[i][lane] - numerics::dot(&follows, &piece[n..])
            };
            let scores = window
                .pieces
                .iter()
                .zip(&self.gradients)
                .map(|(piece, gradient)| score(piece, gradient))
                .collect();
            let left =
                |j: usize| across(i, j) - (0..starts).map(|d| follows[d] * known(j, n + d)).sum::<f64>();
            Column { across: (0..n).map(left).collect(), square: square.max(0.0), scores }
        };
        Some((0..count).map(one).collect())
    }
}

#[inline(always)]
fn simulated(
    pass: &Pass,
    group: &WindowGroup,
    body: &Body<Dual<Lane, AT_ONCE>>,
    start: [Dual<Lane, AT_ONCE>; 3],
    input: impl Fn(usize) -> Dual<Lane, AT_ONCE>,
    slopes: &mut [[Lane; AT_ONCE]],
) {
    follow_acting(pass, group, body, start, input, |k, state| {
        let (counted, scales) = (counted(group, k), pass.scales(k));
        for (d, derivative) in state.into_iter().enumerate() {
            let scale = Lane::splat(scales[d]);
            slopes[3 * k + d] = derivative.tangents.map(|tangent| only(tangent * scale, counted));
        }
    });
}

/// A factor: its place among the motion and the channels, and whether it is the modulus.
type Plain = (usize, bool);

#[derive(Clone, Debug, PartialEq)]
pub(crate) struct ForceProduct {
    /// 0 surge, 1 sway, 2 yaw.
    pub degree: usize,
    pub text: String,
    /// Whether the prime system scales its number: it has no channels but angles and pure numbers.
    pub scaled: bool,
}

/// Places of u, v, r, U and U_s among the motion.
const STATES: [usize; 3] = [0, 1, 2];
const SPEED: usize = 3;
const SIGNED_SPEED: usize = 4;

/// Products that `forces` lacks, of u, v, r, |u|, |v|, |r| and U in pairs, of u, v, r in threes, of the first `inputs`
/// channels with motion and with each other, and each of the other channels by itself.
pub(crate) fn products(forces: &Forces, channels: &[Channel], inputs: usize) -> Vec<ForceProduct> {
    let all = library(channels, inputs);
    let lacking = |degree: usize| {
        let present = terms(forces, degree);
        let absent = all.iter().filter(move |factors| !present.contains(factors));
        let product = |factors: &Vec<Plain>| ForceProduct {
            degree,
            text: text(factors, channels),
            scaled: factors.iter().all(|(variable, _)| is_scaled(*variable, channels)),
        };
        absent.map(product).collect::<Vec<_>>()
    };
    (0..3).flat_map(lacking).collect()
}

/// Whether the prime system scales a number that multiplies this variable.
fn is_scaled(variable: usize, channels: &[Channel]) -> bool {
    let channel = variable.checked_sub(MOTION.len()).map(|variable| channels[variable].unit.as_str());
    channel.is_none_or(|unit| ["rad", "1", ""].contains(&unit))
}

fn own_terms(forces: &Forces, degree: usize) -> usize {
    forces.description().terms()[degree].len()
}

/// The factors of the terms of an equation, in order; those with a division count as none.
fn terms(forces: &Forces, degree: usize) -> Vec<Vec<Plain>> {
    let count = own_terms(forces, degree);
    let plain = |factors: &[Factor]| {
        let whole = factors.iter().all(|factor| !factor.divides);
        whole.then(|| sorted(factors.iter().map(|factor| (factor.variable, factor.modulus)).collect()))
    };
    (0..count).filter_map(|i| plain(forces.factors(degree, i))).collect()
}

/// Factors in order; two moduli of the same are its square.
fn sorted(mut factors: Vec<Plain>) -> Vec<Plain> {
    factors.sort_unstable();
    for i in 1..factors.len() {
        if factors[i - 1] == factors[i] && factors[i].1 {
            (factors[i - 1].1, factors[i].1) = (false, false);
        }
    }
    factors
}

fn library(channels: &[Channel], inputs: usize) -> Vec<Vec<Plain>> {
    let plain = STATES.map(|state| (state, false));
    let motion: Vec<Plain> =
        plain.into_iter().chain(STATES.map(|s| (s, true))).chain([(SPEED, false)]).collect();
    let mut all: Vec<Vec<Plain>> = vec![Vec::new()];
    all.extend(motion.iter().map(|factor| vec![*factor]));
    all.extend(pairs(&motion));
    all.extend([1, 2].map(|value| vec![(value, false), (SIGNED_SPEED, false)]));
    let squares: Vec<Vec<Plain>> = pairs(&plain);
    let cubes = squares.iter().flat_map(|square| plain.map(|plain| [square.as_slice(), &[plain]].concat()));
    all.extend(cubes);
    // A term can have no other names.
    let named =
        |place: &usize| channels[place - MOTION.len()].name.chars().all(|c| c.is_alphanumeric() || c == '_');
    let places = (MOTION.len()..MOTION.len() + inputs.min(channels.len())).filter(named);
    let signed = |place: &usize| {
        channels[place - MOTION.len()].range.is_none_or(|[low, high]| low < 0.0 && high > 0.0)
    };
    let driven: Vec<Plain> = places
        .flat_map(|variable| [Some((variable, false)), signed(&variable).then_some((variable, true))])
        .flatten()
        .collect();
    for factor in &driven {
        all.push(vec![*factor]);
        let beside = plain.into_iter().chain([(SPEED, false)]);
        all.extend(beside.map(|other| vec![other, *factor]));
        if !factor.1 {
            all.extend(squares.iter().map(|square| [square.as_slice(), &[*factor]].concat()));
            all.extend(plain.map(|other| vec![other, *factor, *factor]));
        }
    }
    all.extend(pairs(&driven));
    let others = (MOTION.len() + inputs..MOTION.len() + channels.len()).filter(named);
    all.extend(others.map(|variable| vec![(variable, false)]));
    let mut unique: Vec<Vec<Plain>> = Vec::new();
    for factors in all.into_iter().map(sorted) {
        if !unique.contains(&factors) {
            unique.push(factors);
        }
    }
    unique
}

fn pairs(of: &[Plain]) -> Vec<Vec<Plain>> {
    let with = |i: usize| of[i..].iter().map(move |other| vec![of[i], *other]);
    (0..of.len()).flat_map(with).collect()
}

/// As a term is written: `v^2 |r|`, 1 without a factor.
fn text(factors: &[Plain], channels: &[Channel]) -> String {
    if factors.is_empty() {
        return "1".to_owned();
    }
    let mut parts: Vec<(Plain, usize)> = Vec::new();
    for factor in factors {
        match parts.iter_mut().find(|(known, _)| known == factor) {
            Some((_, power)) => *power += 1,
            None => parts.push((*factor, 1)),
        }
    }
    let part = |((variable, modulus), power): ((usize, bool), usize)| {
        let channel = |place: usize| channels[place - MOTION.len()].name.clone();
        let name = MOTION.get(variable).map_or_else(|| channel(variable), |known| (*known).to_owned());
        let name = if modulus { format!("|{name}|") } else { name };
        if power > 1 { format!("{name}^{power}") } else { name }
    };
    parts.into_iter().map(part).collect::<Vec<_>>().join(" ")
}
