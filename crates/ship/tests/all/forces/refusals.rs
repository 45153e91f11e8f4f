//! What a description is refused for.

use crate::forces::ships::{KVLCC2, MARINER, OTTER, forces};

#[test]
fn a_description_that_contradicts_itself_is_refused_with_the_reason() {
    let cases = [
        // Ship, what is replaced, by what, words of the message.
        (
            KVLCC2,
            "mass_kg = 3270.0",
            "mass_kg = { nominal = 3270.0 }",
            ["ship.mass_kg", "free mass without a prior"],
        ),
        (
            KVLCC2,
            "surge = 0.022,",
            "surge = { prime = 0.022 },",
            ["ship.added_mass.surge", "`prior`, or `fixed"],
        ),
        (KVLCC2, "behind = \"propeller\"", "behind = \"main\"", ["`behind` of rudder", "found `main`"]),
        (KVLCC2, "height_m = 0.345", "", ["`behind` of rudder", "height_m"]),
        (KVLCC2, "unit = \"rad\"", "unit = \"m\"", ["`input` of `rudder`", "rad, deg"]),
        (KVLCC2, "unit = \"1/s\"", "unit = \"N\"", ["`input` of `propeller`", "rpm"]),
        (
            KVLCC2,
            "range = [0.0, 20.0]",
            "range = [-20.0, 20.0]",
            ["[[propeller]] `propeller`", "holds ahead only"],
        ),
        (KVLCC2, "range = [0.0, 20.0]", "", ["[[propeller]] `propeller`", "without a `range`"]),
        (KVLCC2, "prior = 0.02", "prior = 0.0", ["`X_0`", "`fixed = true`"]),
        (KVLCC2, "prime = -0.04,", "prime = -0.04, nominal = 1.0,", ["`X_vv`", "both `nominal` and `prime`"]),
        (KVLCC2, "v^2 r / U", "v^2 r / n", ["v^2 r / n", "division by `n`, which can be 0"]),
        (KVLCC2, "v^2 r / U", "v^2 r / u", ["v^2 r / u", "division by `u`, which can be 0"]),
        (KVLCC2, "v^2 r / U", "v^2 r / V", ["v^2 r / V", "did you mean"]),
        (KVLCC2, "v^2 r / U", "v^2 r /", ["nothing after", "correct the term"]),
        (KVLCC2, "v^2 r / U", "v^2 |r / U", ["unclosed", "correct the term"]),
        (KVLCC2, "\"X_vv\"", "\"X_0\"", ["`X_0`", "the same name twice"]),
        (KVLCC2, "prior = 0.02", "prior = 0.02, bounds = [0.0, 1.0]", ["`X_0`", "beyond its `bounds`"]),
        (KVLCC2, "prior = 0.02", "prior = 0.02, fixed = true", ["`X_0`", "remove the others"]),
        (KVLCC2, "length_m = 7.0", "length_m = 0.0", ["length_m", "0.01 to 10000 m"]),
        (KVLCC2, "gyration_m = 1.75", "", ["[ship]", "neither"]),
        (KVLCC2, "yaw = 0.011", "yaw = -1.0", ["[ship]", "backwards"]),
        (
            MARINER,
            "delta\"\nunit = \"rad\"",
            "delta\"\nunit = \"deg\"",
            ["`prime` with channel `delta`", "SI units"],
        ),
        (OTTER, "ahead = 0.01108\n", "", ["[[thruster]] `port`", "its coefficient `ahead`"]),
        (
            OTTER,
            "astern = 0.006445",
            "astern = { prime = 1.0 }",
            ["`port.astern`", "the prime system has no such number"],
        ),
        (OTTER, "curve = \"square\"", "curve = \"force\"", ["`input` of `port`", "N, kN"]),
        (KVLCC2, "diameter_m = 0.216", "diameter_m = 0.0", ["`propeller.diameter_m`", "above 0"]),
        (KVLCC2, "height_m = 0.345", "height_m = -1.0", ["`rudder.height_m`", "above 0"]),
        (
            OTTER,
            "curve = \"square\"",
            "lag_s = -0.1\ncurve = \"square\"",
            ["`port.lag_s`", "from 0 to 10000 s"],
        ),
        (OTTER, "strips = 21", "strips = 1", ["strips", "2 to 1000"]),
    ];
    for (text, old, new, words) in cases {
        assert!(text.contains(old), "{old}");
        let error = forces(&text.replacen(old, new, 1)).expect_err(new).to_string();
        assert!(words.iter().all(|word| error.contains(word)), "{error}\n{words:?}");
    }
}

#[test]
fn a_tied_number_is_that_of_the_other_in_its_system() {
    let text =
        KVLCC2.replace("prime = -0.013, value = -0.013, prior = 0.1", "tied_to = \"N_vvv\", factor = 0.5");
    assert_ne!(text, KVLCC2);
    let tied = forces(&text).unwrap();
    let free = forces(KVLCC2).unwrap();
    assert_eq!(tied.parameters().len() + 1, free.parameters().len());
    let mut theta = free.nominal();
    let at = |name: &str| free.parameters().iter().position(|own| own.name == name).unwrap();
    theta[at("N_rrr")] = 0.5 * theta[at("N_vvv")];
    let (state, inputs) = ([1.0, 0.2, -0.05], [0.1, 11.0]);
    assert_eq!(
        tied.body(&tied.nominal()).accelerations(state, &inputs),
        free.body(&theta).accelerations(state, &inputs)
    );
    let error = forces(&text.replace("\"N_vvv\", factor", "\"N_vvw\", factor")).unwrap_err();
    assert!(error.remedy.contains("N_v"), "{error}");
}
