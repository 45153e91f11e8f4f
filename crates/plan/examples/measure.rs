//! Times the planner on made-up archipelagos: `measure [nx ny headings informative count seed limit_s costs]`, or on a lattice
//! problem from a file: `measure problem.json [seconds]`, with seconds as its secondary cost.

use std::time::Instant;

#[path = "../tests/all/lattice/seconds.rs"]
mod seconds;
#[path = "../tests/all/lattice/synthetic.rs"]
mod synthetic;

use plan::lattice::{Options, plan};

fn main() {
    let given: Vec<String> = std::env::args().skip(1).collect();
    let number = |k: usize, usual: u64| given.get(k).and_then(|text| text.parse().ok()).unwrap_or(usual);
    let size = |k: usize, usual: u64| number(k, usual) as usize;
    let (nx, ny, headings) = (size(0, 35), size(1, 44), size(2, 4));
    let mut file = match given.first().filter(|first| first.ends_with(".json")) {
        Some(path) => {
            let text = std::fs::read_to_string(path).expect("a file");
            serde_json::from_str(&text).expect("a lattice problem")
        }
        None => synthetic::archipelago(nx, ny, headings, size(3, 3), number(4, 3) as u32, number(5, 1)),
    };
    if given.get(7).is_some_and(|costs| costs == "seconds") {
        (file.basic[0].cost, file.basic[1].cost, file.basic[2].cost) = (12.5, 31.7, 31.7);
    }
    let started = Instant::now();
    let mut problem = file.into_problem().expect("a valid problem");
    if given.get(1).is_some_and(|then| then == "seconds") {
        problem = seconds::with_seconds(&problem);
    }
    let table = started.elapsed();
    let limit = std::time::Duration::from_secs(number(6, 60));
    let options = Options { memory_bytes: 8 << 30, ..Options::default() };
    let outcome = plan(&problem, &options, &mut |_| started.elapsed() < limit);
    let total = started.elapsed();
    println!("{} boxes, {} states", file.obstacles.len(), problem.states());
    println!("start {} goal {:?}", problem.start(), problem.goal());
    println!("table {table:?}, all {total:?}");
    match outcome {
        Ok(s) => {
            println!("{:?} cost {:?} bound {:?} steps {}", s.status, s.cost, s.lower_bound, s.steps.len());
        }
        other => println!("{other:?}"),
    }
}
