use std::collections::BTreeMap;

use refusal::Invalid;
use ship::engine::{Helm, check_diverged, refuse_endless, simulate_command, simulate_one};
use ship::model::{Source, Vessel};

use super::kind::{ManeuverKind, Plan};
use super::played::{PlayedTable, check_range};
use super::spec::ManeuverSpec;
use crate::DictionaryFile;
use crate::feedback::{Executed, Linearised, Tracked, actuated};
use crate::limits::{self, Aim, Limits, StatedLimits, Tolerance};
use crate::standard::orders::{Orders, changes};
use crate::standard::{Settings, Standard, check_names};
use crate::steady::{Motion, Steady};

/// A maneuver turned into inputs.
#[derive(Clone, Debug, PartialEq)]
pub struct Realized {
    /// State at the start: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// N × inputs, row-major; for a maneuver that reacts, those of the undisturbed ship, which the dictionary is computed with.
    pub inputs: Vec<f64>,
    /// Its commands, if they depend on the ship's motion.
    pub helm: Option<Helm>,
}

/// What the maneuvers of a dictionary react by.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Reacting {
    /// Whether any of them tracks a motion by feedback, so that runs have instruments other than their inputs.
    pub tracks: bool,
    /// The inputs, by index, whose actuators follow the commands of any of them with a lag, a rate, a dead band or a hold.
    pub followed: Vec<usize>,
}

/// Turns the maneuvers of a dictionary into inputs for one vessel.
#[derive(Clone, Debug)]
pub struct Generator {
    vessel: Vessel,
    parameters: Vec<f64>,
    maneuvers: Vec<ManeuverSpec>,
    /// Number of maneuvers that are written by hand.
    written: usize,
    limits: Option<Limits>,
    stated: StatedLimits,
    default_s: Option<f64>,
    tolerance: Tolerance,
    tables: BTreeMap<usize, PlayedTable>,
    helms: BTreeMap<usize, Helm>,
}

/// Keys of speeds ahead.
const SPEEDS: [&str; 3] = ["speed_m_s", "from_m_s", "to_m_s"];

impl Generator {
    /// Checks the dictionary and reads its tables of inputs with `read` (name → CSV).
    ///
    /// # Errors
    /// See [`DictionaryFile::expanded`] and [`ship::model::Model::check_simulated`]; swings that are too fast for
    /// the sampling rate; a table of inputs that is refused; missing true values.
    pub fn new(
        vessel: &Vessel,
        dictionary: &DictionaryFile,
        read: impl Fn(&str) -> Result<String, Invalid>,
    ) -> Result<Self, Invalid> {
        let mut maneuvers = dictionary.expanded()?;
        let written = dictionary.maneuvers.len();
        if !vessel.commands_sway() {
            maneuvers[written..].iter_mut().for_each(|drawn| drawn.kind.release_sway());
        }
        vessel.model.check_simulated()?;
        dictionary.check_sampling(vessel.sample_rate_hz)?;
        let limits = dictionary.generate.as_ref().map(|generate| generate.limits.clone());
        limits.as_ref().map_or(Ok(()), |limits| limits.check(&vessel.model))?;
        dictionary.limits.check(&vessel.model)?;
        let source = match vessel.best_known() {
            Source::Value => dictionary.inputs_from,
            Source::Nominal => Source::Nominal,
        };
        let mut tables = BTreeMap::new();
        for (index, maneuver) in dictionary.maneuvers.iter().enumerate() {
            for (key, speed) in
                maneuver.kind.numbers().into_iter().filter(|number| SPEEDS.contains(&number.0))
            {
                vessel.check_speed(speed, || format!("maneuver `{}`, `{key}`", maneuver.name))?;
            }
            if let Some(table) = PlayedTable::of(maneuver, vessel, &read)? {
                tables.insert(index, table);
            }
            if let Some(standard) = maneuver.kind.standard() {
                standard.check_inputs(&maneuver.name, vessel)?;
                check_approach(maneuver, vessel)?;
            }
        }
        let generator = Self {
            vessel: vessel.clone(),
            parameters: vessel.parameters(source)?,
            maneuvers,
            written,
            limits,
            stated: dictionary.limits.clone(),
            default_s: dictionary.duration_s,
            tolerance: dictionary.tolerance,
            tables,
            helms: BTreeMap::new(),
        };
        generator.check_holds()?;
        Ok(generator)
    }

