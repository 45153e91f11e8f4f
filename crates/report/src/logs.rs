use maud::{Markup, display, html};

use super::measured::Measured;
use super::number::{three, three_or_dash};
use super::parts::{Section, missing};
use super::table::{Table, grouped};
use study::documents::{IngestDocument, RecordingSummary, WarningSummary};

/// The logs: per recording its rows, the consistency of its velocities, and its channels.
pub(super) fn logs(measured: &Measured) -> Section {
    let body = match &measured.ingest {
        None => missing("The quality of the logs is", "ingest.json", "ingest"),
        Some(found) => html! {
            p {
                (found.recordings.len()) " recordings became " (found.runs) " runs, " (found.samples) " samples at "
                (three(found.sample_rate_hz)) " Hz"
                @if let Some(point) = &found.reference_point { "; reference point: " (point) }
                "."
            }
            (recordings(found))
            (left_out(found))
            (warnings(found))
            (motion(found))
            h3 { "Channels" }
            @for recording in &found.recordings { (channels(recording)) }
            p.note { "Noise: robust standard deviation of what a parabola through 11 neighbouring samples leaves." }
        },
    };
    Section::new("logs", "Logs", "Logs", body)
}

fn recordings(found: &IngestDocument) -> Table<&RecordingSummary> {
    Table::of(&found.recordings)
        .compact()
        .name("Recording", |r| &r.name)
        .number("Length [s]", |r| three(r.duration_s))
        .number("Samples", |r| r.samples)
        .number("Segments", |r| r.segments)
        .number("Too short", |r| r.short_segments)
        .number("Splits at gaps", |r| r.splits)
        .number("Rows", |r| r.rows.read)
        .number("Empty", |r| r.rows.empty)
        .number("Cut", |r| r.rows.cut)
        .number("Without, with repeated, with earlier time", |r| {
            format!("{}, {}, {}", r.rows.without_time, r.rows.repeated, r.rows.backwards)
        })
}

/// Values that were omitted from all recordings, and recordings that are not used for estimates by default.
fn left_out(found: &IngestDocument) -> Markup {
    let omitted = found.omitted();
    let doubtful = || found.recordings.iter().filter(|recording| !recording.doubtful.is_empty());
    html! {
        @if !omitted.as_slice().is_empty() {
            h3 { "Values left out" }
            ul { @for one in omitted.as_slice() { li { (one.count) " of `" (one.channel) "` (" (display(one.reason)) ")" } } }
        }
        @if doubtful().next().is_some() {
            h3 { "Doubtful recordings" }
            ul { @for recording in doubtful() { li { (recording.name) ": " (recording.doubtful.join("; ")) } } }
        }
    }
}

/// Warnings about channels, with the recordings concerned.
fn warnings(found: &IngestDocument) -> Markup {
    let mut grouped: Vec<(&WarningSummary, Vec<&str>)> = Vec::new();
    for recording in &found.recordings {
        for warning in &recording.warnings {
            let same = |(known, _): &&mut (&WarningSummary, Vec<&str>)| {
                known.kind == warning.kind && known.channel == warning.channel
            };
            match grouped.iter_mut().find(same) {
                Some((_, recordings)) => recordings.push(&recording.name),
                None => grouped.push((warning, vec![&recording.name])),
            }
        }
    }
    html! { @if !grouped.is_empty() {
        h3 { "Warnings" }
        ul { @for (warning, recordings) in &grouped { li {
            (warning.text) " (" (recordings[0])
            @if recordings.len() > 1 { " and " (recordings.len() - 1) " more" }
            ")"
        } } }
    } }
}

fn motion(found: &IngestDocument) -> Markup {
    let states = grouped(&found.recordings, |r| &r.motion);
    if states.is_empty() {
        return html! {};
    }
    let table = Table::of(states)
        .compact()
        .mark("first", |(first, ..)| first)
        .name("Recording", |(first, r, _)| if first { r.name.as_str() } else { "" })
        .text("State", |(.., m)| display(m.state))
        .number("RMS difference", |(.., m)| three(m.rms))
        .number("Robust deviation", |(.., m)| three(m.robust_std))
        .number("Bias", |(.., m)| three(m.bias))
        .number("Lag [s]", |(.., m)| three_or_dash(m.lag_s));
    html! {
        h3 { "Logged velocities against position and heading" }
        (table)
        p.note { "In m/s; r in rad/s. A positive lag: the logged velocity comes after the motion." }
    }
}

fn channels(recording: &RecordingSummary) -> Markup {
    let table = Table::of(&recording.channels)
        .compact()
        .name("Channel", |c| &c.name)
        .text("Unit", |c| &c.unit)
        .number("Rate [Hz]", |c| three_or_dash(c.rate_hz))
        .number("Missing", |c| c.missing)
        .number("Gaps", |c| c.gaps)
        .number("Noise", |c| three_or_dash(c.noise))
        .number("Least", |c| three_or_dash(c.min))
        .number("Greatest", |c| three_or_dash(c.max));
    html! { details { summary { (recording.name) } (table) } }
}
