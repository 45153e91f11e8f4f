//! A campaign: many disturbed runs of the optimized and of the random design.

use std::collections::BTreeMap;
use std::collections::btree_map::Entry;
use std::path::Path;

use artifact::{EncodedBlock, Provenance, Shard, encode_block};
use design::apportion;
use vessel::{Generator, LANES, Realized, Streams, Vessel};

use super::sea::{Departures, Sea};
use super::{exogenous, publish, refuse_endless, writer};
use crate::failure::Failure;
use crate::ordered::ordered;
use crate::progress::Progress;
use study::campaign_file::CampaignFile;
use study::documents::{DesignDocument, Sequence};
use study::track::Track;
use study::trajectories::{BlockBuilder, Layout, NewRun, rows_per_block};
use vessel::lanes::lane_of;

/// Channel of the random stream that draws a random design's maneuvers.
pub(crate) const MANEUVER_CHANNEL: u32 = 100;

/// What happens in a run: maneuver and samples, one after the other.
pub(crate) type Plan = Vec<(usize, usize)>;

/// Everything that the runs of a campaign share.
pub struct Campaign<'a> {
    vessel: &'a Vessel,
    sea: Sea<'a>,
    samples: usize,
    realizations: u32,
    designs: Vec<Design>,
    /// Every maneuver at every length that occurs.
    realized: BTreeMap<(usize, usize), Realized>,
    names: Vec<String>,
}

struct Design {
    name: &'static str,
    streams: Streams,
    rule: Rule,
}

/// What the runs of a design do.
enum Rule {
    /// All the same.
    Fixed(Plan),
    /// One of `maneuvers` drawn for each of the lengths.
    Drawn { maneuvers: Vec<usize>, lengths: Vec<usize> },
}

impl Design {
    fn plan(&self, run: u32) -> Plan {
        match &self.rule {
            Rule::Fixed(plan) => plan.clone(),
            Rule::Drawn { maneuvers, lengths } => {
                let count = maneuvers.len() as u32;
                let drawn = self.streams.choices(run, MANEUVER_CHANNEL, count, lengths.len());
                drawn.iter().zip(lengths).map(|(q, n)| (maneuvers[*q as usize], *n)).collect()
            }
        }
    }
}

/// The files of a campaign, for messages.
pub struct CampaignFiles<'a> {
    /// `vessel.toml`.
    pub vessel: &'a Path,
    /// `dictionary.toml`.
    pub dictionary: &'a Path,
    /// `campaign.toml`.
    pub campaign: &'a Path,
    /// `design.json`.
    pub design: &'a Path,
}

impl<'a> Campaign<'a> {
    /// Plans every run.
    ///
    /// # Errors
    /// A design of other maneuvers, a run shorter than its segments, a maneuver that the model cannot hold.
    pub fn new(
        files: &CampaignFiles<'a>,
        vessel: &'a Vessel,
        generator: &Generator,
        config: &CampaignFile,
        design: &DesignDocument,
        seed: u64,
    ) -> Result<Self, Failure> {
        let sea = Sea::new(files.vessel, vessel, config)?;
        let samples = vessel.samples(config.duration_s);
        refuse_endless(files.campaign, "`duration_s`", samples)?;
        let names: Vec<String> = generator.maneuvers().iter().map(|m| m.name.clone()).collect();
        let runs = config.realizations;
        let optimized = optimized_plan(files, &names, design, samples)?;
        let mut designs = vec![Design {
            name: "optimized",
            streams: Streams::new(seed, "optimized"),
            rule: Rule::Fixed(optimized),
        }];
        if let Some(random) = config.random {
            if random.segments as usize > samples {
                return Err(too_short(files.campaign, samples, "random.segments"));
            }
            let even = vec![1.0 / f64::from(random.segments); random.segments as usize];
            let lengths: Vec<usize> = apportion(&even, samples as u64).iter().map(|n| *n as usize).collect();
            // Generated maneuvers that exceed their limits are in no design.
            let known = |q: &usize| generator.limits(*q).is_none() || design.shares.contains_key(&names[*q]);
            let rule = Rule::Drawn { maneuvers: (0..names.len()).filter(known).collect(), lengths };
            designs.push(Design { name: "random", streams: Streams::new(seed, "random"), rule });
        }
        let mut realized = BTreeMap::new();
        for (index, samples) in designs.iter().flat_map(|d| (0..runs).flat_map(|run| d.plan(run))) {
            if let Entry::Vacant(entry) = realized.entry((index, samples)) {
                let maneuver =
                    generator.realize(index, samples).map_err(|e| Failure::invalid(files.dictionary, &e))?;
                entry.insert(maneuver);
            }
        }
        Ok(Self { vessel, sea, samples, realizations: runs, designs, realized, names })
    }

