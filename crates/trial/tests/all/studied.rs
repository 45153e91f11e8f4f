//! The numbers of studies without a chart: campaigns, moments, rounds, arranged and refined experiments. Laws are beside
//! the golden numbers that they judge.

use std::collections::BTreeMap;

use design::{Bounds, CriterionName, Options};
use estimation::Estimator;
use estimation::predictor::InitialState;
use estimation::predictor::{Flow, NoiseModel};
use estimation::runs::{AdditionalUnknowns, RunEstimators};
use maneuver::{DictionaryFile, Generator};
use numerics::Watch;
use regression::{InstrumentKind, MeanRemoval, Noise};
use ship::engine::{Axes, Current, Disturbances, Measurement, Run, Streams, Wind, simulate_one};
use ship::model::{Source, Vessel};
use trial::arranging::{Arranging, Kept};
use trial::campaign::{Campaign, Designed, Maneuvers, Sea, Settings, SimulatedRun};
use trial::moments::{
    CriterionOf, Estimated, Expected, FreeRunModel, Moments, Pool, Prediction, ShipSampler, structure,
};
use trial::refining::{Limits, Refinement, RefinementStart};
use trial::rounds::{self, Arm, Knowledge, Summary, Trial};

use crate::golden::Table;

const NOISE: Noise = Noise { measurement: [0.02, 0.03, 0.04], current: 0.05 };

/// Maneuvers of the paper's ship: three by hand, and as many drawn ones as keep their limits.
const DICTIONARY: &str = r#"
duration_s = 40.0

[[maneuver]]
name = "zig-zag"
kind = "zig-zag"
speed_m_s = 0.6
yaw_rate_amplitude_rad_s = 0.1
period_s = 20.0

[[maneuver]]
name = "combined"
kind = "combined"
speed_m_s = { mean = 0.5, shape = "sine", amplitude = 0.2, period_s = 12.5 }
yaw_rate_rad_s = { shape = "sine", amplitude = 0.3, period_s = 8.3 }
sway_m_s = { shape = "sine", amplitude = 0.15, period_s = 6.25 }

[[maneuver]]
name = "surge"
kind = "combined"
speed_m_s = { mean = 0.8, shape = "sine", amplitude = 0.4, period_s = 10.0 }
yaw_rate_rad_s = { shape = "sine", amplitude = 0.05, period_s = 20.0 }
sway_m_s = { shape = "sine", amplitude = 0.05, period_s = 15.0 }

[generate]
candidates = 12
duration_s = 30.0
speed_m_s = [0.2, 1.0]
[generate.limits]
u_m_s = 1.3
v_m_s = 0.5
r_rad_s = 0.4
rates = { tau1 = 20000.0, tau2 = 20000.0, tau3 = 9000.0 }
"#;

fn vessel() -> Vessel {
    Vessel::preset("ljungberg-model-ship").unwrap()
}

fn generator(vessel: &Vessel) -> Generator {
    let dictionary: DictionaryFile = DICTIONARY.parse().unwrap();
    Generator::without_tables(vessel, &dictionary).unwrap()
}

fn sea(vessel: &Vessel, std_m_s: f64) -> Sea<'_> {
    let [std_u_m_s, std_v_m_s, std_r_rad_s] = NOISE.measurement;
    let measurement = Measurement { std_u_m_s, std_v_m_s, std_r_rad_s };
    Sea::new(vessel, Disturbances { current: Current::White { std_m_s }, measurement }, None).unwrap()
}

fn simulated(vessel: &Vessel, generator: &Generator) -> Vec<SimulatedRun> {
    let maneuvers = Maneuvers::new(vessel, generator, Source::Value, "dictionary").unwrap();
    maneuvers.simulate(0..maneuvers.count()).unwrap().0
}

/// The moments of `runs`, with what disturbances do to estimates by instruments and by output error.
fn moments(vessel: &Vessel, generator: &Generator, runs: &[Run]) -> Moments {
    let expected = Expected::new(vessel, NOISE, 20.0).unwrap();
    let free = FreeRunModel::new(vessel, Some(generator)).unwrap();
    let prediction = Prediction::new(vessel, InstrumentKind::Nominal, Some(&expected), Some(&free));
    let mut pool = Pool::default();
    let found = prediction.moments(runs).unwrap();
    found.into_iter().try_for_each(|(pooled, own)| pool.add(pooled, own)).unwrap();
    Moments {
        vessel: vessel.name.clone(),
        sample_rate_hz: vessel.sample_rate_hz,
        instruments: Some(InstrumentKind::Nominal),
        degrees: structure(&vessel.model),
        maneuvers: pool.finish(&vessel.model).unwrap(),
        held: Vec::new(),
        beyond: Vec::new(),
        disturbances: Some(expected),
        output_error: Some(free),
        prior: None,
        sampled: None,
    }
}

fn studied() -> (Vessel, Generator, Moments) {
    let vessel = vessel();
    let generator = generator(&vessel);
    let runs: Vec<Run> = simulated(&vessel, &generator).into_iter().map(|own| own.run).collect();
    let moments = moments(&vessel, &generator, &runs);
    (vessel, generator, moments)
}

