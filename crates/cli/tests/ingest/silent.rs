//! A healthy log with one fault: the result must be right, or the fault refused or counted by name.
//!
//! Each kind of fault is tried 25 times; SEATRIAL_CASES=1000 tries it more often, SEATRIAL_CASE=7:12 tries case 12 of kind 7
//! alone, keeps its folder and prints where it is.
#![allow(dead_code)]

use std::fs;
use std::num::NonZeroUsize;
use std::ops::Range;
use std::path::Path;
use std::sync::Mutex;
use std::sync::atomic::{AtomicU64, Ordering};

use study::documents::RecordingSummary;

pub use crate::draw::Draw;
use crate::known;
use crate::runner::{Made, Ran, made, run};

/// The outcome of a log.
#[derive(Debug)]
pub enum Verdict {
    /// All rows, with the known motion.
    Healthy,
    /// Refused in one line, this one; nothing written.
    Refused(String),
    /// Rows are missing or off, and these counts and warnings name why.
    Counted(Vec<String>),
    /// Rows are missing or off, or the program ended badly, and nothing says so.
    Silent(String),
}

/// A healthy log with a fault.
pub struct Faulty {
    /// Names and contents of the files, `ingest.toml` among them.
    pub files: Vec<(String, Vec<u8>)>,
    /// Rows that the log has without the fault.
    pub rows: usize,
    /// Words, one of which the count or warning has that names the fault.
    pub named: &'static [&'static str],
    /// What the fault is, for messages.
    pub what: String,
}

impl Faulty {
    /// A log called `name` that `config` reads.
    pub fn new(config: &str, name: &str, log: impl Into<Vec<u8>>, rows: usize) -> Self {
        let files = vec![("ingest.toml".to_owned(), config.into()), (name.to_owned(), log.into())];
        Self { files, rows, named: &[], what: String::new() }
    }

    /// The counts that name it.
    #[must_use]
    pub fn named(self, named: &'static [&'static str]) -> Self {
        Self { named, ..self }
    }

    /// What it is.
    #[must_use]
    pub fn what(self, what: impl Into<String>) -> Self {
        Self { what: what.into(), ..self }
    }

    /// Writes its files and judges the result of `ingest`.
    fn judged(&self, folder: &Path) -> Verdict {
        for (name, bytes) in &self.files {
            let path = folder.join(name);
            fs::create_dir_all(path.parent().unwrap()).unwrap();
            fs::write(path, bytes).unwrap();
        }
        verdict(folder, self.rows, self.named)
    }
}

/// The outcome of `ingest` on the logs in `folder`, which would be `rows` rows of the known motion; otherwise a count
/// or a warning must have one of the words `named`.
pub fn verdict(folder: &Path, rows: usize, named: &[&str]) -> Verdict {
    let out = tempfile::tempdir().unwrap();
    let target = out.path().join("trajectories.parquet");
    let ran = run(folder, &["--config", "ingest.toml", "--out", target.to_str().unwrap()]);
    match ran.code {
        Some(0) => of_made(&made(&target, ran.stdout), rows, named),
        Some(3) => of_refused(ran, target.exists()),
        _ => Verdict::Silent(format!("ended with {:?}: {}{}", ran.code, ran.stdout, ran.stderr)),
    }
}

fn of_refused(ran: Ran, wrote: bool) -> Verdict {
    let line = ran.stderr.trim_end().rsplit('\n').next().unwrap_or_default().to_owned();
    let parts = ["error: ", ": found ", ", expected ", "; "].iter().all(|part| line.contains(part));
    // Paths of temporary folders are extra.
    match parts && !wrote && line.chars().count() <= 600 && !line.contains("panicked") {
        true => Verdict::Refused(line),
        false => Verdict::Silent(format!("no good refusal: {}", ran.stderr)),
    }
}

fn of_made(made: &Made, rows: usize, named: &[&str]) -> Verdict {
    let off = off(made, rows);
    if off.is_none() && made.rows == rows && made.summary.runs == 1 {
        return Verdict::Healthy;
    }
    let said: Vec<String> = made.summary.recordings.iter().flat_map(said).collect();
    let naming = said.iter().filter(|said| named.iter().any(|name| said.contains(name)));
    let naming: Vec<String> = naming.cloned().collect();
    if !naming.is_empty() {
        return Verdict::Counted(naming);
    }
    let off = off.unwrap_or("within the bounds".to_owned());
    Verdict::Silent(format!("{} rows of {rows}, {off}; said {said:?}: {}", made.rows, made.line))
}

