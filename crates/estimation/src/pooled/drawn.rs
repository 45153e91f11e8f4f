use numerics::symmetric;
use ship::engine::Streams;
use ship::model::Vessel;

use super::delivered::Covariance;

/// Parameters and what an estimate leaves uncertain of them.
pub struct Uncertain {
    parameters: Vec<f64>,
    /// Place of each uncertain parameter.
    places: Vec<usize>,
    /// A root of their covariance, n × n, row-major.
    root: Vec<f64>,
    /// Ends of what each may be.
    ends: Vec<[f64; 2]>,
}

impl Uncertain {
    /// Of `vessel` with `parameters`; what the covariance says of constants is left out. `None` where it is no covariance.
    pub fn new(vessel: &Vessel, parameters: Vec<f64>, covariance: &Covariance) -> Option<Self> {
        let names: Vec<&str> = vessel.model.parameter_names().collect();
        let place = |name: &String| names.iter().position(|own| own == name);
        let known: Vec<(usize, usize)> =
            covariance.names.iter().enumerate().filter_map(|(row, name)| Some((row, place(name)?))).collect();
        let (n, width) = (known.len(), covariance.names.len());
        let entry = |k: usize| covariance.entries[known[k / n].0 * width + known[k % n].0];
        let part: Vec<f64> = (0..n * n).map(entry).collect();
        let (values, vectors) = symmetric(n, &part)?;
        let root = (0..n * n).map(|k| vectors[k] * values[k % n].max(0.0).sqrt()).collect();
        let places: Vec<usize> = known.into_iter().map(|(_, place)| place).collect();
        let ends = places.iter().map(|place| ends(vessel, *place)).collect();
        Some(Self { parameters, places, root, ends })
    }

    /// Parameters of draw `draw`; numbers of forces stay within their bounds, as estimates do.
    pub fn drawn(&self, streams: &Streams, draw: u32) -> Vec<f64> {
        let n = self.places.len();
        let mut normals = vec![0.0; n];
        streams.normals(draw, 0, &mut normals);
        let mut parameters = self.parameters.clone();
        for ((row, place), [low, high]) in self.root.chunks_exact(n.max(1)).zip(&self.places).zip(&self.ends)
        {
            let off = row.iter().zip(&normals).map(|(a, z)| a * z).sum::<f64>();
            parameters[*place] = (parameters[*place] + off).clamp(*low, *high);
        }
        parameters
    }
}

/// The bounds of a number of forces; open for terms.
fn ends(vessel: &Vessel, place: usize) -> [f64; 2] {
    let open = [f64::NEG_INFINITY, f64::INFINITY];
    vessel.model.forces.as_ref().map_or(open, |own| own.forces.parameters()[place].bounds)
}
