//! vessel.toml.

use refusal::Invalid;
use ship::model::{Source, Vessel};

fn vessel(text: &str) -> Result<Vessel, Invalid> {
    Vessel::from_file(text.parse().unwrap())
}

#[test]
fn the_preset_is_the_papers_model() {
    let vessel = vessel("preset = \"ljungberg-model-ship\"").unwrap();
    assert_eq!(vessel.model.parameters(), 10);
    assert_eq!(vessel.parameters(Source::Value).unwrap()[2], 0.08);
    assert_eq!(vessel.nominal[9], 3.5e-4);
    assert_eq!(vessel.couplings[1], Some((2, -2.5)));
    assert_eq!(vessel.model.parameter_units()[1], "m/s per (m/s × m/s)");
}

#[test]
fn a_preset_takes_other_numbers_but_no_other_structure() {
    let changed = vessel("preset = \"ljungberg-model-ship\"\n[nominal]\nX_u = -0.07").unwrap();
    assert_eq!(changed.nominal[0], -0.07);
    let error = vessel("preset = \"ljungberg-model-ship\"\n[nominal]\nX_uuu = -0.07").unwrap_err();
    assert!(error.remedy.contains("`X_uu`"), "{error}");
    assert!(vessel("preset = \"ljungberg-model-ship\"\nsample_rate_hz = 4.0").is_err());
    assert!(vessel("preset = \"ljungberg\"").unwrap_err().remedy.contains("ljungberg-model-ship"));
}

#[test]
fn a_vessel_without_truth_has_a_nominal_model_only() {
    let text = "name = \"x\"\nsample_rate_hz = 1.0\n[[input]]\nname = \"n\"\nunit = \"1/s\"\n\
         [[surge]]\nparameter = \"a\"\nterm = \"n |n|\"\nnominal = 1.0\n[[sway]]\nparameter = \"b\"\nterm = \"v\"\n\
         nominal = 1.0\n[[yaw]]\nparameter = \"c\"\nterm = \"r\"\nnominal = 1.0\n";
    let vessel = vessel(text).unwrap();
    assert!(vessel.parameters(Source::Value).unwrap_err().thing.contains("`a`"));
    assert_eq!(vessel.parameters(Source::Nominal).unwrap(), vec![1.0; 3]);
    assert!(self::vessel(&text.replace("\"c\"", "\"a\"")).is_err());
    assert!(self::vessel(&text.replace("\"n\"\nunit", "\"psi\"\nunit")).is_err());
}

#[test]
fn law_a_parameter_that_is_held_is_one_that_is_fixed() {
    let text =
        std::fs::read_to_string(concat!(env!("CARGO_MANIFEST_DIR"), "/../../pipelines/paper/vessel.toml"))
            .unwrap();
    // Its nominal value is another one, which a fixed parameter cannot have.
    let alike = text.replace("value = -0.1\nnominal = -0.08", "value = -0.1\nnominal = -0.1");
    let fixed = alike.replace("nominal = -0.1\n", "nominal = -0.1\nfixed = true\n");
    assert!(alike != text && fixed != alike);
    let (held, fixed) = (vessel(&alike).unwrap().with_held("Y_v"), vessel(&fixed).unwrap());
    let names = |of: &Vessel| of.model.parameter_names().map(str::to_owned).collect::<Vec<_>>();
    assert_eq!(names(&held), names(&fixed));
    assert_eq!((&held.nominal, &held.value), (&fixed.nominal, &fixed.value));
    assert_eq!(held.model.degrees[1].known.len(), 1);
    assert_eq!(held.model, fixed.model);
    assert_eq!(names(&vessel(&text).unwrap().with_held("Y_vvv")).len(), 10);
}

#[test]
fn a_ship_with_forces_takes_any_rate_and_numbers_by_name() {
    for name in ["mariner", "kvlcc2-l7", "esso-osaka-3m", "otter"] {
        let own = vessel(&format!("preset = \"{name}\"\nsample_rate_hz = 3.0")).unwrap();
        assert_eq!(own.sample_rate_hz, 3.0);
        assert_eq!(own.best_known(), Source::Value);
        assert_eq!(own.parameters(Source::Value).unwrap(), own.nominal);
        assert_eq!(own.model.parameters(), own.nominal.len());
        assert_eq!(own.model.layout().theta(&own.nominal), own.nominal);
        assert!(own.check_terms("ls").unwrap_err().to_string().contains("`ls`"));
    }
    let changed =
        vessel("preset = \"kvlcc2-l7\"\n[nominal]\n\"rudder.epsilon\" = 1.2\n[value]\nN_v = -0.2").unwrap();
    let at = |name: &str| changed.model.parameter_names().position(|own| own == name).unwrap();
    assert_eq!(changed.nominal[at("rudder.epsilon")], 1.2);
    assert_eq!(changed.value[at("N_v")], Some(-0.2));
    let unknown = vessel("preset = \"kvlcc2-l7\"\n[nominal]\nN_w = -0.2").unwrap_err().to_string();
    assert!(unknown.contains("did you mean `N_v`?"), "{unknown}");
}

#[test]
fn keys_of_one_kind_of_model_are_refused_in_the_other() {
    let terms = "name = \"x\"\nsample_rate_hz = 1.0\n[[input]]\nname = \"n\"\nunit = \"1/s\"\n\
         [[surge]]\nparameter = \"a\"\nterm = \"n |n|\"\nnominal = 1.0\n[[sway]]\nparameter = \"b\"\nterm = \"v\"\n\
         nominal = 1.0\n[[yaw]]\nparameter = \"c\"\nterm = \"r\"\nnominal = 1.0\n";
    assert!(vessel(terms).unwrap().model.forces.is_none());
    for (more, words) in [("prior = 0.1", "`prior`"), ("prime = 0.1", "`prime`")] {
        let refused = vessel(&format!("{terms}{more}\n")).unwrap_err().to_string();
        assert!(refused.contains(words) && refused.contains("`c`"), "{refused}");
    }
    let refused = vessel(&format!("density_kg_m3 = 1000.0\n{terms}")).unwrap_err().to_string();
    assert!(refused.contains("density_kg_m3"), "{refused}");
    let without =
        vessel(&format!("model = \"forces\"\ndensity_kg_m3 = 1000.0\n{terms}")).unwrap_err().to_string();
    assert!(without.contains("`ship`"), "{without}");
    let constant = vessel("preset = \"otter\"\nconstant = [0.1, 0.0, 0.0]").unwrap_err().to_string();
    assert!(constant.contains("`constant`"), "{constant}");
    let structure = vessel("preset = \"otter\"\nstep_s = 0.1").unwrap_err().to_string();
    assert!(structure.contains("`preset`"), "{structure}");
}
