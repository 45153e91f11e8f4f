//! The summary of trials in rounds, in words.

use study::campaign_file::CampaignFile;
use study::sequential::document;
use trial::rounds::{Arm, ArmSummary, RoundGain, Summary};

/// The sentence on these gains, if the document has one.
fn sentence(gains: &[RoundGain]) -> Option<String> {
    let campaign: CampaignFile =
        toml::from_str(include_str!("../../../../pipelines/sequential/campaign.toml")).unwrap();
    let config = campaign.rounds.unwrap();
    let arms = Arm::ALL.map(|name| ArmSummary { name, points: Vec::new() }).into();
    let document = document(&config, Summary { arms, gains: gains.to_vec(), stopping: Vec::new() }, 1);
    assert!(document.statements.len() < 2, "{:?}", document.statements);
    document.statements.into_iter().next()
}

#[test]
fn a_gain_is_told_only_where_its_interval_excludes_none() {
    let gain = |time_s: f64, ratio: f64, half: f64| RoundGain {
        time_s,
        pairs: 40,
        ratio: Some(ratio),
        low: Some(ratio - half),
        high: Some(ratio + half),
    };
    let first = gain(10.0, 1.0, 0.0);
    let said = |last: RoundGain| sentence(&[first, last]).unwrap();
    assert!(said(gain(20.0, 0.75, 0.125)).ends_with("makes it 25 % smaller"));
    assert!(said(gain(20.0, 1.25, 0.125)).ends_with("makes it 25 % larger"));
    assert!(said(gain(20.0, 0.75, 0.5)).contains("0.75 after 20 s (0.25 to 1.25)"));
    assert!(said(gain(20.0, 0.75, 0.5)).ends_with("40 realizations do not tell this from no gain at all"));
    assert_eq!(sentence(&[first]), None);
}
