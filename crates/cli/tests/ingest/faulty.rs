//! Healthy logs with one fault at random: the motion is right, or the log is refused, or the output says what is
//! wrong. `SEATRIAL_CASES` sets the number of each kind.

use study::documents::WarningKind;

use crate::known::*;
use crate::runner::*;

/// Numbers that follow from a seed (SplitMix64).
struct Random(u64);

impl Random {
    fn next(&mut self) -> u64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        z ^ (z >> 31)
    }

    fn below(&mut self, n: usize) -> usize {
        (self.next() % n as u64) as usize
    }

    fn pick<T: Copy>(&mut self, of: &[T]) -> T {
        of[self.below(of.len())]
    }

    fn within(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * (self.next() >> 11) as f64 / (1_u64 << 53) as f64
    }
}

/// The table's columns, their channels and units; places first.
const CHANNELS: [[&str; 3]; 8] = [
    ["x", "x", "m"],
    ["y", "y", "m"],
    ["u", "y_u", "m/s"],
    ["v", "y_v", "m/s"],
    ["r", "y_r", "rad/s"],
    ["psi", "psi", "deg"],
    ["delta", "delta", "deg"],
    ["n", "n", "rpm"],
];

/// The values of all columns, second by second.
fn table() -> Vec<[f64; 8]> {
    let rows = rows(60).into_iter().zip(track(60));
    rows.map(|([u, v, r, psi, delta, n], [x, y])| [x, y, u, v, r, psi, delta, n]).collect()
}

/// A log and its configuration.
struct Log {
    rows: Vec<[f64; 8]>,
    /// Keys of each channel in addition to [`CHANNELS`].
    keys: [String; 8],
    units: [&'static str; 8],
    /// Whether the places are read.
    places: bool,
}

impl Log {
    fn healthy() -> Self {
        Self { rows: table(), keys: Default::default(), units: CHANNELS.map(|[.., unit]| unit), places: true }
    }

