//! Products of centred instruments with each other and with their neighbours.

use vessel::{Lane, Number};

use super::kept::{Kept, Zeta};
use super::regressors::{ALL, SPAN};
use crate::Batch;
use crate::batch::{BLOCK, parts};
use crate::groups::{Constants, Groups};

/// Samples that are centred and multiplied before the next ones are, so that they stay in the nearest cache beside a span.
const PART: usize = 2 * BLOCK;
/// A centred instrument at the sample before a part of a span and at those of the part.
type Centred = [Lane; 1 + PART];

/// Adds to Σ ζᶜζᶜᵀ and to Σ (ζᶜ(k−1) ζᶜ(k)ᵀ + its transpose), upper triangles of all degrees of freedom. `means`: the instruments'
/// means per run and group.
#[inline(always)]
pub(crate) fn add_squares<X: Number>(
    batch: &Batch<X>,
    kept: Option<&Kept<X>>,
    means: Groups,
    [squares, neighbours]: [&mut [Lane]; 2],
) {
    let mut means = Constants::<PART>::new(means, batch.model.parameters());
    let mut zeta = Zeta::new(kept, batch, &(0..batch.samples()), ALL);
    let mut centred = vec![[Lane::ZERO; 1 + PART]; batch.model.parameters()];
    for (k, count) in parts::<SPAN>(0..batch.samples()) {
        let zeta = zeta.at(batch, k, count);
        for part in (0..count).step_by(PART) {
            for (i, (own, mean)) in centred.iter_mut().zip(means.at(k + part)).enumerate() {
                let z = zeta.signal(i);
                own[0] = own[PART];
                for t in 0..PART {
                    own[1 + t] = z[part + t].lane() - mean[t];
                }
                own[1 + PART.min(count - part)..].fill(Lane::ZERO);
            }
            let (mut first, mut place) = (0, 0);
            for p in batch.model.degrees.iter().map(|d| d.terms.len()) {
                for i in first..first + p {
                    let sums = [&mut squares[place..], &mut neighbours[place..]];
                    add_row(&centred[i], &centred[i..first + p], sums);
                    place += first + p - i;
                }
                first += p;
            }
        }
    }
}

/// Adds the products of one with all of `others`.
#[inline(always)]
fn add_row(one: &Centred, mut others: &[Centred], [mut squares, mut neighbours]: [&mut [Lane]; 2]) {
    while let [two, three, rest @ ..] = others
        && rest.len() != 1
    {
        add_products(one, [two, three], [squares, neighbours]);
        (others, squares, neighbours) = (rest, &mut squares[2..], &mut neighbours[2..]);
    }
    match others {
        [two, three, four] => add_products(one, [two, three, four], [squares, neighbours]),
        [two] => add_products(one, [two], [squares, neighbours]),
        _ => {}
    }
}

/// Adds the products of one with some others, those at the same sample and those with neighbours.
#[allow(clippy::needless_range_loop)] // What iterators make of arrays is not always inlined, and then has no vectors.
#[inline(always)]
fn add_products<const C: usize>(
    one: &Centred,
    others: [&Centred; C],
    [squares, neighbours]: [&mut [Lane]; 2],
) {
    let mut whole = [[Lane::ZERO; C]; 2];
    whole[0].copy_from_slice(&squares[..C]);
    whole[1].copy_from_slice(&neighbours[..C]);
    for block in (0..PART).step_by(BLOCK) {
        let (mut now, mut after, mut before) = ([Lane::ZERO; C], [Lane::ZERO; C], [Lane::ZERO; C]);
        for t in block..block + BLOCK {
            for i in 0..C {
                now[i] = one[t + 1].fused(others[i][t + 1], now[i]);
                after[i] = one[t].fused(others[i][t + 1], after[i]);
                before[i] = one[t + 1].fused(others[i][t], before[i]);
            }
        }
        for i in 0..C {
            whole[0][i] += now[i];
            whole[1][i] += after[i];
            whole[1][i] += before[i];
        }
    }
    squares[..C].copy_from_slice(&whole[0]);
    neighbours[..C].copy_from_slice(&whole[1]);
}