#[test]
fn golden_dictionary() {
    let (vessel, mut table) = (vessel(), Table::default());
    let generator = generator(&vessel);
    let maneuvers = Maneuvers::new(&vessel, &generator, Source::Value, "dictionary").unwrap();
    let (runs, tally) = maneuvers.simulate(0..maneuvers.count()).unwrap();
    table.counts("tally", [tally.maneuvers, tally.samples, tally.kept]);
    for (name, left_out) in &tally.left_out {
        table.row(name, [left_out.count as f64, left_out.allowed, left_out.nearest]);
    }
    table.counts("rows", maneuvers.rows(0..maneuvers.count()).unwrap());
    table.counts("rows by hand", maneuvers.rows(0..3).unwrap());
    for own in maneuvers.reached().unwrap() {
        table.row(own.maneuver, [own.seconds, own.aims.len() as f64]);
    }
    for own in runs {
        let name = own.run.segments[0].maneuver.clone();
        table.summed(format!("{name} inputs"), &own.run.exogenous);
        table.summed(format!("{name} states"), &own.states);
    }
    table.assert(
        "
        tally 11 2880 8
        rates.tau2 4 20000 21224.2857
        rows 3855 963
        rows_by_hand 963 963
        zig-zag 40 2
        combined 40 2
        surge 40 2
        zig-zag_inputs 960 909121.776 990434.511 8326.72026
        zig-zag_states 963 192.573315 221.216973 1.80550264
        combined_inputs 960 778045.69 1051692.63 7974.63446
        combined_states 963 166.588448 241.916085 1.66820452
        surge_inputs 960 1272659.06 1345288.32 12840.601
        surge_states 963 262.681073 279.944347 2.51212229
        combined-00000_inputs 720 687032.107 1264586.83 8563.24872
        combined-00000_states 723 142.578283 255.117905 2.30242921
        zig-zag-00001_inputs 720 688264.695 848361.557 7911.64706
        zig-zag-00001_states 723 143.767369 194.919522 1.76005839
        multisine-00003_inputs 720 843307.994 1002307.8 10046.1489
        multisine-00003_states 723 194.639334 222.568389 2.2112122
        spiral-00004_inputs 720 1018467.64 1141287.67 10967.0623
        spiral-00004_states 723 119.691901 229.008831 1.33769486
        accelerate-00005_inputs 720 894932.743 894932.743 10704.3636
        accelerate-00005_states 723 180.650038 180.650038 1.55034737
        decelerate-00007_inputs 720 445857.6 445857.6 5332.93913
        decelerate-00007_states 723 103.974185 103.974185 1.9242772
        steady-turn-00008_inputs 720 1332168.94 1512468.78 14867.8799
        steady-turn-00008_states 723 149.486758 311.121752 1.74463364
        combined-00009_inputs 720 459178.519 674422.729 8660.70346
        combined-00009_states 723 107.046774 193.411128 1.02185146
        ",
    );
}

#[test]
fn law_tallies_of_parts_add_up_to_that_of_the_whole() {
    let vessel = vessel();
    let generator = generator(&vessel);
    let maneuvers = Maneuvers::new(&vessel, &generator, Source::Value, "dictionary").unwrap();
    let tally = |indices| maneuvers.simulate(indices).unwrap().1;
    let (count, mut sum) = (maneuvers.count(), tally(0..5));
    sum.merge(&tally(5..count));
    let whole = tally(0..count);
    assert_eq!(sum.to_string(), whole.to_string());
    assert_eq!((sum.maneuvers, sum.samples, sum.kept), (whole.maneuvers, whole.samples, whole.kept));
    let left_out: usize = whole.left_out.values().map(|own| own.count).sum();
    assert_eq!(whole.kept + left_out, 12);
    assert_eq!(whole.maneuvers, 3 + whole.kept);
    let [all, by_hand] = maneuvers.rows(0..count).unwrap();
    assert_eq!(all - by_hand, 12 * (240 + 1));
}

/// A campaign in wind and a current that lasts, of all maneuvers by hand, and of drawn ones.
fn campaign(realizations: u32) -> Vec<SimulatedRun> {
    let vessel = vessel();
    let generator = generator(&vessel);
    let current = Current::GaussMarkov { std_m_s: 0.05, time_constant_s: 20.0, axes: Axes::Earth };
    let [std_u_m_s, std_v_m_s, std_r_rad_s] = NOISE.measurement;
    let measurement = Measurement { std_u_m_s, std_v_m_s, std_r_rad_s };
    let wind =
        Wind { std_surge_m_s2: 0.01, std_sway_m_s2: 0.02, std_yaw_rad_s2: 0.01, time_constant_s: Some(8.0) };
    let sea = Sea::new(&vessel, Disturbances { current, measurement }, Some(wind)).unwrap();
    let settings = Settings { duration_s: 50.0, realizations, random_segments: Some(3), seed: 5 };
    assert_eq!(settings.runs(), 3.0 * f64::from(realizations));
    let shares = [("zig-zag", 0.2), ("combined", 0.5), ("surge", 0.3)];
    let shares = shares.map(|(name, share)| (name.to_owned(), share)).into();
    let campaign = Campaign::new(sea, &generator, &Designed { shares, order: None }, &settings).unwrap();
    assert_eq!((campaign.names(), campaign.samples()), (vec!["optimized", "random", "practice"], 400));
    campaign.simulate_all().unwrap()
}

