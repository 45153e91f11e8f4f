//! The numbers of whole plans, as they were when they were written down.

use std::collections::BTreeMap;

use plan::lattice::Status;
use plan::voyage::{Check, WorstVessel};

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
    let mut informative: BTreeMap<String, Vec<f64>> = BTreeMap::new();
    for own in planned.plan().primitives() {
        let node = [own.di as f64, own.dj as f64, own.to_h as f64, own.fits as f64];
        let times = [own.maneuver_s, own.leg_s, own.residual_m, own.residual_deg, own.spread_m];
        let name = format!("{} {:?} {}", own.maneuver, own.side, own.h);
        informative.entry(name).or_default().extend(node.into_iter().chain(times));
    }
    informative.iter().for_each(|(name, numbers)| table.summed(name, numbers));
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
        cost 4 1538
        lattice 18 18 8
        origin -1056.3368 -1053.9533
        uncharted 0
        wanted_zig-zag-steep 1 180
        wanted_sway-zig-zag 1 240
        faster 2 9 1 2 10 5
        turn-starboard 2 10 5 3 11 4
        zig-zag-steep 3 11 4 5 10 7
        turn-starboard 5 10 7 4 9 6
        slower 4 9 6 3 9 2
        sway-zig-zag 3 9 2 2 9 1
        front 1 1 4 525
        ~information 16.9115977
        ",
    );
}

