//! The numbers of whole plans, as they were when they were written down.

use std::collections::BTreeMap;

use lattice::Status;
use trial::voyage::{Check, WorstVessel};

use crate::golden::Table;
use crate::planned::{Planned, rich, small};

/// The walk over the lattice: cost, and a line per step.
fn walk(planned: &Planned) -> Table {
    let mut table = Table::default();
    let Planned { solved, sailing, prepared } = planned;
    assert_eq!(solved.solution.status, Status::Optimal);
    table.row("cost", [solved.solution.cost.primary, solved.solution.cost.secondary]);
    table.counts("lattice", [prepared.grid.nx, prepared.grid.ny, prepared.grid.layers()]);
    table.row("origin", prepared.grid.origin_m);
    table.row("uncharted", [prepared.uncharted_share()]);
    for wanted in &prepared.wanted {
        let name = format!("wanted {}", wanted.piece.maneuver);
        table.counts(name, [wanted.count as usize, wanted.piece.samples]);
    }
    for (step, leg) in solved.solution.steps.iter().zip(&sailing.legs) {
        let (from, to) = (step.from, step.to);
        let numbers = [from.i, from.j, from.layer, to.i, to.j, to.layer];
        table.counts(&prepared.legs[*leg].name, numbers);
    }
    for point in &solved.front {
        let counts = point.counts.values().map(|count| *count as f64);
        table.row("front", counts.chain([point.cost, point.informative_s]));
        table.rough("information", [point.log_det]);
    }
    table
}

/// The simulated legs: start, duration, that of the maneuver, place, heading, speed, error at the end, largest inputs.
fn legs(planned: &Planned) -> Table {
    let mut table = Table::default();
    for own in planned.plan().legs() {
        let times = [
            own.start_s,
            own.duration_s,
            own.maneuver_start_s.unwrap_or(-1.0),
            own.maneuver_s.unwrap_or(-1.0),
        ];
        let place = [own.longitude_deg, own.latitude_deg, own.heading_deg, own.speed_m_s, own.end_error_m];
        table.row(own.name, times.into_iter().chain(place).chain(own.largest_inputs.into_values()));
    }
    for (pose, state) in &planned.sailing.sailed.ends {
        // A heading by sine and cosine: π and −π are one.
        table.row("end", [pose.x, pose.y, pose.psi.sin(), pose.psi.cos()].into_iter().chain(*state));
    }
    table
}

/// The maneuvers as moves of the lattice, and all basic moves of a mode.
fn primitives(planned: &Planned) -> Table {
    let mut table = Table::default();
    for own in planned.plan().primitives() {
        let node = [own.h as f64, own.di as f64, own.dj as f64, own.to_h as f64, own.fits as f64];
        let times = [own.maneuver_s, own.leg_s, own.residual_m, own.residual_deg, own.spread_m];
        table.row(format!("{} {:?}", own.maneuver, own.side), node.into_iter().chain(times));
    }
    let mut basic: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for (index, own) in planned.prepared.legs.iter().enumerate().filter(|(_, own)| !own.is_informative()) {
        let (leg, end) = (&own.leg, own.end);
        let (_, mode) = planned.prepared.grid.level_and_mode(leg.from);
        let moved = [leg.from as f64, f64::from(leg.di), f64::from(leg.dj), leg.to as f64];
        let rest =
            [own.seconds(planned.rate_hz()), own.longest as f64, end.x, end.y, end.psi.sin(), end.psi.cos()];
        let fits = planned.solved.waters.fits_at(index) as f64;
        let numbers = moved.into_iter().chain(rest).chain([fits]);
        basic.entry(format!("{mode} {}", own.name)).or_default().extend(numbers);
    }
    basic.iter().for_each(|(name, numbers)| table.summed(name, numbers));
    table
}

