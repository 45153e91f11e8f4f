//! What columns are by how they move, in made trials with other names, units, signs and axes.

use std::f64::consts::{PI, TAU};
use std::path::PathBuf;

use logs::TimeUnit;
use logs::by_motion::{Agreement, LoggedTable, SampledRecording, judged};
use logs::guess::{Guess, Head, Needed, Placed};

/// Repeatable numbers.
struct Draw(u64);

impl Draw {
    /// From 0 to 1.
    fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        (self.0 >> 33) as f64 / (1_u64 << 31) as f64
    }

    fn below(&mut self, count: usize) -> usize {
        ((count as f64 * self.unit()) as usize).min(count - 1)
    }

    fn is(&mut self) -> bool {
        self.unit() < 0.5
    }

    fn normal(&mut self) -> f64 {
        (0..12).map(|_| self.unit()).sum::<f64>() - 6.0
    }
}

pub const NAMES: [&str; 9] = ["t", "x", "y", "psi", "y_u", "y_v", "y_r", "delta", "n"];
const DT: f64 = 0.5;
const ROWS: usize = 800;

/// A trial of a ship with rudder and propeller, whose orders change at random; `helm` is how far the rudder goes \[rad\].
fn trial(draw: &mut Draw, helm: f64) -> Vec<Vec<f64>> {
    let mut columns = vec![Vec::new(); NAMES.len()];
    let [mut x, mut y, mut v, mut r, mut delta] = [0.0; 5];
    let (mut psi, mut u) = (TAU * draw.unit(), 1.0);
    let (mut order, mut n) = (0.0, 8.0);
    for row in 0..ROWS {
        if row % 24 == 0 {
            order = helm * (2.0 * draw.unit() - 1.0);
        }
        if row % 130 == 0 {
            n = 6.0 + 4.0 * draw.unit();
        }
        let now = [DT * row as f64, x, y, psi, u, v, r, delta, n];
        columns.iter_mut().zip(now).for_each(|(column, value)| column.push(value));
        for _ in 0..10 {
            let dt = DT / 10.0;
            let du = 0.002 * n * n - 0.12 * u * u.abs() - 0.6 * r * r;
            let dv = -0.3 * v - 0.35 * u * r + 0.02 * u * u * delta;
            let dr = -0.25 * r - 0.5 * r * r.abs() - 0.05 * v + 0.04 * u * u * delta;
            delta += (order - delta).clamp(-0.05 * dt * 10.0, 0.05 * dt * 10.0);
            (x, y) = (x + dt * (u * psi.cos() - v * psi.sin()), y + dt * (u * psi.sin() + v * psi.cos()));
            (psi, u, v, r) = (psi + dt * r, u + dt * du, v + dt * dv, r + dt * dr);
        }
    }
    columns
}

/// Trials with their columns renamed and mixed; what each is: its channel, its unit, whether it counts the other way.
struct Mixed {
    guess: Guess,
    truth: Vec<Option<(&'static str, &'static str, bool)>>,
}

