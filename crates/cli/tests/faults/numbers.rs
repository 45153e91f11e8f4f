//! Every number of a hand-written file, and every flag, with unreasonable numbers: refused by name or used, in little
//! time and memory.

use std::num::NonZeroUsize;
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::{Duration, Instant};

use toml::Value;

use crate::asked;
use crate::damage::Draw;
use crate::ends::{Fault, Tally, Wrong, ends_within, start, wait};
use crate::fuzz::flags;
use crate::grounds::{GROUNDS, Ground, Stage, all};
use crate::places::Place;

/// Limit of a run's time, on a busy machine, and of its memory.
const LIMIT: Duration = Duration::from_secs(20);
const MEMORY_KIB: u64 = 1 << 20;

/// Maximum number of characters of a message.
const LONGEST: usize = 500;

const NUMBERS: [&str; 8] =
    ["-1", "0", "1e-300", "1e25", "1.8446744073709552e19", "9223372036854775807", "nan", "inf"];

/// Number of cases unless all are requested.
const SOME: usize = 120;

/// Numbers that the small studies do not state: the file and their position in it.
const UNSTATED: [(&str, &str); 58] = [
    ("vessel.toml", "sample_rate_hz"),
    ("vessel.toml", "constant.0"),
    ("vessel.toml", "value.X_u"),
    ("vessel.toml", "nominal.X_u"),
    ("vessel.toml", "input.0.factor"),
    ("vessel.toml", "input.0.lag_s"),
    ("vessel.toml", "input.0.rate_per_s"),
    ("vessel.toml", "input.0.dead_band"),
    ("vessel.toml", "input.0.hold_s"),
    ("dictionary.toml", "maneuver.2.duration_s"),
    ("dictionary.toml", "generate.candidates"),
    ("dictionary.toml", "generate.duration_s"),
    ("dictionary.toml", "generate.limits.u_m_s"),
    ("campaign.toml", "random.segments"),
    ("campaign.toml", "wind.std_surge_m_s2"),
    ("campaign.toml", "wind.time_constant_s"),
    ("dictionary.toml", "limits.rates.tau1"),
    ("campaign.toml", "rounds.floor.X_u"),
    ("plan.toml", "raster_per_cell"),
    ("plan.toml", "informative_s"),
    ("plan.toml", "safety.parameter_error"),
    ("plan.toml", "safety.aground_probability"),
    ("plan.toml", "safety.transit_depth_m"),
    ("plan.toml", "safety.trial_depth_m"),
    ("plan.toml", "hull.reference_m"),
    ("plan.toml", "hull.air_draught_m"),
    ("plan.toml", "hull.draught_m"),
    ("plan.toml", "approach.run_in_s"),
    ("plan.toml", "approach.tolerance_cells"),
    ("plan.toml", "approach.tolerance_deg"),
    ("plan.toml", "approach.tolerance_m_s"),
    ("plan.toml", "approach.tolerance_rad_s"),
    ("plan.toml", "sensors.position_m"),
    ("plan.toml", "known_current.speed_m_s"),
    ("plan.toml", "chart.0.radius_m"),
    ("plan.toml", "chart.0.doubtful_radius_m"),
    ("plan.toml", "maneuver.0.count"),
    ("plan.toml", "maneuver.0.piece_s"),
    ("plan.toml", "handling.stop_m"),
    ("logs.toml", "scatter_std"),
    ("logs.toml", "course_rad"),
    ("logs.toml", "seed"),
    ("ingest.toml", "average_s"),
    ("ingest.toml", "velocities.window_s"),
    ("ingest.toml", "window_s"),
    ("ingest.toml", "tail_s"),
    ("ingest.toml", "min_s"),
    ("ingest.toml", "speed_classes_m_s.0"),
    ("ingest.toml", "antenna_m.0"),
    ("ingest.toml", "file.0.columns"),
    ("ingest.toml", "file.0.max_wrong_checksums"),
    ("ingest.toml", "file.0.time.offset_s"),
    ("ingest.toml", "file.0.channel.0.scale"),
    ("ingest.toml", "file.0.channel.0.offset"),
    ("ingest.toml", "file.0.channel.0.sign"),
    ("ingest.toml", "file.0.channel.0.delay_s"),
    ("ingest.toml", "file.0.channel.0.max_gap_s"),
    ("reference.toml", "selection.realizations"),
];