    /// Number of runs of all designs.
    pub fn runs(&self) -> usize {
        self.designs.len() * self.realizations as usize
    }

    /// Samples per run.
    pub fn samples(&self) -> usize {
        self.samples
    }

    /// Repeats a planned trajectory's inputs, open loop, as design `planned`.
    ///
    /// # Errors
    /// A vessel without true parameters.
    pub fn planned(
        vessel_file: &'a Path,
        vessel: &'a Vessel,
        track: &Track,
        config: &CampaignFile,
        seed: u64,
    ) -> Result<Self, Failure> {
        let sea = Sea::new(vessel_file, vessel, config)?;
        let width = vessel.model.inputs;
        let samples = track.inputs.len() / width;
        let starts = track.stretches.iter().map(|(start, _)| *start);
        let ends = starts.clone().skip(1).chain([samples]);
        let plan: Plan = starts.zip(ends).enumerate().map(|(i, (start, end))| (i, end - start)).collect();
        let realized = plan.iter().zip(&track.stretches).map(|(part, (start, _))| {
            let inputs = track.inputs[start * width..(start + part.1) * width].to_vec();
            (*part, Realized { initial: track.initial, inputs })
        });
        Ok(Self {
            vessel,
            sea,
            samples,
            realizations: config.realizations,
            realized: realized.collect(),
            names: track.stretches.iter().map(|(_, name)| name.clone()).collect(),
            designs: vec![Design {
                name: "planned",
                streams: Streams::new(seed, "planned"),
                rule: Rule::Fixed(plan),
            }],
        })
    }

    /// Simulates the runs of `shard` (or all) into `out`.
    ///
    /// # Errors
    /// A simulation that diverges; output that fails.
    pub fn write(
        &self,
        out: &Path,
        provenance: &Provenance,
        shard: Option<Shard>,
        quiet: bool,
    ) -> Result<(), Failure> {
        let (layout, mut writer) = writer(out, self.vessel, provenance)?;
        let blocks = self.blocks();
        let mine = shard.map_or(0..blocks.len(), |s| s.range(blocks.len()));
        let progress = Progress::new("runs", blocks[mine.clone()].iter().map(|b| b.runs.len()).sum(), quiet);
        let work = |i: usize| {
            let block = self.block(&layout, &blocks[i]);
            progress.advance(blocks[i].runs.len());
            block
        };
        ordered(mine, work, |block| Ok(writer.push(block)?))?;
        publish(writer)
    }

    /// Runs of one design that are written together.
    fn blocks(&self) -> Vec<BlockOfRuns> {
        let size = rows_per_block(self.samples);
        let runs = self.realizations as usize;
        let of = |design: usize| {
            let part = move |b: usize| BlockOfRuns { design, runs: b * size..runs.min((b + 1) * size) };
            (0..runs.div_ceil(size)).map(part)
        };
        (0..self.designs.len()).flat_map(of).collect()
    }

    fn block(&self, layout: &Layout, block: &BlockOfRuns) -> Result<EncodedBlock, Failure> {
        let mut builder = BlockBuilder::new(layout, &self.names, self.vessel.sample_rate_hz);
        let runs: Vec<usize> = block.runs.clone().collect();
        for group in runs.chunks(LANES) {
            self.simulate_group(&self.designs[block.design], group, &mut builder)?;
        }
        Ok(encode_block(&layout.schema(), &builder.table())?)
    }

    fn simulate_group(
        &self,
        design: &Design,
        runs: &[usize],
        builder: &mut BlockBuilder,
    ) -> Result<(), Failure> {
        let plans: Vec<Plan> = runs.iter().map(|run| design.plan(*run as u32)).collect();
        let exogenous: Vec<Vec<f64>> = plans.iter().map(|plan| self.exogenous(plan)).collect();
        let numbers: Vec<u32> = runs.iter().map(|run| *run as u32).collect();
        let departures = Departures {
            design: design.name,
            streams: &design.streams,
            runs: &numbers,
            initial: plans.iter().map(|plan| self.realized[&plan[0]].initial).collect(),
            exogenous: exogenous.iter().map(Vec::as_slice).collect(),
        };
        let sailed = self.sea.sail(&departures)?;
        for (lane, run) in runs.iter().enumerate() {
            builder.push(&NewRun {
                design: design.name,
                run: *run as u32,
                segments: &segments(&plans[lane]),
                exogenous: &exogenous[lane],
                measured: &lane_of(&sailed.measured, lane),
                states: &lane_of(&sailed.states, lane),
            });
        }
        Ok(())
    }

