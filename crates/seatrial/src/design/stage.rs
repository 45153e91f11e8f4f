use std::path::Path;

use artifact::{Provenance, commit, read_document, stage_document};
use design::{Available, Bounds, CountOptions, Design, Length, Options, Segments, counted};
use serde_json::json;

use super::Arguments;
use super::problem::Problem;
use super::refusal::scarce;
use crate::cli::Common;
use crate::failure::Failure;
use crate::stage::{Summary, Task};
use study::documents::{DesignDocument, MomentsDocument, Solved};
use trial::moments::Moments;

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        self.check()?;
        let loaded = read_document::<MomentsDocument>(&self.moments)?;
        let moments = loaded.data.moments().map_err(|e| Failure::invalid(&self.moments, &e))?;
        let mut provenance = common.provenance("design");
        provenance.made("moments", &self.moments, loaded.digest, &loaded.provenance)?;
        // Moments of simulated logs say so, and so does the design.
        let label = loaded.provenance.settings.get_key_value("data");
        provenance.settings.extend(label.map(|(k, v)| (k.clone(), v.clone())));
        let seed = common.seed.unwrap_or(1);
        let document = design(self, seed, &moments, &mut provenance)?;
        self.settings(seed, &mut provenance);
        let inputs = [&self.moments].into_iter().chain(&self.weights).chain(&self.available);
        let out = common.main_output("design.json", inputs)?;
        commit(vec![stage_document(&out, &provenance, &document)?])?;
        Ok(summary(&out, &document))
    }
}

/// The design of `moments`: criterion, what is available, shares, counts, order.
fn design(
    a: &Arguments,
    seed: u64,
    moments: &Moments,
    provenance: &mut Provenance,
) -> Result<DesignDocument, Failure> {
    let problem = Problem::read(a, seed, moments, provenance)?;
    let (dictionary, criterion) = (&problem.dictionary, &problem.criterion);
    let refuse = |e| problem.refuse(dictionary.explain(e));
    let options = Options { tolerance: a.tolerance, random_starts: a.starts, seed, ..Options::default() };
    let shortest = problem.shortest(&options)?;
    let length = match &shortest {
        Some((_, accuracy)) => Length { samples: Some(accuracy.samples as f64), segments: None },
        None => a.length(dictionary),
    };
    let available = match (&problem.stock, &a.available) {
        (Some(stock), Some(path)) => Some(stock.within(dictionary, &length).map_err(|e| scarce(path, e))?),
        _ => None,
    };
    let bounds = available.as_ref().map_or(Ok(Bounds::default()), |a| Bounds::new(&a.shares));
    let bounds = bounds.map_err(refuse)?;
    let (relaxed, accuracy) = match shortest {
        Some((design, accuracy)) => (design, Some(accuracy)),
        None => (criterion.solve(&bounds, &options).map_err(refuse)?, None),
    };
    let few = problem.few(&relaxed, &bounds, a.few_duration(dictionary, &length)?, &options)?;
    let restricted = few.as_ref().map(|(_, found)| &found.design);
    let design = restricted.unwrap_or(&relaxed);
    let count_options = CountOptions { random_starts: a.starts, seed, ..CountOptions::default() };
    let sequence = problem.arranged(design, length.samples, provenance)?;
    let segments = length.segments.map(|(total, samples)| {
        let segments = Segments { total, samples, limits: limits(available.as_ref(), restricted, total) };
        let whole = counted(criterion, design, &segments, &count_options, dictionary.parameters());
        whole.map(|whole| (segments, whole))
    });
    Ok(Solved {
        dictionary,
        name: problem.name,
        criterion,
        estimated: problem.estimated,
        removal: a.mean_removal,
        design,
        available: available.as_ref(),
        segments: segments.transpose().map_err(refuse)?,
        samples: length.samples,
        restricted: few.as_ref().map(|(few, found)| (*few, found)),
        accuracy: accuracy.as_ref(),
        sequence,
    }
    .into())
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
    let gap = document.relative_gap;
    let within = gap.map_or(String::new(), |gap| format!(", relative gap {gap:.1e}"));
    let (all, status) = (document.shares.len(), document.status);
    let told = json!({"status": status, "relative_gap": gap, "used": used});
    Summary::of(out, format!("{used} of {all} maneuvers, {status}{within}"), told)
}
