//! Shares over candidates that are read in blocks.

use design::{Blocks, Candidates, Error, Options, Status, solve, solve_streamed};
use rand::{Rng, SeedableRng};
use rand_chacha::ChaCha8Rng;

/// Candidates cut into blocks of a size.
struct Cut {
    candidates: Candidates,
    size: usize,
}

impl Blocks for Cut {
    type Error = Error;

    fn blocks(&self) -> usize {
        self.candidates.len().div_ceil(self.size)
    }

    fn block(&self, i: usize) -> Result<Candidates, Error> {
        let mut block = Candidates::new(vec![3, 2]);
        for q in i * self.size..self.candidates.len().min((i + 1) * self.size) {
            block.push(self.candidates.candidate(q))?;
        }
        Ok(block)
    }
}

/// φφᵀ of a regressor per block, entries of different sizes; not symmetric if `tilted`.
fn candidates(count: usize, tilted: bool) -> Candidates {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut uniform = || (rng.next_u64() >> 11) as f64 * 2.0_f64.powi(-52) - 1.0;
    let mut all = Candidates::new(vec![3, 2]);
    for _ in 0..count {
        let mut entries = Vec::new();
        for n in [3, 2] {
            let scales = [1.0, 1e-3, 50.0];
            let phi: Vec<f64> = (0..n).map(|i| scales[i] * uniform()).collect();
            let zeta: Vec<f64> = phi
                .iter()
                .zip(scales)
                .map(|(x, s)| if tilted { x + 0.1 * s * uniform() } else { *x })
                .collect();
            entries.extend((0..n * n).map(|e| phi[e / n] * zeta[e % n]));
        }
        all.push(&entries).unwrap();
    }
    all
}

#[test]
fn law_streamed_shares_are_those_over_all_at_once_however_they_are_cut() {
    for (tilted, status) in [(false, Status::Optimal), (true, Status::Stationary)] {
        let all = candidates(9000, tilted);
        let options = Options { tolerance: 1e-9, ..Options::default() };
        let whole = solve(&all, &options).unwrap();
        for size in [700, 9000] {
            let found = solve_streamed(&Cut { candidates: all.clone(), size }, &options).unwrap();
            let (value, same) = (found.design.log_det, whole.log_det);
            assert!((value - same).abs() < 1e-8, "{size}: {value} and {same}");
            assert!(found.design.gap <= 1e-9 * 5.0, "{}", found.design.gap);
            assert_eq!((found.design.status, found.candidates), (status, 9000));
            assert!(found.members.windows(2).all(|two| two[0] < two[1]), "{:?}", found.members);
            let mut shares = vec![0.0; 9000];
            for ((block, place), share) in found.members.iter().zip(&found.design.shares) {
                shares[block * size + place] = *share;
            }
            let efficiency = whole.efficiency(&all, &shares, 5);
            assert!((efficiency - 1.0).abs() < 1e-8, "{efficiency}");
        }
    }
}

#[test]
fn law_a_direction_that_one_of_many_excites_is_found_and_none_is_told() {
    let mut rest = Candidates::new(vec![3, 2]);
    let all = candidates(5000, false);
    for q in 0..5000 {
        // The last row of the last block is zero except for one candidate.
        let mut entries = all.candidate(q).to_vec();
        if q != 3333 {
            entries[10..13].fill(0.0);
        } else {
            // It excites that row alone: the products with the others are zero.
            entries[10..12].fill(0.0);
        }
        rest.push(&entries).unwrap();
    }
    let found = solve_streamed(&Cut { candidates: rest.clone(), size: 640 }, &Options::default()).unwrap();
    let place = found.members.iter().position(|place| *place == (3333 / 640, 3333 % 640)).unwrap();
    assert!(found.design.shares[place] > 0.1);
    let mut none = Candidates::new(vec![3, 2]);
    (0..3000).for_each(|q| none.push(rest.candidate(q)).unwrap());
    let refused = solve_streamed(&Cut { candidates: none, size: 640 }, &Options::default());
    assert!(matches!(refused, Err(Error::Unexcited { block: 1, .. })), "{refused:?}");
    let empty =
        solve_streamed(&Cut { candidates: Candidates::new(vec![3, 2]), size: 5 }, &Options::default());
    assert_eq!(empty.unwrap_err(), Error::Empty);
}
