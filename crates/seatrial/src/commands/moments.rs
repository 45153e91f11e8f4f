//! `moments`: what each maneuver tells about the parameters.

use std::path::{Path, PathBuf};

use crate::choice::choice;
use crate::cli::{Common, provenance};
use crate::design::{NoiseModel, OutputErrorNoise, ParameterDraw, Predicted, SimulateWith};
use crate::failure::Failure;
use crate::instruments::{InstrumentKind, Instruments};
use crate::ordered::ordered;
use crate::pooled::{Data, Nominal, NominalModel, PoolFlags};
use crate::progress::Progress;
use crate::stage::{Summary, Task};
use artifact::{Provenance, commit, stage_document};
use clap::Parser;
use identification::pooled::Regression;
use identification::{MeanRemoval, Sums, middle, moments};
use serde_json::json;
use study::documents::{
    DegreeMoments, DegreeStructure, ManeuverMoments, MomentsDocument, OutputErrorMoments,
};
use study::files::read_vessel;
use study::trajectories::{Layout, TrajectoryReader, label};
use vessel::{DegreeOfFreedom, Model, Vessel};
use vessel::{Run, Segment};

/// Computes the lifted moment matrices of every maneuver, M = mean of φ̃ζ̃ᵀ per degree of freedom
#[derive(Parser)]
#[command(
    name = "moments",
    version,
    after_help = "Example:\n  moments --vessel pipelines/paper/vessel.toml \
    --trajectories dictionary.parquet --out moments.json\n  \
    moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --out moments.json\n  \
    moments --vessel vessel.toml --trajectories dictionary.parquet --campaign campaign.toml --estimator output-error --out moments.json"
)]
pub struct Arguments {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// One run per maneuver; of measured runs the segments are pooled by maneuver, instruments start anew with each
    #[arg(long, value_name = "dictionary.parquet")]
    trajectories: PathBuf,
    /// The nominal model that instruments are simulated with: `given` in vessel.toml, `least-squares` (the fit of the same
    /// data), or a previous estimate.json
    #[arg(long, value_name = "given|least-squares|FILE")]
    nominal: Option<Nominal>,
    /// What the instruments are made of
    #[arg(long, value_parser = choice(&InstrumentKind::ALL, InstrumentKind::name, InstrumentKind::description), default_value_t = InstrumentKind::Nominal)]
    instruments: InstrumentKind,
    /// The disturbances to expect: adds the matrices B that the estimate's covariance is made of
    #[arg(long, value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The estimator to predict besides: `output-error` adds the matrices F and P, and G of the campaign's validation maneuvers
    #[arg(long, value_enum, default_value_t = Predicted::Iv, requires = "campaign")]
    estimator: Predicted,
    /// Which parameters the free simulations of `output-error` have (default: the true ones where the vessel has them)
    #[arg(long, value_enum, value_name = "value|nominal")]
    simulate_with: Option<SimulateWith>,
    /// Draws these parameters instead, number K of the seed: each is scaled by a normal number about 1
    #[arg(long, value_name = "K", requires = "spread")]
    draw: Option<u32>,
    /// Standard deviation of a drawn parameter, relative to it
    #[arg(long, value_name = "SHARE", requires = "draw")]
    spread: Option<f64>,
    #[command(flatten)]
    common: Common,
}

/// Name of the design of a dictionary's runs.
const DICTIONARY: &str = "dictionary";

impl Task for Arguments {
    fn common(&self) -> &Common {
        &self.common
    }

