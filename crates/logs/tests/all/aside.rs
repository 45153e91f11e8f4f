//! Long channels, blocks of which are put aside.

use std::fmt::Write;
use std::sync::{Arc, Mutex};

use logs::{
    Conventions, Cut, Derived, FileSpec, Formula, Law, Lever, Log, Method, NonMonotonic, Plan, Propulsor,
    Recorded, Samples, Segmentation, Setup, Source, SpeedClasses, Store, Thruster, read_csv, record,
};

use crate::declared;

/// Keeps blocks of a few values, so that every seam between two of them is met.
#[derive(Debug)]
struct Few {
    block: usize,
    kept: Mutex<Vec<Option<Vec<f64>>>>,
}

impl Few {
    fn new(block: usize) -> Arc<Self> {
        Arc::new(Self { block, kept: Mutex::default() })
    }

    fn left(&self) -> [usize; 2] {
        let kept = self.kept.lock().unwrap();
        [kept.len(), kept.iter().flatten().count()]
    }
}

impl Store for Few {
    fn block(&self) -> usize {
        self.block
    }

    fn put(&self, values: &[f64]) -> u64 {
        let mut kept = self.kept.lock().unwrap();
        kept.push(Some(values.to_vec()));
        kept.len() as u64 - 1
    }

    fn get(&self, place: u64, values: &mut Vec<f64>) {
        values.extend(self.kept.lock().unwrap()[place as usize].as_ref().unwrap());
    }

    fn forget(&self, place: u64) {
        self.kept.lock().unwrap()[place as usize].take().unwrap();
    }
}

#[test]
fn values_are_the_same_in_blocks_and_in_one() {
    let few = Few::new(3);
    let store: Arc<dyn Store> = few.clone();
    let all: Vec<f64> = (0..11).map(f64::from).collect();
    let mut samples = Samples::new(&store).made(all.iter().copied());
    assert_eq!((samples.len(), samples.first(), samples.last()), (11, Some(0.0), Some(10.0)));
    for range in [0..11, 2..3, 5..10, 9..11, 4..4] {
        assert!(samples.range(range.clone()).eq(all[range].iter().copied()));
    }
    assert_eq!(samples, Samples::from(all.clone()));
    for len in [20, 10, 9, 7, 3, 1, 0] {
        samples.truncate(len);
        assert_eq!(samples.to_vec(), all[..len.min(11)]);
    }
    samples.push(5.0);
    assert_eq!((samples.to_vec(), few.left()), (vec![5.0], [3, 0]));
}

/// A log at about 10 Hz with gaps, missing values, rows out of order and a blank line.
fn log() -> String {
    let mut text = "t,lat,lon,psi,v,r,n,a,label\n".to_owned();
    for k in 0..400_u32 {
        // Neighbours change places now and then.
        let k = if k % 37 == 5 {
            k + 1
        } else if k % 37 == 6 {
            k - 1
        } else {
            k
        };
        let t = 0.1 * f64::from(k) + if k >= 150 { 3.0 } else { 0.0 } + 0.003 * f64::from(k % 3);
        let psi = 3.0 + 0.05 * t;
        let (lat, lon) = (55.0 + 2e-5 * t * psi.cos(), 12.0 + 3e-5 * t * psi.sin());
        let n = if k % 29 == 0 { String::new() } else { format!("{}", 60.0 + t) };
        let label = ["", "turn", "turn", "zigzag"][k as usize / 100];
        let psi = psi.to_degrees().rem_euclid(360.0);
        let (v, r) = (0.1 * (0.3 * t).sin(), 0.05 + 1e-3 * f64::from(k % 5));
        writeln!(text, "{t},{lat:.9},{lon:.9},{psi},{v},{r},{n},{},{label}", 5.0 + 10.0 * (0.2 * t).sin())
            .unwrap();
        if k == 77 {
            text.push_str(",,,,,,,,\n");
        }
    }
    text
}

