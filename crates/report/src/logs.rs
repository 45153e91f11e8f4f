use maud::{Markup, html};

use super::measured::Measured;
use super::missing::missing;
use super::number::{three, three_or_dash};
use study::documents::{ChannelSummary, IngestDocument, RecordingSummary, WarningSummary};

/// What was read from the logs: per recording its rows, the consistency of its velocities, and its channels.
pub(super) fn logs(measured: &Measured) -> Markup {
    html! {
        section #logs {
            h2 { "Logs" }
            @match &measured.ingest {
                None => (missing("The quality of the logs is", "ingest.json", "ingest")),
                Some(found) => {
                    p {
                        (found.recordings.len()) " recordings became " (found.runs) " runs, " (found.samples) " samples at "
                        (three(found.sample_rate_hz)) " Hz"
                        @if let Some(point) = &found.reference_point { "; reference point: " (point) }
                        "."
                    }
                    (recordings(found))
                    (warnings(found))
                    (motion(found))
                    h3 { "Channels" }
                    @for recording in &found.recordings { (channels(recording)) }
                    p.note { "Noise: robust standard deviation of what a parabola through 11 neighbouring samples leaves." }
                }
            }
        }
    }
}

fn recordings(found: &IngestDocument) -> Markup {
    html! {
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Recording" }
                @for title in ["Length [s]", "Samples", "Segments", "Too short", "Splits at gaps", "Rows", "Empty", "Cut", "Without, with repeated, with earlier time"] {
                    th.number scope="col" { (title) }
                }
            } }
            tbody { @for r in &found.recordings { tr {
                th scope="row" { (r.name) }
                td.number { (three(r.duration_s)) }
                @let rows = &r.rows;
                @for n in [r.samples, r.segments, r.short_segments, r.splits, rows.read, rows.empty, rows.cut] {
                    td.number { (n) }
                }
                td.number { (rows.without_time) ", " (rows.repeated) ", " (rows.backwards) }
            } } }
        } }
    }
}

/// What is odd about channels, with the recordings that it is so in.
fn warnings(found: &IngestDocument) -> Markup {
    let mut told: Vec<(&WarningSummary, Vec<&str>)> = Vec::new();
    for recording in &found.recordings {
        for warning in &recording.warnings {
            let same = |(known, _): &&mut (&WarningSummary, Vec<&str>)| {
                known.kind == warning.kind && known.channel == warning.channel
            };
            match told.iter_mut().find(same) {
                Some((_, recordings)) => recordings.push(&recording.name),
                None => told.push((warning, vec![&recording.name])),
            }
        }
    }
    html! { @if !told.is_empty() {
        h3 { "Warnings" }
        ul { @for (warning, recordings) in &told { li {
            (warning.text) " (" (recordings[0])
            @if recordings.len() > 1 { " and " (recordings.len() - 1) " more recordings" }
            ")"
        } } }
    } }
}

fn motion(found: &IngestDocument) -> Markup {
    if found.recordings.iter().all(|r| r.motion.is_empty()) {
        return html! {};
    }
    html! {
        h3 { "Logged velocities against position and heading" }
        div.scroll { table.compact {
            thead { tr {
                th scope="col" { "Recording" } th scope="col" { "State" }
                @for title in ["RMS difference", "Robust deviation", "Bias", "Lag [s]"] { th.number scope="col" { (title) } }
            } }
            tbody { @for r in &found.recordings {
                @for (i, m) in r.motion.iter().enumerate() { tr.first[i == 0] {
                    th scope="row" { @if i == 0 { (r.name) } }
                    td { (m.state) }
                    td.number { (three(m.rms)) } td.number { (three(m.robust_std)) }
                    td.number { (three(m.bias)) } td.number { (three_or_dash(m.lag_s)) }
                } }
            } }
        } }
        p.note { "In m/s; r in rad/s. A positive lag: the logged velocity comes after the motion." }
    }
}

fn channels(recording: &RecordingSummary) -> Markup {
    let row = |c: &ChannelSummary| {
        html! { tr {
            th scope="row" { (c.name) } td { (c.unit) }
            td.number { (three_or_dash(c.rate_hz)) } td.number { (c.missing) } td.number { (c.gaps) }
            td.number { (three_or_dash(c.noise)) } td.number { (three_or_dash(c.min)) } td.number { (three_or_dash(c.max)) }
        } }
    };
    html! {
        details {
            summary { (recording.name) }
            div.scroll { table.compact {
                thead { tr {
                    th scope="col" { "Channel" } th scope="col" { "Unit" }
                    @for title in ["Rate [Hz]", "Missing", "Gaps", "Noise", "Least", "Greatest"] { th.number scope="col" { (title) } }
                } }
                tbody { @for channel in &recording.channels { (row(channel)) } }
            } }
        }
    }
}
