//! `design`: how long to run each maneuver.

use std::path::{Path, PathBuf};

use artifact::{Provenance, commit, read_document, stage_document};
use design::{Bounds, CountOptions, Design, Options};
use serde_json::json;

use super::{
    Arguments, Asked, Available, Criterion, Experiment, Few, Question, Segments, Sequencing, Solved, counted,
    document, information, no_design, restricted, squares, weights,
};
use crate::cli::{given, provenance};
use crate::failure::Failure;
use crate::instruments::Removal;
use crate::stage::Summary;
use study::documents::{DesignDocument, MomentsDocument, Sequence};
use study::files::{read_dictionary, read_vessel};

/// Finds the shares that are asked for and writes them.
///
/// # Errors
/// Moments that are refused; no design; what cannot be written.
pub fn stage(a: &Arguments) -> Result<Summary, Failure> {
    a.check()?;
    let loaded = read_document::<MomentsDocument>(&a.moments)?;
    let moments = loaded.data;
    let mut provenance = provenance("design");
    provenance.inputs.insert("moments".into(), loaded.digest);
    // Moments of simulated logs say so, and so does the design.
    provenance
        .settings
        .extend(loaded.provenance.settings.get_key_value("data").map(|(k, v)| (k.clone(), v.clone())));
    let document = design(a, &moments, &mut provenance)?;
    a.settings(&mut provenance);
    let inputs = [Some(&a.moments), a.weights.as_ref(), a.available.as_ref()];
    let inputs: Vec<&Path> = inputs.into_iter().flatten().chain(&a.also).map(PathBuf::as_path).collect();
    let out = a.common.main_output("design.json", &inputs)?;
    commit(vec![stage_document(&out, &provenance, &document)?])?;
    Ok(summary(&out, &document))
}

/// Moments with other models.
fn also(a: &Arguments, provenance: &mut Provenance) -> Result<Vec<(PathBuf, MomentsDocument)>, Failure> {
    let mut out = Vec::new();
    for (i, path) in a.also.iter().enumerate() {
        let loaded = read_document::<MomentsDocument>(path)?;
        provenance.inputs.insert(format!("moments:{}", i + 2), loaded.digest);
        out.push((path.clone(), loaded.data));
    }
    Ok(out)
}

/// The design of `moments`: candidates, what is available, criterion, shares, counts.
fn design(
    a: &Arguments,
    moments: &MomentsDocument,
    provenance: &mut Provenance,
) -> Result<DesignDocument, Failure> {
    let (name, estimated) = (a.criterion_name()?, a.estimated());
    let refuse = |e| no_design(&a.moments, moments, estimated, e);
    let information = information(&a.moments, moments, estimated)?;
    let weights = weights(name, a.relative_to, a.weights.as_deref(), &a.moments, moments, provenance)?;
    let also = also(a, provenance)?;
    let also: Vec<(&Path, MomentsDocument)> = also.iter().map(|(p, m)| (p.as_path(), m.clone())).collect();
    let asked = Asked { name, estimated, weights, also: &also, over: a.over };
    let criterion = Criterion::new(&asked, &a.moments, moments)?;
    let options =
        Options { tolerance: a.tolerance, random_starts: a.starts, seed: a.seed(), ..Options::default() };
    let timed = match a.accuracy {
        Some(accuracy) => {
            let question = Question {
                file: &a.moments,
                moments,
                criterion: &criterion,
                estimated,
                removal: a.mean_removal,
                squares: squares(a.relative_to, &a.moments, moments)?,
                wanted: a.wanted(accuracy),
                least_largest: a.per_parameter && a.criterion.is_none() && a.also.is_empty(),
                available: a.available.as_deref(),
            };
            Some(question.shortest(&options, provenance)?)
        }
        None => None,
    };
    let experiment = match &timed {
        Some(timed) => Experiment { samples: Some(timed.accuracy.samples as f64), segments: None },
        None => a.experiment(moments),
    };
    let available = match &a.available {
        Some(path) => Some(Available::read(path, moments, &experiment, provenance)?),
        None => None,
    };
    let bounds = match &available {
        Some(available) => Bounds::new(&available.shares).map_err(refuse)?,
        None => Bounds::default(),
    };
    let parameters = moments.degrees.iter().map(|d| d.parameters.len()).sum();
    let mut design = match &timed {
        Some(timed) => timed.design.clone(),
        None => criterion.solve(&bounds, &options).map_err(refuse)?,
    };
    let few = Few { most_maneuvers: a.most_maneuvers, minimal_s: a.minimal_s };
    let mut about = None;
    if few.most_maneuvers.is_some() || few.minimal_s.is_some() {
        let duration_s = a.few_duration(moments, &experiment)?;
        let found = restricted(&criterion, &design, &bounds, &few, duration_s, &options, parameters);
        let (restricted, told) = found.map_err(|e| few.refusal(&a.moments, &e))?;
        (design, about) = (restricted, Some(told));
    }
    let segments = experiment.segments.map(|(total, samples)| Segments {
        total,
        samples,
        limits: limits(available.as_ref(), about.is_some().then_some(&design), total),
    });
    let count_options = CountOptions { random_starts: a.starts, seed: a.seed(), ..CountOptions::default() };
    let sequence = sequence(a, moments, &criterion, &design, experiment.samples, provenance)?;
    let count = |segments| counted(&criterion, &design, segments, &count_options, parameters);
    Ok(document(Solved {
        moments,
        information: &information,
        name,
        criterion: &criterion,
        estimated,
        removal: a.mean_removal,
        design: &design,
        available: available.as_ref(),
        counted: segments.as_ref().map(count).transpose().map_err(refuse)?,
        samples: experiment.samples,
        over: (!also.is_empty()).then_some(a.over),
        restricted: about,
        accuracy: timed.map(|timed| timed.accuracy),
        sequence,
    }))
}