#[test]
fn golden_legs_of_the_small_trial() {
    legs(small()).assert("
        faster 0 137 -1 -1 24.9853702 60.000233 359.98733 0 0.305770978 25.3472222 0 0
        turn-starboard 137 154 -1 -1 24.9853697 60.0013101 359.98733 1.5 0.298395314 19.8004388 10.5048147 254.421531
        zig-zag-steep 291 397 321 180 24.9875199 60.0023874 89.9891918 1.5 1.42240047 19.986908 8.87682866 212.121212
        turn-starboard 688 154 -1 -1 24.9918216 60.0013106 179.992917 1.5 0.321652045 19.75 10.4786214 254.364309
        slower 842 186 -1 -1 24.9896713 60.0002334 269.991055 1.5 0.73108765 16.6284692 0.053198819 0.549188308
        sway-zig-zag 1028 511 1028 240 24.9875208 60.0002332 269.989193 0 0.716261367 22.2224308 23.4782609 209.986495
        end 145.740933 -816.336802 0 1 1.49830626 0 0
        end 265.754231 -696.277649 0.999983392 0.00576327598 1.5 0 0.000118352908
        end 146.709436 -455.078228 -0.0265062504 -0.999648648 1.50003132 0 -0.000837335809
        end 26.3394037 -576.203435 -0.999983316 -0.00577644345 1.5 0 0.000121114858
        end 26.0505011 -697.06788 -1 -0.000000778697188 -0.0350845263 -0.000198111972 0.000000173814451
        end 26.0467133 -815.620541 0 1 -0.000000594844869 -0.0402236907 0
        ");
}

#[test]
fn golden_primitives_of_the_small_trial() {
    primitives(small()).assert(
        "
        sway-zig-zag_AsDesigned_0 117 14247.0668 14261.9328 455.071341
        sway-zig-zag_AsDesigned_1 117 14240.0668 14254.9328 455.162577
        sway-zig-zag_AsDesigned_2 117 14253.0668 14267.9328 455.800045
        sway-zig-zag_AsDesigned_3 117 14254.0668 14268.9328 456.105485
        sway-zig-zag_Mirrored_0 117 14243.5431 14258.4091 454.954688
        sway-zig-zag_Mirrored_1 117 14244.5431 14259.4091 455.260127
        sway-zig-zag_Mirrored_2 117 14257.5431 14272.4091 455.885844
        sway-zig-zag_Mirrored_3 117 14250.5431 14265.4091 455.97708
        zig-zag-steep_AsDesigned_0 81 7454.39977 7485.88173 343.440379
        zig-zag-steep_AsDesigned_1 81 7473.39977 7486.88173 344.085706
        zig-zag-steep_AsDesigned_2 81 7447.39977 7512.88173 337.238312
        zig-zag-steep_AsDesigned_3 81 7430.39977 7513.88173 337.415929
        zig-zag-steep_Mirrored_0 81 7435.32804 7449.5702 336.660265
        zig-zag-steep_Mirrored_1 81 7410.32804 7442.5702 332.832031
        zig-zag-steep_Mirrored_2 81 7394.32804 7476.5702 328.974031
        zig-zag-steep_Mirrored_3 81 7405.32804 7469.5702 332.757293
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
        faster 24.9853697 60.0013101 359.98733 120 0.873680504 137 137 -1 0 10 10 -1 -1 704.737586 89.9945311
        straight 24.9853693 60.0023871 359.98733 119.999999 1.49983503 214 214 30 0 10 10 -1 -1 705.575682 92.7813956
        straight 24.9875199 60.0023874 89.9882603 120 1.5 291 291 -1 0 10 10 -1 -1 604.708855 104.780984
        zig-zag-steep,_first_to_port 24.9928013 60.003429 68.503242 316.704967 1.50890441 514 514 -1 0 11.6873001 23.3647785 -1 -1 396.70748 133.014016
        zig-zag-steep,_first_to_port 24.9918216 60.0013106 193.040343 242.266315 1.5058991 688 688 -1 0 31.2878911 12.3159399 -1 -1 345.290274 95.8626049
        straight 24.9918219 60.0002335 179.992918 120 1.50000305 765 765 30 0 10 10 -1 -1 344.118757 90.8783095
        straight 24.9896713 60.0002334 269.991986 120 1.5 842 842 -1 0 10 10 -1 -1 351.707405 89.9972706
        slower 24.9875208 60.0002332 269.990124 120 0.668303238 1028 1028 -1 0 10 10 -1 -1 464.604228 89.9963946
        sway-zig-zag 24.9853702 60.000233 269.988261 120 0.398200382 1539 1539 -1 0 10 21.7138654 -1 -1 584.467951 89.9954645
        corridors 72 -17648.9779 28118.6992 -1828.73479
        ");
}

#[test]
fn golden_check_of_the_small_trial() {
    check(small()).assert(
        "
        clearance 333.75 0 520 0.350845263
        seconds 1538 1539 1537 1541.5 1555
        counts 4 0 0 24 0 1 0 0
        aground 0 0.489890836 0.602364636
        clearances 333.75 333.75 333.75
        searched 143 0 0 858 0
        worst 333.75 0.360349872
        nearest 4 0 0 0 0 0 0 0 0 0 0 0 0
        farthest 5 0.05 320.233832 0 0 0 0 0 0 0 0 0 0
        ~information 16.9115977 31.4759038 65.9555133 3.06586958
        ~design 13
        inputs 4617 40318.7462 91535.3716 81.9645829
        tracks 12350 -3245145.09 4785668.26 -3026.02079
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
        swept 1656 310601358 310601358 1339815.37
        swept_cells 3.85714286
        part_0_false 276 -102681.217 122627.741 -2702.80431
        part_1_false 310 -85313.2239 157939.264 -2334.78552
        part_2_false 62 -12645.5388 29128.6906 -1322.64131
        part_2_true 362 -38472.9933 155288.373 -1397.54028
        part_2_false 376 -27760.1065 132460.813 -464.210582
        part_3_false 310 -66592.0733 84580.0949 -1298.59696
        part_4_false 374 -119011.833 128778.292 -2094.34475
        part_5_true 482 -158783.722 176778.191 -2501.18576
        part_5_false 544 -200129.937 214697.132 -2612.69413
        hull 10 -1923.70951 4583.07085 -847.313551
        hull 10 -3358.0869 3618.5919 -1229.22002
        longitudes 24.9833333 -930.00861 24.9916667 -465.004309 25 0 25.0083333 465.004309 25.0166667 930.00861
        latitudes 59.99 -1114.12185 59.9933333 -742.74803 59.9966667 -371.374021 60 0.000175729151 60.0033333 371.374562 60.0066667 742.749136
        ");
}

#[test]
fn golden_walk_of_the_rich_trial() {
    walk(rich()).assert(
        "
        cost 1174 1
        lattice 17 17 12
        origin -957.000016 -959.905116
        uncharted 0
        wanted_zig-zag-steep 2 120
        wanted_sway-zig-zag 1 240
        sway-zig-zag 1 8 1 1 8 0
        faster 1 8 0 2 8 4
        faster 2 8 4 3 8 8
        zig-zag-steep 3 8 8 5 10 9
        zig-zag-steep 5 10 9 7 12 8
        front 1 1 897 572
        ~information 13.768393
        front 1 2 1174 830
        ~information 19.8526791
        ",
    );
}

#[test]
fn golden_legs_of_the_rich_trial() {
    legs(rich()).assert("
        sway-zig-zag 0 322 0 240 24.985 60 359.98701 0 0.742426067 25.7778557 23.4782609 211.24641
        faster 322 211 -1 -1 24.985 60 89.9870096 0 0.259353812 22.213768 3.20196266 22.5845175
        faster 533 104 -1 -1 24.9871505 60.0000002 89.988872 0.8 0.628363089 21.9945955 3.1298949 1.44404374
        zig-zag-steep 637 266 667 120 24.9893011 60.0000004 89.9907345 1.5 0.799273762 20.5367636 8.80434783 212.121212
        zig-zag-steep 903 271 933 120 24.9936017 60.0021549 359.994459 1.5 0.593660163 20.6562544 12.2232221 213.58582
        end 0.531040012 -837.60082 0.999999992 -0.000124819346 0.0308438829 0.0246049694 0.0000194588769
        end 0.142870932 -716.745141 0.999999601 -0.000892943804 0.800877773 0 -0.0000129440513
        end 0.0992934217 -597.628364 0.999999996 -0.0000924598742 1.49729392 0 -0.00000278414134
        end 240.729853 -357.485457 0.0102359272 0.999947612 1.49982673 -0.00000000596044966 -0.000324850968
        end 480.399459 -116.490441 0.999979454 -0.0064103254 1.49974381 0 -0.000202844587
        ");
}

#[test]
fn golden_primitives_of_the_rich_trial() {
    primitives(rich()).assert(
        "
        sway-zig-zag_AsDesigned_0 117 13434.2061 13452.2237 431.281196
        sway-zig-zag_AsDesigned_1 117 13286.907 13296.9213 427.402485
        sway-zig-zag_AsDesigned_2 117 13364.4607 13382.4771 429.47561
        sway-zig-zag_AsDesigned_3 117 13338.7708 13348.7887 430.360017
        sway-zig-zag_Mirrored_0 117 13480.2879 13498.3043 432.882104
        sway-zig-zag_Mirrored_1 117 13443.1085 13453.1264 432.669617
        sway-zig-zag_Mirrored_2 117 13546.2653 13564.283 434.069584
        sway-zig-zag_Mirrored_3 117 13414.1845 13424.1988 431.616367
        zig-zag-steep_AsDesigned_0 81 5630.89704 5656.43703 251.869818
        zig-zag-steep_AsDesigned_1 81 5540.40627 5553.76867 248.99377
        zig-zag-steep_AsDesigned_2 81 5461.78771 5521.52838 240.517519
        zig-zag-steep_AsDesigned_3 81 5564.74664 5637.53797 247.165775
        zig-zag-steep_Mirrored_0 81 5531.75031 5550.42897 248.223761
        zig-zag-steep_Mirrored_1 81 5528.56572 5557.34555 246.187206
        zig-zag-steep_Mirrored_2 81 5549.53951 5625.19614 244.165527
        zig-zag-steep_Mirrored_3 81 5639.06901 5702.61516 251.80677
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
        start 24.985 60 322 1
        faster 24.9871505 60.0000002 89.9879406 120 0.572841481 533 533 -1 0 26.6920711 10 20 17.5 605.145141 89.995304
        faster 24.9893011 60.0000004 89.9898035 120 1.14535373 637 637 -1 0 10 10 20 17.5 486.028364 89.9962283
        zig-zag-steep,_first_to_port 24.9933237 60.0008748 66.5385881 244.685824 1.52684539 807 807 -1 0 10 25.1893217 20 17.5 260.93291 89.9979749
        zig-zag-steep,_first_to_port 24.9936017 60.0021549 6.20914413 143.455463 1.51947488 903 903 -1 0 10 12.8808493 20 17.5 250.978234 94.6501061
        zig-zag-steep,_first_to_starboard 24.9951748 60.004275 20.3836858 251.99263 1.5551314 1073 1073 -1 0 22.8461537 11.0426803 20 17.5 277.819919 117.736778
        zig-zag-steep,_first_to_starboard 24.997903 60.0043092 88.5690254 152.256917 1.53838147 1174 1174 -1 0 18.4805661 10.8681254 20 17.5 369.050808 179.005446
        corridors 48 -6918.66066 15533.9014 -1638.77314
        ");
}

#[test]
fn golden_check_of_the_rich_trial() {
    check(rich()).assert(
        "
        clearance 240.117157 0 525 0.308438829
        seconds 1174 1174 1158 1169 1193
        counts 12 0 0 60 0 1 0 0
        aground 0 0.242494007 0.264648469
        clearances 236.25 236.25 240.584763
        searched 370 0 0 1850 0
        worst 210 0.737873897
        nearest 4 0.07 100.335235 5 -5 -5 5 -5 -5 5 5 -5 -5
        farthest 1 0.07 167.307176 -5 5 -5 -5 -5 5 5 -5 5 -5
        ~information 19.8526791 22.6831087 61.5179522 1.24324557
        ~design 1.07427158 13
        inputs 3522 23265.6046 76025.3911 5.3714307
        tracks 28106 -6735932.71 9954483.27 -3622.19327
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
        swept 1869 352447010 352447010 1302256.49
        swept_cells 3.64285714
        part_0_true 482 -202847.336 206553.325 -3125.99075
        part_0_false 166 -69160.8938 70212.4715 -2651.61501
        part_1_false 424 -166099.605 166220.637 -3015.65795
        part_2_false 210 -69620.4765 69644.7995 -2321.59127
        part_3_false 62 -17826.4286 17832.4874 -1591.4558
        part_3_true 242 -52696.4341 62499.23 -1756.64789
        part_3_false 234 -24574.3425 60828.9259 -1012.30767
        part_4_false 62 -2916.61114 19236.7576 -459.629698
        part_4_true 242 5595.52231 83179.5555 -328.625566
        part_4_false 244 33140.8861 83644.5909 363.137392
        hull 10 -2779.75848 2796.33809 -981.697915
        hull 10 -374.355056 3197.63025 -309.34327
        longitudes 24.9833333 -930.000028 24.9916667 -465.000018 25 0 25.0083333 465.000018 25.0166667 930.000028
        latitudes 59.9933333 -742.748204 59.9966667 -371.374196 60 0.00000145952903 60.0033333 371.374387 60.0066667 742.748962
        ");
}
