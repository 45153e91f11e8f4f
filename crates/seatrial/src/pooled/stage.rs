use std::path::{Path, PathBuf};

use artifact::{Provenance, TableWriter, commit, encode_block, stage_document};
use serde_json::json;
use vessel::{DegreeOfFreedom, Vessel};

use super::trust::Judge;
use super::words::{lost_instruments, unidentified};
use super::{Data, Estimated, Method, NominalModel, Pool, PoolFlags};
use crate::cli::beside;
use crate::failure::Failure;
use crate::instruments::Removal;
use crate::stage::Summary;
use identification::EstimateStatus as Status;
use study::documents::{
    DegreeSummary, DesignSummary, EstimateDocument, ParameterSummary, TrustDegree, TrustDocument,
};
use study::estimates::{self, Row};

/// Below this share of a regressor its instruments count as lost.
const WEAK: f64 = 0.1;
/// Below this probability a test counts as failed.
const UNLIKELY: f64 = 0.01;

/// What `estimate pool` was asked for.
pub struct Wanted<'a> {
    /// The vessel.
    pub vessel: &'a Vessel,
    /// The runs.
    pub trajectories: &'a Path,
    /// What to pool, and how.
    pub flags: &'a PoolFlags,
    /// The estimator.
    pub method: Method,
    /// How the instruments' mean is removed.
    pub removal: Removal,
    /// Lags of the standard errors; none: by a rule of thumb.
    pub bandwidth: Option<usize>,
    /// Resamples of the bootstrap.
    pub replicates: u32,
    /// Seed of the bootstrap.
    pub seed: u64,
    /// Main output.
    pub out: PathBuf,
    /// No progress.
    pub quiet: bool,
}

/// One estimate from all runs: estimates.parquet with one row, estimate.json, trust.json.
///
/// # Errors
/// Refused files; a nominal simulation that diverges; no degree of freedom that is identified.
pub fn estimate(wanted: &Wanted, mut provenance: Provenance) -> Result<Summary, Failure> {
    let (vessel, flags) = (wanted.vessel, wanted.flags);
    let strength = flags.strength()?;
    let nominal = NominalModel::read(&flags.nominal(), vessel, &mut provenance)?;
    let data = Data::read(wanted.trajectories, vessel, flags, &mut provenance)?;
    note(wanted, strength, &mut provenance);
    let lifted = vessel.model.with_intercepts();
    let removal = wanted.removal;
    let pool = Pool {
        model: &vessel.model,
        lifted: &lifted,
        removal,
        strength,
        nominal: &nominal,
        constant: data.constant(),
    };
    let mut parts = data.parts(vessel);
    let found = pool.estimate(&mut parts, wanted.method).map_err(|diverged| {
        let part = &parts[diverged.part];
        Failure::NoAnswer(format!(
            "{}: {}: found no instruments, expected a nominal model that follows the data; cut shorter parts with \
             --part-s, name another --nominal, or use --estimator ls",
            wanted.trajectories.display(),
            lost_instruments(&part.label, &part.source, diverged)
        ))
    })?;
    refuse_without_any(wanted, &found, data.constant())?;
    let judge = Judge {
        vessel,
        pool: &pool,
        found: &found,
        parts: &parts,
        bandwidth: wanted.bandwidth,
        replicates: wanted.replicates,
        seed: wanted.seed,
        quiet: wanted.quiet,
    };
    let degrees = judge.degrees();
    let mut statements = statements(&found, &degrees);
    if let Some(diverged) = found.diverged {
        let part = &parts[diverged.part];
        statements.insert(0, lost_instruments(&part.label, &part.source, diverged));
    }
    let trust = TrustDocument {
        estimator: wanted.method,
        mean_removal: wanted.removal,
        nominal: flags.nominal().to_string(),
        prior: strength,
        parts: parts.len() as u64,
        sources: data.sources().len() as u64,
        samples: parts.iter().map(|p| p.samples() as u64).sum(),
        bandwidth: judge.bandwidth() as u64,
        replicates: u64::from(wanted.replicates),
        statements,
        degrees,
        runs: judge.runs(&data),
    };
    publish(wanted, &provenance, &data, &trust)
}

fn note(wanted: &Wanted, strength: f64, provenance: &mut Provenance) {
    let settings = [
        ("estimator", json!(wanted.method)),
        ("mean_removal", json!(wanted.removal)),
        ("pool", json!(true)),
        ("prior", json!(strength)),
        ("bootstrap", json!(wanted.replicates)),
        ("seed", json!(wanted.seed)),
        ("bandwidth", json!(wanted.bandwidth)),
    ];
    wanted.flags.note(settings, provenance);
}

fn refuse_without_any(wanted: &Wanted, found: &Estimated, constant: &[String]) -> Result<(), Failure> {
    if found.degrees.iter().any(|d| d.solution.is_some()) {
        return Ok(());
    }
    let reasons = DegreeOfFreedom::ALL.into_iter().filter_map(|d| {
        unidentified(d, &wanted.vessel.model.degrees[d as usize], &found.degrees[d as usize].status, constant)
    });
    Err(Failure::NoAnswer(format!(
        "{}: pooled estimate: found no degree of freedom that is identifiable ({}), expected one; add runs that vary \
         these terms, name a --prior, or use --estimator ls",
        wanted.trajectories.display(),
        reasons.collect::<Vec<_>>().join("; ")
    )))
}