/// The change before a stage runs.
#[derive(Debug)]
enum Change {
    /// A number of a file, by its place in it.
    Key(&'static str, String),
    /// The value of a flag.
    Flag(String),
}

struct Case {
    ground: &'static Ground,
    stage: &'static Stage,
    change: Change,
    number: &'static str,
}

fn cases() -> Vec<Case> {
    let mut found = Vec::new();
    for (ground, stage) in all() {
        let mut files: Vec<&'static str> =
            stage.reads.iter().copied().filter(|name| name.ends_with(".toml")).collect();
        files.dedup();
        let keys = files
            .into_iter()
            .flat_map(|name| keys(ground, name).into_iter().map(move |key| Change::Key(name, key)));
        let flags = flags(stage.line).into_iter().filter(|(_, with_value)| *with_value);
        // Outputs, and the number of threads.
        let other = ["--out", "--threads"];
        let flags = flags.filter(|(flag, _)| !other.contains(&flag.as_str()));
        let changes = keys.chain(flags.map(|(flag, _)| Change::Flag(flag)));
        for change in changes.collect::<Vec<_>>() {
            let again = || match &change {
                Change::Key(name, key) => Change::Key(name, key.clone()),
                Change::Flag(flag) => Change::Flag(flag.clone()),
            };
            found.extend(NUMBERS.map(|number| Case { ground, stage, change: again(), number }));
        }
    }
    found
}

/// Places of the numbers of a file, and of those that it could have.
fn keys(ground: &Ground, name: &str) -> Vec<String> {
    let mut found = Vec::new();
    numbers(&parsed(ground, name), "", &mut found);
    let usual = name.replace(|c: char| c == '-' || c.is_ascii_digit(), "");
    found.extend(UNSTATED.iter().filter(|(file, _)| *file == usual).map(|(_, key)| (*key).to_owned()));
    found.sort();
    found.dedup();
    found
}

fn parsed(ground: &Ground, name: &str) -> Value {
    let text = std::str::from_utf8(&ground.files[name]).unwrap();
    Value::Table(toml::from_str(text).unwrap())
}

fn numbers(value: &Value, above: &str, found: &mut Vec<String>) {
    let below = |key: &str| if above.is_empty() { key.to_owned() } else { format!("{above}.{key}") };
    match value {
        Value::Integer(_) | Value::Float(_) => found.push(above.to_owned()),
        Value::Table(table) => table.iter().for_each(|(key, value)| numbers(value, &below(key), found)),
        Value::Array(list) => {
            list.iter().enumerate().for_each(|(i, value)| numbers(value, &below(&i.to_string()), found));
        }
        _ => {}
    }
}

/// Puts `number` at `key`, with the tables above it. Lists become longer by one at most.
fn put(value: &mut Value, key: &str, number: &Value) {
    let (first, rest) = key.split_once('.').map_or((key, None), |(first, rest)| (first, Some(rest)));
    let inner = match value {
        Value::Table(table) => {
            let lists = rest.is_some_and(|rest| rest.starts_with(|c: char| c.is_ascii_digit()));
            let empty = if lists { Value::Array(Vec::new()) } else { Value::Table(toml::Table::new()) };
            table.entry(first).or_insert(empty)
        }
        Value::Array(list) => {
            let place = first.parse::<usize>().unwrap().min(list.len());
            if place == list.len() {
                list.push(Value::Table(toml::Table::new()));
            }
            &mut list[place]
        }
        _ => return,
    };
    match rest {
        Some(rest) => put(inner, rest, number),
        None => *inner = number.clone(),
    }
}

fn tried(place: &mut Place, case: &Case) -> (String, Result<i32, Fault>) {
    let line = case.stage.line_into("out/").replace("--time-limit-s 8", "--time-limit-s 2");
    let line = match &case.change {
        Change::Flag(flag) => format!("{line} {flag}={}", case.number),
        Change::Key(name, key) => {
            let mut whole = parsed(case.ground, name);
            let number: toml::Table = toml::from_str(&format!("x = {}", case.number)).unwrap();
            put(&mut whole, key, &number["x"]);
            place.put(name, toml::to_string(&whole).unwrap().as_bytes());
            line
        }
    };
    let name = format!("{:?} = {}: {line}", case.change, case.number);
    let ended = ends_within(place, &line, LIMIT, MEMORY_KIB).and_then(|code| {
        let expected: &[i32] =
            if matches!(case.change, Change::Flag(_)) { &[-1, 0, 2, 3, 4] } else { &[-1, 0, 3, 4] };
        if expected.contains(&code) {
            return Ok(code);
        }
        let told = wait(place, start(place, &line, "")).told;
        // Of a flag that names a file.
        let is_absent = matches!(case.change, Change::Flag(_)) && code == 1 && told.contains("No such file");
        if is_absent { Ok(code) } else { Err((Wrong::Other, format!("exit code {code}: {told}"))) }
    });
    let ended = ended.and_then(|code| {
        let told =
            if matches!(code, 2..=4) { wait(place, start(place, &line, "")).told } else { String::new() };
        match told.chars().count() {
            long if long > LONGEST => Err((Wrong::Words, format!("{long} characters: {told}"))),
            _ => Ok(code),
        }
    });
    (name, ended)
}

#[test]
fn law_numbers_that_no_study_means_are_refused_by_name_or_used() {
    let started = Instant::now();
    let all = cases();
    assert!(all.len() > 4000, "{}", all.len());
    let mut draw = Draw::of(9, 1);
    let chosen: Vec<&Case> = match asked() {
        Some(_) => all.iter().collect(),
        None => (0..SOME).map(|_| &all[draw.below(all.len())]).collect(),
    };
    let (next, found) = (AtomicUsize::new(0), Mutex::new(Tally::default()));
    let work = || {
        let mut places = GROUNDS.each_ref().map(Place::on);
        let mut tally = Tally::default();
        while let Some(case) = chosen.get(next.fetch_add(1, Ordering::Relaxed)) {
            let place = places.iter_mut().find(|place| std::ptr::eq(place.ground, case.ground)).unwrap();
            let (name, ended) = tried(place, case);
            tally.case(&name, ended);
            place.restore();
        }
        found.lock().unwrap().add(&tally);
    };
    let workers = std::thread::available_parallelism().map_or(1, NonZeroUsize::get);
    std::thread::scope(|scope| (0..workers).for_each(|_| drop(scope.spawn(work))));
    let mut tally = found.into_inner().unwrap();
    tally.seconds = started.elapsed().as_secs_f64();
    tally.check("numbers");
}