fn mixed(seed: u64) -> Mixed {
    let mut draw = Draw(seed.wrapping_mul(0x9E37_79B9_7F4A_7C15));
    let count = 2 + draw.below(4);
    let mut trials: Vec<Vec<Vec<f64>>> = (0..count).map(|_| trial(&mut draw, 0.5)).collect();
    let degrees = 180.0 / PI;
    let angle = [("rad", 1.0), ("deg", degrees)][draw.below(2)];
    let rate = [("rad/s", 1.0), ("deg/s", degrees), ("deg/min", 60.0 * degrees)][draw.below(3)];
    let speed = [("m/s", 1.0), ("kn", 3600.0 / 1852.0), ("km/h", 3.6), ("cm/s", 100.0)][draw.below(4)];
    let helm = [("rad", 1.0), ("deg", degrees)][draw.below(2)];
    let shaft = [("1/s", 1.0), ("rpm", 60.0)][draw.below(2)];
    let time = [("s", 1.0), ("ms", 1e3)][draw.below(2)];
    let units = [time, ("m", 1.0), ("m", 1.0), angle, speed, speed, rate, helm, shaft];
    let turned: Vec<bool> = NAMES.iter().map(|_| draw.is()).collect();
    // Times, surge and revolutions count as usual.
    let turned: Vec<bool> = (0..NAMES.len()).map(|i| turned[i] && ![0, 4, 8].contains(&i)).collect();
    let is_wrapped = draw.is();
    let noise = 0.002 * draw.unit();
    for columns in &mut trials {
        for (i, column) in columns.iter_mut().enumerate() {
            let most = column.iter().fold(0.0, |most: f64, value| most.max(value.abs()));
            let sign = if turned[i] { -1.0 } else { 1.0 };
            for value in column.iter_mut() {
                let off = if i == 0 { 0.0 } else { noise * most.min(20.0) * draw.normal() };
                *value = sign * units[i].1 * (*value + off);
                if i == 3 && is_wrapped {
                    *value = value.rem_euclid(TAU * units[3].1);
                }
            }
        }
        let mut walk = 0.0;
        let wander = (0..ROWS).map(|_| {
            walk += draw.normal();
            walk
        });
        columns.push(wander.collect());
        columns.push((0..ROWS).map(|_| draw.unit()).collect());
    }
    let mut order: Vec<usize> = (0..NAMES.len() + 2).collect();
    (1..order.len()).for_each(|i| order.swap(i, draw.below(i + 1)));
    let mixed: Vec<Vec<Vec<f64>>> =
        trials.iter().map(|columns| order.iter().map(|i| columns[*i].clone()).collect()).collect();
    let guess = unnamed(mixed);
    // What counts across the heading turns with it.
    let across = |i: usize| [2, 5, 6].contains(&i) && turned[3] != turned[i] || i == 1 && turned[i];
    let is = |i: &usize| NAMES.get(*i).map(|name| (*name, units[*i].0, across(*i)));
    Mixed { guess, truth: order.iter().map(is).collect() }
}

impl Mixed {
    fn truth(&self, column: &str) -> Option<(&'static str, &'static str, bool)> {
        self.truth[column[1..].parse::<usize>().unwrap() - 1]
    }

    fn is_right(&self, placed: &Placed) -> bool {
        self.truth(&placed.column)
            == Some((placed.channel.as_str(), placed.unit.as_str(), placed.is_reversed))
    }
}

/// How many of the channels are placed; none wrongly.
fn placed(seeds: std::ops::Range<u64>) -> f64 {
    let (mut right, mut all) = (0, 0);
    for seed in seeds {
        let mixed = mixed(seed);
        let clock = mixed.guess.clock.as_ref().unwrap_or_else(|| panic!("{seed}: no clock"));
        let (name, unit, _) = mixed.truth(&clock.column).unwrap_or(("", "", false));
        assert_eq!((name, unit), ("t", if clock.unit == TimeUnit::Ms { "ms" } else { "s" }), "{seed}");
        for placed in &mixed.guess.placed {
            assert!(mixed.is_right(placed), "{seed}: {placed:?} is {:?}", mixed.truth(&placed.column));
        }
        right += mixed.guess.placed.len() + 1;
        all += NAMES.len();
        let asked = mixed.guess.asked.iter().map(|question| question.channel.as_str());
        let named: Vec<&str> =
            asked.chain(mixed.guess.placed.iter().map(|own| own.channel.as_str())).collect();
        assert!(named.contains(&"delta") && named.contains(&"n"), "{seed}: {named:?}");
    }
    f64::from(u32::try_from(right).unwrap()) / f64::from(all as u32)
}

#[test]
fn law_columns_of_made_trials_are_found_and_none_wrongly() {
    let share = placed(0..30);
    assert!(share > 0.75, "{share}");
}