/// What to know before using the estimate.
fn statements(found: &Estimated, degrees: &[TrustDegree]) -> Vec<String> {
    let mut out = Vec::new();
    for (i, degree) in degrees.iter().enumerate() {
        if let Some(reason) = &degree.reason {
            out.push(format!("not identifiable: {reason}"));
            continue;
        }
        if degree.condition_index.is_none_or(|index| index > identification::pooled::COLLINEAR) {
            out.push(format!("collinear, use for similar motion only: {}", degree.weakest));
        }
        let lost: Vec<String> = degree
            .parameters
            .iter()
            .filter_map(|p| {
                p.instrument_strength
                    .filter(|s| *s < WEAK)
                    .map(|s| format!("`{}` {:.0} %", p.term, 100.0 * s))
            })
            .collect();
        if !lost.is_empty() && found.used[i].by_instruments() {
            out.push(format!(
                "{}: weak instruments: the nominal simulation tells of {}",
                degree.name,
                study::listed(&lost)
            ));
        }
        if let Some(white) = degree.whiteness.as_ref().filter(|w| w.p_value < UNLIKELY) {
            let allowed = match found.used[i] {
                super::Used::OutputError => "any correlation within a sub-experiment".to_owned(),
                _ => format!("{} lags", white.lags),
            };
            out.push(format!(
                "{}: residuals are not white (neighbours correlate by {:.2}): the standard errors allow for {allowed}",
                degree.name, white.first_autocorrelation
            ));
        }
        if let Some(crossed) = degree.instrument_residual.as_ref().filter(|c| c.p_value < UNLIKELY) {
            out.push(format!(
                "{}: residuals correlate by {:.2} with `{}` {} sample{} {}: the model lacks some motion",
                degree.name,
                crossed.strongest,
                crossed.instrument,
                crossed.lag.abs(),
                if crossed.lag.abs() == 1 { "" } else { "s" },
                if crossed.lag > 0 { "before" } else { "after" }
            ));
        }
    }
    out
}

fn publish(
    wanted: &Wanted,
    provenance: &Provenance,
    data: &Data,
    trust: &TrustDocument,
) -> Result<Summary, Failure> {
    let (vessel, out) = (wanted.vessel, &wanted.out);
    let row = row(data, trust);
    let schema = estimates::schema(vessel);
    let mut writer = TableWriter::create(out, &schema, provenance)?;
    writer.push(encode_block(&schema, &estimates::table(vessel, &[row]))?)?;
    let document = document(vessel, data, trust);
    commit(vec![
        writer.finish()?,
        stage_document(beside(out, "estimate.json"), provenance, &document)?,
        stage_document(beside(out, "trust.json"), provenance, trust)?,
    ])?;
    let refused: Vec<String> = trust.degrees.iter().filter_map(|d| d.reason.clone()).collect();
    let rest = if refused.is_empty() {
        String::new()
    } else {
        format!("; not identifiable: {}", refused.join("; "))
    };
    Ok(Summary {
        line: format!(
            "{}: {} from {} parts of {} runs, {} samples{rest}",
            out.display(),
            trust.estimator,
            trust.parts,
            trust.sources,
            trust.samples
        ),
        json: json!({"out": out, "parts": trust.parts, "sources": trust.sources, "samples": trust.samples,
            "not_identifiable": refused, "statements": trust.statements}),
    })
}

fn row(data: &Data, trust: &TrustDocument) -> Row {
    let parameters = || trust.degrees.iter().flat_map(|d| &d.parameters);
    let theta: Option<Vec<f64>> = parameters().map(|p| p.estimate).collect();
    let errors: Option<Vec<f64>> = parameters().map(|p| p.standard_error).collect();
    let estimate = theta.zip(errors);
    Row {
        design: data.design().to_owned(),
        run: 0,
        estimator: trust.estimator,
        status: if estimate.is_some() { Status::Identified } else { Status::NotIdentifiable },
        estimate,
        condition: [0, 1, 2].map(|d: usize| trust.degrees[d].condition.unwrap_or(f64::INFINITY)),
        weakest: [0, 1, 2].map(|d: usize| weakest_parameter(&trust.degrees[d])),
    }
}

/// The parameter with the largest standard error for its size.
fn weakest_parameter(degree: &TrustDegree) -> String {
    let relative = |p: &study::documents::TrustParameter| match (p.estimate, p.standard_error) {
        (Some(estimate), Some(error)) if estimate != 0.0 => (error / estimate).abs(),
        _ => 1.0 / p.variation.max(1e-300),
    };
    let largest = degree.parameters.iter().max_by(|a, b| relative(a).total_cmp(&relative(b)));
    largest.map_or(String::new(), |p| p.name.clone())
}

fn document(vessel: &Vessel, data: &Data, trust: &TrustDocument) -> EstimateDocument {
    let whole = trust.degrees.iter().all(|d| d.reason.is_none());
    let parameters = trust.degrees.iter().flat_map(|d| &d.parameters).enumerate();
    let parameter = |(i, p): (usize, &study::documents::TrustParameter)| ParameterSummary {
        name: p.name.clone(),
        unit: p.unit.clone(),
        truth: vessel.value[i],
        nominal: vessel.nominal[i],
        mean: p.estimate,
        spread: None,
        predicted_se: p.standard_error,
        ..ParameterSummary::default()
    };
    let degree = |d: &TrustDegree| DegreeSummary {
        name: d.name.clone(),
        condition_median: d.condition,
        condition_max: d.condition,
        weakest_parameter: weakest_parameter(d),
        weakest_share: 1.0,
        ..DegreeSummary::default()
    };
    EstimateDocument {
        estimator: trust.estimator,
        mean_removal: trust.mean_removal,
        seed: None,
        trusted_within: None,
        designs: vec![DesignSummary {
            design: data.design().to_owned(),
            runs: 1,
            identified: u64::from(whole),
            parameters: parameters.map(parameter).collect(),
            degrees: trust.degrees.iter().map(degree).collect(),
            ..DesignSummary::default()
        }],
        compared: None,
        trust: Some(trust.statements.clone()),
    }
}