#[test]
fn golden_campaign() {
    let mut table = Table::default();
    for own in campaign(3) {
        let name = format!("{} {}", own.run.design, own.run.run);
        let starts: Vec<f64> = own.run.segments.iter().map(|segment| segment.start as f64).collect();
        table.row(format!("{name} starts"), starts);
        table.summed(format!("{name} inputs"), &own.run.exogenous);
        table.summed(format!("{name} states"), &own.states);
        table.summed(format!("{name} measured"), &own.run.measured);
    }
    table.assert(
        "
        optimized_0_starts 0 80 280
        optimized_0_inputs 1200 1215689.59 1457012.2 8574.53762
        optimized_0_states 1203 228.462201 312.885586 1.81192492
        optimized_0_measured 1203 227.94612 316.494936 1.82413292
        optimized_1_starts 0 80 280
        optimized_1_inputs 1200 1215689.59 1457012.2 8574.53762
        optimized_1_states 1203 258.858158 337.945359 1.91185536
        optimized_1_measured 1203 258.354324 341.2241 1.90024336
        optimized_2_starts 0 80 280
        optimized_2_inputs 1200 1215689.59 1457012.2 8574.53762
        optimized_2_states 1203 213.058206 304.07755 1.73708721
        optimized_2_measured 1203 213.09494 306.557478 1.72876674
        random_0_starts 0 134 267
        random_0_inputs 1200 1296834.8 1473927.4 8546.21861
        random_0_states 1203 259.695411 306.190459 1.77752668
        random_0_measured 1203 260.455623 310.545139 1.82979077
        random_1_starts 0 134 267
        random_1_inputs 1200 1489953.89 1662434.23 8906.84109
        random_1_states 1203 289.638233 327.737484 1.72960585
        random_1_measured 1203 288.233599 332.08163 1.71771067
        random_2_starts 0 134 267
        random_2_inputs 1200 1078759.56 1325988.4 8477.24075
        random_2_states 1203 200.550936 273.189541 1.75393655
        random_2_measured 1203 200.625985 275.78268 1.76775375
        practice_0_starts 0 134 267
        practice_0_inputs 1200 1297512.71 1472994.49 8702.55563
        practice_0_states 1203 297.308339 340.835911 2.05416363
        practice_0_measured 1203 297.310477 343.75653 2.0053671
        practice_1_starts 0 134 267
        practice_1_inputs 1200 1297512.71 1472994.49 8702.55563
        practice_1_states 1203 267.371274 320.117905 1.85596567
        practice_1_measured 1203 267.210472 324.871893 1.91961965
        practice_2_starts 0 134 267
        practice_2_inputs 1200 1297512.71 1472994.49 8702.55563
        practice_2_states 1203 274.341426 330.864575 1.86628489
        practice_2_measured 1203 274.841724 335.995995 1.88542719
        ",
    );
}

#[test]
fn law_runs_are_measured_with_the_stated_noise_and_last_by_their_shares() {
    let runs = campaign(64);
    assert_eq!(runs.len(), 192);
    for (d, std) in NOISE.measurement.into_iter().enumerate() {
        let off = runs.iter().flat_map(|own| {
            let both = own.run.measured.iter().zip(&own.states).skip(d).step_by(3);
            both.map(|(measured, truth)| (measured - truth).powi(2))
        });
        let (count, sum) = off.fold((0.0, 0.0), |(n, sum), square| (n + 1.0, sum + square));
        assert!(((sum / count).sqrt() / std - 1.0).abs() < 0.02, "{d}: {}", (sum / count).sqrt());
    }
    for own in &runs {
        let starts: Vec<usize> = own.run.segments.iter().map(|segment| segment.start).collect();
        let optimized = own.run.design == "optimized";
        // A round of practice is longer than the run: its three maneuvers of one length are shortened alike.
        assert_eq!(starts, if optimized { [0, 80, 280] } else { [0, 134, 267] }, "{:?}", own.run.segments);
    }
    let names: std::collections::BTreeSet<&str> = runs[64..128]
        .iter()
        .flat_map(|own| own.run.segments.iter().map(|own| own.maneuver.as_str()))
        .collect();
    assert_eq!(names.len(), 3, "generated ones are of no design here: {names:?}");
}

