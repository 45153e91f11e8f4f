//! Models whose structure is known when the program is compiled, beside the same models looked up term by term.

use vessel::{
    Ambient, Arithmetic, Built, Compiled, LANES, Lane, Look, Model, Shaped, Step, Term, Vessel, Wide,
};

fn model_ship() -> Vessel {
    Vessel::from_file(toml::from_str("preset = \"ljungberg-model-ship\"").unwrap()).unwrap()
}

/// Numbers between -1 and 1, some of them zero.
struct Some(u64);

impl Some {
    fn next(&mut self) -> f64 {
        self.0 = self.0.wrapping_mul(6_364_136_223_846_793_005).wrapping_add(1_442_695_040_888_963_407);
        let value = (self.0 >> 11) as f64 / (1_u64 << 52) as f64 - 1.0;
        if value.abs() < 0.05 { 0.0 } else { value }
    }

    fn lane(&mut self) -> Lane {
        Lane(std::array::from_fn(|_| self.next()))
    }
}

/// Steps as bits, with and without current and force; those in place are the same.
fn steps<X: Arithmetic>(step: &mut impl Step<X>, mut number: impl FnMut() -> X) -> Vec<String> {
    let mut state = [(); 3].map(|()| number());
    let mut states = Vec::new();
    for k in 0..200 {
        let exogenous = [(); 3].map(|()| number());
        let (current, force) = ([(); 2].map(|()| number()), [(); 3].map(|()| number()));
        let ambient =
            Ambient { current: (k % 2 == 0).then_some(current), force: (k % 3 == 0).then_some(force) };
        let next = step.step(state, &exogenous, ambient);
        states.push(format!("{next:?}"));
        let row = [0.3, 0.1 * f64::from(k) - 7.0, 0.0];
        let drifting = step.step(state, &row, Ambient { current: Option::Some(current), force: None });
        let mut advanced = state;
        step.advance(&mut advanced, row.as_slice(), |place| current.map(|own| own.at(place)));
        assert_eq!(format!("{advanced:?}"), format!("{drifting:?}"));
        state = if k % 5 == 0 { [(); 3].map(|()| number()) } else { next };
    }
    states
}

#[test]
fn law_a_structure_steps_like_its_model_bit_by_bit() {
    let vessel = model_ship();
    let structure = vessel.model.structure().expect("the preset's");
    let truth = &vessel.nominal;
    let lanes: Vec<Lane> = (0..10).map(|i| Some(i).lane()).collect();
    let wide: Vec<Wide<2>> = (0..10).map(|i| Wide([Some(i).lane(), Some(100 + i).lane()])).collect();
    for seed in 0..5 {
        let (mut one, mut other) = (Some(seed), Some(seed));
        let built = steps(&mut Built::new(structure, truth), || one.next());
        assert_eq!(built, steps(&mut Compiled::new(&vessel.model, truth), || other.next()));
        let (mut one, mut other) = (Some(seed), Some(seed));
        let built = steps(&mut Built::new(structure, &lanes), || one.lane());
        assert_eq!(built, steps(&mut Compiled::new(&vessel.model, &lanes), || other.lane()));
        let (mut one, mut other) = (Some(seed), Some(seed));
        let built = steps(&mut Built::new(structure, &wide), || Wide([one.lane(), one.lane()]));
        assert_eq!(
            built,
            steps(&mut Compiled::new(&vessel.model, &wide), || Wide([other.lane(), other.lane()]))
        );
    }
    assert_eq!(lanes[0].0.len(), LANES);
}

/// The model ship with other terms of surge, sway and yaw.
fn model_of(terms: [&[&str]; 3]) -> Model {
    let mut model = model_ship().model;
    let names: Vec<String> = model.variables.iter().map(|variable| variable.name.clone()).collect();
    let names: Vec<&str> = names.iter().map(String::as_str).collect();
    let parsed = |texts: &[&str]| texts.iter().map(|text| Term::parse(text, &names).unwrap()).collect();
    model.degrees.iter_mut().zip(terms).for_each(|(degree, texts)| degree.terms = parsed(texts));
    model
}

/// Whether steps of a model in a shape are those of the model, bit by bit.
fn check_shape<const L: usize, const P: usize, const I: usize>(model: &Model) {
    assert!(model.structure().is_none());
    let count = model.degrees.iter().map(|degree| degree.terms.len()).sum::<usize>() as u64;
    let lanes: Vec<Lane> = (0..count).map(|i| Some(i).lane()).collect();
    let wide: Vec<Wide<2>> = (0..count).map(|i| Wide([Some(i).lane(), Some(100 + i).lane()])).collect();
    for seed in 0..5 {
        let (mut one, mut other) = (Some(seed), Some(seed));
        let mut own = Compiled::new(model, &lanes);
        let mut shaped = Shaped::<_, L, P, I>::new(&own).expect("of this shape");
        assert_eq!(steps(&mut shaped, || one.lane()), steps(&mut own, || other.lane()));
        let (mut one, mut other) = (Some(seed), Some(seed));
        let mut own = Compiled::new(model, &wide);
        let mut shaped = Shaped::<_, L, P, I>::new(&own).expect("of this shape");
        assert_eq!(
            steps(&mut shaped, || Wide([one.lane(), one.lane()])),
            steps(&mut own, || Wide([other.lane(), other.lane()]))
        );
    }
}

