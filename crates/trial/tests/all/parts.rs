//! Maneuvers that are realized once for several plans.

use maneuver::{DictionaryFile, Generator};
use ship::model::Vessel;

use trial::campaign::{Parts, Plan};

#[test]
fn law_maneuvers_are_the_same_whatever_was_made_of_them_before() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let dictionary: DictionaryFile =
        include_str!("../../../../pipelines/paper/dictionary.toml").parse().unwrap();
    let generator = Generator::without_tables(&vessel, &dictionary).unwrap();
    let mut shared = Parts::default();
    for samples in [40, 100, 30, 120, 200, 40] {
        let plan: Plan = (0..generator.maneuvers().len()).map(|index| (index, samples)).collect();
        let mut own = Parts::default();
        own.make(&generator, &plan).unwrap();
        shared.make(&generator, &plan).unwrap();
        assert_eq!(shared.joined(&plan), own.joined(&plan), "{samples}");
    }
}