#[test]
#[ignore = "long: `make nightly` runs it"]
fn law_columns_of_many_made_trials_are_found_and_none_wrongly() {
    let share = placed(1000..2000);
    assert!(share > 0.75, "{share}");
}

/// A guess of these trials whose columns are called `names`, for a ship with rudder and propeller.
fn guessed(names: &[&str], trials: Vec<Vec<Vec<f64>>>) -> Guess {
    let cells: Vec<Vec<String>> =
        trials[0].iter().map(|column| column.iter().take(99).map(f64::to_string).collect()).collect();
    let head = Head::of_cells(names.iter().map(|name| (*name).to_owned()).collect(), &cells);
    let needed = [("n", "1/s"), ("delta", "rad")];
    let needed = needed.map(|(channel, unit)| Needed { channel: channel.to_owned(), unit: unit.to_owned() });
    Guess::of(&head, &LoggedTable::of(trials.into_iter().map(|columns| (1, columns)).collect()), &needed)
}

/// The same with columns that are called `c1` and so on.
fn unnamed(trials: Vec<Vec<Vec<f64>>>) -> Guess {
    let names: Vec<String> = (1..=trials[0].len()).map(|i| format!("c{i}")).collect();
    guessed(&names.iter().map(String::as_str).collect::<Vec<_>>(), trials)
}

const PLAIN: [&str; 9] = ["a", "b", "c", "d", "e", "f", "g", "h", "i"];

pub fn trials(seed: u64, count: usize) -> Vec<Vec<Vec<f64>>> {
    let mut draw = Draw(seed);
    (0..count).map(|_| trial(&mut draw, 0.5)).collect()
}

fn columns_of(guess: &Guess) -> Vec<(&str, &str)> {
    guess.placed.iter().map(|own| (own.channel.as_str(), own.column.as_str())).collect()
}

#[test]
fn logs_at_rest_say_nothing() {
    let still = trials(1, 3).into_iter().map(|columns| {
        let rest =
            columns.iter().enumerate().map(|(i, c)| if i == 0 { c.clone() } else { vec![c[0]; c.len()] });
        rest.collect()
    });
    let guess = guessed(&PLAIN, still.collect());
    assert_eq!((guess.clock.unwrap().column.as_str(), guess.placed.len()), ("a", 0));
    assert_eq!((guess.asked.len(), guess.missing.len()), (0, 2));
}

#[test]
fn of_one_recording_actuators_are_asked_and_answered() {
    let mut guess = guessed(&PLAIN, trials(2, 1));
    let motion = [("y_u", "e"), ("y_v", "f"), ("y_r", "g"), ("x", "b"), ("y", "c"), ("psi", "d")];
    assert_eq!(columns_of(&guess), motion);
    let asked = |guess: &Guess| guess.asked.iter().map(|own| own.channel.clone()).collect::<Vec<_>>();
    assert_eq!(asked(&guess), ["n", "delta"]);
    let rudder = &guess.asked[1].choices;
    assert!(rudder[0].placed.column == "h" && rudder[0].why.starts_with("gain "), "{rudder:?}");
    guess.answer(1, 0);
    assert_eq!((asked(&guess), guess.missing.len()), (vec!["n".to_owned()], 1));
    assert_eq!(guess.placed.last().unwrap().column, "h");
}

