use std::path::PathBuf;

use clap::Args;
use files::Provenance;
use maneuver::Generator;
use ship::model::Vessel;
use study::LoggedHelm;
use study::campaign_file::CampaignFile;
use study::documents::DesignDocument;
use study::files::{VesselReader, read_campaign, read_dictionary};
use trial::campaign::{Campaign, Settings};

use super::Files;
use crate::cli::given;
use crate::failure::Failure;
use crate::inputs;

/// The input files of a campaign.
#[derive(Clone, Debug, Args)]
pub struct CampaignFlags {
    /// The vessel
    #[arg(long, visible_alias = "model", required_unless_present = "gather", value_name = "vessel.toml")]
    vessel: Option<PathBuf>,
    /// The maneuvers
    #[arg(long, required_unless_present = "gather", value_name = "dictionary.toml")]
    dictionary: Option<PathBuf>,
    /// Runs, disturbances, validation, bounds, seed
    #[arg(long, required_unless_present = "gather", value_name = "campaign.toml")]
    campaign: Option<PathBuf>,
    /// The optimized shares
    #[arg(long, required_unless_present = "gather", value_name = "design.json")]
    design: Option<PathBuf>,
}

/// The contents of these files.
pub struct CampaignInputs<'a> {
    /// Their names, for messages.
    pub files: Files<'a>,
    /// The vessel.
    pub vessel: Vessel,
    dictionary: Generator,
    /// Runs, disturbances, validation, bounds, seed.
    pub config: CampaignFile,
    design: DesignDocument,
}

impl CampaignFlags {
    /// All given files.
    pub fn paths(&self) -> impl Iterator<Item = &PathBuf> {
        [&self.vessel, &self.dictionary, &self.campaign, &self.design].into_iter().flatten()
    }

    /// The files, for messages.
    ///
    /// # Errors
    /// A usage error that names the missing one.
    fn files(&self) -> Result<Files<'_>, Failure> {
        let campaign = given(&self.campaign, "campaign")?;
        Ok(Files {
            vessel: given(&self.vessel, "vessel")?,
            dictionary: given(&self.dictionary, "dictionary")?,
            campaign,
            sea: campaign,
            design: given(&self.design, "design")?,
        })
    }

    /// Reads them, the vessel by that reader.
    ///
    /// # Errors
    /// A file that is refused.
    pub fn read(&self, vessel: VesselReader, noted: &mut Provenance) -> Result<CampaignInputs<'_>, Failure> {
        let files = self.files()?;
        let vessel = vessel(files.vessel, noted)?;
        let dictionary = read_dictionary(files.dictionary, &vessel, noted)?;
        let config = read_campaign(files.campaign, noted)?;
        let design: DesignDocument = inputs::document(files.design, "design", noted)?;
        // Estimates of its trials tell nothing of these.
        let vessel = design.held.iter().fold(vessel, |vessel, own| vessel.with_held(&own.parameter));
        Ok(CampaignInputs { files, vessel, dictionary, config, design })
    }
}

impl CampaignInputs<'_> {
    /// Maneuvers whose inputs follow the noise of the log.
    pub fn logged_helm(&self) -> LoggedHelm {
        LoggedHelm::among(&self.dictionary)
    }

    /// The runs of `settings`.
    ///
    /// # Errors
    /// A vessel without true parameters; a design of other maneuvers; a maneuver that does not fit the model.
    pub fn campaign(&self, settings: &Settings) -> Result<Campaign<'_>, Failure> {
        let sea = self.config.sea(&self.vessel).map_err(|e| Failure::invalid(self.files.vessel, &e))?;
        let campaign = Campaign::new(sea, &self.dictionary, &self.design.designed(), settings);
        campaign.map_err(|e| self.files.refused(e))
    }
}

/// Notes how maneuvers with inputs from tables were played, if there are any.
pub fn note_plays(campaign: &Campaign, provenance: &mut Provenance) {
    if !campaign.statements().is_empty() {
        provenance.settings.insert("plays".into(), campaign.statements().into());
    }
}
