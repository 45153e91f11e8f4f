//! `new`: the hand-written files of a study.

use std::path::{Path, PathBuf};

use crate::pipeline::starting::{Charted, PRESETS, Preset, measured, of_ship, schemas, simulated};
use clap::Parser;
use files::{Staged, commit, whole_folder};
use serde_json::json;
use study::plan::second;

use crate::cli::{Common, folder_of};
use crate::failure::Failure;
use crate::stage::{Summary, Task};

/// Writes the commented files of a new study: of a ship that is known, or of your logs
#[derive(Parser)]
#[command(name = "new", after_help = help())]
pub struct Arguments {
    /// Folder of the study; made here
    #[arg(value_name = "FOLDER")]
    out: PathBuf,
    /// The ship to begin with: a preset, or a vessel.toml with forces as `guess` and `scale` write it
    #[arg(long, value_name = "PRESET|vessel.toml")]
    vessel: String,
    /// Folder of logs in CSV: what is in them is guessed, and what was guessed is marked
    #[arg(long, value_name = "FOLDER")]
    logs: Option<PathBuf>,
    /// A chart, or the folder of an exchange set: the trial is planned on it
    #[arg(long, value_name = "PATH", requires = "place")]
    chart: Option<PathBuf>,
    /// Where the trial is to be, such as 24.97,60.12
    #[arg(long, value_name = "LONGITUDE,LATITUDE", requires = "chart", allow_hyphen_values = true, value_parser = place)]
    place: Option<[f64; 2]>,
    /// When it may be, such as 2026-06-01T08:00:00Z/2026-06-01T18:00:00Z
    #[arg(long, value_name = "FROM/UNTIL", requires = "chart", value_parser = slot)]
    slot: Option<[String; 2]>,
}

/// Two times.
fn slot(text: &str) -> Result<[String; 2], String> {
    let expected = || {
        "expected FROM/UNTIL, the earlier time first, such as 2026-06-01T08:00:00Z/2026-06-01T18:00:00Z"
            .to_owned()
    };
    let (from, until) = text.split_once('/').ok_or_else(expected)?;
    let [at, end] = [from, until].map(|time| second("--slot", time));
    let is_in_order = at.and_then(|at| Ok(at < end?)).map_err(|_| expected())?;
    is_in_order.then(|| [from.to_owned(), until.to_owned()]).ok_or_else(expected)
}

/// A longitude and a latitude \[deg\].
fn place(text: &str) -> Result<[f64; 2], String> {
    let parts = text
        .split_once(',')
        .and_then(|(lon, lat)| Some([lon.trim().parse().ok()?, lat.trim().parse().ok()?]));
    parts.ok_or_else(|| "expected LONGITUDE,LATITUDE in degrees, such as 24.97,60.12".to_owned())
}

/// The presets and an example.
fn help() -> String {
    let presets = PRESETS.iter().map(|preset| format!("{}: {}\n", preset.name, preset.about));
    format!(
        "Presets:\n{}\nExample:\n  new my-study --vessel model-ship\n  new my-study --vessel guessed.toml",
        presets.collect::<String>()
    )
}

impl Task for Arguments {
    fn run(&self, common: &Common) -> Result<Summary, Failure> {
        let out = &common.out;
        let preset = || {
            Preset::named(&self.vessel)
                .map_err(|e| Failure::Usage(format!("--vessel: {e}, or a vessel.toml")))
        };
        let own = Some(Path::new(&self.vessel)).filter(|file| file.is_file());
        let with = |flag: &str| {
            let expected = "a preset with it; name the preset that the ship is most like";
            Failure::Usage(format!("--vessel: found a file together with {flag}, expected {expected}"))
        };
        if out.symlink_metadata().is_ok() {
            let found = "it there already";
            return Err(Failure::refuse(
                out,
                "folder",
                found,
                "a new folder",
                "name another, or run this one",
            ));
        }
        let slot = self.slot.as_ref();
        let charted =
            self.chart.as_deref().zip(self.place).map(|(file, place)| Charted { file, place, slot });
        let name = out.file_name().map_or(String::new(), |name| name.to_string_lossy().into_owned());
        let (files, said) = match (own, &self.logs) {
            (Some(_), Some(_)) => return Err(with("--logs")),
            (Some(_), None) if self.chart.is_some() => return Err(with("--chart")),
            (Some(file), None) => (of_ship(file, common.seed)?, String::new()),
            (None, None) => (simulated(preset()?, &name, charted.as_ref())?, String::new()),
            (None, Some(logs)) => {
                let (files, looked) = measured(preset()?, logs, charted.as_ref())?;
                let (guessed, missing) = (looked.guessed(), looked.missing().len());
                let half = looked.half_a_wind().map(|[channel, what]| {
                    format!("; `{channel}` is not used: no {what} of the wind was found")
                });
                let logs = looked.files.len();
                let said = format!("; {logs} logs, {guessed} lines guessed, {missing} channels missing");
                (files, said + &half.unwrap_or_default())
            }
        };
        let schemas = schemas();
        std::fs::create_dir_all(folder_of(out)).map_err(|e| files::Error::io(out, "create", e))?;
        let has_next = files.iter().any(|(name, _)| name.starts_with("next/"));
        let within: &[&str] = if has_next { &["schemas", "next"] } else { &["schemas"] };
        whole_folder(out, within, |folder| {
            // One by one: this process holds the folder, which a set would wait for.
            let mut all = files.iter().chain(&schemas);
            all.try_for_each(|(name, text)| commit(vec![Staged::bytes(folder.join(name), text.as_bytes())?]))
        })?;
        let names: Vec<&str> = files.iter().map(|(name, _)| name.as_str()).collect();
        let line = format!("{}{said}; next: seatrial run {}", names.join(", "), out.display());
        Ok(Summary::of(out, line, json!({"files": names})))
    }
}