/// Order and lengths of the maneuvers of `design`, where they are asked for.
fn sequence(
    a: &Arguments,
    moments: &MomentsDocument,
    criterion: &Criterion,
    design: &Design,
    samples: Option<f64>,
    provenance: &mut Provenance,
) -> Result<Option<Sequence>, Failure> {
    if !a.arrange {
        return Ok(None);
    }
    let usage = |found: &str, expected: &str| {
        Err(Failure::Usage(format!("--arrange: found {found}, expected {expected}")))
    };
    let Some(samples) = samples else {
        return usage(
            "no length of the experiment",
            "one to fill; add --duration-s, --accuracy, or --segments and --segment-samples",
        );
    };
    if a.available.is_some()
        || a.most_maneuvers.is_some()
        || a.minimal_s.is_some()
        || a.mean_removal == Removal::Batch
    {
        return usage(
            "--available, --most-maneuvers, --minimal-s or --mean-removal batch, which the search does not keep",
            "none of them; leave them out",
        );
    }
    let (vessel_file, dictionary_file) = (given(&a.vessel, "vessel")?, given(&a.dictionary, "dictionary")?);
    let vessel = read_vessel(vessel_file, provenance)?;
    let generator = read_dictionary(dictionary_file, &vessel, provenance)?;
    let sequencing = Sequencing {
        vessel: &vessel,
        generator: &generator,
        dictionary_file,
        moments,
        name: a.criterion_name()?,
        criterion,
        estimated: a.estimated(),
        seed: a.seed(),
    };
    sequencing.search(&design.shares, &design.sensitivities, samples.round() as usize).map(Some)
}

/// Most segments of every maneuver: none of those that a restricted design does not use.
fn limits(available: Option<&Available>, restricted: Option<&Design>, total: u64) -> Option<Vec<u64>> {
    let limits = available.and_then(|available| available.counts.clone());
    let Some(design) = restricted else { return limits };
    let limits = limits.unwrap_or_else(|| vec![total; design.shares.len()]);
    Some(limits.iter().zip(&design.shares).map(|(limit, w)| if *w > 0.0 { *limit } else { 0 }).collect())
}

fn summary(out: &Path, document: &DesignDocument) -> Summary {
    let used = document.shares.values().filter(|w| **w > 0.0).count();
    Summary {
        line: format!(
            "{}: {} of {} maneuvers, {}, relative gap {:.1e}",
            out.display(),
            used,
            document.shares.len(),
            document.status,
            document.relative_gap
        ),
        json: json!({"out": out, "status": document.status, "relative_gap": document.relative_gap, "used": used}),
    }
}