#[test]
fn golden_moments() {
    let (_, _, moments) = studied();
    let mut table = Table::default();
    for own in &moments.maneuvers {
        table.counts(&own.name, [own.samples as usize]);
        for degree in &own.degrees {
            table.matrix(format!("{} M", degree.name), &degree.m);
            table.matrix(format!("{} B", degree.name), degree.b.as_ref().unwrap());
            table.row(format!("{} nonstationarity", degree.name), [degree.nonstationarity]);
        }
        let output_error = own.output_error.as_ref().unwrap();
        table.matrix("F", &output_error.f);
        table.matrix("P", output_error.p.as_ref().unwrap());
    }
    table.matrix("G", moments.output_error.as_ref().unwrap().g.as_ref().unwrap());
    table.assert(
        "
        zig-zag 320
        surge_M 25 11.1209511 24.2452005 2.32737466 -0.938374849
        surge_B 25 11.0712969 22.0376567 2.30726887 -57.0468671
        surge_nonstationarity 0.116912417
        sway_M 16 1.84328802 9.89356563 0.856500419 -3.55785161
        sway_B 16 1.98353633 9.69859438 0.830815395 -45.1758446
        sway_nonstationarity 0.0489198049
        yaw_M 16 1.90352216 10.0795187 0.893139754 -5.39432635
        yaw_B 16 2.24691514 9.73351568 0.877732688 -40.2035999
        yaw_nonstationarity 0.0632596373
        F 169 12.9142646 50.9219014 1.89043271 138.558975
        P 169 6.71451223 86.9847249 1.70717553 137.29684
        combined 320
        surge_M 25 18.5971343 18.5971343 3.20920069 1.59969772
        surge_B 25 16.5869623 16.5869623 2.90495683 -53.8215011
        surge_nonstationarity 0.563217067
        sway_M 16 5.78131562 5.83285427 1.74535033 2.68064209
        sway_B 16 5.40049127 5.93184819 1.63801663 -37.9856677
        sway_nonstationarity 0.333415706
        yaw_M 16 6.9890362 6.9890362 1.94107917 0.446421206
        yaw_B 16 6.92396967 6.92396967 1.94636821 -34.1222094
        yaw_nonstationarity 0.306900829
        F 169 36.6110296 37.5266328 2.78858279 150.691282
        P 169 57.3090423 59.3708178 3.2440244 149.548531
        surge 320
        surge_M 25 17.9143928 18.0353098 3.13408595 0.826542359
        surge_B 25 17.8419526 17.8419526 3.04701511 -54.5530482
        surge_nonstationarity 1.38869696
        sway_M 16 6.44968071 6.74472842 1.85923613 -3.4318807
        sway_B 16 6.36512856 6.41521277 1.86798755 -44.7347271
        sway_nonstationarity 1.33729595
        yaw_M 16 6.99752371 6.99752371 1.91759725 -7.1348377
        yaw_B 16 7.2952808 7.2952808 2.00394478 -41.7615155
        yaw_nonstationarity 1.43048912
        F 169 29.4574338 33.4028084 2.50548327 137.093921
        P 169 34.1405773 51.180294 2.6790272 135.101928
        combined-00000 240
        surge_M 25 21.898373 21.898373 3.58852823 6.12223425
        surge_B 25 19.6689911 19.6689911 3.22760471 -48.270608
        surge_nonstationarity 0.729385343
        sway_M 16 3.53999935 11.6754741 1.70966513 5.90764734
        sway_B 16 3.35640454 10.9111074 1.66208908 -34.7589874
        sway_nonstationarity 0.317127427
        yaw_M 16 3.44690592 13.8087912 1.72174896 1.06171515
        yaw_B 16 3.43207668 13.6969664 1.79187302 -33.4325317
        yaw_nonstationarity 0.0637630593
        F 169 35.6795945 63.2636087 3.05969418 159.014292
        P 169 53.6221243 97.9061533 3.55256026 165.490791
        zig-zag-00001 240
        surge_M 25 11.4465611 23.8058021 2.3802398 2.12365806
        surge_B 25 12.230571 20.8701278 2.43090438 -53.3244723
        surge_nonstationarity 0.142762816
        sway_M 16 1.60453993 9.02303019 0.813151788 1.58216728
        sway_B 16 1.70560311 8.68882385 0.810777776 -39.4016577
        sway_nonstationarity 0.116880671
        yaw_M 16 2.61643239 9.23850175 1.02628756 -0.255454385
        yaw_B 16 3.11269629 8.78037776 1.05004769 -34.9334036
        yaw_nonstationarity 0.14665488
        F 169 12.2045623 53.0545703 1.84446349 149.949605
        P 169 4.58478131 89.9152248 1.65734094 149.880189
        multisine-00003 240
        surge_M 25 12.0903492 23.0649386 2.44254016 4.05065792
        surge_B 25 12.1414548 21.0146305 2.42236149 -51.2534485
        surge_nonstationarity 0.904306481
        sway_M 16 0.397152833 13.6865009 0.636630256 1.15308579
        sway_B 16 0.497263394 13.0181879 0.622136436 -40.0828174
        sway_nonstationarity 0.598183228
        yaw_M 16 3.23255851 13.9195479 1.08279712 -0.690018376
        yaw_B 16 3.59005205 13.410575 1.08915877 -35.3851849
        yaw_nonstationarity 0.629706195
        F 169 12.9886258 67.1772548 1.91252338 151.904847
        P 169 4.14995574 115.942144 1.64886025 155.585814
        spiral-00004 240
        surge_M 25 9.54738618 25.1330612 2.14260935 3.95322618
        surge_B 25 9.68293142 23.8576252 2.15833582 -51.3499072
        surge_nonstationarity 0.738368905
        sway_M 16 3.99503478 15.9288624 1.14866232 7.74879929
        sway_B 16 4.12895558 15.421931 1.11009454 -33.2755431
        sway_nonstationarity 0.686053302
        yaw_M 16 0.0587945868 16.0235861 0.614689585 3.54303232
        yaw_B 16 0.111927837 15.7741209 0.560531597 -30.9676904
        yaw_nonstationarity 0.675226564
        F 169 9.28385767 100.396487 1.72358528 165.218428
        P 169 7.65620581 133.118123 1.65165668 181.130077
        accelerate-00005 240
        surge_M 25 16.6396723 16.6396723 2.9960902 13.2837266
        surge_B 25 15.9771426 15.9771426 2.86678756 -31.6295757
        surge_nonstationarity 0.121578043
        sway_M 16 1 1 0.0625 0
        sway_B 16 1 1 0.0625 -10.1072556
        sway_nonstationarity 0
        yaw_M 16 1 1 0.0625 0
        yaw_B 16 1 1 0.0625 -8.48570787
        yaw_nonstationarity 0
        F 169 17.7553525 18.1805616 2.38145746 86.5416874
        P 169 15.9933836 19.9663313 2.36938666 89.9463866
        decelerate-00007 240
        surge_M 25 15.5707246 15.5707246 2.87638922 9.11022956
        surge_B 25 13.4400025 13.4400025 2.58265864 -33.7294416
        surge_nonstationarity 1.06902266
        sway_M 16 1 1 0.0625 0
        sway_B 16 1 1 0.0625 -10.1077845
        sway_nonstationarity 0
        yaw_M 16 1 1 0.0625 0
        yaw_B 16 1 1 0.0625 -8.49127312
        yaw_nonstationarity 0
        F 169 17.6715851 17.9098098 2.36742653 82.5552582
        P 169 15.8749418 19.8451267 2.35951198 84.6915496
        steady-turn-00008 240
        surge_M 25 9.33994104 25.1914505 2.12389272 8.12375915
        surge_B 25 9.51344782 24.1900159 2.1381613 -46.4929927
        surge_nonstationarity 0.152509814
        sway_M 16 3.92363291 16.0065636 1.13655153 9.62177906
        sway_B 16 4.07887444 15.47475 1.10453202 -31.4425022
        sway_nonstationarity 0.149421576
        yaw_M 16 -0.0441561492 16.1081088 0.596457837 5.99267944
        yaw_B 16 0.0119520024 15.8372592 0.544415979 -28.506819
        yaw_nonstationarity 0.120043323
        F 169 7.40288104 109.091431 1.6567369 173.650701
        P 169 5.52782338 143.147194 1.57862499 190.342548
        combined-00009 240
        surge_M 25 19.576928 19.7126898 3.35311836 0.283435859
        surge_B 25 17.8044118 17.8044118 3.0124796 -54.9178427
        surge_nonstationarity 1.31975283
        sway_M 16 8.52568301 8.52568301 2.14974624 5.09552496
        sway_B 16 7.40319008 7.5255028 1.98403855 -35.6562035
        sway_nonstationarity 1.60913862
        yaw_M 16 8.39996354 8.39996354 2.10023587 3.32492616
        yaw_B 16 7.71269838 7.71269838 1.99891048 -31.0533504
        yaw_nonstationarity 1.5331682
        F 169 52.7173208 53.8428152 3.16622767 158.338044
        P 169 77.5615039 80.9193044 3.72068498 168.211639
        G 169 16.1056401 31.9412239 1.97136474 57.7185051
        ",
    );
}