/// Everything that ingest.json counts or warns of, such as `psi quality 3`, `rows wrong_checksums 2`, `splits 1`.
pub fn said(recording: &RecordingSummary) -> Vec<String> {
    let omitted = recording.omitted.iter().map(|o| format!("{} {} {}", o.channel, o.reason, o.count));
    let warnings = recording.warnings.iter().map(|warning| warning.text.clone());
    let rows = serde_json::to_value(recording.rows).unwrap();
    let rows = rows.as_object().unwrap().clone().into_iter();
    let rows = rows.filter(|(name, count)| name != "read" && count.as_u64() != Some(0));
    let rows = rows.map(|(name, count)| format!("rows {name} {count}"));
    let splits = (recording.splits > 0).then(|| format!("splits {}", recording.splits));
    let channels = recording.channels.iter().filter(|channel| channel.missing > 0);
    let missing =
        channels.map(|channel| format!("{} has no value in {} rows", channel.name, channel.missing));
    omitted.chain(warnings).chain(rows).chain(splits).chain(missing).collect()
}

/// Tolerances of the states, the heading and the inputs: m/s, m/s, rad/s, rad, rad, 1/s.
const BOUNDS: [(&str, f64); 6] =
    [("y_u", 0.02), ("y_v", 0.02), ("y_r", 0.002), ("psi", 0.01), ("delta", 0.01), ("n", 0.05)];

/// What column `name` is at `t` \[s\].
fn truth(name: &str, t: f64) -> f64 {
    match name {
        "y_u" => known::motion(t)[0],
        "y_v" => known::motion(t)[1],
        "y_r" => known::motion(t)[2],
        "psi" => known::heading(t),
        "delta" => known::rudder(t).to_radians(),
        _ => known::revolutions(t) / 60.0,
    }
}

/// The deviations beyond the tolerances: each run may begin at any whole second of the motion.
fn off(made: &Made, rows: usize) -> Option<String> {
    let runs = made.i32("run").iter().copied().collect::<std::collections::BTreeSet<_>>();
    runs.into_iter().find_map(|run| {
        let own = made.rows_of(run);
        let shifts = 0..=rows.saturating_sub(own.len());
        let found = shifts.map(|from| beyond(made, &own, from as f64));
        found.reduce(|best, other| if other.0 < best.0 { other } else { best }).and_then(|(_, text)| text)
    })
}

/// The largest deviation of rows `own` from the motion from second `from` on, in tolerances, and in words if it
/// exceeds one.
fn beyond(made: &Made, own: &[usize], from: f64) -> (f64, Option<String>) {
    let times = made.f64("t");
    let of = |(name, bound): &(&str, f64)| {
        let values = made.columns.get(*name)?.as_f64()?;
        // The inputs of the last row of a run belong to no sample, and may be unknown.
        let rows = if ["delta", "n"].contains(name) { &own[..own.len() - 1] } else { own };
        let squares = rows.iter().map(|row| {
            let turns = std::f64::consts::TAU;
            let error = values[*row] - truth(name, from + times[*row]);
            let error = if *name == "psi" { error - turns * (error / turns).round() } else { error };
            error * error
        });
        let rms = (squares.sum::<f64>() / rows.len().max(1) as f64).sqrt();
        let share = if rms.is_finite() { rms / bound } else { f64::INFINITY };
        Some((share, (share > 1.0).then(|| format!("{name} is {rms:.4} off"))))
    };
    let all = BOUNDS.iter().filter_map(of);
    all.reduce(|worst, other| if other.0 > worst.0 { other } else { worst }).unwrap_or((0.0, None))
}

/// Cases of each kind.
fn count() -> u64 {
    std::env::var("SEATRIAL_CASES").ok().and_then(|cases| cases.parse().ok()).unwrap_or(25)
}

/// The one case to retry, if it is of `kind`.
fn again(kind: u64) -> Option<Range<u64>> {
    let wanted = std::env::var("SEATRIAL_CASE").ok()?;
    let (own, case) = wanted.split_once(':')?;
    let case = case.parse().ok()?;
    Some(if own.parse() == Ok(kind) { case..case + 1 } else { 0..0 })
}

