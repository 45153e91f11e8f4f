//! Disturbed runs, and the experiments of designs.

use maneuver::Generator;
use ship::engine::{Current, Disturbances, Measurement, Streams, Wind};
use ship::model::Vessel;
use trial::campaign::{Designed, Group, Refusal, Sea, Tables};

#[test]
fn law_a_run_that_continues_keeps_its_past() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let measurement = Measurement { std_u_m_s: 0.1, std_v_m_s: 0.1, std_r_rad_s: 0.1 };
    let disturbances = Disturbances { current: Current::White { std_m_s: 0.1 }, measurement };
    let sea = Sea::new(&vessel, disturbances, None).unwrap();
    let (streams, exogenous) = (Streams::new(1, "trial"), vec![100.0; 3 * 41]);
    let simulate = |samples: usize| {
        let exogenous = vec![&exogenous[..3 * samples]; 2];
        let initial = vec![[1.0, 0.0, 0.0]; 2];
        sea.simulate(&Group {
            design: "d",
            streams: &streams,
            runs: &[3, 4],
            initial,
            exogenous,
            helms: Vec::new(),
        })
        .unwrap()
    };
    let (short, long) = (simulate(20), simulate(41));
    assert_eq!(short.truth[..], long.truth[..3 * 21]);
    assert_eq!(short.measured[..], long.measured[..3 * 21]);
    assert!(short.measured[1][0] != short.measured[1][1], "runs differ");
}

#[test]
fn what_lets_a_run_diverge_is_named() {
    let mut vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let measurement = Measurement { std_u_m_s: 0.1, std_v_m_s: 0.1, std_r_rad_s: 0.1 };
    let exogenous = vec![0.0; 3 * 400];
    let refused = |vessel: &Vessel, current, wind| {
        let sea = Sea::new(vessel, Disturbances { current, measurement }, wind).unwrap();
        let streams = Streams::new(1, "trial");
        let (initial, exogenous) = (vec![[1.0, 0.0, 0.0]], vec![exogenous.as_slice()]);
        let group =
            Group { design: "d", streams: &streams, runs: &[3], initial, exogenous, helms: Vec::new() };
        sea.simulate(&group).err().map(|refusal| refusal.to_string())
    };
    let strong = Current::White { std_m_s: 1e4 };
    let storm = Wind { std_surge_m_s2: 1e5, std_sway_m_s2: 1e5, std_yaw_rad_s2: 1e5, time_constant_s: None };
    assert_eq!(refused(&vessel, Current::None, None), None);
    let said = refused(&vessel, strong, None).unwrap();
    assert!(said.starts_with("sea: `current.std_m_s`: found design d, run 3, which diverges"), "{said}");
    let said = refused(&vessel, Current::White { std_m_s: 0.1 }, Some(storm)).unwrap();
    assert!(said.starts_with("sea: [wind]"), "{said}");
    // One that diverges in still water, too.
    vessel.value.iter_mut().for_each(|value| *value = Some(3.0));
    let said = refused(&vessel, strong, None).unwrap();
    assert!(said.starts_with("vessel: model in design d, run 3"), "{said}");
}

fn names() -> Vec<String> {
    ["turn", "zig-zag"].map(str::to_owned).to_vec()
}

fn designed(shares: [(&str, f64); 2]) -> Designed {
    Designed { shares: shares.map(|(name, share)| (name.to_owned(), share)).into(), order: None }
}

#[test]
fn samples_are_shared_out_in_the_dictionarys_order_or_taken_in_the_designs_own() {
    let design = designed([("zig-zag", 0.75), ("turn", 0.25)]);
    assert_eq!(design.plan(&names(), &Tables::new(), 8).unwrap(), [(0, 2), (1, 6)]);
    let order = Some(vec![("zig-zag".to_owned(), 5), ("turn".to_owned(), 3)]);
    let arranged = Designed { order, ..design };
    assert_eq!(arranged.plan(&names(), &Tables::new(), 8).unwrap(), [(1, 5), (0, 3)]);
    let other = Refusal::OtherLength { ordered: 8, samples: 9 };
    assert_eq!(arranged.plan(&names(), &Tables::new(), 9), Err(other));
}

#[test]
fn law_tables_are_played_whole_as_often_as_is_nearest_and_fits() {
    let vessel = Vessel::preset("ljungberg-model-ship").unwrap();
    let text = ["turn", "zig-zag"].map(|name| {
        format!("[[maneuver]]\nname = \"{name}\"\nkind = \"inputs\"\nfile = \"{name}\"\nspeed_m_s = 0.0\n")
    });
    let rows = |file: &str| {
        let row = |k: i32| format!("{},100,0,0\n", f64::from(k) / 8.0);
        let samples = if file == "turn" { 30 } else { 40 };
        Ok((0..samples).map(row).fold("t,tau1,tau2,tau3\n".to_owned(), |all, row| all + &row))
    };
    let generator = Generator::new(&vessel, &text.concat().parse().unwrap(), rows).unwrap();
    let tables = generator.tables();
    // 0.5 and 0.5 of 100 are 1.67 and 1.25 plays: two and one, 100 samples in all.
    let design = designed([("turn", 0.5), ("zig-zag", 0.5)]);
    assert_eq!(design.plan(&names(), tables, 100).unwrap(), [(0, 30), (0, 30), (1, 40)]);
    // 1.5 and 1.125 of 90 round to two and one, which is too long by ten: the one that is most beyond its share goes.
    let said = design.plan(&names(), tables, 90).unwrap_err().to_string();
    assert!(
        said.contains("whole plays of tables fill 70: 1 of turn") && said.contains("1 of zig-zag"),
        "{said}"
    );
}

#[test]
fn shares_that_are_none_are_refused() {
    let refused = |design: Designed| design.plan(&names(), &Tables::new(), 8).unwrap_err().to_string();
    assert!(refused(designed([("turn", 0.5), ("zig-zag", 0.4)])).contains("sum of `data.shares`"));
    assert!(refused(designed([("turn", 1.5), ("zig-zag", -0.5)])).contains("a share from 0 to 1"));
    assert!(refused(designed([("turn", 0.5), ("spiral", 0.5)])).contains("`spiral`"));
}
