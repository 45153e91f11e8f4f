//! Limits of inputs, rates and motion: from a file, from what candidates were generated within, or from the start itself.

use std::collections::BTreeMap;
use std::path::Path;

use artifact::{Provenance, read_toml};
use identification::refine::SignalLimits;
use serde::Deserialize;
use vessel::{Generator, Vessel, nearest};

use super::{Refine, start::Start};
use crate::failure::Failure;

/// `limits.toml` as written: largest moduli.
#[derive(Clone, Debug, Default, Deserialize)]
#[serde(deny_unknown_fields)]
struct LimitsFile {
    u_m_s: Option<f64>,
    v_m_s: Option<f64>,
    r_rad_s: Option<f64>,
    #[serde(default)]
    inputs: BTreeMap<String, f64>,
    /// Of the inputs' rates, per second.
    #[serde(default)]
    rates: BTreeMap<String, f64>,
}

/// The limits with their names.
pub struct Limits {
    /// `u_m_s`, `v_m_s`, `r_rad_s`, `inputs.…`, `rates.…`.
    pub names: Vec<String>,
    /// In the same order, in the limits' units; infinite without limit.
    pub allowed: Vec<f64>,
    /// As the search has them.
    pub signal: SignalLimits,
}

/// The states' keys.
const STATES: [&str; 3] = ["u_m_s", "v_m_s", "r_rad_s"];

impl Limits {
    /// The limits of `a`, which the start must keep.
    ///
    /// # Errors
    /// A limit that is none, or of an unknown input; one that the start breaks.
    pub fn new(
        a: &Refine,
        vessel: &Vessel,
        generator: &Generator,
        start: &Start,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let inputs: Vec<&str> =
            vessel.model.variables[3..3 + vessel.model.inputs].iter().map(|v| v.name.as_str()).collect();
        let file = match &a.limits {
            Some(path) => {
                let (file, digest) = read_toml::<LimitsFile>(path)?;
                provenance.inputs.insert("limits".into(), digest);
                check(path, &file, &inputs)?;
                file
            }
            None => LimitsFile::default(),
        };
        let generated = (0..generator.maneuvers().len()).rev().find_map(|q| generator.limits(q));
        let width = inputs.len();
        let largest = |values: &[f64], i: usize, width: usize| {
            values.iter().skip(i).step_by(width).fold(0.0_f64, |most, x| most.max(x.abs()))
        };
        let states = [file.u_m_s, file.v_m_s, file.r_rad_s];
        let generated_states = generated.map(|g| [g.u_m_s, g.v_m_s, g.r_rad_s]);
        let state = |d: usize| {
            states[d].or(generated_states.map(|g| g[d])).unwrap_or_else(|| largest(&start.states, d, 3))
        };
        let input = |(i, name): (usize, &&str)| {
            let stated = file.inputs.get(*name).or_else(|| generated?.inputs.get(*name)).copied();
            stated.unwrap_or_else(|| largest(&start.inputs, i, width))
        };
        let rate = |name: &&str| file.rates.get(*name).copied().unwrap_or(f64::INFINITY);
        let states = [0, 1, 2].map(state);
        let amplitudes: Vec<f64> = inputs.iter().enumerate().map(input).collect();
        let rates: Vec<f64> = inputs.iter().map(rate).collect();
        let steps = rates.iter().map(|rate| rate / vessel.sample_rate_hz).collect();
        let under = |table: &'static str| inputs.iter().map(move |name| format!("{table}.{name}"));
        let names =
            STATES.iter().map(|s| (*s).to_owned()).chain(under("inputs")).chain(under("rates")).collect();
        let limits = Self {
            names,
            allowed: states.iter().chain(&amplitudes).chain(&rates).copied().collect(),
            signal: SignalLimits { states, inputs: amplitudes, steps },
        };
        limits.check_start(a, start)?;
        Ok(limits)
    }

    /// The largest moduli of an experiment, in the limits' units. `rate_hz`: of the samples.
    pub fn moduli(&self, states: &[f64], inputs: &[f64], rate_hz: f64) -> Vec<f64> {
        let width = self.signal.inputs.len();
        let unit =
            SignalLimits { states: [1.0; 3], inputs: vec![1.0; width], steps: vec![1.0 / rate_hz; width] };
        unit.reached(states, inputs)
    }

    fn check_start(&self, a: &Refine, start: &Start) -> Result<(), Failure> {
        let stated_in = a.limits.as_ref().unwrap_or(&a.dictionary);
        if let Some(i) = self.allowed.iter().position(|limit| *limit == 0.0) {
            return Err(Failure::refuse(
                &a.design,
                &format!("`{}` of the design's experiment", self.names[i]),
                "zero all the time, and no limit is stated",
                "a limit, or an experiment that moves it",
                "state it in --limits limits.toml",
            ));
        }
        let reached = self.signal.reached(&start.states, &start.inputs);
        let most = (0..reached.len()).max_by(|i, j| reached[*i].total_cmp(&reached[*j])).unwrap_or(0);
        if reached[most] <= 1.0 + 1e-9 {
            return Ok(());
        }
        Err(Failure::refuse(
            stated_in,
            &format!("limit `{}`", self.names[most]),
            &format!("{} in the design's experiment", reached[most] * self.allowed[most]),
            &format!("at most {}", self.allowed[most]),
            "begin with a design that keeps it, or state a wider one in --limits",
        ))
    }
}

fn check(path: &Path, file: &LimitsFile, inputs: &[&str]) -> Result<(), Failure> {
    let tables = [("inputs", &file.inputs), ("rates", &file.rates)];
    for (table, values) in tables {
        if let Some(unknown) = values.keys().find(|key| !inputs.contains(&key.as_str())) {
            let near = nearest(unknown, inputs.iter().copied()).unwrap_or_default();
            let (thing, found) = (format!("`{table}`"), format!("`{unknown}`"));
            let remedy = format!("did you mean `{near}`?");
            return Err(Failure::refuse(path, &thing, &found, &inputs.join(", "), &remedy));
        }
    }
    let states = STATES.iter().zip([file.u_m_s, file.v_m_s, file.r_rad_s]);
    let states = states.filter_map(|(key, limit)| Some(((*key).to_owned(), limit?)));
    let named = |(table, values): (&str, &BTreeMap<String, f64>)| {
        values.iter().map(|(key, limit)| (format!("{table}.{key}"), *limit)).collect::<Vec<_>>()
    };
    match states.chain(tables.into_iter().flat_map(named)).find(|(_, l)| !(l.is_finite() && *l > 0.0)) {
        None => Ok(()),
        Some((key, limit)) => Err(Failure::refuse(
            path,
            &format!("`{key}`"),
            &limit.to_string(),
            "a number above 0",
            "correct it, or leave it out",
        )),
    }
}