#[test]
fn an_order_beside_its_answer_is_asked_or_its_name_decides() {
    let with_order = || {
        let add = |mut columns: Vec<Vec<f64>>| {
            let helm = columns[7].clone();
            columns.push((0..ROWS).map(|row| helm[(row + 3).min(ROWS - 1)]).collect());
            columns
        };
        trials(3, 4).into_iter().map(add).collect::<Vec<_>>()
    };
    let guess = guessed(&[&PLAIN[..], &["j"]].concat(), with_order());
    let asked = guess.asked.iter().find(|own| own.channel == "delta").unwrap();
    let choices: Vec<&str> = asked.choices.iter().map(|own| own.placed.column.as_str()).collect();
    assert!(choices.contains(&"h") && choices.contains(&"j"), "{choices:?}");
    let names = [&PLAIN[..7], &["rudder", "i", "rudder_setpoint"]].concat();
    assert!(columns_of(&guessed(&names, with_order())).contains(&("delta", "rudder")));
    // A set point is taken for nothing, even where nothing else is there.
    let names = [&PLAIN[..7], &["rudder_setpoint", "i"]].concat();
    let guess = guessed(&names, trials(3, 4));
    assert!(columns_of(&guess).iter().all(|(channel, _)| *channel != "delta"));
}

#[test]
fn a_copy_of_a_column_changes_nothing() {
    let copied = trials(4, 4).into_iter().map(|mut columns| {
        columns.push(columns[3].iter().map(|psi| psi.to_degrees()).collect());
        columns
    });
    let guess = guessed(&[&PLAIN[..], &["j"]].concat(), copied.collect());
    let psi = guess.placed.iter().find(|own| own.channel == "psi").unwrap();
    assert!([("d", "rad"), ("j", "deg")].contains(&(psi.column.as_str(), psi.unit.as_str())), "{psi:?}");
}

#[test]
fn thrust_that_never_changes_is_asked_or_missing() {
    let steady = trials(5, 4).into_iter().map(|mut columns| {
        columns[8].fill(8.0);
        columns
    });
    let guess = guessed(&PLAIN, steady.collect());
    assert!(guess.missing.iter().any(|need| need.channel == "n"));
    assert!(columns_of(&guess).iter().all(|(channel, _)| *channel != "n"));
}

#[test]
fn a_compass_that_jumps_is_not_taken_for_sure() {
    let jumping = trials(6, 4).into_iter().map(|mut columns| {
        columns[3]
            .iter_mut()
            .enumerate()
            .for_each(|(row, psi)| *psi += if row / 60 % 2 == 0 { 0.0 } else { 0.8 });
        columns
    });
    let guess = guessed(&PLAIN, jumping.collect());
    for (channel, column) in columns_of(&guess) {
        let at = NAMES.iter().position(|name| *name == channel).unwrap();
        assert_eq!(column, PLAIN[at], "{channel}");
    }
}

#[test]
fn earth_fixed_speeds_and_degrees_are_found() {
    let moved = trials(7, 4).into_iter().map(|mut columns| {
        let [psi, u, v] = [3, 4, 5].map(|at| columns[at].clone());
        for row in 0..ROWS {
            let (sin, cos) = psi[row].sin_cos();
            (columns[4][row], columns[5][row]) = (u[row] * cos - v[row] * sin, u[row] * sin + v[row] * cos);
        }
        columns
    });
    let guess = guessed(&PLAIN, moved.collect());
    let found = columns_of(&guess);
    assert!(found.contains(&("v_x", "e")) && found.contains(&("v_y", "f")), "{found:?}");
    let on_earth = trials(8, 4).into_iter().map(|mut columns| {
        columns[1].iter_mut().for_each(|x| *x = 60.1 + *x / 111_200.0);
        columns[2].iter_mut().for_each(|y| *y = 24.9 + *y / 111_200.0 / 60.1_f64.to_radians().cos());
        columns
    });
    let guess = guessed(&PLAIN, on_earth.collect());
    let found = columns_of(&guess);
    assert!(found.contains(&("latitude_deg", "b")) && found.contains(&("longitude_deg", "c")), "{found:?}");
    assert!(!guess.is_east);
}

#[test]
fn of_set_points_alone_nothing_is_taken() {
    let names = [
        "t",
        "x_ref",
        "y_ref",
        "heading_setpoint",
        "speed_cmd",
        "v_set",
        "rate_error",
        "rudder_order",
        "rpm_target",
    ];
    let guess = guessed(&names, trials(12, 4));
    assert_eq!((columns_of(&guess), guess.asked.len(), guess.missing.len()), (vec![], 0, 2));
}

