//! Logs of sentences (NMEA 0183) in a folder: what the first of them has, as a group of files of `ingest.toml`.

use std::fmt::Write;
use std::io::Read;
use std::path::Path;

use files::Error;
use logs::guess::{Needed, Placed, SentenceGuess};
use logs::{Format, has_sentences, sentence_census};
use refusal::listed;
use study::ingest_file::read::check_format;
use study::refuse;

use super::bags::{MARK, channel, quoted, reader, wrong};

/// Endings of logs of sentences.
pub(super) const SENTENCES: [&str; 2] = [".nmea", ".nmea.gz"];

/// Endings of files in which there may be sentences.
pub(super) const PERHAPS: [&str; 4] = [".log", ".txt", ".log.gz", ".txt.gz"];

/// Bytes of a file that are looked at for a sentence.
const LOOKED: u64 = 1 << 14;

/// Whether the file at `path` begins with sentences.
pub(super) fn is_of_sentences(path: &Path) -> bool {
    let mut bytes = Vec::new();
    let read = reader(path).map(|file| file.take(LOOKED).read_to_end(&mut bytes));
    // Damage is reported when the file is ingested.
    read.is_ok() && has_sentences(&String::from_utf8_lossy(&bytes))
}

/// What is in the log at `path`, for a model that needs the channels `needed`.
///
/// # Errors
/// A file that cannot be read; one without a sentence with a time, or without a field from which the motion follows.
pub(super) fn guessed(path: &Path, needed: &[Needed]) -> Result<SentenceGuess, Error> {
    check_format(path, Format::Nmea, true)?;
    let spoken = sentence_census(reader(path)?).map_err(|error| wrong(path, error))?;
    let remedy = "write ingest.toml yourself (docs/own-logs.md)";
    let Some(guess) = SentenceGuess::of(&spoken, needed) else {
        let expected = "sentences with a time: RMC, ZDA, GGA, GNS or GLL";
        let remedy = "write ingest.toml yourself, with the `format` of stamps (docs/own-logs.md)";
        return Err(refuse(path, "time", "none", expected, remedy));
    };
    match guess.placed.is_empty() {
        false => Ok(guess),
        true => {
            let found = format!("none among {}", listed(&guess.unused));
            Err(refuse(path, "field", &found, "one of a motion, such as GGA.latitude or HDT.heading", remedy))
        }
    }
}

/// The group of files of `ingest.toml`.
pub(super) fn group(guess: &SentenceGuess, patterns: &[String]) -> String {
    let listed = |all: &[String]| all.iter().map(|own| quoted(own)).collect::<Vec<_>>().join(", ");
    let mut text = format!("\n[[file]]\npattern = [{}]\n", listed(patterns));
    if !patterns.iter().all(|pattern| SENTENCES.iter().any(|end| pattern.to_lowercase().ends_with(end))) {
        text += "format = \"nmea\"\n";
    }
    let spread = if guess.is_spread { ", repeated = \"spread\"" } else { "" };
    let why = if guess.is_spread { ", and are spread until the next one" } else { "" };
    let _ = writeln!(text, "# Sentences without a time have that of the last {}{why}.", guess.clock);
    let _ = writeln!(text, "time = {{ column = {}{spread} }}{MARK}", quoted(guess.clock));
    if guess.is_unchecked {
        let _ = writeln!(text, "checksums = \"optional\"{MARK}: most sentences have none");
    }
    if !guess.prefer.is_empty() {
        let _ = writeln!(
            text,
            "prefer = [{}]{MARK}: the talkers that say most come first",
            listed(&guess.prefer)
        );
    }
    let line = |placed: &Placed| {
        let mark = if placed.is_channel_guessed {
            format!("{MARK}: by the kind of sentence")
        } else {
            String::new()
        };
        format!("    {},{mark}\n", channel(placed))
    };
    let _ = writeln!(text, "channel = [\n{}]", guess.placed.iter().map(line).collect::<String>());
    if !guess.unused.is_empty() {
        let _ = writeln!(text, "\n# Fields that are not used: {}", listed(&guess.unused));
    }
    text
}
