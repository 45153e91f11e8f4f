//! Rows of all channels from rows of inputs.

use refusal::Invalid;

use crate::model::Model;

/// The exogenous inputs of a model where there are no logs: inputs from a maneuver, measured disturbances as
/// `simulated`, derived channels by their formulas. Rows hold them in this order.
impl Model {
    /// Sets the disturbances and derived channels of a row whose inputs are set, as in simulated trials.
    pub fn complete(&self, row: &mut [f64]) {
        for (variable, value) in &self.simulated {
            row[variable - 3] = *value;
        }
        self.derive(row);
    }

    /// Sets the derived channels of a row whose other channels are set.
    pub fn derive(&self, row: &mut [f64]) {
        for own in &self.derived {
            row[own.variable - 3] = own.value(row);
        }
    }

    /// Adds to the derivatives by inputs and measured disturbances the part by way of derived channels, at
    /// `row`. `slopes`: a row per variable, of `N` quantities.
    pub fn by_sources<const N: usize>(&self, row: &[f64], slopes: &mut [[f64; N]]) {
        for own in self.derived.iter().rev() {
            let outer = slopes[own.variable];
            for (channel, source) in own.sources.iter().enumerate() {
                let inner = own.formula.slope(channel, |channel| row[own.sources[channel] - 3]);
                slopes[*source].iter_mut().zip(outer).for_each(|(slope, outer)| *slope += inner * outer);
            }
        }
    }

    /// Inputs, N × inputs, completed by the other channels of simulated trials: N × exogenous, row-major.
    pub fn undisturbed(&self, inputs: &[f64]) -> Vec<f64> {
        if self.exogenous() == self.inputs {
            return inputs.to_vec();
        }
        let mut rows = vec![0.0; inputs.len() / self.inputs.max(1) * self.exogenous()];
        for (row, own) in rows.chunks_exact_mut(self.exogenous()).zip(inputs.chunks_exact(self.inputs)) {
            row[..self.inputs].copy_from_slice(own);
            self.complete(row);
        }
        rows
    }

    /// The inputs of N × exogenous rows, row-major: N × inputs.
    pub fn inputs_of(&self, rows: &[f64]) -> Vec<f64> {
        let rows = rows.chunks_exact(self.exogenous().max(1));
        rows.flat_map(|row| row[..self.inputs].iter().copied()).collect()
    }

    /// Refuses a measured disturbance without a value for simulated trials: taking it as zero would silently
    /// change the motion.
    ///
    /// # Errors
    /// Names the first of them.
    pub fn check_simulated(&self) -> Result<(), Invalid> {
        let known = |variable: &usize| {
            self.simulated.contains_key(variable) || self.derived.iter().any(|own| own.variable == *variable)
        };
        match (3 + self.inputs..self.variables.len()).find(|variable| !known(variable)) {
            None => Ok(()),
            Some(variable) => Err(Invalid::new(
                format!("measured disturbance `{}` of the vessel", self.variables[variable].name),
                "no value for simulated trials",
                "`simulated` in its [[measured]], or a [[derived]] channel",
                "add `simulated = 0.0` if simulated trials have none of it, or compute it by [[derived]]",
            )),
        }
    }
}