    fn run(&self) -> Result<Summary, Failure> {
        stage(self)
    }
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    let mut provenance = provenance("moments");
    let mut vessel = read_vessel(&a.vessel, &mut provenance)?;
    if let Some(nominal) = &a.nominal {
        vessel.nominal = nominal_of(a, nominal, &vessel, &mut provenance)?;
    }
    let reader = TrajectoryReader::open(&a.trajectories, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    reader.whole()?;
    provenance.inputs.insert("trajectories".into(), reader.digest());
    if reader.blocks() > 0 {
        label(reader.runs(0)?.iter().map(|run| run.design.as_str()), &mut provenance);
    }
    let kind = a.instruments.name().to_owned();
    let noise = match &a.campaign {
        Some(campaign) => Some(NoiseModel::read(campaign, &vessel, a.instruments, &mut provenance)?),
        None => None,
    };
    provenance.settings.insert("instruments".into(), json!(kind));
    let output_error = match (a.estimator, &noise, &a.campaign) {
        (Predicted::OutputError, Some(noise), Some(campaign)) => {
            let seed = a.common.seed.unwrap_or(1);
            let draw = a.draw.zip(a.spread).map(|(number, spread)| ParameterDraw { number, spread, seed });
            let files = [a.vessel.as_path(), campaign, &a.trajectories];
            Some(OutputErrorNoise::new(files, &vessel, noise.noise, a.simulate_with, draw, &mut provenance)?)
        }
        _ => None,
    };
    let instruments = Instruments::new(&vessel, &a.vessel, a.instruments);
    let progress = Progress::new("blocks", reader.blocks(), a.common.quiet);
    let mut maneuvers: Vec<ManeuverMoments> = Vec::new();
    let work = |block: usize| {
        let found = maneuver_moments(
            &vessel,
            &instruments,
            noise.as_ref(),
            output_error.as_ref(),
            &reader.runs(block)?,
        );
        progress.advance(1);
        found
    };
    ordered(0..reader.blocks(), work, |found| {
        for (pooled, maneuver) in found {
            match maneuvers.iter_mut().find(|m| m.name == maneuver.name) {
                None => maneuvers.push(maneuver),
                Some(known) if pooled => pool(known, &maneuver),
                Some(_) => return Err(twice(&a.trajectories, &maneuver.name)),
            }
        }
        Ok(())
    })?;
    let short = maneuvers.iter().find(|m| (m.samples as usize) < unknowns(&vessel.model));
    if let Some(short) = short {
        return Err(too_short(&a.trajectories, &short.name, short.samples, unknowns(&vessel.model)));
    }
    let document = MomentsDocument {
        vessel: vessel.name.clone(),
        sample_rate_hz: vessel.sample_rate_hz,
        instruments: kind,
        degrees: structure(&vessel.model),
        maneuvers,
        disturbances: noise.map(|noise| noise.document(&vessel)),
        output_error: output_error.map(|o| o.document()),
    };
    let inputs: Vec<&Path> =
        [&a.vessel, &a.trajectories].into_iter().chain(&a.campaign).map(PathBuf::as_path).collect();
    let out = a.common.main_output("moments.json", &inputs)?;
    commit(vec![stage_document(&out, &provenance, &document)?])?;
    let count = document.maneuvers.len();
    Ok(Summary {
        line: format!("{}: moments of {count} maneuvers", out.display()),
        json: json!({"out": out, "maneuvers": count}),
    })
}

fn structure(model: &Model) -> Vec<DegreeStructure> {
    let of = |(d, degree): (DegreeOfFreedom, &vessel::Degree)| DegreeStructure {
        name: d.name().to_owned(),
        regressors: degree.terms.iter().map(|t| t.text.clone()).chain(["1".to_owned()]).collect(),
        parameters: degree.parameters.clone(),
    };
    DegreeOfFreedom::ALL.into_iter().zip(&model.degrees).map(of).collect()
}

/// Unknowns of the largest degree of freedom.
fn unknowns(model: &Model) -> usize {
    model.degrees.iter().map(|d| d.terms.len() + 1).max().unwrap_or(0)
}

fn too_short(file: &Path, maneuver: &str, samples: u64, most: usize) -> Failure {
    Failure::refuse(
        file,
        &format!("maneuver `{maneuver}`"),
        &format!("{samples} samples"),
        &format!("at least {most}, the unknowns of a degree of freedom"),
        "lengthen the maneuver",
    )
}

/// The moments of every maneuver in `runs`, and whether they may be pooled with others of the same name: those of measured
/// runs, segment by segment, but not those of a dictionary, where a name stands for one run.
fn maneuver_moments(
    vessel: &Vessel,
    instruments: &Instruments,
    noise: Option<&NoiseModel>,
    output_error: Option<&OutputErrorNoise>,
    runs: &[Run],
) -> Result<Vec<(bool, ManeuverMoments)>, Failure> {
    let parts: Vec<Run> = runs.iter().flat_map(|run| segments(run, vessel.model.exogenous())).collect();
    let mut out = Vec::with_capacity(parts.len());
    instruments.batches(&parts, |batch, members| {
        let mut middles = noise.map(|n| middle(batch, &n.parameters, &n.noise).into_iter());
        for (run, found) in members.iter().zip(moments(batch)) {
            let middle = middles.as_mut().and_then(Iterator::next);
            let output_error = output_error.map(|o| o.moments(run)).transpose()?;
            out.push((run.design != DICTIONARY, document_of(run, found, middle, output_error)));
        }
        Ok(())
    })?;
    Ok(out)
}

/// A measured run as one run per segment, each from its first measured state; a run of a dictionary as it is.
fn segments(run: &Run, width: usize) -> Vec<Run> {
    if run.design == DICTIONARY || run.segments.len() < 2 {
        return vec![run.clone()];
    }
    let ends = run.segments.iter().skip(1).map(|s| s.start).chain([run.samples()]);
    let part = |(segment, end): (&Segment, usize)| {
        let measured = run.measured[3 * segment.start..3 * (end + 1)].to_vec();
        let initial = if segment.start == 0 { run.initial } else { [0, 1, 2].map(|d| measured[d]) };
        Run {
            design: run.design.clone(),
            run: run.run,
            segments: vec![Segment { maneuver: segment.maneuver.clone(), start: 0 }],
            exogenous: run.exogenous[segment.start * width..end * width].to_vec(),
            measured,
            initial,
        }
    };
    run.segments.iter().zip(ends).map(part).collect()
}

/// Adds the moments of more samples of the same maneuver.
fn pool(known: &mut ManeuverMoments, more: &ManeuverMoments) {
    let samples = known.samples + more.samples;
    let share = more.samples as f64 / samples.max(1) as f64;
    for (own, other) in known.degrees.iter_mut().zip(&more.degrees) {
        own.m.iter_mut().zip(&other.m).for_each(|(m, o)| *m += share * (o - *m));
        if let (Some(own), Some(other)) = (&mut own.b, &other.b) {
            own.iter_mut().zip(other).for_each(|(b, o)| *b += share * (o - *b));
        }
        own.nonstationarity = own.nonstationarity.max(other.nonstationarity);
    }
    if let (Some(own), Some(other)) = (&mut known.output_error, &more.output_error) {
        let pairs = [
            (Some(&mut own.f), Some(&other.f)),
            (own.e.as_mut(), other.e.as_ref()),
            (own.p.as_mut(), other.p.as_ref()),
        ];
        for (own, other) in pairs.into_iter().filter_map(|(own, other)| own.zip(other)) {
            own.iter_mut().zip(other).for_each(|(f, o)| *f += share * (o - *f));
        }
    }
    known.samples = samples;
}

/// The nominal parameters that `--nominal` asks for, without intercepts.
fn nominal_of(
    a: &Arguments,
    nominal: &Nominal,
    vessel: &Vessel,
    provenance: &mut Provenance,
) -> Result<Vec<f64>, Failure> {
    let model = NominalModel::read(nominal, vessel, provenance)?;
    let data = Data::read(&a.trajectories, vessel, &PoolFlags::default(), provenance)?;
    let sums: Vec<Sums> =
        data.parts(vessel).iter().map(|p| Regression::of(&vessel.model, p).sums()).collect();
    let found = model.parameters(&sums.iter().collect::<Vec<_>>(), MeanRemoval::None);
    found.map(|(theta, _)| theta).ok_or_else(|| {
        Failure::NoAnswer(format!(
            "{}: nominal model: found data that identify no least-squares model, expected all terms to vary; name another \
             --nominal",
            a.trajectories.display()
        ))
    })
}

fn document_of(
    run: &Run,
    found: identification::ManeuverMoments,
    middle: Option<Vec<Vec<f64>>>,
    output_error: Option<OutputErrorMoments>,
) -> ManeuverMoments {
    let degrees = DegreeOfFreedom::ALL.into_iter().zip(found.matrices).zip(found.nonstationarity);
    let mut middle = middle.into_iter().flatten();
    ManeuverMoments {
        name: run.segments[0].maneuver.clone(),
        samples: found.samples,
        output_error,
        degrees: degrees
            .map(|((d, m), nonstationarity)| DegreeMoments {
                name: d.name().to_owned(),
                shape: [m.len().isqrt() as u64; 2],
                m,
                nonstationarity,
                b: middle.next(),
            })
            .collect(),
    }
}

fn twice(file: &Path, name: &str) -> Failure {
    let (found, expected) = ("two runs of it", "one run per maneuver");
    Failure::refuse(file, &format!("maneuver `{name}`"), found, expected, "name each maneuver once")
}