#[test]
fn oracle_matrices_of_designs_are_centred_moments() {
    let (_, _, moments) = studied();
    for (index, own) in moments.maneuvers.iter().enumerate() {
        // By columns of regressors and instruments: covariance is the mean product less the product of means.
        let covariances = own.degrees.iter().flat_map(|degree| {
            let n = degree.shape[0] as usize;
            let (m, p) = (&degree.m, n - 1);
            (0..p * p)
                .map(move |k| m[k / p * n + k % p] - m[k / p * n + p] * m[p * n + k % p])
                .collect::<Vec<_>>()
        });
        let found = moments.dictionary(Estimated::Iv(MeanRemoval::Batch)).unwrap().information;
        assert_close(found.candidate(index), covariances);
        let middle = own.degrees.iter().flat_map(|degree| {
            let (n, b) = (degree.shape[0] as usize, degree.b.as_ref().unwrap());
            let mean: Vec<f64> = (0..n).map(|j| degree.m[(n - 1) * n + j]).collect();
            // B of Tζ̃ is TBTᵀ, T the identity with −Z̄ in its last column.
            let row = |i: usize, j: usize| b[i * n + j] - mean[i] * b[(n - 1) * n + j];
            let (p, centred) = (n - 1, |i: usize, j: usize| row(i, j) - mean[j] * row(i, n - 1));
            (0..p * p).map(|k| centred(k / p, k % p)).collect::<Vec<_>>()
        });
        let found = moments.middle(Estimated::Iv(MeanRemoval::Batch)).unwrap();
        assert_close(found.candidate(index), middle);
        let output_error = own.output_error.as_ref().unwrap();
        let e = output_error.e.as_ref().unwrap_or(&output_error.f);
        let sums = e.iter().zip(output_error.p.as_ref().unwrap()).map(|(e, p)| e + p);
        assert_close(moments.middle(Estimated::OutputError).unwrap().candidate(index), sums);
    }
}

#[track_caller]
fn assert_close(found: &[f64], expected: impl IntoIterator<Item = f64>) {
    let expected: Vec<f64> = expected.into_iter().collect();
    assert_eq!(found.len(), expected.len());
    let size = expected.iter().fold(1.0, |most: f64, own| most.max(own.abs()));
    assert!(
        found.iter().zip(&expected).all(|(a, b)| (a - b).abs() <= 1e-12 * size),
        "{found:?} {expected:?}"
    );
}

#[test]
fn what_is_no_moments_of_the_model_is_refused() {
    let (_, _, moments) = studied();
    let iv = Estimated::Iv(MeanRemoval::Complete);
    let refused = |change: &dyn Fn(&mut Moments)| {
        let mut other = moments.clone();
        change(&mut other);
        let said = other.dictionary(iv).map(|_| ()).and_then(|()| other.middle(iv).map(|_| ()));
        said.unwrap_err().to_string()
    };
    let twice = |own: &mut Moments| own.maneuvers.push(own.maneuvers[0].clone());
    assert!(refused(&twice).contains("its moments twice"));
    assert!(refused(&|own| own.maneuvers.clear()).contains("none"));
    assert!(refused(&|own| own.degrees[1].parameters.clear()).contains("0 parameters"));
    assert!(refused(&|own| own.degrees[2].parameters.truncate(1)).contains("regressors and"));
    assert!(refused(&|own| own.maneuvers[1].degrees.truncate(2)).contains("2 degrees of freedom"));
    assert!(refused(&|own| own.maneuvers[1].degrees[0].m.truncate(1)).contains("entries in surge"));
    assert!(refused(&|own| own.disturbances = None).contains("no expected disturbances"));
    let b =
        |change: fn(&mut Vec<f64>)| refused(&|own| change(own.maneuvers[0].degrees[0].b.as_mut().unwrap()));
    assert!(b(|b| b.truncate(1)).contains("entries of `B` in surge"));
    assert!(b(|b| b[0] = -b[0]).contains("no covariance"));
    // More than fully correlated, and not symmetric.
    assert!(b(|b| b.iter_mut().skip(1).step_by(2).for_each(|own| *own *= 3.0)).contains("no covariance"));
    assert!(b(|b| b[1] += 1e-3 * b[0]).contains("no covariance"));
}

