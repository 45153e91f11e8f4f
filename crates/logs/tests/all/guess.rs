//! What is guessed of a log by the names of its columns.

use logs::TimeUnit;
use logs::guess::{Guess, Head, Named, Needed};

fn needed(channel: &str, unit: &str) -> Needed {
    Needed { channel: channel.to_owned(), unit: unit.to_owned() }
}

/// Column, channel and unit of what is placed of a log with `header` and two rows.
fn placed(header: &str, rows: &str, model: &[Needed]) -> Vec<[String; 3]> {
    let head = Head::of_csv(&format!("{header}\n{rows}\n")).unwrap();
    let guess = Guess::of(&head, &head.table(), model);
    guess.placed.into_iter().map(|own| [own.column, own.channel, own.unit]).collect()
}

#[test]
fn oracle_columns_of_published_logs_have_the_channels_that_were_given_them_by_hand() {
    let model = [needed("n", "1/s"), needed("delta", "rad")];
    let header = "t [s],x_position_mid [m],u_velo [m/s],y_position_mid [m],vm_velo [m/s],psi_hat [rad],r_angvelo [rad/s],n_prop \
                  [rps],delta_rudder [rad],wind_velo_true [m/s]";
    let rows = "0,1,2,3,4,5,6,7,8,9\n0.1,1,2,3,4,5,6,7,8,9\n0.2,1,2,3,4,5,6,7,8,9";
    let expected = [
        ("u_velo [m/s]", "y_u", "m/s"),
        ("vm_velo [m/s]", "y_v", "m/s"),
        ("r_angvelo [rad/s]", "y_r", "rad/s"),
        ("x_position_mid [m]", "x", "m"),
        ("y_position_mid [m]", "y", "m"),
        ("psi_hat [rad]", "psi", "rad"),
        ("n_prop [rps]", "n", "rps"),
        ("delta_rudder [rad]", "delta", "rad"),
    ];
    let expected = expected.map(|(a, b, c)| [a, b, c].map(str::to_owned));
    assert_eq!(placed(header, rows, &model), expected);
}

#[test]
fn law_a_column_is_placed_once_and_only_where_its_unit_fits() {
    let model = [needed("n_1", "1/s"), needed("alpha_1", "rad")];
    let header = "time,thruster 1 [deg],thruster 1 [rpm],yaw rate [deg/s],heading";
    let found = placed(header, "0,1,2,3,10\n1,1,2,3,40\n2,1,2,3,300", &model);
    let expected = [
        ["yaw rate [deg/s]", "y_r", "deg/s"],
        ["heading", "psi", "deg"],
        ["thruster 1 [rpm]", "n_1", "rpm"],
        ["thruster 1 [deg]", "alpha_1", "deg"],
    ];
    assert_eq!(found, expected.map(|own| own.map(str::to_owned)));
}

#[test]
fn no_channel_is_guessed_where_a_word_or_a_unit_says_that_it_is_something_else() {
    let model = [needed("n", "1/s"), needed("delta", "rad")];
    let header = "t,max_cell_voltage_delta,delta_q_reset,delta_angle,delta_xy,heading_error,rudder_setpoint,rudder current \
                  [A],rudder_rate,prop_torque,n_sat,N,Y,y_force,U [m/s],x_accel,psi_d,rudder [degC],Heading_ref,rudder_V,\
                  yaw [%],rpm_limit,north_vel,lat_std";
    let rows = ["0", "1", "2"].map(|t| format!("{t}{}", ",1".repeat(23))).join("\n");
    assert_eq!(placed(header, &rows, &model), Vec::<[String; 3]>::new());
    for (column, channel) in [
        ("delta", "delta"),
        ("Rudder angle [deg]", "delta"),
        ("rudder.delta_stbd", "delta"),
        ("RPM", "n"),
        ("n_prop", "n"),
        ("Y [m]", "y"),
        ("HEADING", "psi"),
        ("psi_hat", "psi"),
        ("u_velo", "y_u"),
    ] {
        assert_eq!(placed(&format!("t,{column}"), "0,1\n1,1\n2,1", &model)[0][1], channel, "{column}");
    }
}

#[test]
fn what_the_model_lacks_and_what_is_left_are_listed() {
    let head = Head::of_csv("t_s;delta_deg;torque_Nm\n0,0;1,5;2\n0,5;1,5;2\n1,0;1,5;2\n").unwrap();
    assert_eq!((head.separator, head.decimal), (';', ','));
    let guess = Guess::of(&head, &head.table(), &[needed("delta", "rad"), needed("thrust", "N")]);
    assert_eq!(guess.missing, [needed("thrust", "N")]);
    assert_eq!(guess.unplaced, ["torque_Nm"]);
    let clock = guess.clock.unwrap();
    assert_eq!((clock.column.as_str(), clock.unit, clock.step_s), ("t_s", TimeUnit::S, 0.5));
}

#[test]
fn clocks_are_known_by_units_by_text_and_by_size() {
    let clock = |column: &str, times: [&str; 3]| {
        let rows = times.map(|time| format!("{time},1")).join("\n");
        let head = Head::of_csv(&format!("{column},a\n{rows}\n0,0\n")).unwrap();
        let clock = Guess::of(&head, &head.table(), &[]).clock.unwrap();
        (clock.unit, clock.is_unit_guessed)
    };
    assert_eq!(clock("time [ms]", ["0", "100", "200"]), (TimeUnit::Ms, false));
    assert_eq!(clock("time", ["0", "0.1", "0.2"]), (TimeUnit::S, true));
    assert_eq!(
        clock("timestamp", ["1700000000000000000", "1700000000100000000", "1700000000200000000"]).0,
        TimeUnit::Ns
    );
    let times = ["2024-05-01T12:00:00Z", "2024-05-01T12:00:01Z", "2024-05-01T12:00:02Z"];
    let text =
        Head::of_csv(&format!("utc,a\n{}\n", times.map(|time| format!("{time},1")).join("\n"))).unwrap();
    let clock = Guess::of(&text, &text.table(), &[]).clock.unwrap();
    assert_eq!((clock.unit, clock.step_s), (TimeUnit::Iso8601, 1.0));
}

#[test]
fn a_column_of_ships_is_known() {
    for name in ["MMSI", "ship name", "vessel", "imo number"] {
        assert!(Named::of(name).is_identity(), "{name}");
    }
    for name in ["ship speed", "heading", "vessel heading [deg]"] {
        assert!(!Named::of(name).is_identity(), "{name}");
    }
}
