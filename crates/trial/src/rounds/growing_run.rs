use maneuver::Generator;
use refusal::Invalid;
use ship::engine::{Helm, Run, Segment};
use ship::model::Vessel;

use crate::campaign::{OwnLoop, Parts};

/// One realization's run so far: it grows, the ship does not restart.
#[derive(Clone, Debug, Default)]
pub struct GrowingRun {
    /// State at its first sample: u, v \[m/s\], r \[rad/s\].
    pub initial: [f64; 3],
    /// Inputs and measured disturbances, N × exogenous, row-major; before a reacting part is run, those of an undisturbed ship.
    pub exogenous: Vec<f64>,
    /// Maneuver and first sample of every segment.
    segments: Vec<(usize, usize)>,
    /// The helm of every segment, with its samples.
    helms: Vec<(Helm, usize)>,
}

impl GrowingRun {
    /// Number of samples N.
    pub fn samples(&self, vessel: &Vessel) -> usize {
        self.exogenous.len() / vessel.model.exogenous().max(1)
    }

    /// Continues with `plan`, from the vessel's current state; a new run starts with the initial state of its
    /// first maneuver. `parts` has the realized maneuvers of other runs.
    ///
    /// # Errors
    /// A motion that the model cannot hold.
    pub fn extend(
        &mut self,
        vessel: &Vessel,
        generator: &Generator,
        parts: &mut Parts,
        plan: &[(usize, usize)],
    ) -> Result<(), Invalid> {
        parts.make(generator, plan)?;
        let (initial, inputs) = parts.joined(plan);
        if self.segments.is_empty() {
            self.initial = initial;
        }
        let mut start = self.samples(vessel);
        for (maneuver, samples) in plan {
            self.segments.push((*maneuver, start));
            start += samples;
        }
        self.exogenous.extend(vessel.model.undisturbed(&inputs));
        self.helms.extend(parts.helms(plan));
        Ok(())
    }

    /// Its commands.
    pub fn helm(&self) -> Helm {
        Helm::sequence(self.helms.clone())
    }

    /// As a run of `design` with its measured states, (N+1) × 3.
    pub fn recorded(
        &self,
        vessel: &Vessel,
        generator: &Generator,
        design: &str,
        run: u32,
        measured: Vec<f64>,
    ) -> Run {
        let own_loop = OwnLoop::new(vessel, self.initial, &self.helms);
        let instruments = own_loop.map(|own| own.instruments(&vessel.model, &self.exogenous));
        let segment = |(maneuver, start): &(usize, usize)| Segment {
            maneuver: generator.maneuvers()[*maneuver].name.clone(),
            start: *start,
        };
        Run {
            design: design.to_owned(),
            run: run as i32,
            segments: self.segments.iter().map(segment).collect(),
            exogenous: self.exogenous.clone(),
            instrument_exogenous: instruments.unwrap_or_default(),
            measured,
            initial: self.initial,
        }
    }
}