#[test]
fn law_criteria_of_moments_relate_as_their_definitions_do() {
    let (vessel, _, moments) = studied();
    let iv = Estimated::Iv(MeanRemoval::Complete);
    let dictionary = moments.dictionary(iv).unwrap();
    assert_eq!((iv.d_optimal(), dictionary.intercepts), (CriterionName::DHessian, true));
    let value = |name| {
        let of = CriterionOf { name, estimated: iv, relative_to: Source::Value, figures: (&[], &[]) };
        let (criterion, meat) = moments.criterion(&dictionary, &of).unwrap();
        assert_eq!(meat.is_some(), name != CriterionName::DHessian);
        criterion.solve(&Bounds::default(), &Options::default()).unwrap()
    };
    let mut table = Table::default();
    for name in [CriterionName::DHessian, CriterionName::D, CriterionName::ARelative, CriterionName::A] {
        let found = value(name);
        assert!((found.shares.iter().sum::<f64>() - 1.0).abs() < 1e-9);
        table.row(format!("{name:?} value"), [found.log_det]);
        table.row(format!("{name:?} shares"), found.shares.iter().map(|share| (1e5 * share).round() / 1e5));
    }
    let squares = moments.squares(Source::Value).unwrap();
    let truth = vessel.parameters(Source::Value).unwrap();
    assert_close(&squares, truth.iter().map(|theta| theta * theta));
    // The nominal model of the preset has no quadratic drag.
    assert!(moments.squares(Source::Nominal).unwrap_err().to_string().contains("parameter `X_uu`: found 0"));
    let rivals = moments.rivals(MeanRemoval::Complete, 1);
    assert!(rivals.random.iter().all(|shares| (shares.iter().sum::<f64>() - 1.0).abs() < 1e-12));
    let papers = rivals.paper.as_ref().unwrap().iter().zip(value(CriterionName::DHessian).shares);
    assert!(papers.into_iter().all(|(a, b)| (a - b).abs() < 1e-6));
    table.summed("random", rivals.random[0].iter());
    table.counts("random", [rivals.random.len(), rivals.random_segments as usize]);
    table.assert(
        "
        DHessian_value 1.78847168
        DHessian_shares 0 0 0.03232 0.42324 0 0 0 0 0 0.17946 0.36498
        D_value 97.7543344
        D_shares 0 0 0.23289 0.2466 0 0 0 0 0 0.17648 0.34403
        ARelative_value -5.87560274
        ARelative_shares 0 0.48619 0.19796 0 0 0 0 0 0 0.10808 0.20777
        A_value 1.40419585
        A_shares 0 0.79119 0.09668 0 0 0 0 0 0 0.11213 0
        random 11 1 1 0.418571429
        random 400 5
        ",
    );
}

#[test]
fn law_a_measured_run_counts_by_its_segments() {
    let (vessel, generator) = (vessel(), generator(&vessel()));
    let measured = campaign(1).remove(0).run;
    let parts = Prediction::runs(std::slice::from_ref(&measured));
    assert_eq!(parts.len(), 3);
    let ends = [(0, 80), (80, 280), (280, 400)];
    for (part, (from, to)) in parts.iter().zip(ends) {
        assert_eq!(part.samples(), to - from);
        assert_eq!(part.measured, measured.measured[3 * from..3 * (to + 1)]);
        assert_eq!(part.exogenous, measured.exogenous[3 * from..3 * to]);
        let initial = if from == 0 { measured.initial } else { [0, 1, 2].map(|d| part.measured[d]) };
        assert_eq!(part.initial, initial);
    }
    let dictionary = simulated(&vessel, &generator).remove(1).run;
    assert_eq!(Prediction::runs(std::slice::from_ref(&dictionary)), [dictionary]);
}

#[test]
fn golden_sampled_ships() {
    let mut vessel = vessel();
    let generator = generator(&vessel);
    vessel.value.iter_mut().for_each(|value| *value = None);
    let maneuvers = Maneuvers::new(&vessel, &generator, Source::Nominal, "dictionary").unwrap();
    let sampler = ShipSampler::new(&vessel, None).unwrap();
    let runs = maneuvers.simulate(0..3).unwrap().0;
    let played: Vec<_> = runs.iter().map(|own| sampler.play(&own.run)).collect();
    let mut table = Table::default();
    for motion in &played {
        for aim in &motion.missed {
            table.counts(format!("{} {}", motion.maneuver, aim.what), [aim.ships as usize]);
        }
    }
    let ships = sampler.found(played);
    let promise = ships.promise(0.2, |_| true).unwrap();
    assert!(promise.range[0] < 0.2 && 0.2 < promise.range[1]);
    table.row("promise", [promise.parameter_error].into_iter().chain(promise.range));
    for motion in ships.unreached(|name| name != "surge") {
        table.row(format!("{} {}", motion.maneuver, motion.what), [motion.missed.share]);
        assert!(motion.missed.share >= 0.25 && motion.maneuver != "surge");
    }
    table.assert(
        "
        zig-zag_mean_speed_of_the_second_half 18
        zig-zag_change_of_heading 0
        combined_mean_speed_of_the_second_half 8
        combined_change_of_heading 0
        surge_mean_speed_of_the_second_half 9
        surge_change_of_heading 0
        promise 0.2 0.037037037 0.769230769
        zig-zag_mean_speed_of_the_second_half 0.28125
        ",
    );
}

