//! `moments`: what each maneuver tells about the parameters.

use std::path::{Path, PathBuf};
use std::process::ExitCode;

use artifact::{commit, stage_document};
use clap::Parser;
use identification::moments;
use serde_json::json;
use stages::cli::{Common, Summary, name_of, provenance, run};
use stages::documents::{DegreeMoments, DegreeStructure, ManeuverMoments, MomentsDocument};
use stages::failure::Failure;
use stages::instruments::{InstrumentKind, Instruments};
use stages::ordered::ordered;
use stages::progress::Progress;
use stages::study_files::read_vessel;
use stages::trajectories::{Layout, Run, TrajectoryReader};
use vessel::{DegreeOfFreedom, Model, Vessel};

/// Computes the lifted moment matrices of every maneuver, M = mean of φ̃ζ̃ᵀ per degree of freedom
#[derive(Parser)]
#[command(
    name = "moments",
    version,
    after_help = "Example:\n  moments --vessel pipelines/paper/vessel.toml \
    --trajectories dictionary.parquet --out moments.json"
)]
struct Arguments {
    /// The vessel
    #[arg(long, value_name = "vessel.toml")]
    vessel: PathBuf,
    /// One run per maneuver
    #[arg(long, value_name = "dictionary.parquet")]
    trajectories: PathBuf,
    /// What the instruments are made of
    #[arg(long, value_enum, default_value_t = InstrumentKind::Nominal)]
    instruments: InstrumentKind,
    #[command(flatten)]
    common: Common,
}

fn main() -> ExitCode {
    run(|a: &Arguments| &a.common, stage)
}

fn stage(a: &Arguments) -> Result<Summary, Failure> {
    let mut provenance = provenance("moments");
    let vessel = read_vessel(&a.vessel, &mut provenance)?;
    let reader = TrajectoryReader::open(&a.trajectories, &Layout::new(&vessel.model), vessel.sample_rate_hz)?;
    reader.whole()?;
    provenance.inputs.insert("trajectories".into(), reader.digest());
    let kind = name_of(a.instruments);
    provenance.settings.insert("instruments".into(), json!(kind));
    let instruments = Instruments::new(&vessel, &a.vessel, a.instruments);
    let progress = Progress::new("blocks", reader.blocks(), a.common.quiet);
    let mut maneuvers: Vec<ManeuverMoments> = Vec::new();
    let work = |block: usize| {
        let found = maneuver_moments(&vessel, &a.trajectories, &instruments, &reader.runs(block)?);
        progress.advance(1);
        found
    };
    ordered(0..reader.blocks(), work, |found| {
        for maneuver in found {
            check_new(&a.trajectories, &maneuvers, &maneuver)?;
            maneuvers.push(maneuver);
        }
        Ok(())
    })?;
    let document = MomentsDocument {
        vessel: vessel.name.clone(),
        sample_rate_hz: vessel.sample_rate_hz,
        instruments: kind,
        degrees: structure(&vessel.model),
        maneuvers,
    };
    let out = a.common.main_output("moments.json", &[&a.vessel, &a.trajectories])?;
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

fn maneuver_moments(
    vessel: &Vessel,
    file: &Path,
    instruments: &Instruments,
    runs: &[Run],
) -> Result<Vec<ManeuverMoments>, Failure> {
    let most = vessel.model.degrees.iter().map(|d| d.terms.len() + 1).max().unwrap_or(0);
    let mut out = Vec::with_capacity(runs.len());
    instruments.batches(runs, |batch, members| {
        if batch.samples() < most {
            return Err(Failure::refuse(
                file,
                &format!("maneuver `{}`", members[0].segments[0].maneuver),
                &format!("{} samples", batch.samples()),
                &format!("at least {most}, the unknowns of a degree of freedom"),
                "lengthen the maneuver",
            ));
        }
        for (run, found) in members.iter().zip(moments(batch)) {
            out.push(document_of(run, found));
        }
        Ok(())
    })?;
    Ok(out)
}

fn document_of(run: &Run, found: identification::ManeuverMoments) -> ManeuverMoments {
    let degrees = DegreeOfFreedom::ALL.into_iter().zip(found.matrices).zip(found.nonstationarity);
    ManeuverMoments {
        name: run.segments[0].maneuver.clone(),
        samples: found.samples,
        degrees: degrees
            .map(|((d, m), nonstationarity)| DegreeMoments {
                name: d.name().to_owned(),
                shape: [m.len().isqrt() as u64; 2],
                m,
                nonstationarity,
            })
            .collect(),
    }
}

fn check_new(file: &Path, known: &[ManeuverMoments], new: &ManeuverMoments) -> Result<(), Failure> {
    if known.iter().any(|m| m.name == new.name) {
        return Err(Failure::refuse(
            file,
            &format!("maneuver `{}`", new.name),
            "two runs of it",
            "one run per maneuver",
            "name each maneuver once",
        ));
    }
    Ok(())
}
