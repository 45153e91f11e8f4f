use crate::forces::Real;
use crate::forces::channels::Driven;
use crate::forces::term::Motion;

/// What all components see at a moment.
pub(crate) struct Surroundings<'a, X> {
    /// u, v, r, U, U_s, du.
    pub motion: Motion<X>,
    /// The channels.
    pub channel: &'a dyn Fn(usize) -> X,
    /// Density of the water \[kg/m³\].
    pub density: X,
    /// Length of the ship \[m\].
    pub length: f64,
}

impl<X: Real> Surroundings<'_, X> {
    /// A channel in the unit of a component.
    #[inline(always)]
    pub fn driven(&self, driven: Driven) -> X {
        let value = (self.channel)(driven.channel);
        if driven.factor == 1.0 { value } else { value.times(driven.factor) }
    }
}
