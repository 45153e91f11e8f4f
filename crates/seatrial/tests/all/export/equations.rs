//! The right-hand sides of the model in the languages.

use seatrial::export::{Knowledge, Origin, Portable, Target};
use ship::model::{Source, Vessel};

const SHIP: &str = "name = \"ship\"\nsample_rate_hz = 1.0\n\
    input = [{ name = \"n\", unit = \"1/s\" }, { name = \"δ\", unit = \"rad\" }]\n\
    derived = [{ name = \"thrust\", unit = \"1\", formula = \"-2 ahead^2 cos(δ)\" }, \
    { name = \"ahead\", unit = \"1/s\", formula = \"positive(n)\" }, \
    { name = \"idle\", unit = \"1/s\", formula = \"|n|\" }]\n\
    surge = [{ parameter = \"X\", term = \"u thrust\", nominal = 0.1 }]\n\
    sway = [{ parameter = \"Y\", term = \"v\", nominal = 0.1 }]\n\
    yaw = [{ parameter = \"N\", term = \"r\", nominal = 0.1 }]\n";

#[test]
fn channels_are_computed_before_they_are_taken_and_are_no_inputs() {
    let vessel = Vessel::from_file(SHIP.parse().unwrap()).unwrap();
    let known = Knowledge { covered: vec![("ahead".to_owned(), [0.0, 1.0])], ..Knowledge::default() };
    let portable = Portable::new(&vessel, Source::Nominal, &known, Origin::default()).unwrap();
    assert_eq!((portable.inputs().len(), portable.ranges.len()), (2, 0));
    let lines = [
        (
            Target::Python,
            "    ahead = (0.5 * (n + abs(n)))\n    thrust = -2.0 * (ahead * ahead) * cos(delta)\n",
        ),
        (Target::Matlab, "ahead = (0.5 * (n + abs(n)));\nthrust = -2.0 * (ahead * ahead) * cos(delta);\n"),
        (
            Target::C,
            "    const double ahead = (0.5 * (n + fabs(n)));\n    \
             const double thrust = -2.0 * (ahead * ahead) * cos(delta);\n",
        ),
    ];
    for (target, expected) in lines {
        let files = portable.files(target, None).unwrap();
        let text = String::from_utf8(files[0].clone()).unwrap();
        assert!(text.contains(expected) && !text.contains("abs(n);\n"), "{text}");
    }
    assert!(!portable.unit_sources()[0].1.contains("thrust"));
}
