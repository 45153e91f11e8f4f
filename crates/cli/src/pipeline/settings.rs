//! `study.mk`: flags of a study's stages.

use std::collections::BTreeMap;
use std::path::Path;

use files::{Error, read_hand_written};
use refusal::{Invalid, foreign, nearest};

use study::invalid;

/// What a study may set.
const KNOWN: [&str; 19] = [
    "DICTIONARY",
    "MOMENTS_FLAGS",
    "DESIGN_FLAGS",
    "ESTIMATE_FLAGS",
    "PLAN_FLAGS",
    "MONTE_CARLO",
    "LENGTH_M",
    "LOGS",
    "POOL_FLAGS",
    "ESTIMATOR",
    "BOOTSTRAP",
    "CROSS_FLAGS",
    "TEST",
    "TEST_FLAGS",
    "SELECTION_FLAGS",
    "SELECTED",
    "NEXT",
    "SEARCH_FLAGS",
    "NEXT_FLAGS",
];

/// What a value may refer to, and what stands for it in the words of a [`crate::pipeline::Step`].
const REFERENCES: [(&str, &str); 5] = [
    ("$(STUDY)", "\0study"),
    ("$(DICTIONARY)", "\0dictionary"),
    ("$(LOGS)", "\0logs"),
    ("$(MEASURED)", "\0out/measured"),
    ("$(OUT)", "\0out"),
];

/// The settings of a study, by their names.
#[derive(Debug, Default)]
pub struct Settings(BTreeMap<String, String>);

impl Settings {
    /// Reads `study.mk` in the folder `study`; none if it is absent.
    ///
    /// # Errors
    /// A file that cannot be read; a line that is no setting, a setting that no stage has, a reference that only make resolves.
    pub fn read(study: &Path) -> Result<Self, Error> {
        let file = study.join("study.mk");
        let mut settings = Self::default();
        if !file.exists() {
            return Ok(settings);
        }
        // A line that ends with a backslash goes on in the next one.
        let text = read_hand_written(&file)?.replace("\\\n", " ");
        for line in text.lines() {
            settings.take(line).map_err(|wrong| invalid(&file, &wrong))?;
        }
        Ok(settings)
    }

    /// Sets what `given` says, as a line of study.mk would at its end: `NAME=VALUE`.
    ///
    /// # Errors
    /// As of such a line.
    pub fn set(&mut self, given: &str) -> Result<(), Invalid> {
        let (name, value) = given.split_once('=').ok_or_else(|| not_a_setting(given))?;
        self.put(name.trim(), None, value)
    }

    /// The value of `name`, empty if it is not set.
    pub fn get(&self, name: &str) -> &str {
        self.0.get(name).map_or("", String::as_str)
    }

    /// The value of `name`, or `usual` if it is not set.
    pub fn or<'a>(&'a self, name: &str, usual: &'a str) -> &'a str {
        self.0.get(name).map_or(usual, String::as_str)
    }

    /// These settings with sub-experiments designed, picked and compared, as studies on simulated logs have them.
    #[must_use]
    pub fn selecting(&self) -> Self {
        let mut settings = self.0.clone();
        settings.insert("SELECTED".to_owned(), "yes".to_owned());
        Self(settings)
    }

    fn take(&mut self, line: &str) -> Result<(), Invalid> {
        let line = line.split('#').next().unwrap_or_default().trim();
        // The kind of a study is known by its files: what make includes for it says nothing more.
        let included = line.strip_prefix("include ").map(str::trim);
        if line.is_empty() || matches!(included, Some("pipelines/measured.mk" | "pipelines/simulated.mk")) {
            return Ok(());
        }
        let (name, value) = line.split_once('=').ok_or_else(|| not_a_setting(line))?;
        let kind = name.chars().next_back().filter(|last| [':', '?', '+'].contains(last));
        self.put(name.trim_end_matches([':', '?', '+']).trim(), kind, value)
    }

    /// Sets `name` to `value`: `kind` `?` only if it is not set, `+` behind what it is set to.
    fn put(&mut self, name: &str, kind: Option<char>, value: &str) -> Result<(), Invalid> {
        if !KNOWN.contains(&name) {
            let meant = nearest(name, KNOWN).map_or(String::new(), |near| format!(" (did you mean {near}?)"));
            let remedy = format!("correct or remove it{meant}");
            return Err(Invalid::new(
                format!("`{}`", foreign(name)),
                "a setting of no stage",
                KNOWN.join(", "),
                remedy,
            ));
        }
        if value.contains('\0') {
            return Err(Invalid::new(format!("`{name}`"), "a byte 0", "text", "remove it"));
        }
        let value = resolved(name, value.trim())?;
        let known = self.0.get(name).cloned();
        let value = match (kind, known) {
            (Some('?'), Some(known)) => known,
            (Some('+'), Some(known)) => format!("{known} {value}"),
            _ => value,
        };
        self.0.insert(name.to_owned(), value);
        Ok(())
    }
}

fn not_a_setting(line: &str) -> Invalid {
    let expected = "settings such as `DESIGN_FLAGS = --minimal-s 60`, and comments";
    Invalid::new("line", format!("`{}`", foreign(line)), expected, "correct or remove it")
}

/// `value` without references to other settings.
fn resolved(name: &str, value: &str) -> Result<String, Invalid> {
    let value = REFERENCES.iter().fold(value.to_owned(), |value, (from, to)| value.replace(from, to));
    if !value.contains('$') {
        return Ok(value);
    }
    let known = REFERENCES.map(|(name, _)| name).join(", ");
    let remedy = "write the value out";
    Err(Invalid::new(format!("`{name}`"), format!("`{}`", foreign(&value)), known, remedy))
}
