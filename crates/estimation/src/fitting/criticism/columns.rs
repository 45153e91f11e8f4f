//! Derivatives of errors by candidates, along the windows as they were fitted.

use numerics::{Lane, vectorized};
use ship::forces::{Body, Channel, Dual, Forces, TermSpec};

use super::products::Product;
use crate::fitting::Unfit;
use crate::fitting::pass::Pass;
use crate::fitting::sums::{AT_ONCE, Derivatives, Sums, counted, follow_acting, only, start};
use crate::fitting::window::Group;

/// Up to [`AT_ONCE`] candidates whose derivatives are computed at once.
pub(crate) enum Block {
    /// The ship with further terms, what each of her parameters is, and the number of the terms.
    Terms(Box<Forces>, Vec<Of>, usize),
    /// Inputs that act later, by their places in a row.
    Late(Vec<usize>),
}

/// What a parameter of a ship with further terms is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Of {
    /// A fitted number.
    Fitted(usize),
    /// A candidate, by its place in the block.
    Candidate(usize),
}

/// Sums of a window over the derivatives by a candidate, once the window's start is chosen best.
#[derive(Clone, Debug, PartialEq)]
pub(crate) struct Column {
    /// Products with the derivatives by θ.
    pub across: Vec<f64>,
    /// Its own square.
    pub square: f64,
    /// Jᵀe of each piece.
    pub scores: Vec<f64>,
}

/// The unit of a candidate's number in SI, and what one of the prime system is, where it has one.
pub(crate) type Measure = (String, Option<f64>);

