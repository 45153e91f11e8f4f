//! Files of two runs in one set: whoever reads several of them refuses them.

use std::collections::BTreeSet;
use std::fs;
use std::time::{Duration, Instant};

use crate::asked;
use crate::ends::{Fault, Tally, Wrong, start, wait};
use crate::grounds::{Files, Ground, Stage};
use crate::places::{Place, is_unfinished};
use crate::points::for_every_stage;
use crate::support::draw::Draw;

/// Readers of what the stages of the grounds write, besides these stages.
const READERS: [&str; 5] = [
    "ingest --config ingest.toml --vessel vessel.toml --logs . --out out/t.parquet",
    "simulate campaign --vessel vessel.toml --dictionary refined-design-refined-dictionary.toml --campaign campaign-2.toml \
     --design refined-design.json --out out/t.parquet",
    "validate --vessel vessel.toml --campaign campaign.toml --estimates kept-estimates.parquet --validation \
     validation.parquet --out out/s.parquet",
    "report --study . --results . --out out/r.html",
    "export --model model.json --to c --out out/",
];

/// A stage that writes over the result of another run, beside its inputs, and what its readers make of both.
struct Mixed {
    place: Place,
    line: String,
    /// All files with the result of the other run, and with that of this one.
    whole: [Files; 2],
    /// What the stage writes.
    names: BTreeSet<String>,
    /// Each reader with what it makes of the two.
    readers: Vec<(String, [Option<Files>; 2])>,
}

impl Mixed {
    /// `None` if the stage writes a single file or into a folder of its own.
    fn new(ground: &'static Ground, stage: &'static Stage) -> Option<Self> {
        let place = Place::on(ground);
        let run = |line: &str| {
            let ended = wait(&place, start(&place, line, ""));
            assert_eq!(ended.judged().ok(), Some(0), "{line}: {}", ended.told);
            crate::grounds::files(place.path())
        };
        if stage.out.is_empty() {
            return None;
        }
        let line = stage.line_into("");
        let whole = [run(&stage.other_into("")), run(&line)];
        let [old, new] = &whole;
        let names: BTreeSet<String> =
            new.keys().filter(|name| old.get(*name) != new.get(*name)).cloned().collect();
        if names.len() < 2 {
            return None;
        }
        let lines =
            ground.stages.iter().filter(|own| own.line != stage.line).map(|own| own.line_into("out/"));
        let lines = lines.chain(READERS.map(|line| format!("{line} --allow=mixed")));
        let reads = |line: &String| {
            let words: Vec<&str> = line.split_whitespace().collect();
            words[0] == "report" || words.contains(&".") || words.iter().any(|word| names.contains(*word))
        };
        let lines: Vec<String> = lines.filter(reads).collect();
        let mut mixed = Self { place, line, whole, names, readers: Vec::new() };
        for line in lines {
            let made = [0, 1].map(|which| {
                mixed.put(&mixed.whole[which]);
                mixed.made(&line).unwrap()
            });
            if made.iter().any(Option::is_some) {
                mixed.readers.push((line, made));
            }
        }
        Some(mixed)
    }

    fn put(&self, files: &Files) {
        for name in crate::grounds::files(self.place.path()).keys().filter(|name| !files.contains_key(*name))
        {
            fs::remove_file(self.place.path().join(name)).unwrap();
        }
        crate::grounds::write(self.place.path(), files);
    }

    /// What a reader makes; `None` if it refuses.
    fn made(&self, line: &str) -> Result<Option<Files>, Fault> {
        let ended = wait(&self.place, start(&self.place, line, ""));
        let is_refused = ended.judged()? != 0;
        let made = self.place.outputs();
        self.place.put_outputs(&Files::new());
        Ok(if is_refused { None } else { Some(made) })
    }

    /// Has all readers read what stands there: whether it is the new result; `None` if that is neither.
    fn read(&self) -> Result<Option<bool>, Fault> {
        let mut found = crate::grounds::files(self.place.path());
        found.retain(|name, _| !is_unfinished(name));
        if let Some(which) = self.whole.iter().position(|whole| *whole == found) {
            return Ok(Some(which == 1));
        }
        for (line, whole) in &self.readers {
            if self.made(line)?.is_some_and(|made| !whole.contains(&Some(made))) {
                let new = self.names.iter().filter(|name| found.get(*name) == self.whole[1].get(*name));
                return Err((Wrong::Mixed, format!("{line}: takes {:?}", new.collect::<Vec<_>>())));
            }
        }
        Ok(None)
    }

    /// Runs the line over the old result and kills it: after `share` of the time that it takes, or `late` after its first rename.
    fn killed(&self, after: Duration, late: Option<Duration>) -> Result<Option<bool>, Fault> {
        self.put(&self.whole[0]);
        let times = || {
            let of =
                |name: &String| self.place.path().join(name).metadata().and_then(|own| own.modified()).ok();
            self.names.iter().map(of).collect::<Vec<_>>()
        };
        let (before, started) = (times(), Instant::now());
        let mut child = start(&self.place, &self.line, "");
        match late {
            None => std::thread::sleep(after),
            Some(late) => {
                while times() == before
                    && child.try_wait().unwrap().is_none()
                    && started.elapsed() < 9 * after
                {}
                let renamed = Instant::now();
                while renamed.elapsed() < late {}
            }
        }
        let _ = child.kill();
        let _ = wait(&self.place, child);
        let left = self.read()?;
        let again = wait(&self.place, start(&self.place, &self.line, ""));
        if again.judged()? != 0 || crate::grounds::files(self.place.path()) != self.whole[1] {
            return Err((Wrong::Left, format!("the next run: {}", again.told)));
        }
        Ok(left)
    }
}

#[test]
fn law_no_reader_takes_files_of_two_runs() {
    let each = asked().map_or(1, |cases| 1 + cases / 10 / 20);
    for_every_stage("mixtures of two", |which, ground, stage| {
        let mut tally = Tally::default();
        let started = Instant::now();
        let Some(mixed) = Mixed::new(ground, stage) else { return tally };
        let took = started.elapsed() / (2 + 2 * mixed.readers.len() as u32);
        for i in 0..each {
            let mut draw = Draw::of(900 + which as u64, i);
            let late = (i % 4 != 3).then(|| Duration::from_micros(draw.below(400) as u64));
            let left = mixed.killed(took.mul_f64(draw.below(1000) as f64 / 1000.0), late);
            tally.fault(&format!("{}: killed {late:?}", mixed.line), left);
            // As two writers at once may leave them.
            mixed.put(&mixed.whole[0]);
            for name in mixed.names.iter().filter(|_| draw.below(2) == 0) {
                fs::write(mixed.place.path().join(name), &mixed.whole[1][name]).unwrap();
            }
            tally.fault(&format!("{}: mixed", mixed.line), mixed.read());
        }
        tally
    });
}
