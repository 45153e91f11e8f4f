//! Fields keep the time of their own sentence, for any order of sentences.

use crate::known::*;
use crate::runner::*;
use crate::silent::{Draw, Faulty, none_is_silent};

fn made(config: &str, log: &str) -> Made {
    read(folder(&[("ingest.toml", config), ("a.nmea", log)]).path())
}

fn config(clock: &str) -> String {
    nmea_config(clock, "HDT.heading", "")
}

#[test]
fn a_place_before_the_clock_keeps_its_time() {
    let mut all = epochs(60);
    all.iter_mut().for_each(|epoch| epoch.bodies.swap(0, 1));
    healthy(&made(&config("RMC"), &nmea(&all)), 61);
}

#[test]
fn sentences_after_a_place_are_not_those_of_the_second_before() {
    let mut all = epochs(60);
    for epoch in &mut all {
        let clock = epoch.bodies.remove(0);
        // The clock ends the second that the place began.
        epoch.bodies.push(clock);
    }
    healthy(&made(&config("RMC"), &nmea(&all)), 61);
}

#[test]
fn a_place_that_comes_late_keeps_its_time() {
    for late in [3, 7, 14, 20] {
        let mut bodies: Vec<String> = epochs(60).into_iter().flat_map(|epoch| epoch.bodies).collect();
        let places: Vec<usize> = (0..bodies.len()).filter(|i| bodies[*i].starts_with("GPGGA")).collect();
        for i in places.into_iter().rev() {
            let place = bodies.remove(i);
            bodies.insert((i + late).min(bodies.len()), place);
        }
        let log: String = bodies.iter().map(|body| sentence(body) + "\r\n").collect();
        healthy(&made(&config("RMC"), &log), 61);
    }
}

#[test]
fn places_faster_than_the_clock_keep_their_times() {
    // Only every fifth second has a clock sentence.
    let mut all = epochs(60);
    for epoch in all.iter_mut().filter(|epoch| epoch.second % 5 > 0) {
        epoch.bodies.remove(0);
    }
    healthy(&made(&config("RMC"), &nmea(&all)), 61);
}

#[test]
fn places_of_another_clock_are_refused() {
    for off in [18, 3600, 40_000] {
        let mut all = epochs(60);
        for epoch in &mut all {
            let own = clock(epoch.second);
            let other = clock_from(9 * 3600 + 8 * 60 + 20 + off, epoch.second);
            epoch.bodies[1] = epoch.bodies[1].replace(&own, &other);
        }
        let folder = folder(&[("ingest.toml", &config("RMC")), ("a.nmea", &nmea(&all))]);
        refused_in(
            folder.path(),
            &[],
            &["times of GPGGA", "differ from those of RMC", "the first in line 2", "s away"],
        );
    }
}

#[test]
fn law_the_order_of_sentences_is_never_silent() {
    none_is_silent(221, |draw: &mut Draw| {
        let clock = *draw.one_of(&[&"RMC", &"GGA"]);
        let (late, share) = (draw.below(20), draw.share());
        let kind = *draw.one_of(&[&"GPGGA", &"GPRMC"]);
        let mut bodies: Vec<String> = epochs(60).into_iter().flat_map(|epoch| epoch.bodies).collect();
        let moved: Vec<usize> = (0..bodies.len()).filter(|i| bodies[*i].starts_with(kind)).collect();
        for i in moved.into_iter().rev() {
            // The clock itself cannot come late of all sentences but those with times.
            let late = if kind.ends_with(clock) { late.min(1) } else { late };
            if draw.share() < share {
                let body = bodies.remove(i);
                bodies.insert((i + late).min(bodies.len()), body);
            }
        }
        let log: String = bodies.iter().map(|body| sentence(body) + "\r\n").collect();
        let what = format!("{kind} up to {late} sentences late, clock {clock}");
        Faulty::new(&config(clock), "a.nmea", log, 61).named(&["late", "without_time", "time "]).what(what)
    });
}

#[test]
fn law_places_of_another_time_are_never_silent() {
    none_is_silent(222, |draw: &mut Draw| {
        let (off, from, length) = (draw.between(6, 80_000), draw.below(55), draw.between(1, 61));
        let mut all = epochs(60);
        for epoch in all.iter_mut().filter(|epoch| (from..from + length).contains(&epoch.second)) {
            let other = clock_from(9 * 3600 + 8 * 60 + 20 + off, epoch.second);
            epoch.bodies[1] = epoch.bodies[1].replace(&clock(epoch.second), &other);
        }
        let what = format!("{off} s off, {length} s from {from}");
        Faulty::new(&config("RMC"), "a.nmea", nmea(&all), 61).named(&[" time "]).what(what)
    });
}