fn setup(labels: bool, method: Method, average_s: Option<f64>) -> Setup {
    let channel = |(column, channel, unit): (&str, &str, &str)| {
        format!("[[channel]]\ncolumn = \"{column}\"\nchannel = \"{channel}\"\nunit = \"{unit}\"\n")
    };
    let channels = [
        ("lat", "latitude_deg", "deg"),
        ("lon", "longitude_deg", "deg"),
        ("psi", "psi", "deg"),
        ("v", "y_v", "m/s"),
        ("r", "y_r", "rad/s"),
        ("n", "n", "rpm"),
        ("a", "a", "deg"),
    ];
    let label = if labels { "label_column = \"label\"\n" } else { "" };
    let text = format!("pattern = [\"*.csv\"]\n{label}time = {{ column = \"t\", unit = \"s\" }}\n");
    let file: FileSpec = toml::from_str(&(text + &channels.map(channel).concat())).unwrap();
    let square = Formula::parse("n |n|").unwrap();
    let thruster = Thruster { law: Law::Quadratic, coefficient: 2.0, position_m: [-3.0, 0.5] };
    let conventions = Conventions {
        lever: Lever([4.0, 1.0]),
        derived: vec![Derived { channel: "nn".into(), formula: square, unit: "1".into() }],
        thrusters: vec![Propulsor { thruster, speed: "n".into(), angle: Some("a".into()), table: None }],
        average_s,
        ..declared::conventions(method, 7.0)
    };
    let non_monotonic = if labels { NonMonotonic::Sort } else { NonMonotonic::Drop };
    Setup {
        written_in: "ingest.toml",
        files: vec![file],
        conventions,
        max_gap_s: 0.5,
        non_monotonic,
        max_speed_m_s: 30.0,
    }
}

fn recorded(setup: Setup, cut: Cut, store: Option<&Arc<dyn Store>>) -> Recorded {
    let plan = Plan::new(setup, None).unwrap();
    let columns = read_csv(log().as_bytes(), None, &plan, 0, store).unwrap();
    let source = Source { name: "a".into(), files: vec![vec!["a.csv".into()]], kind: "sea".into() };
    let log = Log::new(columns, 0, &plan).unwrap();
    record(&source, vec![log], &plan, &Segmentation { cut, least: 2, each_is_a_run: false }).unwrap()
}

/// Every number of every run as bits, for some are NaN.
fn bits(recorded: &Recorded) -> Vec<Vec<u64>> {
    let mut all = Vec::new();
    for run in &recorded.runs {
        let bits = |values: &mut dyn Iterator<Item = f64>| values.map(f64::to_bits).collect::<Vec<_>>();
        all.extend((0..6).map(|i| bits(&mut run.exogenous(i))));
        all.extend((0..3).map(|d| bits(&mut run.measured(d))));
        all.extend((0..3).map(|i| bits(&mut run.further(i))));
        assert_eq!(bits(&mut run.detached().exogenous(1)), bits(&mut run.exogenous(1)));
    }
    all
}

#[test]
fn law_what_is_put_aside_changes_no_bit() {
    let names = ["slow", "fast"].map(String::from).into();
    let windows =
        Cut::Windows { samples: 40, tail: 15, classes: Some(SpeedClasses { bounds_m_s: vec![2.0], names }) };
    let cases = [
        (false, Method::Smoother, None, Cut::Whole),
        (false, Method::Euler, Some(0.7), windows),
        (true, Method::Smoother, Some(0.4), Cut::Labels),
    ];
    for (labels, method, average_s, cut) in cases {
        let expected = recorded(setup(labels, method, average_s), cut.clone(), None);
        assert!(expected.runs.len() > 1, "{cut:?}");
        for block in [1, 7, 64] {
            let few = Few::new(block);
            let store: Arc<dyn Store> = few.clone();
            let found = recorded(setup(labels, method, average_s), cut.clone(), Some(&store));
            assert_eq!(found.summary, expected.summary, "{cut:?}");
            assert!(bits(&found) == bits(&expected), "{cut:?} in blocks of {block}");
            drop(found);
            let [put, left] = few.left();
            assert!(put > 100 / block && left == 0, "{put} {left}");
        }
    }
}
