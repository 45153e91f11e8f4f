//! A new study: the hand-written files that it begins with, from a ship that is known, and from logs.

mod bags;
mod chart;
mod ingest;
mod looking;
mod next;
mod own;
mod presets;
mod reading;
mod sentences;
mod table;
mod text;

use std::path::Path;

use files::Error;
use study::files as hand_written;

pub use chart::Charted;
pub use looking::{Found, Looked};
pub use own::of_ship;

pub use presets::{PRESETS, Preset};

/// A hand-written file of a new study: its name and its text.
pub type NewFile = (String, String);

/// The files of the study `name` of `preset` that is simulated, and with a chart planned on it.
///
/// # Errors
/// A ship that sails on no chart; a chart that cannot be read, or has no water for the trial.
pub fn simulated(preset: &Preset, name: &str, charted: Option<&Charted>) -> Result<Vec<NewFile>, Error> {
    let own = |(name, text): (&str, &str)| (name.to_owned(), text.to_owned());
    let mut files: Vec<NewFile> = preset.files().map(own).collect();
    if let Some(charted) = charted {
        let template = preset.plan().map_err(|why| Error::invalid(charted.file, why))?;
        files.push(("plan.toml".to_owned(), chart::planned(charted, name, template)?));
    }
    Ok(files.into_iter().map(with_schema).collect())
}

/// The files of a study of `preset` with the logs in the folder `logs`, and what was found there. On a chart its next trial is planned.
///
/// # Errors
/// A folder without logs, or with those of several ships; a log whose columns cannot be read; a chart as of [`simulated`].
pub fn measured(
    preset: &Preset,
    logs: &Path,
    charted: Option<&Charted>,
) -> Result<(Vec<NewFile>, Looked), Error> {
    let mut looked = Looked::at(logs, &preset.needed())?;
    let is_wind_logged = looked.take_wind();
    let mut files = vec![
        ("vessel.toml".to_owned(), preset.without_truth(is_wind_logged)),
        ("ingest.toml".to_owned(), ingest::written(&looked, preset)),
        ("study.mk".to_owned(), ingest::flags(&looked, preset)),
    ];
    files.extend(next::trial(preset, charted)?);
    Ok((files.into_iter().map(with_schema).collect(), looked))
}

/// The JSON Schemas of all hand-written files, which editors check them by.
pub fn schemas() -> Vec<NewFile> {
    let all = hand_written::schemas().into_iter();
    let file = |kind| format!("schemas/{}", hand_written::file_name(kind));
    all.map(|(kind, schema)| (file(kind), format!("{schema:#}\n"))).collect()
}

/// A file with the line that editors find its schema by.
fn with_schema((name, text): NewFile) -> NewFile {
    let (up, own) = name.rsplit_once('/').map_or(("", name.as_str()), |(_, own)| ("../", own));
    match hand_written::kind_of(own) {
        None => (name, text),
        Some(kind) => {
            let text = format!("#:schema {up}schemas/{}\n{text}", hand_written::file_name(kind));
            (name, text)
        }
    }
}