    /// Refuses a maneuver that reacts and ends before an actuator takes a second command.
    fn check_holds(&self) -> Result<(), Invalid> {
        let actuators = self.vessel.actuators.iter().zip(self.vessel.model.input_variables());
        let Some((actuator, input)) = actuators.max_by(|(a, _), (b, _)| a.hold_s.total_cmp(&b.hold_s)) else {
            return Ok(());
        };
        let seconds = |index: usize| match self.tables.get(&index) {
            Some(table) => Some(table.samples as f64 / self.vessel.sample_rate_hz),
            None => self.maneuvers[index].duration(self.default_s),
        };
        let mut reacting = (0..self.maneuvers.len()).filter(|index| self.reacts(*index));
        let ended =
            reacting.find_map(|index| Some((index, seconds(index).filter(|all| actuator.hold_s >= *all)?)));
        match ended {
            None => Ok(()),
            Some((index, duration_s)) => Err(Invalid::new(
                format!("maneuver `{}` of {duration_s} s", self.maneuvers[index].name),
                format!("`hold_s` = {} s of input `{}` in the vessel's file", actuator.hold_s, input.name),
                "a shorter hold, so that a command can follow the ship's motion",
                "shorten the hold, or lengthen the maneuver with `duration_s`",
            )),
        }
    }

    /// The generator with maneuver `index` commanded by `helm`; its motion only determines the initial state.
    #[must_use]
    pub fn commanded(mut self, index: usize, helm: Helm) -> Self {
        self.helms.insert(index, helm);
        self
    }

    /// The generator with the approaches of zig-zag tests held for so much longer \[s\]: their helm then goes over elsewhere
    /// within samples.
    #[must_use]
    pub fn later(mut self, seconds: f64) -> Self {
        for maneuver in &mut self.maneuvers {
            if let ManeuverKind::ZigZagTest(test) = &mut maneuver.kind {
                test.hold_s += seconds;
            }
        }
        self
    }

    /// A generator for a dictionary without tables of inputs.
    ///
    /// # Errors
    /// See [`Generator::new`]; a maneuver with a table of inputs.
    pub fn without_tables(vessel: &Vessel, dictionary: &DictionaryFile) -> Result<Self, Invalid> {
        let none = |name: &str| {
            Err(Invalid::new(format!("inputs `{name}`"), "a table", "none", "use maneuvers without tables"))
        };
        Self::new(vessel, dictionary, none)
    }

    /// The maneuvers, in order.
    pub fn maneuvers(&self) -> &[ManeuverSpec] {
        &self.maneuvers
    }

    /// How many of them are written by hand; the others are generated.
    pub fn written(&self) -> usize {
        self.written
    }

    /// The limits that maneuver `index` has to keep, if it is generated.
    pub fn limits(&self, index: usize) -> Option<&Limits> {
        self.limits.as_ref().filter(|_| index >= self.written)
    }

    /// The limits that refined inputs keep.
    pub fn stated_limits(&self) -> &StatedLimits {
        &self.stated
    }

    /// The parameters that turn maneuvers into inputs.
    pub fn parameters(&self) -> &[f64] {
        &self.parameters
    }

    /// Number of samples of maneuver `index` in the dictionary.
    ///
    /// # Errors
    /// A duration shorter than half a sample, or unbounded.
    pub fn samples(&self, index: usize) -> Result<usize, Invalid> {
        let maneuver = &self.maneuvers[index];
        let endless = || format!("maneuver `{}`, `duration_s`", maneuver.name);
        let stated = maneuver.duration(self.default_s).map(|s| self.vessel.samples(s));
        match self.tables.get(&index).map(|table| table.samples).or(stated) {
            Some(samples) if samples > 0 => refuse_endless(endless(), samples).map(|()| samples),
            _ => Err(Invalid::new(
                format!("maneuver `{}`", maneuver.name),
                "zero samples",
                format!("at least one sample ({} s)", 1.0 / self.vessel.sample_rate_hz),
                "lengthen it with `duration_s`",
            )),
        }
    }

    /// The maneuvers with tables of inputs, by index.
    pub fn tables(&self) -> &BTreeMap<usize, PlayedTable> {
        &self.tables
    }

    /// Whether a shorter run of maneuver `index` is the beginning of a longer one: no part of it is stretched.
    pub fn is_unstretched(&self, index: usize) -> bool {
        self.helms.contains_key(&index) || self.maneuvers[index].kind.is_unstretched()
    }

