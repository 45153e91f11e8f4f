//! Presets, and stages of studies.

mod presets;
