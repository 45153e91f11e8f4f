//! Figures and the map.

mod archipelago;
mod drawing;
mod figures;
mod map;