impl Block {
    /// The ship `forces` with `products` as further terms of 0, and what each number is measured in.
    ///
    /// # Errors
    /// A product with a channel whose name no term can have.
    pub fn terms(
        forces: &Forces,
        products: &[Product],
        channels: &[Channel],
    ) -> Result<(Self, Vec<Measure>), Unfit> {
        let mut description = forces.description().clone();
        let name = |i: usize| format!("candidate {i}");
        for (i, product) in products.iter().enumerate() {
            let spec = TermSpec {
                parameter: name(i),
                term: product.text.clone(),
                nominal: Some(0.0),
                ..TermSpec::default()
            };
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
            let own = more.parameters().iter().find(|own| own.name == names[i]);
            let prime = own.and_then(|own| own.prime).filter(|_| products[i].scaled);
            (own.map_or(String::new(), |own| own.si_unit.clone()), prime)
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
    ///
    /// # Errors
    /// A window whose start is not determined.
    pub(crate) fn columns(
        &self,
        group: &Group,
        (theta, starts): (&[f64], &[[f64; 3]]),
        blocks: &[Block],
    ) -> Result<(Vec<Sums>, Vec<Vec<Column>>), Unfit> {
        let known = self.derivatives(group, theta, starts);
        let sums = self.sums_of(group, &known);
        let mut found: Vec<Vec<Column>> = sums.iter().map(|_| Vec::new()).collect();
        for block in blocks {
            let slopes = self.by_candidates(group, (theta, starts), block);
            let all = self.products(&known, &slopes, block.count());
            for (lane, (window, own)) in found.iter_mut().zip(&sums).enumerate() {
                let columns = all.columns(lane, theta.len(), own);
                window.extend(columns.ok_or_else(|| self.without_start(&group.windows[lane]))?);
            }
        }
        Ok((sums, found))
    }

    /// Derivatives of the errors by the candidates of `block`: [`AT_ONCE`] for each error.
    fn by_candidates(
        &self,
        group: &Group,
        (theta, starts): (&[f64], &[[f64; 3]]),
        block: &Block,
    ) -> Vec<[Lane; AT_ONCE]> {
        let begin = start(starts).map(Dual::constant);
        let mut slopes = vec![[Lane::ZERO; AT_ONCE]; 3 * (group.samples + 1)];
        let fitted: Vec<Lane> = theta.iter().map(|own| Lane::splat(*own)).collect();
        let acting = self.acting(group, &fitted);
        match block {
            Block::Terms(more, places, _) => {
                let own = |place: &Of| match *place {
                    Of::Fitted(i) => Dual::constant(fitted[i]),
                    Of::Candidate(i) => Dual::unknown(Lane::ZERO, i),
                };
                let numbers: Vec<Dual<Lane, AT_ONCE>> = places.iter().map(own).collect();
                let body = more.body(&numbers);
                let input = |at: usize| Dual::constant(acting[at]);
                vectorized!(simulated(self, group, &body, begin, input, &mut slopes));
            }
            Block::Late(inputs) => {
                let numbers: Vec<Dual<Lane, AT_ONCE>> =
                    fitted.iter().map(|own| Dual::constant(*own)).collect();
                let body = self.forces.body(&numbers);
                let changes = self.changes(group, &acting, inputs);
                let input = |at: usize| {
                    let mut own = Dual::constant(acting[at]);
                    if let Some(i) = inputs.iter().position(|input| *input == at % self.width) {
                        own.tangents[i] = changes[i][at / self.width];
                    }
                    own
                };
                vectorized!(simulated(self, group, &body, begin, input, &mut slopes));
            }
        }
        slopes
    }

    /// What acts in every row of inputs.
    fn acting(&self, group: &Group, theta: &[Lane]) -> Vec<Lane> {
        if self.late {
            let body = self.forces.body(theta);
            return body.acting(&group.inputs, self.width, self.settings.sample_s);
        }
        group.inputs.clone()
    }

    /// By how much each of `inputs` changes for each second that it acts later, row by row: central differences.
    fn changes(&self, group: &Group, acting: &[Lane], inputs: &[usize]) -> Vec<Vec<Lane>> {
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
    fn products(&self, known: &Derivatives, slopes: &[[Lane; AT_ONCE]], count: usize) -> Products {
        let unknowns = self.unknowns();
        let piece = 3 * self.settings.samples(self.settings.piece_s);
        let mut own = Products {
            unknowns,
            across: vec![Lane::ZERO; count * unknowns],
            squares: vec![Lane::ZERO; count],
            gradients: vec![vec![Lane::ZERO; count]; slopes.len() / piece + 1],
        };
        vectorized!(own.add(known, slopes, piece));
        own
    }
}

/// Sums over the windows of a group, side by side.
struct Products {
    unknowns: usize,
    /// Candidates × unknowns.
    across: Vec<Lane>,
    squares: Vec<Lane>,
    /// Jᵀe of each piece.
    gradients: Vec<Vec<Lane>>,
}

impl Products {
    #[inline(always)]
    fn add(&mut self, known: &Derivatives, slopes: &[[Lane; AT_ONCE]], piece: usize) {
        let rows = known.slopes.chunks_exact(self.unknowns).zip(&known.left).zip(slopes);
        for (k, ((row, error), own)) in rows.enumerate() {
            let gradient = &mut self.gradients[k / piece];
            for (i, own) in own.iter().enumerate().take(self.squares.len()) {
                gradient[i] += *own * *error;
                self.squares[i] += *own * *own;
                let sums = &mut self.across[i * self.unknowns..][..self.unknowns];
                for (sum, known) in sums.iter_mut().zip(row) {
                    *sum += *own * *known;
                }
            }
        }
    }

    /// The columns of the window in `lane`, whose sums of `n` of θ and its start are `window`; `None` where the start is not
    /// determined.
    fn columns(&self, lane: usize, n: usize, window: &Sums) -> Option<Vec<Column>> {
        let (starts, count) = (self.unknowns - n, self.squares.len());
        let known = |i: usize, j: usize| window.products[i * self.unknowns + j];
        let across = |i: usize, j: usize| self.across[i * self.unknowns + j][lane];
        // How the start would follow each candidate.
        let sides: Vec<f64> = (0..starts * count).map(|k| across(k % count, n + k / count)).collect();
        let follows = if starts > 0 { window.solved_by_start(n, 0.0, &sides)? } else { sides };
        let one = |i: usize| {
            let follows: Vec<f64> = (0..starts).map(|d| follows[d * count + i]).collect();
            let begins: Vec<f64> = (0..starts).map(|d| across(i, n + d)).collect();
            let own = self.squares[i][lane] - numerics::dot(&follows, &begins);
            let score = |piece: &Vec<f64>, gradient: &Vec<Lane>| {
                gradient[i][lane] - numerics::dot(&follows, &piece[n..])
            };
            let scores =
                window.pieces.iter().zip(&self.gradients).map(|(piece, own)| score(piece, own)).collect();
            let left =
                |j: usize| across(i, j) - (0..starts).map(|d| follows[d] * known(j, n + d)).sum::<f64>();
            Column { across: (0..n).map(left).collect(), square: own.max(0.0), scores }
        };
        Some((0..count).map(one).collect())
    }
}

/// Derivatives of the errors by the candidates.
#[inline(always)]
fn simulated(
    pass: &Pass,
    group: &Group,
    body: &Body<Dual<Lane, AT_ONCE>>,
    start: [Dual<Lane, AT_ONCE>; 3],
    input: impl Fn(usize) -> Dual<Lane, AT_ONCE>,
    slopes: &mut [[Lane; AT_ONCE]],
) {
    follow_acting(pass, group, body, start, input, |k, state| {
        let (counted, scales) = (counted(group, k), pass.scales(k));
        for (d, own) in state.into_iter().enumerate() {
            let scale = Lane::splat(scales[d]);
            slopes[3 * k + d] = own.tangents.map(|own| only(own * scale, counted));
        }
    });
}
