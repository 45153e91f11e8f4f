use ship::engine::Streams;

/// The knowledge of the parameters before a trial, and its update by estimates.
pub struct Knowledge {
    /// Parameters that crude models are drawn around.
    pub about: Vec<f64>,
    /// Standard deviation of the logarithm of crude over these.
    pub spread: f64,
    /// Least moduli that errors are relative to; 0 for none.
    pub floor: Vec<f64>,
    /// Seed of the draws.
    pub seed: u64,
}

impl Knowledge {
    /// The crude model of a realization.
    pub fn crude(&self, realization: u32) -> Vec<f64> {
        let mut normals = vec![0.0; self.about.len()];
        Streams::new(self.seed, "crude model").normals(realization, 0, &mut normals);
        self.about.iter().zip(normals).map(|(theta, z)| theta * libm::exp(self.spread * z)).collect()
    }

    /// The variance-weighted mean of the crude and the estimated parameters: the crude one's variance is
    /// (spread × parameter)², at least that of the floor.
    pub fn learnt(&self, crude: &[f64], estimate: &[f64], standard_errors: &[f64]) -> Vec<f64> {
        let between = |(i, error): (usize, &f64)| {
            let before = (self.spread * crude[i]).abs().max(self.floor[i]).powi(2);
            let sum = before + error * error;
            if sum > 0.0 { crude[i] + before / sum * (estimate[i] - crude[i]) } else { estimate[i] }
        };
        standard_errors.iter().enumerate().map(between).collect()
    }

    /// The sizes that errors of the parameters are relative to.
    pub fn sizes(&self, theta: &[f64]) -> Vec<f64> {
        theta.iter().zip(&self.floor).map(|(theta, floor)| theta.abs().max(*floor)).collect()
    }

    /// 2-norm over the parameters of `standard_errors` over the sizes of `theta`.
    pub fn relative(&self, standard_errors: &[f64], theta: &[f64]) -> f64 {
        let relative = standard_errors.iter().zip(self.sizes(theta)).map(|(error, size)| error / size);
        relative.map(|x| x * x).sum::<f64>().sqrt()
    }
}
