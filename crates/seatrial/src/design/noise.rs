use std::path::Path;

use artifact::Provenance;
use identification::Noise;
use vessel::{Source, Vessel};

use crate::failure::Failure;
use crate::instruments::InstrumentKind;
use study::documents::ExpectedDisturbances;
use study::files::read_campaign;

/// The disturbances to expect, and the parameters that the residual is linearised with.
pub struct NoiseModel {
    /// Standard deviations.
    pub noise: Noise,
    /// One per parameter: the true ones where all are known, else the nominal ones.
    pub parameters: Vec<f64>,
    source: Source,
}

impl NoiseModel {
    /// Reads the disturbances of `campaign.toml` and notes its digest.
    ///
    /// # Errors
    /// A file that is refused; instruments that are the measured regressors and noise in them, where the covariance of
    /// instrumental variables does not hold.
    pub fn read(
        campaign: &Path,
        vessel: &Vessel,
        instruments: InstrumentKind,
        provenance: &mut Provenance,
    ) -> Result<Self, Failure> {
        let config = read_campaign(campaign, provenance)?;
        let m = config.measurement;
        let noisy = [m.std_u_m_s, m.std_v_m_s, m.std_r_rad_s].iter().any(|std| *std > 0.0);
        if instruments == InstrumentKind::Regressors && noisy {
            return Err(Failure::refuse(
                campaign,
                "`measurement`",
                "noise in the regressors that --instruments regressors makes the instruments of",
                "instruments free of noise: a covariance does not tell how far least squares is off",
                "take --instruments nominal, or leave out --campaign",
            ));
        }
        let noise = config.noise().ok_or_else(|| lasting(campaign, "leave out --campaign"))?;
        let (source, parameters) = match vessel.parameters(Source::Value) {
            Ok(parameters) => (Source::Value, parameters),
            Err(_) => (Source::Nominal, vessel.nominal.clone()),
        };
        Ok(Self { noise, parameters, source })
    }

    /// As it stands in `moments.json`.
    pub fn document(&self, vessel: &Vessel) -> ExpectedDisturbances {
        let named = |values: &[f64]| {
            vessel.model.parameter_names().map(str::to_owned).zip(values.iter().copied()).collect()
        };
        let [std_u_m_s, std_v_m_s, std_r_rad_s] = self.noise.measurement;
        ExpectedDisturbances {
            std_u_m_s,
            std_v_m_s,
            std_r_rad_s,
            current_std_m_s: self.noise.current,
            linearised_at: match self.source {
                Source::Value => "value".into(),
                Source::Nominal => "nominal".into(),
            },
            parameters: named(&self.parameters),
            nominal: named(&vessel.nominal),
        }
    }
}

pub(super) fn lasting(campaign: &Path, remedy: &str) -> Failure {
    Failure::refuse(
        campaign,
        "`current.kind`",
        "a current that lasts",
        "`none` or `white`, which the covariance of the estimate is predicted for",
        remedy,
    )
}
