//! Fault injection through the real binary: damaged inputs, failing and killed writing, full disks, closed outputs,
//! two writers at once. CI tries a bounded, fixed part of it; `make faults CASES=100000` tries more of the same and
//! prints the results.

#[path = "../../../chart/tests/all/enc/made.rs"]
mod made;
#[path = "../plans/planned.rs"]
#[allow(dead_code)]
mod planned;
#[path = "../support/mod.rs"]
mod support;

mod corpus;
mod damage;
mod ends;
mod foreign;
mod fuzz;
mod grounds;
mod kills;
mod mixtures;
mod named;
mod numbers;
mod outputs;
mod places;
mod points;
mod readers;
mod sets;
mod strangers;
mod tables;

/// The number of cases of `make faults CASES=100000`: damaged inputs, and a tenth as many kills and failing places.
pub fn asked() -> Option<u64> {
    std::env::var("SEATRIAL_CASES").ok().and_then(|cases| cases.parse().ok())
}