/// Published sets: their folders, and how their columns are called in the order of [`NAMES`].
pub const PUBLISHED: [(&str, &str); 2] = [
    (
        "esso_osaka",
        "t [s],x_position_mid [m],y_position_mid [m],psi_hat [rad],u_velo [m/s],vm_velo [m/s],r_angvelo [rad/s],delta_rudder \
         [rad],n_prop [rps]",
    ),
    ("kvlcc2_hsva", "t_s,x_m,y_m,psi_rad,u_mps,v_mps,r_radps,delta_rad,thrust_N"),
];
const UNITS: [&str; 7] = ["s", "m", "m", "rad", "m/s", "m/s", "rad/s"];

/// Recordings by columns, and which of these are meant.
pub type Published = (Vec<Vec<Vec<f64>>>, Vec<usize>);

/// The recordings of a published set, if it is there, and the place of each channel among the columns.
pub fn published((folder, columns): &(&str, &str)) -> Option<Published> {
    let (mut folders, mut files) =
        (vec![format!("../../../shared/data/{folder}").into()], Vec::<PathBuf>::new());
    while let Some(folder) = folders.pop() {
        for entry in std::fs::read_dir(folder).ok()? {
            let path = entry.unwrap().path();
            match path.extension() {
                None => folders.extend(path.is_dir().then_some(path)),
                Some(end) => files.extend((end == "csv").then_some(path)),
            }
        }
    }
    files.sort();
    let texts: Vec<String> = files.iter().map(|path| std::fs::read_to_string(path).unwrap()).collect();
    let head = Head::of_csv(&texts[0]).unwrap();
    let read = |text: &String| head.numbers_of(text.as_bytes(), 1).unwrap();
    let place = |name: &str| head.columns.iter().position(|own| own == name).unwrap();
    Some((texts.iter().map(read).collect(), columns.split(',').map(place).collect()))
}

#[test]
fn oracle_columns_of_published_logs_are_found_without_names() {
    let (mut sure, mut named, mut all) = (0, 0, 0);
    for set in &PUBLISHED {
        let Some((recordings, places)) = published(set) else { return };
        let degrees = 180.0 / PI;
        // Which channels are logged otherwise, by how much and in which unit.
        let changes: [(&[usize], f64, &str); 8] = [
            (&[], 1.0, ""),
            (&[3], degrees, "deg"),
            (&[6], 60.0 * degrees, "deg/min"),
            (&[4, 5], 3600.0 / 1852.0, "kn"),
            (&[4, 5], 3.6, "km/h"),
            (&[0], 1e3, "ms"),
            (&[5, 6], -1.0, ""),
            (&[2], -1.0, ""),
        ];
        for (changed, by, unit) in changes {
            let mut recordings = recordings.clone();
            for recording in &mut recordings {
                for i in changed {
                    recording[places[*i]].iter_mut().for_each(|value| *value *= by);
                }
            }
            let guess = unnamed(recordings);
            for (i, channel) in NAMES.iter().enumerate() {
                let column = format!("c{}", places[i] + 1);
                let unit = if changed.contains(&i) && !unit.is_empty() { Some(&unit) } else { UNITS.get(i) };
                all += 1;
                if i == 0 {
                    let clock = guess.clock.as_ref().unwrap();
                    assert_eq!((&clock.column, clock.unit == TimeUnit::Ms), (&column, unit == Some(&"ms")));
                    (sure, named) = (sure + 1, named + 1);
                } else if let Some(own) = guess.placed.iter().find(|own| own.channel == **channel) {
                    let is_right = own.column == column && unit.is_none_or(|unit| own.unit == **unit);
                    assert!(is_right, "{}: {own:?}", set.0);
                    (sure, named) = (sure + 1, named + 1);
                } else if let Some(question) = guess.asked.iter().find(|own| own.channel == **channel) {
                    named += usize::from(question.choices.iter().any(|own| own.placed.column == column));
                }
            }
        }
    }
    assert!(4 * sure >= 3 * all && 100 * named >= 92 * all, "{sure} sure, {named} named of {all}");
}

