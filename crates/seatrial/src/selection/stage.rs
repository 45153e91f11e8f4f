use std::collections::BTreeMap;
use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, commit, encode_block, stage_document};
use identification::Sums;
use identification::pooled::{Centring, Part, Regression, Score, Window, Windows, strength};
use serde_json::json;
use vessel::{LANES, Vessel};

use study::selection::{Row, schema, summarize, table};

use super::{Draw, Realization, Realizer, counts};
use crate::cli::beside;
use crate::failure::Failure;
use crate::instruments::Removal;
use crate::ordered::ordered;
use crate::pooled::{
    Data, Method, NominalModel, Pool, PoolFlags, deviations, instrument_fit, lost_instruments,
};
use crate::progress::Progress;
use crate::stage::Summary;
use study::documents::{PublishedLimits, SelectionDocument};

/// What `validate selection` was asked for.
pub struct Wanted<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The runs.
    pub trajectories: &'a Path,
    /// What to pool, and how.
    pub flags: &'a PoolFlags,
    /// `design.json`, whose counts or shares are picked.
    pub design: Option<&'a Path>,
    /// `label=n`, instead.
    pub counts: &'a [String],
    /// How many to pick where the design has shares only.
    pub picks: Option<u64>,
    /// Realizations per design.
    pub realizations: u32,
    /// The estimator.
    pub method: Method,
    /// How the instruments' mean is removed.
    pub removal: Removal,
    /// Whether estimated intercepts are simulated too.
    pub intercepts: bool,
    /// Norm of RMSE/std from which a model is degenerate.
    pub degenerate_from: f64,
    /// Errors at which the figures of a published study end.
    pub published: Option<PublishedLimits>,
    /// Seed of the picks.
    pub seed: u64,
    /// Main output.
    pub out: PathBuf,
    /// No progress.
    pub quiet: bool,
}

/// Picks, estimates, simulates: selection.parquet with a row per realization, selection.json.
///
/// # Errors
/// Refused files; counts that there are not; a nominal simulation that diverges.
pub fn select(wanted: &Wanted, mut provenance: Provenance) -> Result<Summary, Failure> {
    let (vessel, flags) = (wanted.vessel, wanted.flags);
    let prior = flags.strength()?;
    let nominal = NominalModel::read(&flags.nominal(), vessel, &mut provenance)?;
    let data = Data::read(wanted.trajectories, vessel, flags, &mut provenance)?;
    let parts = data.segments(vessel);
    let available = available(&parts);
    let counts = counts(wanted.design, wanted.counts, wanted.picks, &available, &mut provenance)?;
    let lifted = vessel.model.with_intercepts();
    let removal = wanted.removal;
    let pool = Pool {
        model: &vessel.model,
        lifted: &lifted,
        removal,
        strength: prior,
        nominal: &nominal,
        constant: data.constant(),
    };
    let prepared = Prepared::new(wanted, &pool, &data)?;
    let windows: Vec<Window> = parts
        .iter()
        .map(|p| Window { exogenous: p.exogenous.clone(), measured: p.measured.clone() })
        .collect();
    let simulated = Windows::new(&lifted, &windows);
    let realizer = Realizer {
        pool: &pool,
        method: wanted.method,
        nominal: prepared.nominal.as_deref(),
        ls: &prepared.ls,
        iv: prepared.iv.as_deref(),
        windows: &simulated,
        intercepts: wanted.intercepts,
    };
    let labels: Vec<&str> = parts.iter().map(|p| p.label.as_str()).collect();
    let picks = counts.values().sum::<u64>();
    let draws = [
        ("optimized", Draw::by_design(wanted.seed, &labels, &counts)),
        ("random", Draw::at_random(wanted.seed, parts.len(), picks as usize)),
    ];
    let std = deviations(parts.iter().map(|p| p.measured.as_slice()));
    let rows = realized(wanted, &realizer, &draws, std)?;
    let document = SelectionDocument {
        estimator: wanted.method,
        mean_removal: wanted.removal,
        nominal: flags.nominal().to_string(),
        prior,
        intercepts: wanted.intercepts,
        picks,
        seed: Some(wanted.seed),
        counts,
        available,
        parts: parts.len() as u64,
        samples: parts.iter().map(|p| p.samples() as u64).sum(),
        std_u: std[0],
        std_v: std[1],
        std_r: std[2],
        degenerate_from: wanted.degenerate_from,
        ratio_q90: None,
        statements: Vec::new(),
        instrument_fit: prepared.instrument_fit,
        published_limits: wanted.published,
        designs: ["optimized", "random"]
            .map(|design| summarize(design, &rows, wanted.degenerate_from, wanted.published))
            .into(),
    };
    note(wanted, prior, &mut provenance);
    publish(&wanted.out, &provenance, &rows, concluded(document, prepared.statements))
}