/// The outcomes of the cases of a kind.
#[derive(Debug, Default)]
pub struct Tally {
    pub healthy: usize,
    pub refused: usize,
    pub counted: usize,
    /// Those that were silent.
    silent: Vec<String>,
}

/// Tries the cases of `kind`, a number that no other kind has: `fault` makes a faulty log of what it draws. None may be silent.
#[track_caller]
pub fn none_is_silent(kind: u64, fault: impl Fn(&mut Draw) -> Faulty + Sync) -> Tally {
    let cases = again(kind).unwrap_or(0..count());
    let (next, found) = (AtomicU64::new(cases.start), Mutex::new(Tally::default()));
    let work = || {
        loop {
            let case = next.fetch_add(1, Ordering::Relaxed);
            if case >= cases.end {
                return;
            }
            let faulty = fault(&mut Draw::of(kind, case));
            let mut folder = tempfile::tempdir().unwrap();
            let verdict = faulty.judged(folder.path());
            if again(kind).is_some() {
                folder.disable_cleanup(true);
                println!("{}: {}: {verdict:?}", folder.path().display(), faulty.what);
            }
            let mut tally = found.lock().unwrap();
            match verdict {
                Verdict::Healthy => tally.healthy += 1,
                Verdict::Refused(_) => tally.refused += 1,
                Verdict::Counted(_) => tally.counted += 1,
                Verdict::Silent(why) => tally.silent.push(format!("{kind}:{case}, {}: {why}", faulty.what)),
            }
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    let tally = found.into_inner().unwrap();
    let Tally { healthy, refused, counted, silent } = &tally;
    println!("kind {kind}: {healthy} healthy, {refused} refused, {counted} counted, {} silent", silent.len());
    let first: Vec<&String> = silent.iter().take(5).collect();
    assert!(
        silent.is_empty(),
        "{} of {} cases are silent: {first:#?}",
        silent.len(),
        cases.end - cases.start
    );
    tally
}

#[test]
fn law_a_row_of_a_table_that_is_lost_is_never_silent() {
    let config = known::table_config("*.csv", "unit = \"s\"", "");
    none_is_silent(1, |draw| {
        // Rows missing before the first or after the last cannot be detected.
        let (first, lost) = (draw.between(2, 60), draw.between(1, 6));
        let log = known::csv(60, |k| format!("{k}"));
        let lines = log.lines().enumerate().filter(|(k, _)| *k < first || *k >= first + lost);
        let log: String = lines.map(|(_, line)| format!("{line}\n")).collect();
        let kept = log.lines().count() - 1;
        let rows = if first + lost > 61 { kept } else { 61 };
        Faulty::new(&config, "a.csv", log, rows).named(&["splits"]).what(format!("{lost} rows from {first}"))
    });
}

#[test]
fn the_judge_tells_what_is_silent() {
    let config = known::table_config("*.csv", "unit = \"s\"", "");
    let judge = |log: &str, rows| {
        let folder = tempfile::tempdir().unwrap();
        Faulty::new(&config, "a.csv", log, rows).named(&["splits"]).judged(folder.path())
    };
    let healthy = known::csv(60, |k| format!("{k}"));
    assert!(matches!(judge(&healthy, 61), Verdict::Healthy));
    assert!(matches!(judge(&healthy, 62), Verdict::Silent(_)));
    let refused = healthy.replacen("\n7,", "\nx,", 1);
    assert!(matches!(judge(&refused, 61), Verdict::Refused(_)));
    let late = known::csv(60, |k| format!("{}", if k > 30 { k + 1 } else { k }));
    assert!(matches!(judge(&late, 61), Verdict::Counted(_)));
    let wrong: String = healthy
        .lines()
        .enumerate()
        .map(|(k, line)| match line.split(',').collect::<Vec<_>>().as_slice() {
            [t, u, v, rest @ ..] if k > 0 => {
                format!("{t},{},{v},{}\n", u.parse::<f64>().unwrap() + 0.05, rest.join(","))
            }
            _ => format!("{line}\n"),
        })
        .collect();
    assert!(matches!(judge(&wrong, 61), Verdict::Silent(_)));
}