    fn folder(&self) -> tempfile::TempDir {
        let of = |(i, [column, channel, _]): (usize, [&str; 3])| {
            let (unit, keys) = (self.units[i], &self.keys[i]);
            format!("{{ column = \"{column}\", channel = \"{channel}\", unit = \"{unit}\"{keys} }},\n")
        };
        let first = if self.places { 0 } else { 2 };
        let channels: String = CHANNELS.into_iter().enumerate().skip(first).map(of).collect();
        let config = format!(
            "sample_rate_hz = 1.0\nmax_gap_s = 1.5\nvelocities = {{ window_s = 5.0 }}\n[[file]]\npattern = [\"*.csv\"]\n\
             time = {{ column = \"t\", unit = \"s\" }}\nchannel = [\n{channels}]\n"
        );
        let line =
            |(t, row): (usize, &[f64; 8])| format!("{t},{}\n", row.map(|cell| format!("{cell}")).join(","));
        let lines: String = self.rows.iter().enumerate().map(line).collect();
        let header = CHANNELS.map(|[column, ..]| column).join(",");
        folder(&[("ingest.toml", &config), ("a.csv", &format!("t,{header}\n{lines}"))])
    }
}

/// Whether inputs and heading, too, are those of the motion.
fn all_healthy(made: &Made) -> bool {
    let near = |name: &str, truth: &dyn Fn(f64) -> f64, within: f64| {
        let off = made.f64(name).iter().zip(made.f64("t")).map(|(value, t)| (value - truth(*t)).powi(2));
        let known: Vec<f64> = off.filter(|off| off.is_finite()).collect();
        (known.iter().sum::<f64>() / known.len() as f64).sqrt() < within
    };
    let [u, v, r] = off(made, 0.0);
    u < 0.02
        && v < 0.02
        && r < 0.002
        && made.summary.runs == 1
        && near("psi", &heading, 0.02)
        && near("delta", &|t| rudder(t).to_radians(), 0.05)
        && near("n", &|t| revolutions(t) / 60.0, 0.05)
}

/// Must be healthy, refused, or say in words that name one of `channels` what is wrong.
#[track_caller]
fn not_silent(folder: &std::path::Path, channels: &[&str], case: &str) {
    let target = folder.join("out/trajectories.parquet");
    std::fs::create_dir_all(target.parent().unwrap()).unwrap();
    let ran = run(folder, &["--config", "ingest.toml", "--out", target.to_str().unwrap()]);
    if ran.code == Some(3) {
        assert!(ran.stderr.len() < 500, "{case}: {}", ran.stderr);
        return;
    }
    assert_eq!(ran.code, Some(0), "{case}: {}", ran.stderr);
    let made = read(folder);
    let told = made.summary.recordings.iter().any(|r| {
        let omitted = r.omitted.iter().map(|one| one.channel.as_str());
        let is_odd = |kind: WarningKind| kind != WarningKind::Rate;
        let odd = r.warnings.iter().filter(|w| is_odd(w.kind)).map(|w| w.channel.as_str());
        !r.doubtful.is_empty() || omitted.chain(odd).any(|channel| channels.contains(&channel))
    });
    assert!(told || all_healthy(&made), "{case}: silent: {}", made.line);
}

fn cases(kind: u64, case: impl Fn(&mut Random, &str)) {
    let count = std::env::var("SEATRIAL_CASES").map_or(25, |cases| cases.parse().unwrap());
    for i in 0..count {
        case(&mut Random(kind << 32 | i), &format!("case {i}"));
    }
}

/// Indices of `count` consecutive rows.
fn row_range(random: &mut Random, count: usize) -> std::ops::Range<usize> {
    let first = random.below(62 - count);
    first..first + count
}

#[test]
fn the_healthy_table_is_read_without_a_word() {
    let made = read(Log::healthy().folder().path());
    assert!(all_healthy(&made), "{}", made.line);
    let recording = &made.summary.recordings[0];
    assert_eq!(
        (recording.omitted.len(), recording.warnings.len(), recording.doubtful.len()),
        (0, 0, 0),
        "{recording:?}"
    );
}

#[test]
fn numbers_that_stand_for_no_value_are_never_silent() {
    const RAW: [f64; 9] =
        [65_535.0, 655.35, -9_999.0, 9_999.0, 32_767.0, -32_768.0, 1e20, 2_147_483_647.0, -999.0];
    cases(1, |random, case| {
        let (mut log, column, none) = (Log::healthy(), random.below(8), random.pick(&RAW));
        log.places = column < 2 || random.below(2) == 0;
        if random.below(2) == 0 {
            // Whole numbers that a scale turns into values.
            log.keys[column] = ", scale = 0.001".to_owned();
            log.rows.iter_mut().for_each(|row| row[column] = (1000.0 * row[column]).round());
        }
        for _ in 0..=random.below(3) {
            let count = 1 + random.below(3);
            row_range(random, count).for_each(|row| log.rows[row][column] = none);
        }
        let channel = CHANNELS[column][1];
        not_silent(log.folder().path(), &[channel], &format!("{case}: {none} in {channel}"));
    });
}

#[test]
fn fixes_at_0_n_0_e_are_never_silent() {
    cases(2, |random, case| {
        let mut epochs = epochs(60);
        let fixes = 1 + random.below(4);
        let places = [
            "0000.0000000,N,00000.0000000,E",
            "0000.0000000,N,02454.0000000,E",
            "6006.0000000,N,00000.0000000,E",
        ];
        let wrong = random.pick(&places);
        for row in row_range(random, fixes) {
            for body in &mut epochs[row].bodies {
                *body = replaced(body, wrong);
            }
        }
        let config = nmea_config("RMC", "HDT.heading", "");
        let folder = folder(&[("ingest.toml", &config), ("a.nmea", &nmea(&epochs))]);
        not_silent(
            folder.path(),
            &["latitude_deg", "longitude_deg", "x", "y"],
            &format!("{case}: {fixes} at {wrong}"),
        );
    });
}

/// A body with another place, if it has one.
fn replaced(body: &str, place: &str) -> String {
    let mut fields: Vec<&str> = body.split(',').collect();
    if let Some(first) =
        fields.iter().position(|field| ["N", "S"].contains(field)).filter(|_| body.starts_with("GP"))
    {
        fields.splice(first - 1..first + 3, [place]);
    }
    fields.join(",")
}

#[test]
fn places_that_jump_are_never_silent() {
    cases(3, |random, case| {
        let mut log = Log::healthy();
        let (metres, course) =
            (10_f64.powf(random.within(1.0, 5.0)), random.within(0.0, std::f64::consts::TAU));
        let fixes = [1, 2, 3, 5, 30][random.below(5)];
        for row in row_range(random, fixes) {
            log.rows[row][0] += metres * course.cos();
            log.rows[row][1] += metres * course.sin();
        }
        not_silent(log.folder().path(), &["x", "y"], &format!("{case}: {fixes} places {metres} m off"));
    });
}

#[test]
fn sensors_that_freeze_while_the_ship_moves_are_never_silent() {
    cases(4, |random, case| {
        let mut log = Log::healthy();
        let (columns, count) = (random.pick(&[[0, 1], [2, 2], [3, 3], [4, 4], [5, 5]]), 8 + random.below(12));
        // The motion begins with a sway of zero, below what an instrument resolves.
        let first = 1 + random.below(61 - count);
        for row in first + 1..first + count {
            let before = log.rows[row - 1];
            columns.into_iter().for_each(|column| log.rows[row][column] = before[column]);
        }
        let channels = columns.map(|column| CHANNELS[column][1]);
        not_silent(log.folder().path(), &channels, &format!("{case}: {channels:?} for {count} s"));
    });
}

#[test]
fn other_units_and_scales_of_the_motion_are_never_silent() {
    const UNITS: [&[&str]; 4] = [
        &["m/s", "knot", "km/h", "cm/s", "ft/s"],
        &["rad/s", "deg/s", "deg/min"],
        &["m", "km", "ft", "cm", "nmi"],
        &["rad", "deg"],
    ];
    cases(5, |random, case| {
        let mut log = Log::healthy();
        let columns = random.pick(&[[0, 1], [2, 3], [4, 4], [5, 5]]);
        let own = log.units[columns[0]];
        let units = UNITS.into_iter().find(|units| units.contains(&own)).unwrap();
        let (unit, scale) =
            (random.pick(units), random.pick(&[1.0, 0.1, 10.0, 0.01, 100.0, 0.75, 1.25, -1.0]));
        for column in columns {
            log.units[column] = unit;
            log.keys[column] = format!(", scale = {scale:.2}");
        }
        let channels = ["x", "y", "y_u", "y_v", "y_r", "psi"];
        not_silent(log.folder().path(), &channels, &format!("{case}: {columns:?} in {unit}, {scale} times"));
    });
}

#[test]
fn places_that_come_late_are_never_silent() {
    cases(6, |random, case| {
        let mut log = Log::healthy();
        let late = 1 + random.below(5);
        for row in (0..61_usize).rev() {
            let from = log.rows[row.saturating_sub(late)];
            (log.rows[row][0], log.rows[row][1]) = (from[0], from[1]);
        }
        not_silent(log.folder().path(), &["x", "y", "y_u", "y_v"], &format!("{case}: {late} s late"));
    });
}

#[test]
fn a_heading_that_is_off_is_never_silent() {
    cases(7, |random, case| {
        let mut log = Log::healthy();
        let off = random.within(1.5, 40.0) * random.pick(&[1.0, -1.0]);
        log.rows.iter_mut().for_each(|row| row[5] += off);
        not_silent(log.folder().path(), &["psi"], &format!("{case}: {off} deg off"));
    });
}