/// Sums per part, and what to know about their instruments.
struct Prepared {
    ls: Vec<Sums>,
    iv: Option<Vec<Sums>>,
    nominal: Option<Vec<f64>>,
    instrument_fit: Option<[f64; 3]>,
    statements: Vec<String>,
}

impl Prepared {
    fn new(wanted: &Wanted, pool: &Pool, data: &Data) -> Result<Self, Failure> {
        let pieces = data.pieces(wanted.vessel);
        let counts: Vec<usize> = pieces.iter().map(Vec::len).collect();
        let mut parts = pieces.concat();
        // Instruments start anew with every piece; a part's sums are those of its pieces.
        let sums = |pieces: Vec<Regression>| -> Vec<Sums> {
            let mut all = pieces.iter().map(Regression::sums);
            let merged = |count: &usize| {
                let mut whole = Sums::default();
                all.by_ref().take(*count).for_each(|sums| whole.merge(&sums));
                whole
            };
            counts.iter().map(merged).collect()
        };
        let ls = sums(pool.regressions(&parts));
        let nominal = pool.nominal.parameters(&ls.iter().collect::<Vec<_>>(), pool.removal);
        let mut prepared = Self {
            ls,
            iv: None,
            nominal: nominal.as_ref().map(|(theta, _)| theta.clone()),
            instrument_fit: None,
            statements: Vec::new(),
        };
        let (false, Some((theta, c))) = (wanted.method == Method::Ls, &nominal) else { return Ok(prepared) };
        match Part::instrument(&mut parts, pool.lifted, &pool.lifted.layout().woven(theta, *c)) {
            Ok(()) => {
                let data = pool.instrumented_regressions(&parts);
                prepared.instrument_fit = instrument_fit(&parts);
                let weakest = weakest_instrument(pool, &data);
                prepared.statements.extend(prepared.instrument_fit.and_then(|fits| poor(fits, weakest)));
                prepared.iv = Some(sums(data));
            }
            Err(diverged) => {
                let lost =
                    lost_instruments(&parts[diverged.part].label, &parts[diverged.part].source, diverged);
                if wanted.method != Method::Auto {
                    return Err(Failure::NoAnswer(format!(
                        "{}: {lost}: found no instruments, expected a nominal model that follows the data; cut \
                         shorter parts with --part-s, name another --nominal, or use --estimator ls",
                        wanted.trajectories.display()
                    )));
                }
                prepared.statements.push(lost);
            }
        }
        Ok(prepared)
    }
}

/// Below this the instruments have lost a state: the nominal simulation explains less than half of its deviations.
const POOR: f64 = 50.0;

/// The term that its instrument tells least of, with Shea's partial R².
fn weakest_instrument(pool: &Pool, data: &[Regression]) -> Option<(String, f64)> {
    let parts: Vec<&Regression> = data.iter().collect();
    let sums: Vec<Sums> = data.iter().map(Regression::sums).collect();
    let centring = Centring::new(&sums.iter().collect::<Vec<_>>(), pool.removal);
    let degree = |d: usize| {
        let terms = pool.model.degrees[d].terms.iter().map(|t| t.text.clone());
        terms.zip(strength(&parts, &centring, d).unwrap_or_default()).collect::<Vec<_>>()
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
            study::listed(&lost)
        )
    })
}

