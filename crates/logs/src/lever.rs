/// The antenna's position relative to the reference point, in body axes (x forward, y starboard) \[m\].
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Lever(pub [f64; 2]);

impl Lever {
    /// Whether the antenna is at the reference point.
    pub fn is_zero(self) -> bool {
        self.0 == [0.0; 2]
    }

    /// North and east of the reference point \[m\] from those of the antenna and the heading \[rad\]:
    /// p_ref = p_antenna − R(ψ) l.
    pub fn position(self, [north, east]: [f64; 2], psi: f64) -> [f64; 2] {
        let [x, y] = self.0;
        let (sin, cos) = libm::sincos(psi);
        [north - (x * cos - y * sin), east - (x * sin + y * cos)]
    }

    /// Surge and sway of the reference point \[m/s\] from those of the antenna and the yaw rate \[rad/s\]:
    /// the antenna moves with u − r l_y and v + r l_x.
    pub fn velocity(self, [u, v]: [f64; 2], r: f64) -> [f64; 2] {
        let [x, y] = self.0;
        [u + r * y, v - r * x]
    }
}