/// The passage: a line per leg.
fn passage(planned: &Planned) -> Table {
    let mut table = Table::default();
    let own = planned.plan().passage();
    table.row("start", [own.longitude_deg, own.latitude_deg, own.leave_s, own.before.len() as f64]);
    for leg in &own.legs {
        let line = [leg.longitude_deg, leg.latitude_deg, leg.course_deg, leg.distance_m, leg.speed_m_s];
        let times = [leg.end_s, leg.leave_s, leg.turn_radius_m.unwrap_or(-1.0), leg.then.len() as f64];
        let wide = [leg.xtd_port_m, leg.xtd_starboard_m];
        let depth = [leg.least_depth_m, leg.under_keel_m].map(|depth| depth.unwrap_or(-1.0));
        let nearest = leg.nearest.as_ref().map_or([-1.0; 2], |own| [own.distance_m, own.bearing_deg]);
        table.row(&leg.what, line.into_iter().chain(times).chain(wide).chain(depth).chain(nearest));
    }
    let corridors = own.corridors(planned.prepared.chart.plane());
    let corners: Vec<f64> = corridors.into_iter().flatten().flatten().flatten().collect();
    table.summed("corridors", &corners);
    table
}

/// The check in continuous space, and the information.
fn check(planned: &Planned) -> Table {
    let mut table = Table::default();
    let Check { clearance_m, shortfall_m, sight_m, tolerance_used, proved_s, sailed_s, .. } =
        planned.sailing.check;
    let own = &planned.sailing.check;
    table.row("clearance", [clearance_m, shortfall_m, sight_m, tolerance_used]);
    table.row("seconds", [proved_s, sailed_s].into_iter().chain(own.sailed_quantiles_s));
    let counts =
        [own.runs, own.aground, own.below_margin, own.ends, own.ends_astray, own.rounds, own.left_area];
    table.row("counts", counts.into_iter().chain([own.aground_open_loop]).map(|count| count as f64));
    table.row("aground", own.aground_interval.into_iter().chain(own.aground_bound));
    table.row("clearances", own.clearance_quantiles_m);
    if let Some(worst) = &own.worst {
        let counts = [worst.searched, worst.aground, worst.below_margin, worst.ends, worst.ends_astray];
        table.row("searched", counts.map(|count| count as f64));
        table.row("worst", [worst.clearance_m, worst.tolerance_used]);
        for (name, who) in [("nearest", &worst.nearest), ("farthest", &worst.farthest)] {
            let WorstVessel { step, current_m_s, towards_deg, parameters_percent, .. } = who;
            let parameters = parameters_percent.values().copied();
            table.row(name, [*step as f64, *current_m_s, *towards_deg].into_iter().chain(parameters));
        }
    }
    let information = &planned.sailing.information;
    let found = [information.predicted_log_det, information.realised_log_det, information.whole_log_det];
    table.rough("information", found.into_iter().flatten().chain(information.efficiency));
    table.rough("design", information.design_efficiency.into_iter().chain([information.dimension as f64]));
    let inputs: Vec<f64> =
        planned.sailing.sailed.samples.iter().flat_map(|sample| sample.inputs.iter().copied()).collect();
    table.summed("inputs", &inputs);
    let tracks = planned.sailing.runs.iter().flatten().flat_map(|fix| [fix.pose.x, fix.pose.y]);
    table.summed("tracks", &tracks.collect::<Vec<_>>());
    table
}

/// The map.
fn map(planned: &Planned) -> Table {
    let mut table = Table::default();
    let plan = planned.plan();
    let frame = plan.frame();
    table.row("frame", frame.min.into_iter().chain(frame.max));
    table.row("shades", plan.shades_m().iter().copied());
    let raster = plan.raster();
    table.row("raster", [raster.nx as f64, raster.ny as f64, raster.cell_m].into_iter().chain(raster.origin));
    for (index, set) in plan.margins().iter().enumerate() {
        let places: Vec<f64> = (0..set.len()).filter(|k| set[*k]).map(|k| k as f64).collect();
        table.summed(format!("margin {index}"), &places);
    }
    table.counts("areas", plan.areas().iter().map(|area| area.rings.len()));
    for (place, name) in plan.names() {
        table.row(name, place);
    }
    let (grid, swept) = plan.swept().unwrap();
    let places: Vec<f64> = (0..swept.len()).filter(|k| swept[*k]).map(|k| k as f64).collect();
    table.summed("swept", &places);
    table.row("swept cells", [grid.cell_m]);
    for part in plan.track() {
        let points: Vec<f64> = part.points.concat();
        table.summed(format!("part {} {}", part.step, part.informative), &points);
    }
    plan.hulls().iter().for_each(|hull| table.summed("hull", &hull.concat()));
    for (name, lines) in ["longitudes", "latitudes"].iter().zip(plan.graticule()) {
        table.row(*name, lines.into_iter().flat_map(|(at, place)| [at, place]));
    }
    table
}

