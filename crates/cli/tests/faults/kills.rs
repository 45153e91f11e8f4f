//! Processes that are killed at any moment, and two that write the same files.

use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

use crate::asked;
use crate::ends::{Fault, Tally, Wrong, start, wait};
use crate::places::is_unfinished;
use crate::points::{Watched, for_every_stage};

/// Signals with the exit codes of processes that handle them; without a handler the code is the system's.
const SIGNALS: [(&str, Option<i32>, i32); 4] =
    [("KILL", None, 9), ("INT", Some(130), 2), ("TERM", Some(143), 15), ("HUP", Some(129), 1)];

/// Runs a line, and ends it by a signal after a while; whether the result of `watched.line` is there then; `None` if it is refused.
fn killed(watched: &Watched, line: &str, after: Duration, which: usize) -> Result<Option<bool>, Fault> {
    use std::os::unix::process::ExitStatusExt;
    let before = watched.unfinished();
    let finished = || {
        let mut files = watched.place.outputs();
        files.retain(|name, _| !is_unfinished(name));
        files
    };
    let found = finished();
    let child = start(&watched.place, line, "");
    std::thread::sleep(after);
    let (signal, code, number) = SIGNALS[which];
    let id = child.id().to_string();
    Command::new("kill").args(["-s", signal, &id]).stderr(Stdio::null()).status().unwrap();
    let ended = wait(&watched.place, child);
    let Some(status) = ended.status else { return ended.judged().map(|_| None) };
    let heard = status.code().is_some() && status.code() == code;
    if !status.success() && !heard && status.signal() != Some(number) {
        return Err((Wrong::Other, format!("{signal}: {status}: {}", ended.told)));
    }
    // A process that handles the signal removes its unfinished files; those of a killed one are removed by the next
    // run that finishes.
    let left = watched.unfinished();
    if status.success() && !left.is_empty() || heard && !left.is_subset(&before) {
        return Err((Wrong::Left, format!("{signal}: {status}: it left {left:?}, found {before:?}")));
    }
    // It may have found what an earlier one left that was killed.
    let is_whole = status.success() || heard && finished() != found;
    match watched.left()? {
        None if is_whole => Err((Wrong::Mixed, format!("{signal}: {status}"))),
        left => Ok(left),
    }
}

#[test]
fn law_processes_that_are_ended_at_any_moment_leave_the_old_files_or_the_new_or_refused_ones() {
    let each = asked().map_or(1, |cases| cases / 10 / 33);
    for_every_stage("signals", |stage, ground, line| {
        let watched = Watched::new(ground, line);
        let started = Instant::now();
        let _ = wait(&watched.place, start(&watched.place, &watched.line, ""));
        let whole = started.elapsed();
        let mut tally = Tally::default();
        for i in 0..each {
            // Spread over the whole run by the golden ratio.
            let share = ((i as f64 + stage as f64 / 7.0) * 0.618_034).fract();
            let line = [&watched.line, &watched.other][i as usize % 2];
            let which = (i as usize / 2 + stage) % SIGNALS.len();
            let new = killed(&watched, line, whole.mul_f64(share), which);
            tally.fault(&format!("{line}: {} after {share:.3} of it", SIGNALS[which].0), new);
        }
        let last = wait(&watched.place, start(&watched.place, &watched.line, ""));
        tally.fault(&watched.line, last.judged().and_then(|_| watched.is_new(true)));
        tally
    });
}

#[test]
fn law_two_processes_that_write_the_same_files_leave_those_of_one_or_refused_ones() {
    let each = asked().map_or(1, |cases| 1 + cases / 10_000);
    for_every_stage("two writers", |_, ground, stage| {
        let watched = Watched::new(ground, stage);
        let mut tally = Tally::default();
        for _ in 0..each {
            let both = [&watched.line, &watched.other].map(|line| start(&watched.place, line, ""));
            let ended = both.map(|mut child| child.wait().unwrap().code());
            let found = match ended {
                [Some(0), Some(0)] if watched.unfinished().is_empty() => watched.left(),
                other => Err((Wrong::Other, format!("exit codes {other:?}, {:?}", watched.unfinished()))),
            };
            tally.fault(&watched.line, found);
        }
        tally
    });
}
