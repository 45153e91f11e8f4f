use ship::engine::Compiled;
use ship::model::Vessel;

/// The signs of the inputs that mirror the vessel's motion about its centre plane: u, −v, −r under `signs` · inputs
/// is the mirrored motion of u, v, r under inputs. `None` where the model is not symmetric.
///
/// All signs are tried by evaluating the nominal model at a few points.
pub fn mirror(vessel: &Vessel) -> Option<Vec<f64>> {
    let inputs = vessel.model.inputs;
    if inputs > 12 {
        return None;
    }
    let signs = |bits: u32| {
        (0..inputs).map(move |i| if bits >> i & 1 == 1 { -1.0 } else { 1.0 }).collect::<Vec<f64>>()
    };
    (0..1_u32 << inputs).map(signs).find(|signs| (1..=5).all(|point| is_mirrored(vessel, signs, point)))
}

fn is_mirrored(vessel: &Vessel, signs: &[f64], point: u32) -> bool {
    let value = |i: usize| libm::sin(f64::from(point) * 0.7 + i as f64 * 1.3);
    let count = vessel.model.exogenous();
    let mut own: Vec<f64> = (0..count).map(|i| if i < signs.len() { value(i + 3) } else { 0.0 }).collect();
    let mut mirrored: Vec<f64> =
        own.iter().enumerate().map(|(i, u)| signs.get(i).unwrap_or(&1.0) * u).collect();
    vessel.model.complete(&mut own);
    vessel.model.complete(&mut mirrored);
    let [u, v, r] = [0, 1, 2].map(value);
    let (a, b) = (increments(vessel, [u, v, r], &own), increments(vessel, [u, -v, -r], &mirrored));
    let close = |x: f64, y: f64| (x - y).abs() <= 1e-9 * (x.abs() + y.abs());
    close(a[0], b[0]) && close(a[1], -b[1]) && close(a[2], -b[2])
}

fn increments(vessel: &Vessel, states: [f64; 3], exogenous: &[f64]) -> [f64; 3] {
    let mut model = Compiled::new(&vessel.model, &vessel.nominal);
    model.look(states, exogenous, None);
    model.increments()
}