#[test]
fn golden_arranged_experiments() {
    let (vessel, generator, moments) = studied();
    let mut table = Table::default();
    for (estimated, name) in [
        (Estimated::Iv(MeanRemoval::Complete), CriterionName::DHessian),
        (Estimated::Iv(MeanRemoval::None), CriterionName::D),
        (Estimated::OutputError, CriterionName::ARelative),
    ] {
        let dictionary = moments.dictionary(estimated).unwrap();
        let of = CriterionOf { name, estimated, relative_to: Source::Value, figures: (&[], &[]) };
        let (criterion, _) = moments.criterion(&dictionary, &of).unwrap();
        let design = criterion.solve(&Bounds::default(), &Options::default()).unwrap();
        let (dictionary, criterion) = (&dictionary, &criterion);
        let arranging = Arranging {
            vessel: &vessel,
            generator: &generator,
            moments: &moments,
            dictionary,
            criterion,
            estimated,
            seed: 1,
        };
        let found = arranging.search(&design.shares, &design.sensitivities, 160).unwrap();
        assert_eq!(found.parts.iter().map(|(_, samples)| samples).sum::<usize>(), 160);
        let least = |name: &str| {
            let place = generator.maneuvers().iter().position(|own| own.name == name).unwrap();
            (0.15 * generator.samples(place).unwrap() as f64).ceil() as usize
        };
        assert!(found.parts.iter().all(|(name, samples)| *samples >= least(name)), "{found:?}");
        assert!(found.gain >= 0.0, "the search begins with the shares in order: {found:?}");
        table.row(format!("{name:?}"), [found.value, found.gain, found.tried as f64]);
        for (maneuver, samples) in &found.parts {
            table.counts(maneuver, [*samples]);
        }
        match &found.limits {
            Kept::Unlimited => panic!("generated maneuvers have limits"),
            Kept::Within => table.row("within", []),
            Kept::Beyond(own) => table.row(&own.limit, [own.allowed, own.found]),
        }
    }
    table.assert(
        "
        DHessian 0.85355767 2.03771649 721
        combined-00000 36
        steady-turn-00008 38
        combined-00009 36
        combined 50
        within
        D 102.918488 0.32962214 865
        combined 49
        combined-00000 36
        steady-turn-00008 75
        within
        ARelative -5.81050619 1.22781706 848
        combined 51
        surge 48
        combined-00009 61
        within
        ",
    );
}

#[test]
fn golden_refined_experiment() {
    let vessel = vessel();
    let limited = DICTIONARY.to_owned() + "\n[limits]\nu_m_s = 1.4\n";
    let generator = Generator::without_tables(&vessel, &limited.parse().unwrap()).unwrap();
    let start = RefinementStart::new(&vessel, &generator, &[(1, 60), (2, 60)], NOISE).unwrap();
    let states =
        simulate_one(&vessel.model, &vessel.parameters(Source::Value).unwrap(), start.initial, &start.inputs);
    assert_eq!(states, start.states);
    let (limits, start) = Limits::new(&vessel, &generator, start).unwrap();
    let mut table = Table::default();
    limits.names.iter().zip(&limits.allowed).for_each(|(name, allowed)| table.row(name, [*allowed]));
    table.counts("slowed", [start.slowed.len()]);
    let found = Refinement::search(&vessel, start, limits, 40, &Watch::default()).unwrap();
    let refined = &found.refined;
    let reached = found.limits.moduli(&refined.after.states, &refined.inputs, vessel.sample_rate_hz);
    for ((name, reached), allowed) in found.limits.names.iter().zip(&reached).zip(&found.limits.allowed) {
        assert!(*reached <= allowed * (1.0 + 1e-9), "{name}: {reached} of {allowed}");
    }
    assert!(found.efficiency() > 1.05 && !found.unchanged(), "{}", found.efficiency());
    table.counts("knot", [found.knot]);
    table.rough("values", [refined.before.value, refined.after.value, found.efficiency()]);
    table.assert(
        "
        u_m_s 1.4
        v_m_s 0.5
        r_rad_s 0.4
        inputs.tau1 6162.68039
        inputs.tau2 1147.57371
        inputs.tau3 358.514156
        rates.tau1 20000
        rates.tau2 20000
        rates.tau3 9000
        slowed 0
        knot 8
        ~values 20.4251651 0.812853913 25.1277195
        ",
    );
}

