//! Faults at every place where a stage creates, writes, flushes or renames a file: afterwards all is old,
//! all is new, or what is mixed is refused.

use std::cell::RefCell;
use std::collections::BTreeSet;
use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

use crate::asked;
use crate::ends::{Fault, Tally, Wrong, read, start, wait};
use crate::grounds::{Files, Ground, Stage, all};
use crate::places::{Place, is_unfinished};

/// A stage that is run over the result of another run.
pub struct Watched {
    pub place: Place,
    pub line: String,
    pub other: String,
    /// The files of the other run, and of this one.
    pub before: Files,
    pub after: Files,
    /// What runs of the line have begun from.
    begun_from: RefCell<Vec<Files>>,
}

impl Watched {
    pub fn new(ground: &'static Ground, stage: &'static Stage) -> Self {
        let place = Place::on(ground);
        let (line, other) = (stage.line_into("out/"), stage.other_into("out/"));
        let made = |line: &str| {
            let ended = wait(&place, start(&place, line, ""));
            assert_eq!(ended.judged().ok(), Some(0), "{line}: {}", ended.told);
            place.outputs()
        };
        let (before, after) = (made(&other), made(&line));
        assert!(before.keys().eq(after.keys()), "{line}: other files");
        assert_ne!(before, after, "{line}: the same result");
        let begun_from = RefCell::new(vec![before.clone()]);
        Self { place, line, other, before, after, begun_from }
    }

    /// Unfinished files in `out`.
    pub fn unfinished(&self) -> BTreeSet<String> {
        self.place.outputs().into_keys().filter(|name| is_unfinished(name)).collect()
    }

    /// Checks that `out` has one of the two results complete, and, if so said, nothing else; returns whether it is the new one.
    pub fn is_new(&self, and_nothing_else: bool) -> Result<bool, Fault> {
        let mut found = self.place.outputs();
        let left = self.unfinished();
        if and_nothing_else && !left.is_empty() {
            return Err((Wrong::Left, format!("it left {left:?}")));
        }
        found.retain(|name, _| !is_unfinished(name));
        if found == self.before || found == self.after {
            return Ok(found == self.after);
        }
        let differs = |files: &Files| {
            let names = files.keys().chain(found.keys());
            names.filter(|name| files.get(*name) != found.get(*name)).cloned().collect::<Vec<_>>()
        };
        let (old, new) = (differs(&self.before), differs(&self.after));
        Err((Wrong::Mixed, format!("other than before: {old:?}, other than new: {new:?}")))
    }

    /// What a run that did not come to its end left: whether the new result; `None` if it is refused, or no document vouches for it.
    pub fn left(&self) -> Result<Option<bool>, Fault> {
        let before = self.place.outputs();
        let read = read(&self.place, self.after.keys().map(String::as_str));
        if self.place.outputs() != before {
            return Err((Wrong::Other, "who only reads changed what stands there".to_owned()));
        }
        let is_vouched = self.after.keys().any(|name| name.ends_with(".json"));
        match (self.is_new(false), read) {
            (Ok(new), Ok(())) => Ok(Some(new)),
            (Err(_), Err((_, told))) if told.contains("; run the stage that writes both again") => Ok(None),
            (Err(_), Ok(())) if !is_vouched => Ok(None),
            (Err(fault), Ok(())) | (_, Err(fault)) => Err(fault),
        }
    }

    /// Runs the line with a fault at its `count`-th place over the old result: returns whether it finished, and
    /// what it left.
    fn at(&self, kind: &str, count: u32) -> Result<(bool, Option<bool>), Fault> {
        self.place.put_outputs(&self.before);
        let ended = wait(&self.place, start(&self.place, &self.line, &format!("{kind}:{count}")));
        let success = ended.status.is_some_and(|status| status.success());
        let left = self.left()?;
        // A process that sees an error has time to clean up.
        if kind == "error" && (ended.judged()? > 1 || !self.unfinished().is_empty()) {
            return Err((Wrong::Left, format!("{:?}: {}", self.unfinished(), ended.told)));
        }
        if success && left != Some(true) {
            return Err((Wrong::Mixed, "succeeds without the new result".to_owned()));
        }
        let found = self.place.outputs();
        if self.begun_from.borrow().contains(&found) {
            return Ok((success, left));
        }
        self.begun_from.borrow_mut().push(found);
        let again = wait(&self.place, start(&self.place, &self.line, ""));
        if again.judged()? != 0 || !self.is_new(true)? {
            return Err((Wrong::Left, format!("the next run: {}", again.told)));
        }
        Ok((success, left))
    }

    /// Tries places: all of them, or those visited by a bisection for the last one, which are dense near the renames, with
    /// an error at the last two.
    fn try_places(&self, every: bool) -> Tally {
        let mut tally = Tally::default();
        let mut at = |kind: &str, count: u32| {
            let ended = self.at(kind, count);
            tally.fault(&format!("{}: {kind}:{count}", self.line), ended.clone().map(|(_, left)| left));
            ended.is_ok_and(|(success, _)| success)
        };
        let (mut reached, mut beyond) = (0, 1);
        while !at("kill", beyond) {
            assert!(beyond < 1 << 16, "{}: places without end", self.line);
            (reached, beyond) = (beyond, if every { beyond + 1 } else { 2 * beyond });
        }
        while beyond - reached > 1 {
            let middle = reached.midpoint(beyond);
            if at("kill", middle) { beyond = middle } else { reached = middle }
        }
        let last = reached;
        for count in if every { 1 } else { last - 1 }..=last {
            at("error", count);
        }
        assert!(last > 2, "{}: {last} places", self.line);
        tally
    }
}

/// Does `work` for every stage on all processors, and prints the results. Without a number of
/// cases it does a sixth of the stages. Each law has another sixth, by the length of its name.
pub fn for_every_stage(name: &str, work: impl Fn(usize, &'static Ground, &'static Stage) -> Tally + Sync) {
    let started = Instant::now();
    let mut stages: Vec<_> = all().into_iter().enumerate().collect();
    if asked().is_none() {
        stages.retain(|(i, _)| i % 6 == name.len() % 6);
    }
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Tally::default()));
    let one = || {
        while let Some(&(i, (ground, stage))) = stages.get(next.fetch_add(1, Ordering::Relaxed)) {
            let tally = work(i, ground, stage);
            found.lock().unwrap().add(&tally);
        }
    };
    let workers = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(one))));
    let mut tally = found.into_inner().unwrap();
    tally.seconds = started.elapsed().as_secs_f64();
    tally.check(name);
}

#[test]
fn law_a_fault_at_any_place_of_any_stage_leaves_the_old_files_or_the_new_or_refused_ones() {
    for_every_stage("places", |_, ground, stage| Watched::new(ground, stage).try_places(asked().is_some()));
}