fn available(parts: &[Part]) -> BTreeMap<String, u64> {
    let mut available = BTreeMap::new();
    parts.iter().for_each(|part| *available.entry(part.label.clone()).or_insert(0) += 1);
    available
}

fn realized(
    wanted: &Wanted,
    realizer: &Realizer,
    draws: &[(&str, Draw)],
    std: [f64; 3],
) -> Result<Vec<Row>, Failure> {
    let chunks = (wanted.realizations as usize).div_ceil(LANES);
    let progress = Progress::new("realizations", 2 * chunks, wanted.quiet);
    let mut rows = Vec::with_capacity(2 * wanted.realizations as usize);
    let work = |i: usize| {
        let (design, draw) = &draws[i / chunks];
        let first = i % chunks * LANES;
        let count = LANES.min(wanted.realizations as usize - first);
        let found = realizer.chunk(draw, first as u32, count);
        progress.advance(1);
        let own = found.into_iter().zip(first..).map(|(r, number)| row(design, number, &r, std));
        Ok::<_, Failure>(own.collect::<Vec<_>>())
    };
    ordered(0..2 * chunks, work, |own| {
        rows.extend(own);
        Ok(())
    })?;
    Ok(rows)
}

fn row(design: &str, number: usize, found: &Realization, std: [f64; 3]) -> Row {
    let norm = |rmse: [f64; 3]| (0..3).map(|d| (rmse[d] / std[d]).powi(2)).sum::<f64>().sqrt();
    let rmse = |score: &Option<Score>| score.as_ref().and_then(Score::rmse);
    let finite = |x: &f64| x.is_finite();
    let (overlapping, left_out) = (rmse(&found.overlapping), rmse(&found.left_out));
    let picked: Vec<String> = found.picked.iter().map(usize::to_string).collect();
    Row {
        design: design.to_owned(),
        realization: number as i32,
        picked: picked.join(" "),
        identified: found.overlapping.is_some(),
        rmse: overlapping,
        error_norm: overlapping.map(norm).filter(finite),
        left_out_rmse: left_out,
        left_out_norm: left_out.map(norm).filter(finite),
    }
}

/// Adds the result in words and the ratio of the quantiles.
fn concluded(mut document: SelectionDocument, warnings: Vec<String>) -> SelectionDocument {
    let q90 = |i: usize| document.designs[i].overlapping.error_norm.q90;
    let told = |q: Option<f64>| q.map_or("infinite".to_owned(), |q| format!("{q:.2}"));
    document.ratio_q90 = q90(0).zip(q90(1)).map(|(optimized, random)| optimized / random);
    let share = |i: usize| 100.0 * document.designs[i].degenerate_share;
    let mut statements = vec![format!(
        "90 % quantile of the error norm: optimized {}, random {}; degenerate: optimized {:.1} %, random {:.1} %",
        told(q90(0)),
        told(q90(1)),
        share(0),
        share(1)
    )];
    statements.extend(warnings);
    document.statements = statements;
    document
}

fn publish(
    out: &Path,
    provenance: &Provenance,
    rows: &[Row],
    document: SelectionDocument,
) -> Result<Summary, Failure> {
    let mut writer = TableWriter::create(out, &schema(), provenance)?;
    writer.push(encode_block(&schema(), &table(rows))?)?;
    let staged = stage_document(beside(out, "selection.json"), provenance, &document)?;
    commit(vec![writer.finish()?, staged])?;
    Ok(Summary {
        line: format!("{}: {}", out.display(), document.statements.join("; ")),
        json: json!({"out": out, "ratio_q90": document.ratio_q90, "statements": document.statements}),
    })
}

fn note(wanted: &Wanted, strength: f64, provenance: &mut Provenance) {
    let settings = [
        ("estimator", json!(wanted.method)),
        ("mean_removal", json!(wanted.removal)),
        ("prior", json!(strength)),
        ("intercepts", json!(wanted.intercepts)),
        ("realizations", json!(wanted.realizations)),
        ("seed", json!(wanted.seed)),
    ];
    wanted.flags.note(settings, provenance);
}