    fn exogenous(&self, plan: &Plan) -> Vec<f64> {
        plan.iter().flat_map(|part| exogenous(&self.vessel.model, &self.realized[part].inputs)).collect()
    }
}

/// Runs `runs` of design `design`.
struct BlockOfRuns {
    design: usize,
    runs: std::ops::Range<usize>,
}

/// Maneuver and first sample of each part of a plan.
fn segments(plan: &Plan) -> Vec<(usize, usize)> {
    let mut start = 0;
    let begin = |(maneuver, samples): &(usize, usize)| {
        start += samples;
        (*maneuver, start - samples)
    };
    plan.iter().map(begin).collect()
}

/// The design's maneuvers, (place in `names`, samples) one after the other: in its own order, or in the dictionary's, each for
/// its share of the samples.
///
/// # Errors
/// A design of other maneuvers, or of another length.
pub fn optimized_plan(
    files: &CampaignFiles,
    names: &[String],
    design: &DesignDocument,
    samples: usize,
) -> Result<Plan, Failure> {
    if let Some(unknown) = design.shares.keys().find(|name| !names.contains(name)) {
        return Err(Failure::refuse(
            files.design,
            "`data.shares`",
            &format!("maneuver `{unknown}`"),
            &format!("maneuvers of {}", files.dictionary.display()),
            "make the design again from this dictionary",
        ));
    }
    check_shares(files.design, design)?;
    if let Some(sequence) = &design.sequence {
        return sequence_plan(files, names, sequence, samples);
    }
    let shares: Vec<f64> = names.iter().map(|name| design.shares.get(name).copied().unwrap_or(0.0)).collect();
    let counts = apportion(&shares, samples as u64);
    if samples == 0 {
        return Err(too_short(files.campaign, samples, "duration_s"));
    }
    Ok(counts.iter().enumerate().filter(|(_, n)| **n > 0).map(|(q, n)| (q, *n as usize)).collect())
}

/// The design's own order and lengths.
fn sequence_plan(
    files: &CampaignFiles,
    names: &[String],
    sequence: &Sequence,
    samples: usize,
) -> Result<Plan, Failure> {
    let refuse = |found: &str, expected: &str, remedy: &str| {
        Err(Failure::refuse(files.design, "`data.sequence`", found, expected, remedy))
    };
    let total: u64 = sequence.parts.iter().map(|part| part.samples).sum();
    if total != samples as u64 {
        return refuse(
            &format!("{total} samples"),
            &format!("the {samples} samples of `duration_s` in {}", files.campaign.display()),
            "arrange the design for this duration, or change `duration_s`",
        );
    }
    let mut plan = Plan::new();
    for part in &sequence.parts {
        match names.iter().position(|name| *name == part.maneuver) {
            Some(q) if part.samples > 0 => plan.push((q, part.samples as usize)),
            Some(_) => {
                return refuse(
                    &format!("`{}` without a sample", part.maneuver),
                    "at least one",
                    "arrange it again",
                );
            }
            None => {
                let expected = format!("maneuvers of {}", files.dictionary.display());
                return refuse(&format!("maneuver `{}`", part.maneuver), &expected, "arrange it again");
            }
        }
    }
    Ok(plan)
}

/// Refuses shares that are no shares.
fn check_shares(file: &Path, design: &DesignDocument) -> Result<(), Failure> {
    let refuse = |thing: &str, found: f64, expected: &str| {
        Err(Failure::refuse(file, thing, &found.to_string(), expected, "make the design again"))
    };
    if let Some((name, share)) = design.shares.iter().find(|(_, share)| !(0.0..=1.0).contains(*share)) {
        return refuse(&format!("`data.shares` of `{name}`"), *share, "a share from 0 to 1");
    }
    let sum = design.shares.values().fold(0.0, |sum, share| sum + share);
    if (sum - 1.0).abs() > 1e-6 { refuse("sum of `data.shares`", sum, "1") } else { Ok(()) }
}

fn too_short(file: &Path, samples: usize, key: &str) -> Failure {
    Failure::refuse(
        file,
        &format!("`{key}`"),
        &format!("runs of {samples} samples"),
        "at least one sample per segment",
        "lengthen `duration_s` or take fewer segments",
    )
}