    /// What the maneuvers react by.
    pub fn reacting(&self) -> Reacting {
        let tracks = self.maneuvers.iter().any(|maneuver| maneuver.executed == Executed::Feedback)
            || self.helms.values().any(Helm::tracks);
        let reacts = (0..self.maneuvers.len()).any(|index| self.reacts(index));
        let actuators = self.vessel.actuators.iter().enumerate();
        let followed =
            actuators.filter(|(_, actuator)| reacts && !actuator.is_immediate()).map(|(i, _)| i).collect();
        Reacting { tracks, followed }
    }

    /// Whether what is commanded in maneuver `index` depends on the ship's motion.
    pub fn reacts(&self, index: usize) -> bool {
        let maneuver = &self.maneuvers[index];
        let by_kind = maneuver.kind.standard().is_some() || maneuver.executed == Executed::Feedback;
        by_kind || self.helms.contains_key(&index)
    }

    /// Whether the ship stops in maneuver `index`, so that a longer run of it says little more.
    pub fn stops(&self, index: usize) -> bool {
        matches!(self.maneuvers[index].kind.standard(), Some(Standard::Stop(_)))
    }

    /// The inputs of maneuver `index` in `samples` samples. Swings keep their period, sweeps are stretched to
    /// the length. Tables are played from their first row.
    ///
    /// # Errors
    /// A motion that the model cannot hold; a table of fewer samples.
    pub fn realize(&self, index: usize, samples: usize) -> Result<Realized, Invalid> {
        let maneuver = &self.maneuvers[index];
        let named = |e: Invalid| self.named(index, e);
        let table = self.tables.get(&index);
        let plan =
            Plan::new(&maneuver.kind, self.vessel.sample_rate_hz, if table.is_some() { 0 } else { samples });
        let initial = plan.start();
        if let Some(helm) = self.helms.get(&index) {
            return Ok(self.react(initial, samples, helm.clone()));
        }
        if let Some(standard) = maneuver.kind.standard() {
            let (orders, approach) = self.orders(standard, &maneuver.approach).map_err(named)?;
            let helm = actuated(Helm::new(orders), &self.vessel, &approach);
            return Ok(self.react(initial, samples, helm));
        }
        let inputs = self.held(index, &plan, samples)?;
        let helm = match maneuver.executed {
            Executed::Inputs => None,
            Executed::Feedback => {
                let tracked = self.tracked(index, initial, &inputs).map_err(named)?;
                Some(actuated(tracked, &self.vessel, &inputs[..self.vessel.model.inputs]))
            }
        };
        Ok(Realized { initial, inputs, helm })
    }

    /// The commands of maneuver `index` in up to `samples` samples, before any actuator; `None` if they do not depend
    /// on the ship's motion.
    ///
    /// # Errors
    /// As [`Generator::realize`].
    pub fn program(&self, index: usize, samples: usize) -> Result<Option<Helm>, Invalid> {
        let maneuver = &self.maneuvers[index];
        let named = |e: Invalid| self.named(index, e);
        if let Some(helm) = self.helms.get(&index) {
            return Ok(Some(helm.clone()));
        }
        if let Some(standard) = maneuver.kind.standard() {
            let orders = self.orders(standard, &maneuver.approach);
            return orders.map(|(orders, _)| Some(Helm::new(orders))).map_err(named);
        }
        if maneuver.executed == Executed::Inputs {
            return Ok(None);
        }
        let plan = Plan::new(&maneuver.kind, self.vessel.sample_rate_hz, samples);
        let inputs = self.held(index, &plan, samples)?;
        self.tracked(index, plan.start(), &inputs).map(Some).map_err(named)
    }

    /// The inputs of maneuver `index` that the nominal ship holds its motion with, or those of its table.
    fn held(&self, index: usize, plan: &Plan, samples: usize) -> Result<Vec<f64>, Invalid> {
        if let Some(table) = self.tables.get(&index) {
            return table.first(samples).map(<[f64]>::to_vec);
        }
        // What feedback will need is not known, and actuators keep to their ranges.
        let within = index < self.written || self.maneuvers[index].executed == Executed::Inputs;
        self.inputs(plan, samples, within).map_err(|e| self.named(index, e))
    }

    /// An error in maneuver `index`.
    fn named(&self, index: usize, e: Invalid) -> Invalid {
        Invalid { thing: format!("maneuver `{}`, {}", self.maneuvers[index].name, e.thing), ..e }
    }

    /// The commands of `helm` to the undisturbed ship.
    fn react(&self, initial: [f64; 3], samples: usize, helm: Helm) -> Realized {
        let (model, rate_hz) = (&self.vessel.model, self.vessel.sample_rate_hz);
        let run = simulate_command(model, &self.parameters, initial, samples, rate_hz, &helm);
        Realized { initial, inputs: model.inputs_of(&run.exogenous), helm: Some(helm) }
    }