#[test]
fn oracle_reversed_steering_and_hauls_are_named_in_published_logs_and_nothing_else() {
    for set in &PUBLISHED {
        let Some((recordings, places)) = published(set) else { return };
        // Means over a second.
        let each = |columns: &Vec<Vec<f64>>| {
            let rows = (1.0 / (columns[places[0]][1] - columns[places[0]][0])).round() as usize;
            let mean = |i: &usize| {
                columns[places[*i]].chunks(rows).map(|own| own.iter().sum::<f64>() / own.len() as f64)
            };
            SampledRecording { runs: vec![[4, 5, 6, 7, 8].iter().map(|i| mean(i).collect()).collect()] }
        };
        let all: Vec<SampledRecording> = recordings.iter().map(each).collect();
        let all: Vec<_> =
            all.into_iter().filter(|own| own.runs[0].iter().flatten().all(|x| x.is_finite())).collect();
        let against = |all: &[SampledRecording]| -> Vec<usize> {
            let judged = judged(all, 1.0);
            (0..all.len()).filter(|at| matches!(judged[*at], Agreement::Against(_))).collect()
        };
        assert_eq!(against(&all), Vec::<usize>::new(), "{}", set.0);
        let mut found = 0;
        for at in 0..all.len() {
            let mut turned = all.clone();
            turned[at].runs[0][3].iter_mut().for_each(|helm| *helm = -*helm);
            let named = against(&turned);
            assert!(named.iter().all(|other| *other == at), "{} {at}: {named:?}", set.0);
            found += named.len();
        }
        assert!(4 * found >= 3 * all.len(), "{found} of {}", all.len());
        // Hauled back.
        let (mut found, mut tried) = (0, 0);
        for at in (0..all.len()).step_by(4) {
            let mut hauled = all.clone();
            hauled[at].runs[0][0].iter_mut().for_each(|surge| *surge = -*surge);
            let named = against(&hauled);
            assert!(named.iter().all(|other| *other == at), "{} {at}: {named:?}", set.0);
            (found, tried) = (found + named.len(), tried + 1);
        }
        assert!(4 * found >= 3 * tried, "{found} of {tried}");
    }
}

fn sampled(trials: &[Vec<Vec<f64>>]) -> Vec<SampledRecording> {
    let of = |columns: &Vec<Vec<f64>>| SampledRecording {
        runs: vec![[4, 5, 6, 7, 8].map(|at| columns[at].clone()).to_vec()],
    };
    trials.iter().map(of).collect()
}

#[test]
fn law_a_recording_with_reversed_steering_is_named_and_no_other() {
    for at in 0..8 {
        let mut all = trials(9, 8);
        all[at][7].iter_mut().for_each(|helm| *helm = -*helm);
        let judged = judged(&sampled(&all), DT);
        for (other, own) in judged.iter().enumerate() {
            assert_eq!(
                matches!(own, Agreement::Against(why) if why.contains("steering")),
                other == at,
                "{at}: {judged:?}"
            );
        }
    }
}

#[test]
fn a_recording_that_is_hauled_is_named_and_one_that_hardly_steers_is_not_judged() {
    let mut all = trials(10, 7);
    all.push(trial(&mut Draw(11), 0.004));
    all[2][4].iter_mut().for_each(|u| *u *= -0.5);
    let judged = judged(&sampled(&all), DT);
    assert!(matches!(&judged[2], Agreement::Against(_)), "{judged:?}");
    assert!(matches!(&judged[7], Agreement::Unjudged(_)), "{judged:?}");
    assert_eq!(judged.iter().filter(|own| **own == Agreement::Alike).count(), 6, "{judged:?}");
}