#[test]
fn golden_walk_of_the_small_trial() {
    walk(small()).assert(
        "
        cost 8 1624
        lattice 18 18 8
        origin -1056.3368 -1053.9533
        uncharted 0
        wanted_zig-zag-steep 1 180
        wanted_sway-zig-zag 1 240
        faster 2 9 1 2 10 5
        turn-starboard 2 10 5 3 11 4
        turn-starboard 3 11 4 4 10 7
        zig-zag-steep 4 10 7 5 7 7
        turn-starboard 5 7 7 4 6 6
        straight 4 6 6 3 6 6
        turn-starboard 3 6 6 2 7 5
        straight 2 7 5 2 8 5
        slower 2 8 5 2 9 1
        sway-zig-zag 2 9 1 2 9 1
        front 1 1 8 525
        ~information 16.9115977
        ",
    );
}

#[test]
fn golden_legs_of_the_small_trial() {
    legs(small()).assert("
        faster 0 137 -1 -1 24.9853702 60.000233 359.98733 0 0.305770978 25.3472222 0 0
        turn-starboard 137 154 -1 -1 24.9853697 60.0013101 359.98733 1.5 0.298395314 19.8004388 10.5048147 254.421531
        turn-starboard 291 154 -1 -1 24.9875199 60.0023874 89.9891918 1.5 0.32254698 19.75 10.5078292 254.453638
        zig-zag-steep 445 266 475 180 24.989671 60.0013105 179.991055 1.5 0.321863574 19.9115496 8.80434783 212.121212
        turn-starboard 711 154 -1 -1 24.9918224 59.9980794 179.992918 1.5 0.312901638 19.75 10.5059828 254.452784
        straight 865 80 -1 -1 24.9896723 59.9970021 269.991056 1.5 0.128176678 19.75 0.022207669 0.543854413
        turn-starboard 945 154 -1 -1 24.987522 59.997002 269.989194 1.5 0.317932074 19.75 10.5111955 254.453936
        straight 1099 80 -1 -1 24.9853712 59.9980788 359.987331 1.5 0.156669821 19.75 0.0214619004 0.526531814
        slower 1179 187 -1 -1 24.9853707 59.9991559 359.987331 1.5 0.714726723 16.6209528 0.00387961969 0.0534439959
        sway-zig-zag 1366 259 1366 240 24.9853702 60.000233 359.98733 0 0.452021302 0.391382384 23.4782609 0.303415262
        end 145.740933 -816.336802 0 1 1.49830626 0 0
        end 265.754231 -696.277649 0.999983392 0.00576327598 1.5 0 0.000118352908
        end 145.887686 -576.617426 0.00550818472 -0.99998483 1.5 0 0.000108688932
        end -213.855777 -456.643537 0.00635630008 -0.999979799 1.50001322 -0.00000663286426 0.000205070696
        end -333.667195 -576.463506 -0.999984177 -0.00562541194 1.5 0 0.000112961153
        end -333.931288 -696.463075 -0.999999893 -0.000463671165 1.5 0 0.0000146574506
        end -213.797681 -816.059557 -0.0054369971 0.999985219 1.5 0 0.000106379442
        end -93.7980849 -816.315474 -0.000449348206 0.999999899 1.5 0 0.0000142048007
        end 26.7614305 -816.336541 -0.0000000440043995 1 -0.0346370307 -0.0000137078476 0.0000000112868727
        end 25.8782498 -815.917342 -0.0000331316584 0.999999999 0.00645970523 -0.0466111635 -0.00000288247957
        ");
}

#[test]
fn golden_primitives_of_the_small_trial() {
    primitives(small()).assert(
        "
        zig-zag-steep_AsDesigned 0 4 -1 0 214 180 346 0.431275322 0.0356237667 13.2948964
        zig-zag-steep_Mirrored 0 3 1 0 235 180 266 0.388738439 -0.461377375 15.5510358
        zig-zag-steep_AsDesigned 1 1 4 1 215 180 346 0.431275322 0.0356237667 13.2948964
        zig-zag-steep_Mirrored 1 -1 3 1 234 180 266 0.388738439 -0.461377375 15.5510358
        zig-zag-steep_AsDesigned 2 -4 1 2 215 180 346 0.431275322 0.0356237667 13.2948964
        zig-zag-steep_Mirrored 2 -3 -1 2 235 180 266 0.388738439 -0.461377375 15.5510358
        zig-zag-steep_AsDesigned 3 -1 -4 3 215 180 346 0.431275322 0.0356237667 13.2948964
        zig-zag-steep_Mirrored 3 1 -3 3 235 180 266 0.388738439 -0.461377375 15.5510358
        sway-zig-zag_AsDesigned 0 0 0 0 315 240 259 0.419507172 0 27.2961033
        sway-zig-zag_Mirrored 0 0 0 0 315 240 259 0.419507172 0 27.3327426
        sway-zig-zag_AsDesigned 1 0 0 1 315 240 259 0.419507172 0 27.2961033
        sway-zig-zag_Mirrored 1 0 0 1 315 240 259 0.419507172 0 27.3327426
        sway-zig-zag_AsDesigned 2 0 0 2 315 240 259 0.419507172 0 27.2961033
        sway-zig-zag_Mirrored 2 0 0 2 315 240 259 0.419507172 0 27.3327426
        sway-zig-zag_AsDesigned 3 0 0 3 315 240 259 0.419507172 0 27.2961033
        sway-zig-zag_Mirrored 3 0 0 3 315 240 259 0.419507172 0 27.3327426
        0_faster 44 2316 2802.77692 158.015184
        0_straight 44 3436 3921.08032 243.398879
        0_turn-port 44 1712 1716.03012 94.1175133
        0_turn-starboard 44 1716 1720.03012 94.6630398
        1_slower 44 2708 3198.96078 191.261515
        1_straight 44 1868 2356 127.179953
        1_turn-port 44 2381 3352.4059 178.805193
        1_turn-starboard 44 2381 3352.4059 159.329117
        ",
    );
}

#[test]
fn golden_passage_of_the_small_trial() {
    passage(small()).assert("
        start 24.9853702 60.000233 0 0
        faster 24.9853697 60.0013101 359.98733 120 0.873680504 137 137 -1 0 4 4 -1 -1 704.737586 89.9945311
        straight 24.9853693 60.0023871 359.98733 119.999999 1.49983503 214 214 30 0 4 6.15135943 -1 -1 705.575682 92.7813956
        straight 24.9896706 60.0023875 89.9891917 240 1.5 368 368 30 0 4 6.69266891 -1 -1 493.496829 107.374856
        straight 24.989671 60.0013105 179.991055 120 1.5 445 445 -1 0 4 6.22526752 -1 -1 466.296871 94.2344505
        zig-zag-steep_(mirrored) 24.9918224 59.9980794 161.557038 379.473319 1.50814215 711 711 -1 0 31.0912237 19.5952132 -1 -1 346.472181 86.4958487
        straight 24.9918227 59.9970023 179.992918 120.000001 1.50000129 788 788 30 0 4 6.26955982 -1 -1 359.927398 73.4590153
        straight 24.9853716 59.9970017 269.990125 360 1.5 1022 1022 30 0 4 6.64981316 -1 -1 413.019979 58.4356317
        straight 24.9853707 59.9991559 359.987331 239.999999 1.5 1179 1179 -1 0 4 6.34518993 -1 -1 704.703578 89.8393374
        slower 24.9853702 60.000233 359.987331 120 0.664380366 1366 1625 -1 1 4 28.0143504 -1 -1 704.712635 89.9945315
        corridors 72 -25013.4143 31811.7824 -1975.20312
        ");
}

#[test]
fn golden_check_of_the_small_trial() {
    check(small()).assert(
        "
        clearance 337.520813 0 520 0.346370307
        seconds 1624 1625 1641 1655 1667
        counts 4 0 0 40 0 1 0 0
        aground 0 0.489890836 0.602364636
        clearances 333.75 334.3125 337.510406
        searched 65 0 0 650 0
        worst 330 0.414895655
        nearest 4 0.05 90 0 0 0 0 0 0 0 0 0 0
        farthest 4 0.05 261.452631 0 0 0 0 0 0 0 0 0 0
        ~information 16.9115977 31.4485615 59.0302605 3.05942806
        ~design 13
        inputs 4875 51394.9446 91077.7762 87.5375273
        tracks 13236 -4854062.1 5644297.17 -3402.61948
        ",
    );
}

#[test]
fn golden_map_of_the_small_trial() {
    map(small()).assert("
        frame -1116.3368 -1113.9533 1043.6632 1046.0467
        shades
        raster 72 72 30 -1116.3368 -1113.9533
        margin_0 36 95922 95922 10231.6949
        margin_1 36 95922 95922 10231.6949
        areas 1
        Holm 0 0.0016953311
        swept 1736 267641354 267641354 967918.82
        swept_cells 3.85714286
        part_0_false 276 -102681.217 122627.741 -2702.80431
        part_1_false 310 -85313.2239 157939.264 -2334.78552
        part_2_false 310 -57905.3734 130534.295 -1614.34915
        part_3_false 62 -14047.051 21697.1015 -1282.5259
        part_3_true 362 -96805.4807 104697.14 -1837.43242
        part_3_false 114 -35842.7539 35842.7539 -1712.99862
        part_4_false 310 -122512.583 122512.583 -2316.26344
        part_5_false 162 -78595.3041 78595.3041 -2721.60412
        part_6_false 310 -168499.213 168499.213 -3456.48864
        part_7_false 162 -78572.7502 78572.7502 -3069.54919
        part_8_false 376 -154858.466 159177.801 -3114.94952
        part_9_true 482 -187777.764 200257.378 -2945.68629
        part_9_false 40 -15783.1054 16815.9263 -1972.13858
        hull 10 -2380.77425 3383.65467 -922.461967
        hull 10 -3944.87555 4218.48986 -1421.0945
        longitudes 24.9833333 -930.00861 24.9916667 -465.004309 25 0 25.0083333 465.004309 25.0166667 930.00861
        latitudes 59.99 -1114.12185 59.9933333 -742.74803 59.9966667 -371.374021 60 0.000175729151 60.0033333 371.374562 60.0066667 742.749136
        ");
}

#[test]
fn golden_walk_of_the_rich_trial() {
    walk(rich()).assert(
        "
        cost 1233 2
        lattice 17 17 12
        origin -957.000016 -959.905116
        uncharted 0
        wanted_zig-zag-steep 2 120
        wanted_sway-zig-zag 1 240
        sway-zig-zag 1 8 1 1 8 1
        turn-starboard 1 8 1 1 8 0
        faster 1 8 0 2 8 4
        faster 2 8 4 3 8 8
        zig-zag-steep 3 8 8 5 6 11
        zig-zag-steep 5 6 11 4 3 11
        front 1 1 943 572
        ~information 13.768393
        front 1 2 1233 830
        ~information 19.8526791
        ",
    );
}

#[test]
fn golden_legs_of_the_rich_trial() {
    legs(rich()).assert("
        sway-zig-zag 0 314 0 240 24.985 60 359.98701 0 0.736455078 25.7767303 23.4782609 0.691989305
        turn-starboard 314 54 -1 -1 24.985 60 359.98701 0 0.0800641497 1.03373642 3.28050488 212.091722
        faster 368 210 -1 -1 24.985 60 89.9870096 0 0.141487312 23.1709218 3.1479024 6.1664284
        faster 578 105 -1 -1 24.9871505 60.0000002 89.988872 0.8 0.335616847 22.0507622 3.13038407 1.45828402
        zig-zag-steep 683 280 713 120 24.9893011 60.0000004 89.9907345 1.5 0.404229328 21.0320303 11.4304204 213.037014
        zig-zag-steep 963 270 993 120 24.9936026 59.9978465 179.99446 1.5 1.54261465 21.0789905 8.80434783 212.121212
        end 0.823528552 -837.106992 -0.0000000506624597 1 -0.0406386884 0.00573116469 0.0000000195771549
        end 0.12632348 -837.07365 0.999971442 -0.00755752452 0.00294949262 0.00180425427 -0.00221133768
        end 0.0994878822 -717.141429 0.999999996 -0.0000856448152 0.799561974 0 -0.00000123899664
        end 0.0952954775 -596.6644 1 -0.00000862838528 1.50161004 0 -0.000000260853564
        end -239.621249 -357.287803 0.00606193035 -0.999981626 1.49993976 0 0.000191337081
        end -599.89314 -475.457448 -0.0324700861 -0.999472708 1.50000027 0.0000000020789279 -0.00102142051
        ");
}

#[test]
fn golden_primitives_of_the_rich_trial() {
    primitives(rich()).assert(
        "
        zig-zag-steep_AsDesigned 0 2 -2 3 135 120 280 0.43163079 -0.367153592 23.1908004
        zig-zag-steep_AsDesigned 0 4 -1 0 116 120 347 0.19000003 0.223920095 23.1908004
        zig-zag-steep_AsDesigned 0 4 0 0 116 120 353 0.392491497 -0.345538083 23.1908004
        zig-zag-steep_Mirrored 0 3 1 0 136 120 260 1.43607154 -1.66260894 23.6155558
        zig-zag-steep_AsDesigned 1 2 2 0 133 120 271 0.295141401 0.348689493 23.4504565
        zig-zag-steep_AsDesigned 1 1 4 1 119 120 332 0.458264719 0.213020719 23.4504565
        zig-zag-steep_AsDesigned 1 0 4 1 114 120 342 0.651927897 -0.461791004 23.4504565
        zig-zag-steep_Mirrored 1 -2 2 2 135 120 269 0.417117906 -0.367760432 23.1743627
        zig-zag-steep_Mirrored 1 -1 4 1 118 120 331 0.579114994 -0.198535591 23.1743627
        zig-zag-steep_AsDesigned 2 -3 1 2 137 120 258 1.50257432 1.7359857 23.4769943
        zig-zag-steep_Mirrored 2 -2 -2 3 130 120 279 0.711136869 0.22936115 23.3586004
        zig-zag-steep_Mirrored 2 -4 -1 2 116 120 344 0.692511653 -0.236059052 23.3586004
        zig-zag-steep_Mirrored 2 -4 0 2 116 120 350 0.384061569 0.363028075 23.3586004
        zig-zag-steep_AsDesigned 3 -1 -3 3 136 120 270 1.53905362 1.8432657 23.2253974
        zig-zag-steep_AsDesigned 3 0 -4 3 120 120 363 0.33291477 -0.351439994 23.2253974
        zig-zag-steep_Mirrored 3 2 -2 0 134 120 277 1.03116377 0.957435749 23.8042525
        zig-zag-steep_Mirrored 3 1 -4 3 120 120 352 0.754071329 -0.157195916 23.8042525
        zig-zag-steep_Mirrored 3 0 -4 3 115 120 363 0.441035045 0.339185525 23.8042525
        sway-zig-zag_AsDesigned 0 0 0 0 251 240 315 0.737676177 0.000000245827616 25.5929915
        sway-zig-zag_Mirrored 0 0 0 0 250 240 318 0.732218308 0.0000000504319183 28.3702266
        sway-zig-zag_AsDesigned 1 0 0 1 246 240 314 0.736455078 -0.00000290274511 23.4167799
        sway-zig-zag_Mirrored 1 0 0 1 250 240 314 0.732702467 0.0000028192524 32.4332198
        sway-zig-zag_AsDesigned 2 0 0 2 247 240 318 0.732218308 0.0000000504319183 20.6142852
        sway-zig-zag_Mirrored 2 0 0 2 247 240 315 0.737676177 0.000000245827616 35.8283205
        sway-zig-zag_AsDesigned 3 0 0 3 250 240 314 0.732702467 0.0000028192524 23.7918617
        sway-zig-zag_Mirrored 3 0 0 3 246 240 314 0.736455078 -0.00000290274517 31.9765898
        0_faster 44 2697 3184.70321 193.315636
        0_straight 44 3234 3719.08032 233.858884
        0_turn-port 44 1573 1577.03012 88.6298196
        0_turn-starboard 44 1578 1582.03012 89.5879189
        1_faster 44 1778 2268.10178 129.672554
        1_slower 44 3115 3605.90992 229.066075
        1_straight 44 2226 2714 160.672831
        1_turn-port 44 3283 4255.05281 254.347626
        1_turn-starboard 44 3285 4257.05281 235.107224
        2_slower 44 1770 2257.93743 132.089995
        2_straight 44 1591 2079 118.687746
        2_turn-port 44 2090 3061.4059 169.708707
        2_turn-starboard 44 2090 3061.4059 150.164449
        ",
    );
}

#[test]
fn golden_passage_of_the_rich_trial() {
    passage(rich()).assert("
        start 24.985 60 368 2
        faster 24.9871505 60.0000002 89.9879406 120 0.571108613 578 578 -1 0 18.1227212 6 20 17.5 605.541428 89.9953009
        faster 24.9893011 60.0000004 89.9898035 120 1.14740028 683 683 -1 0 6 6 20 17.5 485.064399 89.9962358
        zig-zag-steep 24.9933476 59.9992901 109.315884 239.265955 1.47826958 853 853 -1 0 21.4587433 9.34563243 20 17.5 259.610499 89.9979855
        zig-zag-steep 24.9936026 59.9978465 174.944028 161.453748 1.48232524 963 963 -1 0 13.0469442 8.54567604 20 17.5 249.095955 87.1750624
        zig-zag-steep 24.991453 59.9946152 198.428478 379.47332 1.46650256 1233 1233 -1 0 20.0093993 22.5102058 20 17.5 277.125987 62.4385138
        corridors 40 -13209.9262 13347.8657 -1824.27976
        ");
}

#[test]
fn golden_check_of_the_rich_trial() {
    check(rich()).assert(
        "
        clearance 164.402313 0 525 0.406386884
        seconds 1233 1233 1208 1223 1236
        counts 12 0 0 72 0 1 0 0
        aground 0 0.242494007 0.264648469
        clearances 156.469833 156.469833 164.402313
        searched 252 0 0 1512 0
        worst 143.189117 0.742822303
        nearest 6 0.07 225.598015 5 5 -5 5 -5 -5 5 5 5 5
        farthest 2 0.07 164.722138 -5 5 5 -5 5 5 -5 5 5 -5
        ~information 19.8526791 18.0462627 55.6527357 0.870267095
        ~design 1.07427158 13
        inputs 3699 29484.7695 73273.1632 27.1449952
        tracks 29378 -10815818.8 10863577.8 -4044.16822
        ",
    );
}

#[test]
fn golden_map_of_the_rich_trial() {
    map(rich()).assert("
        frame -1017.00002 -1019.90512 1022.99998 1020.09488
        shades 0 2 5 10 20 50
        raster 68 68 30 -1017.00002 -1019.90512
        margin_0 395 756897 756897 4145.28776
        margin_1 199 628419 628419 10973.9195
        areas 1 1 1 1 1
        Holm 0 0.0016953311
        swept 1673 215238474 215238474 653322.401
        swept_cells 3.64285714
        part_0_true 482 -197407.946 201114.042 -3096.75919
        part_0_false 150 -62277.8667 63352.3224 -2595.86202
        part_1_false 110 -46023.0766 46058.4101 -2497.78075
        part_2_false 422 -165346.829 165394.305 -3013.29972
        part_3_false 212 -70266.0452 70286.5836 -2325.86444
        part_4_false 62 -17795.8619 17801.7612 -1588.83148
        part_4_true 242 -61298.0974 61300.0793 -1813.22227
        part_4_false 262 -66607.7575 66607.7575 -1566.82639
        part_5_false 62 -19198.4823 19198.4823 -1466.86992
        part_5_true 242 -91085.2749 91085.2749 -2076.83531
        part_5_false 242 -117962.314 117962.314 -2736.1495
        hull 10 -2774.78719 2791.35745 -979.919604
        hull 10 -3191.69069 3191.69069 -966.01667
        longitudes 24.9833333 -930.000028 24.9916667 -465.000018 25 0 25.0083333 465.000018 25.0166667 930.000028
        latitudes 59.9933333 -742.748204 59.9966667 -371.374196 60 0.00000145952903 60.0033333 371.374387 60.0066667 742.748962
        ");
}
