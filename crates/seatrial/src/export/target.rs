//! The targets of an export.

use refusal::Invalid;

use crate::export::Portable;

/// Another tool's language.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Target {
    /// One module of the standard library alone.
    Python,
    /// C99: a header, a source, a program that goes from CSV to CSV.
    C,
    /// One function file for MATLAB and Octave.
    Matlab,
    /// A Functional Mock-up Unit.
    Fmu,
}

impl Target {
    /// All of them.
    pub const ALL: [Self; 4] = [Self::Python, Self::C, Self::Matlab, Self::Fmu];

    /// As on the command line.
    pub fn name(self) -> &'static str {
        ["python", "c", "matlab", "fmu"][self as usize]
    }

    /// In a line.
    pub fn description(self) -> &'static str {
        [
            "A Python module; needs nothing but Python, takes numpy's arrays too",
            "C99: header, source, and a program from CSV to CSV",
            "A function file for MATLAB and Octave",
            "A Functional Mock-up Unit: FMI 2.0, co-simulation, with its C source",
        ][self as usize]
    }
}

/// A file's name and text.
pub(crate) type TextFile = (String, String);

impl Portable {
    /// The names of the files of `target`, the main file first.
    pub fn file_names(&self, target: Target) -> Vec<String> {
        match target {
            Target::Fmu => vec![format!("{}.fmu", self.base)],
            _ => self.texts(target).into_iter().map(|(name, _)| name).collect(),
        }
    }

    /// The contents of these files, in the same order; a unit contains the `library` built from its sources,
    /// if there is one.
    ///
    /// # Errors
    /// A unit that is too long for an archive.
    pub fn files(&self, target: Target, library: Option<Vec<u8>>) -> Result<Vec<Vec<u8>>, Invalid> {
        match target {
            Target::Fmu => Ok(vec![self.unit(library)?]),
            _ => Ok(self.texts(target).into_iter().map(|(_, text)| text.into_bytes()).collect()),
        }
    }

    fn texts(&self, target: Target) -> Vec<TextFile> {
        match target {
            Target::Python => vec![self.python()],
            Target::C => self.c(),
            Target::Matlab => vec![self.matlab()],
            Target::Fmu => self.unit_sources(),
        }
    }
}
