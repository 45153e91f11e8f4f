use estimation::Estimator;
use estimation::pooled::{InstrumentFit, NoEstimate, Pool};
use refusal::listed;
use regression::Sums;
use regression::pooled::{Centring, LostInstruments, Part, PooledRuns, PooledSums, Strength};

/// Instruments are poor below this fit of a state: the nominal simulation explains less than half of its deviations.
const POOR: f64 = 50.0;

/// Sums per part, and the fit of their instruments.
pub(super) struct Prepared {
    /// With the regressors as instruments.
    pub ls: Vec<Sums>,
    /// With simulated instruments.
    pub iv: Option<Vec<Sums>>,
    /// Nominal parameters for a prior.
    pub nominal: Option<Vec<f64>>,
    /// See [`InstrumentFit`].
    pub instrument_fit: Option<[f64; 3]>,
    /// In words.
    pub warnings: Vec<String>,
}

impl Prepared {
    /// # Errors
    /// The nominal simulation diverges, and the estimator needs it.
    pub(super) fn new(pool: &Pool, runs: &PooledRuns, estimator: Estimator) -> Result<Self, LostInstruments> {
        let segments = runs.segments(pool.part_samples);
        let counts: Vec<usize> = segments.iter().map(Vec::len).collect();
        let parts: Vec<Part> = segments.into_iter().flatten().collect();
        let ls = merged(&sums(pool, &parts, None)?.1, &counts);
        let nominal = pool.nominal.parameters(&PooledSums::of(&ls, pool.removal));
        let theta = nominal.as_ref().map(|(theta, _)| theta.clone());
        let mut prepared = Self { ls, iv: None, nominal: theta, instrument_fit: None, warnings: Vec::new() };
        let (false, Some((theta, c))) = (estimator == Estimator::Ls, &nominal) else { return Ok(prepared) };
        let model = pool.model.layout().woven(theta, *c);
        match sums(pool, &parts, Some(&model)) {
            Ok((pooled, own)) => {
                prepared.warn(pool, &parts, &model, &pooled.centring());
                prepared.iv = Some(merged(&own, &counts));
            }
            Err(lost) if estimator == Estimator::Auto => prepared.warnings.push(lost.to_string()),
            Err(lost) => return Err(lost),
        }
        Ok(prepared)
    }

    /// Checks how well instruments simulated with `model` follow the data, and warns if they do not.
    fn warn(&mut self, pool: &Pool, parts: &[Part], model: &[f64], centring: &Centring) {
        let mut fit = InstrumentFit::of(parts.iter().map(|part| part.measured.as_slice()));
        let mut strengths: [Strength; 3] = Default::default();
        for (i, part) in parts.iter().enumerate() {
            // Parts that diverge were refused before.
            let Ok((regression, states)) = pool.regression(&part.whole(), Some(model)) else { continue };
            fit.add(&states, &part.measured);
            for (d, (strength, degree)) in strengths.iter_mut().zip(&regression.degrees).enumerate() {
                strength.add(i, degree, centring, d);
            }
        }
        self.instrument_fit = fit.found();
        self.warnings.extend(self.instrument_fit.and_then(|fits| poor(fits, weakest(pool, strengths))));
    }
}

/// The sums of all `parts`, and of each.
fn sums(
    pool: &Pool,
    parts: &Vec<Part>,
    simulated: Option<&[f64]>,
) -> Result<(PooledSums, Vec<Sums>), LostInstruments> {
    let mut own = Vec::with_capacity(parts.len());
    match pool.sums(parts, simulated, |_, sums| own.push(sums.clone())) {
        Ok(pooled) => Ok((pooled, own)),
        Err(NoEstimate::Lost(lost)) => Err(lost),
    }
}

/// Adds the sums of the parts that a segment was cut into, `counts` each; instruments restart with every part.
fn merged(parts: &[Sums], counts: &[usize]) -> Vec<Sums> {
    let mut rest = parts;
    let mut merged = |count: &usize| {
        let own;
        (own, rest) = rest.split_at(*count);
        Sums::total(own)
    };
    counts.iter().map(&mut merged).collect()
}

/// The term that its instrument explains least, with Shea's partial R².
fn weakest(pool: &Pool, strengths: [Strength; 3]) -> Option<(String, f64)> {
    let degree = |(d, strength): (usize, Strength)| {
        let terms = pool.vessel.model.degrees[d].terms.iter().map(|t| t.text.clone());
        terms.zip(strength.partial().unwrap_or_default()).collect::<Vec<_>>()
    };
    strengths.into_iter().enumerate().flat_map(degree).min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The warning that the instruments do not follow the motion.
fn poor(fits: [f64; 3], weakest: Option<(String, f64)>) -> Option<String> {
    let lost: Vec<String> = ["u", "v", "r"]
        .into_iter()
        .zip(fits)
        .filter(|(_, fit)| *fit < POOR)
        .map(|(name, fit)| format!("{name} to {fit:.0} %"))
        .collect();
    let explained = weakest.map_or(String::new(), |(term, share)| {
        format!(" and tells {:.1} % of `{term}` (partial R²)", 100.0 * share)
    });
    (!lost.is_empty()).then(|| {
        format!(
            "poor instruments: simulated from the first state of each part the nominal model follows {} only{explained}; \
             estimates divide by what instruments tell, so that those from few parts are free to diverge: cut shorter \
             parts (--part-s), improve the nominal model or the structure, name a --prior, or use --estimator ls",
            listed(&lost)
        )
    })
}
