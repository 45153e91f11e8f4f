use design::{Bounds, CountOptions, Design, Length, Options, Segments, Streamed, counted, solve_streamed};
use files::{Provenance, commit, exists, read_document, stage_document};
use serde_json::json;

use super::Arguments;
use super::problem::Problem;
use super::refusal::{no_design, scarce};
use crate::cli::Common;
use crate::failure::Failure;
use crate::stage::{Summary, Task};
use study::documents::{DesignDocument, MomentsDocument, Solved};
use study::moments_table::{MomentsTable, TableError, table_of};
use trial::moments::Moments;

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        self.check()?;
        let inputs = [&self.moments].into_iter().chain(&self.available).chain(&self.figures);
        let out = common.main_output("design.json", inputs)?;
        let loaded = read_document::<MomentsDocument>(&self.moments)?;
        let moments = loaded.data.moments().map_err(|e| Failure::invalid(&self.moments, &e))?;
        let moments = self.with_prior(moments)?;
        let mut provenance = common.provenance("design");
        provenance.made("moments", &self.moments, loaded.digest, &loaded.provenance)?;
        // The label of simulated logs is copied from the moments to the design.
        let label = loaded.provenance.settings.get_key_value("data");
        provenance.settings.extend(label.map(|(k, v)| (k.clone(), v.clone())));
        let seed = common.seed.unwrap_or(1);
        let (moments, streamed) = match moments.maneuvers.is_empty() && exists(table_of(&self.moments)) {
            true => self.streamed(moments, seed).map(|(own, found)| (own, Some(found)))?,
            false => (moments, None),
        };
        let document = design(self, (seed, streamed), &moments, &mut provenance)?;
        self.settings(seed, &moments, &mut provenance);
        commit(vec![stage_document(&out, &provenance, &document)?])?;
        let (status, gap, used) = (document.status, document.relative_gap, document.used());
        let details = json!({"status": status, "relative_gap": gap, "used": used});
        Ok(Summary::of(&out, document.summary(), details))
    }
}

impl Arguments {
    /// Options of the search for shares.
    fn options(&self, seed: u64) -> Options {
        Options { tolerance: self.tolerance, random_starts: self.starts, seed, ..Options::default() }
    }

    /// The maneuvers of the table that have a share, and the result over the whole table.
    fn streamed(&self, head: Moments, seed: u64) -> Result<(Moments, Streamed), Failure> {
        let limits = [
            (self.available.is_some(), "--available"),
            (self.most_maneuvers.is_some(), "--most-maneuvers"),
            (self.minimal_s.is_some(), "--minimal-s"),
        ];
        if let Some((_, flag)) = limits.into_iter().find(|(given, _)| *given) {
            return Err(Failure::Usage(format!(
                "{flag}: found moments in a table, which is gone through without it, expected moments in a document; run `moments` \
                 without --table, or leave it out"
            )));
        }
        let table = MomentsTable::open(&self.moments, head, self.estimated())?;
        let found = solve_streamed(&table, &self.options(seed)).map_err(|e| match e {
            TableError::Table(error) => error.into(),
            TableError::Design(error) => {
                let dictionary = table.with(&[(0, 0)]).map_err(Failure::from).and_then(|moments| {
                    let dictionary = moments.dictionary(self.estimated());
                    dictionary.map_err(|e| Failure::invalid(&self.moments, &e))
                });
                match dictionary {
                    Ok(dictionary) => no_design(&self.moments, None, dictionary.explain(error)),
                    Err(failure) => failure,
                }
            }
        })?;
        Ok((table.with(&found.members)?, found))
    }
}

/// The design of `moments`: criterion, stock, shares, counts, order.
fn design(
    a: &Arguments,
    (seed, streamed): (u64, Option<Streamed>),
    moments: &Moments,
    provenance: &mut Provenance,
) -> Result<DesignDocument, Failure> {
    let problem = Problem::read(a, seed, moments, provenance)?;
    let (dictionary, criterion) = (&problem.of.dictionary, &problem.of.criterion);
    let refuse = |e| problem.refuse(dictionary.explain(e));
    let options = a.options(seed);
    let shortest = problem.shortest(&options)?;
    let length = match &shortest {
        Some((_, accuracy)) => Length { samples: Some(accuracy.samples as f64), segments: None },
        None => a.length(moments),
    };
    let available = match (&problem.of.stock, &a.available) {
        (Some(stock), Some(path)) => Some(stock.within(dictionary, &length).map_err(|e| scarce(path, e))?),
        _ => None,
    };
    let bounds = available.as_ref().map_or(Ok(Bounds::default()), |a| Bounds::new(&a.shares));
    let bounds = bounds.map_err(refuse)?;
    let (relaxed, accuracy) = match shortest {
        Some((design, accuracy)) => (design, Some(accuracy)),
        None => (criterion.solve(&bounds, &options).map_err(refuse)?, None),
    };
    let relaxed = match &streamed {
        // The same shares, with the certificate over all candidates.
        Some(Streamed { design, .. }) => Design { gap: design.gap, status: design.status, ..relaxed },
        None => relaxed,
    };
    let few = problem.few(&relaxed, &bounds, a.few_duration(dictionary, &length)?, &options)?;
    let restricted = few.as_ref().map(|(_, found)| &found.design);
    let design = restricted.unwrap_or(&relaxed);
    let count_options = CountOptions { random_starts: a.starts, seed, ..CountOptions::default() };
    let figures = problem.figures(design, &bounds, length.samples, &options)?;
    let sequence = problem.arranged(design, length.samples, provenance)?;
    let segments = length.segments.map(|(total, samples)| {
        let segments = Segments::within((total, samples), available.as_ref(), restricted);
        let whole = counted(criterion, design, &segments, &count_options, dictionary.parameters());
        whole.map(|whole| (segments, whole))
    });
    Ok(Solved {
        dictionary,
        name: problem.of.wish.name,
        criterion,
        estimated: problem.of.wish.estimated,
        design,
        available: available.as_ref(),
        segments: segments.transpose().map_err(refuse)?,
        samples: length.samples,
        restricted: few.as_ref().map(|(few, found)| (*few, found)),
        figures,
        accuracy: accuracy.as_ref(),
        sequence,
        streamed: streamed.as_ref(),
        moments,
    }
    .into())
}
