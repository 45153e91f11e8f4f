//! Units of depths.

use chart::{DepthUnit, UnitFrom};

#[test]
fn units_are_known_by_all_their_names() {
    for (text, unit) in [
        ("m", DepthUnit::Metre),
        (" Meters ", DepthUnit::Metre),
        ("METRE", DepthUnit::Metre),
        ("dm", DepthUnit::Decimetre),
        ("Centimeters", DepthUnit::Centimetre),
        ("FEET", DepthUnit::Foot),
        ("US survey foot", DepthUnit::SurveyFoot),
        ("US_survey_feet", DepthUnit::SurveyFoot),
        ("us-ft", DepthUnit::SurveyFoot),
        ("Fathoms", DepthUnit::Fathom),
    ] {
        assert_eq!(DepthUnit::of_text(text), Some(unit), "{text}");
    }
    for text in ["", "m/s", "m2", "m-1", "1", "degrees", "yards", "m s"] {
        assert_eq!(DepthUnit::of_text(text), None, "{text}");
    }
    for name in ["m", "dm", "cm", "mm", "km", "ft", "us-ft", "fathom"] {
        assert_eq!(DepthUnit::of_text(name).map(DepthUnit::name), Some(name));
    }
}

#[test]
fn what_file_and_plan_say_has_to_agree() {
    let (ft, m) = (Some(DepthUnit::Foot), Some(DepthUnit::Metre));
    assert_eq!(DepthUnit::agreed(ft, ft), Ok((DepthUnit::Foot, UnitFrom::File)));
    assert_eq!(DepthUnit::agreed(None, ft), Ok((DepthUnit::Foot, UnitFrom::Declared)));
    assert_eq!(DepthUnit::agreed(None, None), Ok((DepthUnit::Metre, UnitFrom::Assumed)));
    assert!(DepthUnit::agreed(ft, m).unwrap_err().to_string().contains("`ft`, as the file says"));
}
