use crate::pooled::{Centring, LostInstruments, Part, Pool, PooledRuns, listed, strength};
use crate::{Estimator, Sums};

/// Below this the instruments have lost a state: the nominal simulation explains less than half of its deviations.
const POOR: f64 = 50.0;

/// Sums per part, and what to know about their instruments.
pub(super) struct Prepared {
    /// With the regressors as instruments.
    pub ls: Vec<Sums>,
    /// With simulated instruments.
    pub iv: Option<Vec<Sums>>,
    /// Nominal parameters that a prior pulls to.
    pub nominal: Option<Vec<f64>>,
    /// See [`Part::instrument_fit`].
    pub instrument_fit: Option<[f64; 3]>,
    /// In words.
    pub warnings: Vec<String>,
}

impl Prepared {
    /// # Errors
    /// The nominal simulation diverges, and the estimator cannot do without it.
    pub(super) fn new(pool: &Pool, runs: &PooledRuns, estimator: Estimator) -> Result<Self, LostInstruments> {
        let pieces = runs.segments(pool.part_samples);
        let counts: Vec<usize> = pieces.iter().map(Vec::len).collect();
        let mut parts: Vec<Part> = pieces.into_iter().flatten().collect();
        let ls = merged(&pool.regressions(&parts, false).sums(), &counts);
        let nominal = pool.nominal.parameters(&ls.iter().collect::<Vec<_>>(), pool.removal);
        let theta = nominal.as_ref().map(|(theta, _)| theta.clone());
        let mut prepared = Self { ls, iv: None, nominal: theta, instrument_fit: None, warnings: Vec::new() };
        let (false, Some((theta, c))) = (estimator == Estimator::Ls, &nominal) else { return Ok(prepared) };
        match pool.instrument(&mut parts, theta, *c) {
            Ok(()) => prepared.take(pool, &parts, &counts),
            Err(lost) if estimator == Estimator::Auto => prepared.warnings.push(lost.to_string()),
            Err(lost) => return Err(lost),
        }
        Ok(prepared)
    }

    fn take(&mut self, pool: &Pool, parts: &[Part], counts: &[usize]) {
        let sums = pool.regressions(parts, true).sums();
        self.instrument_fit = Part::instrument_fit(parts);
        self.warnings.extend(self.instrument_fit.and_then(|fits| poor(fits, weakest(pool, parts, &sums))));
        self.iv = Some(merged(&sums, counts));
    }
}

/// Instruments start anew with every piece; a part's sums are those of its pieces.
fn merged(pieces: &[Sums], counts: &[usize]) -> Vec<Sums> {
    let mut rest = pieces;
    let mut merged = |count: &usize| {
        let own;
        (own, rest) = rest.split_at(*count);
        Sums::total(own)
    };
    counts.iter().map(&mut merged).collect()
}

/// The term that its instrument tells least of, with Shea's partial R².
fn weakest(pool: &Pool, parts: &[Part], sums: &[Sums]) -> Option<(String, f64)> {
    let centring = Centring::new(&sums.iter().collect::<Vec<_>>(), pool.removal);
    let degree = |d: usize| {
        let terms = pool.vessel.model.degrees[d].terms.iter().map(|t| t.text.clone());
        terms
            .zip(strength(&pool.regressions(parts, true), &centring, d).unwrap_or_default())
            .collect::<Vec<_>>()
    };
    (0..3).flat_map(degree).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// That the instruments have lost the motion, and what comes of it.
fn poor(fits: [f64; 3], weakest: Option<(String, f64)>) -> Option<String> {
    let lost: Vec<String> = ["u", "v", "r"]
        .into_iter()
        .zip(fits)
        .filter(|(_, fit)| *fit < POOR)
        .map(|(name, fit)| format!("{name} to {fit:.0} %"))
        .collect();
    let told = weakest.map_or(String::new(), |(term, share)| {
        format!(" and tells {:.1} % of `{term}` (partial R²)", 100.0 * share)
    });
    (!lost.is_empty()).then(|| {
        format!(
            "poor instruments: simulated from the first state of each part the nominal model follows {} only{told}; \
             estimates divide by what instruments tell, so that those from few parts are free to diverge: cut shorter \
             parts (--part-s), improve the nominal model or the structure, name a --prior, or use --estimator ls",
            listed(&lost)
        )
    })
}
