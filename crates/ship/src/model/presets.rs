use refusal::Invalid;

use crate::model::written::{Kind, VesselFile};

/// The built-in vessels: name and `vessel.toml`.
const PRESETS: [(&str, &str); 5] = [
    ("ljungberg-model-ship", include_str!("../../presets/ljungberg-model-ship.toml")),
    ("mariner", include_str!("../../presets/mariner.toml")),
    ("kvlcc2-l7", include_str!("../../presets/kvlcc2-l7.toml")),
    ("esso-osaka-3m", include_str!("../../presets/esso-osaka-3m.toml")),
    ("otter", include_str!("../../presets/otter.toml")),
];

/// The preset that `file` names, with the values and the name of `file`.
///
/// # Errors
/// An unknown name; a structure in addition.
pub(crate) fn preset(file: VesselFile) -> Result<VesselFile, Invalid> {
    let name = file.preset.as_deref().unwrap_or_default();
    let Some((_, text)) = PRESETS.iter().find(|(preset, _)| *preset == name) else {
        return Err(Invalid::unknown("`preset`", name, PRESETS.iter().map(|(name, _)| *name)));
    };
    let mut base: VesselFile = text.parse().map_err(|e: toml::de::Error| {
        Invalid::new("`preset`", e.message().to_owned(), "a vessel", "report this as a defect")
    })?;
    let any_rate = base.model == Some(Kind::Forces);
    if has_structure(&file) || (file.sample_rate_hz.is_some() && !any_rate) {
        return Err(Invalid::new(
            "`preset`",
            "a structure of the file's own in addition",
            "a preset with `name`, [value] and [nominal] only, and `sample_rate_hz` where it has forces",
            "remove `preset`, or the terms, inputs and `sample_rate_hz`",
        ));
    }
    base.name = file.name.or(base.name);
    base.unusual = file.unusual.or(base.unusual);
    base.sample_rate_hz = file.sample_rate_hz.or(base.sample_rate_hz);
    base.value.extend(file.value);
    base.nominal.extend(file.nominal);
    base.constant = file.constant;
    Ok(base)
}

/// Whether a file has more than names, numbers and a rate.
fn has_structure(file: &VesselFile) -> bool {
    let terms = [&file.surge, &file.sway, &file.yaw].iter().any(|terms| !terms.is_empty());
    let channels = !(file.input.is_empty() && file.measured.is_empty() && file.derived.is_empty());
    terms || channels || file.model.is_some() || crate::model::physics::has_forces(file)
}