#[test]
fn law_a_model_of_a_common_shape_steps_like_any_model_bit_by_bit() {
    check_shape::<1, 2, 1>(&model_of([&["u", "v r", "u |u|", "tau1"], &["v", "u r", "tau2"], &["r", "u v"]]));
    // Products of inputs and of more than two factors, an input before its place, a constant.
    check_shape::<1, 2, 1>(&model_of([
        &["u", "u^2 |tau1| r", "tau1"],
        &["tau2", "v", "u r"],
        &["1", "r", "v"],
    ]));
    let mut model = model_of([
        &["u", "u |u|", "v r", "|tau1| tau1", "tau2", "tau1"],
        &["v", "u r", "v |v|", "u |u| tau3", "tau2"],
        &["r", "u v", "r |r|", "tau3", "|v| r"],
    ]);
    check_shape::<1, 5, 1>(&model);
    model.constant[1] = 0.25;
    let factors = model.degrees[0].terms[1].factors.clone();
    model.degrees[2].known.push(vessel::Product { coefficient: -0.5, factors });
    check_shape::<1, 5, 1>(&model);
}

#[test]
fn a_model_of_another_shape_or_of_few_terms_is_stepped_as_it_is() {
    let fits = |model: &Model| {
        let count = model.degrees.iter().map(|degree| degree.terms.len()).sum::<usize>();
        Shaped::<_, 1, 2, 1>::new(&Compiled::new(model, &vec![1.0; count])).is_some()
    };
    let sway: &[&str] = &["v", "u r", "tau2"];
    let mut model = model_of([&["u", "u |u|", "v r", "tau1"], sway, sway]);
    assert!(fits(&model));
    assert!(!fits(&model_of([&["u", "u |u|", "v r", "r |r|", "tau1"], sway, sway])), "three products");
    assert!(!fits(&model_of([&["u", "v r", "tau1"], &["v", "tau2"], &["r", "tau3"]])), "seven terms");
    let tied = vessel::Product { coefficient: 2.0, factors: model.degrees[0].terms[2].factors.clone() };
    model.degrees[1].terms[1].tied.push(tied);
    assert!(!fits(&model), "tied terms");
}

/// What is seen at points, as bits.
fn seen<X: Arithmetic>(
    look: &mut impl Look<X>,
    parameters: usize,
    mut number: impl FnMut() -> X,
) -> Vec<String> {
    let mut all = Vec::new();
    for k in 0..100 {
        let (state, exogenous) = ([(); 3].map(|()| number()), [(); 3].map(|()| number()));
        let current = [(); 2].map(|()| number());
        look.look(state, &exogenous, (k % 2 == 0).then_some(current));
        let terms: Vec<X> = (0..parameters).map(|i| look.term(i)).collect();
        all.push(format!("{terms:?} {:?} {:?} {:?}", look.slopes(), look.known(), look.next(state, None)));
    }
    all
}

#[test]
fn law_a_structure_shows_terms_and_slopes_of_its_model_bit_by_bit() {
    let vessel = model_ship();
    let with_intercepts = vessel.model.with_intercepts();
    assert!(with_intercepts.structure().is_none() && vessel.model.structure_with_intercepts().is_none());
    let lanes: Vec<Lane> = (0..13).map(|i| Some(i).lane()).collect();
    let (one, other) =
        (vessel.model.structure().unwrap(), with_intercepts.structure_with_intercepts().unwrap());
    for seed in 0..5 {
        let (mut a, mut b) = (Some(seed), Some(seed));
        let built = seen(&mut Built::new(one, &lanes), 10, || a.lane());
        assert_eq!(built, seen(&mut Compiled::new(&vessel.model, &lanes[..10]), 10, || b.lane()));
        let (mut a, mut b) = (Some(seed), Some(seed));
        let built = seen(&mut Built::new(other, &lanes), 13, || a.lane());
        assert_eq!(built, seen(&mut Compiled::new(&with_intercepts, &lanes), 13, || b.lane()));
    }
}

#[test]
fn a_model_that_differs_in_anything_has_no_known_structure() {
    type Change = fn(&mut vessel::Model);
    let changes: [Change; 5] = [
        |model| model.constant[1] = 0.1,
        |model| model.degrees[0].terms.swap(0, 1),
        |model| model.degrees[2].terms.truncate(2),
        |model| model.degrees[1].known.push(vessel::Product { coefficient: 1.0, factors: Vec::new() }),
        |model| model.variables.push(vessel::Variable { name: "wind".to_owned(), unit: "m/s".to_owned() }),
    ];
    for change in changes {
        let mut model = model_ship().model;
        assert!(model.structure().is_some());
        change(&mut model);
        assert!(model.structure().is_none());
    }
}