#[test]
fn golden_trials_in_rounds() {
    let (vessel, generator) = (vessel(), generator(&vessel()));
    let levels = NoiseModel {
        measurement: NOISE.measurement,
        current: Flow::White { std: NOISE.current },
        force: None,
        drift: None,
    };
    let estimators = RunEstimators {
        vessel: &vessel,
        estimators: vec![Estimator::OutputError],
        removal: MeanRemoval::Complete,
        initial: InitialState::Known,
        additional: AdditionalUnknowns::default(),
        levels: Some(levels),
    };
    let about = vessel.parameters(Source::Value).unwrap();
    let knowledge = Knowledge { floor: vec![0.0; about.len()], about, spread: 0.2, seed: 2 };
    let ends = rounds::ends(&vessel, 30.0, 3).unwrap();
    assert_eq!(ends, [80, 160, 240]);
    let trial =
        Trial::new(sea(&vessel, NOISE.current), &generator, NOISE, estimators, knowledge, ends, 5).unwrap();
    let rows = trial.realizations(0..2).unwrap();
    assert_eq!(rows.len(), 2 * Arm::ALL.len() * 3);
    let mut table = Table::default();
    table.counts("maneuvers", [trial.maneuvers()]);
    for row in &rows {
        let numbers = [row.parameter_error, row.predicted_error, row.expected_error];
        let name = format!(
            "{} {} {} {:?} {:?}",
            row.arm.name(),
            row.realization,
            row.round,
            row.shared,
            row.outcome
        );
        table.rough(&name, [row.samples as f64].into_iter().chain(numbers.into_iter().flatten()));
    }
    let summary = Summary::new(&rows, trial.ends(), 1.7, vessel.sample_rate_hz);
    for arm in &summary.arms {
        for point in &arm.points {
            let numbers = [Some(point.time_s), point.median, point.q90, point.predicted, Some(point.within)];
            let counts = [point.not_identifiable, point.not_converged, point.diverged, point.undesigned];
            let counts = counts.map(|count| count as f64);
            table.rough(arm.name.name(), numbers.into_iter().flatten().chain(counts));
        }
    }
    // A realization alone is the same as among others.
    assert_eq!(trial.realizations(1..2).unwrap(), rows[rows.len() / 2..]);
    table.assert(
        "
        maneuvers 11
        ~sequential_0_0_Designed_Identified 80 18.886532 8.05575414
        ~sequential_0_1_Designed_Identified 160 2.29154821 1.60529516
        ~sequential_0_2_Designed_Identified 240 1.59921098 1.36838349
        ~one-shot_0_0_Designed_Identified 80 18.886532 8.05575414 4.61765259
        ~one-shot_0_1_Designed_Identified 160 2.91667434 1.83140727 1.233449
        ~one-shot_0_2_Designed_Identified 240 2.04697247 1.08038426 0.729163944
        ~informed_0_0_Designed_Identified 80 9.7709065 4.22587344
        ~informed_0_1_Designed_Identified 160 3.53328766 1.78976304
        ~informed_0_2_Designed_Identified 240 2.39783485 0.908024267
        ~random_0_0_Drawn_Identified 80 11.1627843 8.09741713
        ~random_0_1_Drawn_Identified 160 8.85762743 7.20759926
        ~random_0_2_Drawn_Identified 240 1.48744952 1.59204103
        ~sequential_1_0_Designed_Identified 80 7.85098261 6.90293932
        ~sequential_1_1_Designed_Identified 160 1.31110658 1.73803449
        ~sequential_1_2_Designed_Identified 240 1.15707137 1.52726805
        ~one-shot_1_0_Designed_Identified 80 7.85098261 6.90293932 7.97216196
        ~one-shot_1_1_Designed_Identified 160 1.70517265 2.52369192 3.04081256
        ~one-shot_1_2_Designed_Identified 240 0.445687846 1.15981445 1.74587408
        ~informed_1_0_Designed_Identified 80 0.920778896 3.72456633
        ~informed_1_1_Designed_Identified 160 0.559595004 1.88244493
        ~informed_1_2_Designed_Identified 240 0.639940117 1.1412815
        ~random_1_0_Drawn_Identified 80 7.13285261 6.96108206
        ~random_1_1_Drawn_Identified 160 0.445860339 4.00119871
        ~random_1_2_Drawn_Identified 240 1.1722148 1.82650236
        ~sequential 10 13.3687573 17.782977 7.47934673 0 0 0 0 0
        ~sequential 20 1.8013274 2.19350405 1.67166482 0.5 0 0 0 0
        ~sequential 30 1.37814117 1.55499701 1.44782577 1 0 0 0 0
        ~one-shot 10 13.3687573 17.782977 7.47934673 0 0 0 0 0
        ~one-shot 20 2.3109235 2.79552417 2.17754959 0 0 0 0 0
        ~one-shot 30 1.24633016 1.88684401 1.12009935 0.5 0 0 0 0
        ~informed 10 5.3458427 8.88589374 3.97521988 0.5 0 0 0 0
        ~informed 20 2.04644133 3.23591839 1.83610398 0.5 0 0 0 0
        ~informed 30 1.51888748 2.22204538 1.02465288 0.5 0 0 0 0
        ~random 10 9.14781848 10.7597912 7.52924959 0 0 0 0 0
        ~random 20 4.65174389 8.01645072 5.60439898 0.5 0 0 0 0
        ~random 30 1.32983216 1.45592605 1.70927169 1 0 0 0 0
        ",
    );
}

#[test]
fn law_crude_models_scatter_by_their_spread() {
    let known = Knowledge { about: vec![2.0, -0.5], spread: 0.3, floor: vec![0.0; 2], seed: 1 };
    let logs = (0..4000).flat_map(|run| {
        known
            .crude(run)
            .into_iter()
            .zip(&known.about)
            .map(|(crude, about)| (crude / about).ln())
            .collect::<Vec<_>>()
    });
    let (count, sum, squares) =
        logs.fold((0.0, 0.0, 0.0), |(n, sum, squares), log| (n + 1.0, sum + log, squares + log * log));
    assert!((sum / count).abs() < 0.01 && ((squares / count).sqrt() / 0.3 - 1.0).abs() < 0.03);
    let streams = Streams::new(1, "trial");
    let drawn = trial::campaign::random_segments(&streams, 3, &[4, 7], &[10, 20, 30]);
    assert!(drawn.iter().all(|(q, _)| [4, 7].contains(q)));
    assert_eq!(drawn.iter().map(|(_, n)| *n).collect::<Vec<_>>(), [10, 20, 30]);
    let shares: BTreeMap<String, f64> = [("a".to_owned(), 0.5), ("b".to_owned(), 0.5)].into();
    let plan = Designed { shares, order: None }.plan(&["a".to_owned(), "b".to_owned()], &BTreeMap::new(), 9);
    assert_eq!(plan.unwrap().iter().map(|(_, n)| n).sum::<usize>(), 9);
}