    /// The orders of a standard maneuver, and the inputs of its approach, by which it begins.
    fn orders(&self, standard: Standard, given: &Option<Settings>) -> Result<(Orders, Vec<f64>), Invalid> {
        let (vessel, width) = (&self.vessel, self.vessel.model.inputs);
        let mut inputs = vec![0.0; width + 1];
        let motion = Motion { u: standard.speed_m_s(), v: None, r: 0.0 };
        match given {
            Some(given) => inputs = changes(given, vessel),
            None => Steady::new(vessel, &self.parameters).solve(motion, &mut inputs)?,
        }
        inputs.truncate(width);
        let mut linearised = Linearised::new(vessel, &self.parameters);
        linearised.look([motion.u, 0.0, 0.0], &vessel.model.undisturbed(&inputs));
        let orders = Orders::new(standard, vessel, &inputs, linearised.by_inputs(), linearised.decay());
        let key = standard.settings().0;
        orders.extremes().try_for_each(|inputs| check_range(vessel, &inputs, || format!("`{key}`")))?;
        Ok((orders, inputs))
    }

    /// The controller that makes ships move as the nominal one does under `inputs`.
    fn tracked(&self, index: usize, initial: [f64; 3], inputs: &[f64]) -> Result<Helm, Invalid> {
        let (vessel, maneuver) = (&self.vessel, &self.maneuvers[index]);
        let exogenous = vessel.model.undisturbed(inputs);
        let states = simulate_one(&vessel.model, &self.parameters, initial, &exogenous);
        if let Some(at) = check_diverged(states.iter().copied()) {
            return Err(at.invalid("the motion to be held", vessel.sample_rate_hz));
        }
        let coupled = !self.tables.contains_key(&index) && maneuver.kind.sway_is_free();
        let controller = maneuver.feedback.unwrap_or_default();
        Tracked::new(vessel, &self.parameters, (inputs, &states), coupled, &controller).map(Helm::new)
    }

    /// What written maneuver `index` is to reach, and what it reaches in `states`, (N+1) × 3; nothing of one that is
    /// drawn, or whose inputs stand in a table.
    pub fn reached(&self, index: usize, states: &[f64]) -> Vec<Aim> {
        let (maneuver, rate_hz) = (&self.maneuvers[index], self.vessel.sample_rate_hz);
        if index >= self.written || self.tables.contains_key(&index) || self.helms.contains_key(&index) {
            return Vec::new();
        }
        if let Some(standard) = maneuver.kind.standard() {
            return limits::of_standard(standard, states, rate_hz);
        }
        let samples = states.len() / 3 - 1;
        let plan = Plan::new(&maneuver.kind, rate_hz, samples);
        let wanted: Vec<[f64; 2]> =
            (0..samples).map(|k| plan.motion(k)).map(|motion| [motion.u, motion.r]).collect();
        limits::of_motion(&wanted, states, rate_hz, &self.tolerance)
    }

    /// The inputs that hold or follow the motion of `plan`; `within` the ranges of the vessel's inputs, or not.
    fn inputs(&self, plan: &Plan, samples: usize, within: bool) -> Result<Vec<f64>, Invalid> {
        let width = self.vessel.model.inputs;
        let mut inputs = Vec::with_capacity(samples * width);
        let mut unknowns = vec![0.0; width + 1];
        let mut steady = Steady::new(&self.vessel, &self.parameters);
        let mut held: Option<(Motion, [f64; 3])> = None;
        for k in 0..samples {
            let motion = plan.motion(k);
            let gain = plan.gain(k);
            if held != Some((motion, gain)) {
                unknowns.fill(0.0);
                steady.follow(motion, gain, &mut unknowns)?;
                let wanted = || format!("wanted motion: u = {} m/s, r = {} rad/s", motion.u, motion.r);
                if within {
                    check_range(&self.vessel, &unknowns[..width], wanted)?;
                }
                held = Some((motion, gain));
            }
            inputs.extend_from_slice(&unknowns[..width]);
        }
        Ok(inputs)
    }
}

/// Refuses an approach by inputs that `vessel` does not have, or beyond their ranges.
fn check_approach(maneuver: &ManeuverSpec, vessel: &Vessel) -> Result<(), Invalid> {
    let Some(approach) = &maneuver.approach else { return Ok(()) };
    check_names(&maneuver.name, "approach", approach, vessel)?;
    let thing = || format!("maneuver `{}`, `approach`", maneuver.name);
    check_range(vessel, &changes(approach, vessel), thing)
}
