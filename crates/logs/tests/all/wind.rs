//! Wind on a hull.

use logs::chain::{Hull, Wind};

const HULL: Hull =
    Hull { frontal_area_m2: 40.0, lateral_area_m2: 120.0, length_m: 30.0, c_x: 0.7, c_y: 0.8, c_n: 0.1 };

#[test]
fn law_the_air_takes_energy_from_a_ship_that_moves_through_it() {
    for k in 0..24 {
        let (sin, cos) = (0.2618 * f64::from(k)).sin_cos();
        let [x, y, _] = HULL.forces([5.0 * cos, 5.0 * sin]);
        assert!(x * cos + y * sin < 0.0, "{k}");
    }
}

#[test]
fn law_port_mirrors_starboard_and_twice_the_speed_is_four_times_the_force() {
    let [x, y, n] = HULL.forces([3.0, 2.0]);
    assert_eq!(HULL.forces([3.0, -2.0]), [x, -y, -n]);
    for (twice, once) in HULL.forces([6.0, 4.0]).into_iter().zip([x, y, n]) {
        approx::assert_relative_eq!(twice, 4.0 * once, max_relative = 1e-14);
    }
}

#[test]
fn wind_from_the_north_blows_south() {
    let north = Wind { speed_m_s: 8.0, from_rad: 0.0, gust_std_m_s: 0.0, gust_time_s: None };
    let [to_north, to_east] = north.velocity(8.0);
    approx::assert_abs_diff_eq!(to_north, -8.0, epsilon = 1e-14);
    approx::assert_abs_diff_eq!(to_east, 0.0, epsilon = 1e-14);
    // Heading north at rest, the air comes from ahead: it pushes aft.
    assert!(HULL.forces([-to_north, -to_east])[0] < 0.0);
}
