use std::time::Instant;
use identification::*;
use vessel::*;
fn main() {
    let vessel = Vessel::from_file(toml::from_str("preset = \"ljungberg-model-ship\"").unwrap()).unwrap();
    let truth: Vec<Lane> = vessel.parameters(Source::Value).unwrap().into_iter().map(Lane::splat).collect();
    let n = 1000;
    let inputs: Vec<Lane> = (0..3*n).map(|i| Lane::splat([3000.0, 500.0, 200.0][i%3] * ((i as f64)*0.01).sin())).collect();
    let std = 0.158;
    let d = Disturbances { current: Current::White { std_m_s: std }, measurement: Measurement { std_u_m_s: std, std_v_m_s: std, std_r_rad_s: std } };
    let streams = Streams::new(1, "x");
    let reps = 200;
    let t = |name: &str, f: &mut dyn FnMut()| { let s = Instant::now(); for _ in 0..reps { f() } println!("{name}: {:.2} us per realization", s.elapsed().as_secs_f64()/reps as f64/8.0*1e6) };
    let runs = [0,1,2,3,4,5,6,7];
    let mut current = Vec::new();
    t("current", &mut || current = d.current(&streams, runs, n));
    let mut states = vec![Lane::ZERO; 3*(n+1)];
    let init = [1.0,0.0,0.0].map(Lane::splat);
    t("simulate", &mut || simulate(&vessel.model, &truth, init, &inputs, &current, &mut states));
    let nominal = states.clone();
    t("measure", &mut || d.measure(&streams, runs, &mut states));
    simulate(&vessel.model, &truth, init, &inputs, &current, &mut states); d.measure(&streams, runs, &mut states);
    let batch = Batch { model: &vessel.model, measured: &states, instrument_states: &nominal, exogenous: &inputs, segments: [&[0]; LANES] };
    t("estimate", &mut || { std::hint::black_box(estimate(&batch, MeanRemoval::Complete)); });
    t("moments", &mut || { std::hint::black_box(moments(&batch)); });
    let reference: Vec<f64> = nominal.iter().map(|l| l[0]).collect();
    let mut b = Vec::new();
    t("free", &mut || { std::hint::black_box(free_runs(&vessel.model, &truth, &inputs, &reference, &mut b)); });
}
