//! The calibration base of `config/practice/base-drawing.toml`: where it is touched, and how the tool truly sits in it.

use chance::Chance;
use geometry::{Base, Point, Rigid, Tool, Vector};

use crate::plan::Calibration;

/// The lines along the bottoms of the grooves, mm.
const GROOVES: [[[f64; 3]; 2]; 3] = [
    [[15.0, 0.0, -4.0], [60.0, 0.0, -4.0]],
    [[-3.0, 15.0, -4.0], [-10.0, 60.0, -4.0]],
    [[-15.0, -15.0, -4.0], [-45.0, -45.0, -4.0]],
];
const SEAT_MM: [f64; 3] = [5.0, -7.0, 80.0];
/// The groups of the touches, and how often each is touched: as the guided steps ask for it.
const PARTS: [(&str, usize); 4] = [("plane", 10), ("groove_0", 6), ("groove_1", 6), ("groove_2", 6)];

/// The base as drawn.
pub(super) fn drawing(dials: &Calibration) -> String {
    let mut text = "[plane]\nat_mm = [0, 0, 0]\nnormal = [0, 0, 1]\n".to_owned();
    for [start, end] in GROOVES {
        text += &format!("[[groove]]\nstart_mm = {start:?}\nend_mm = {end:?}\nhalf_angle_deg = 45\n");
    }
    let (mm, deg) = (dials.seat_mm.max(1e-3), dials.seat_deg.max(1e-3));
    text + &format!(
        "[seat]\nquaternion = [0, 1, 0, 0]\ntranslation_mm = {SEAT_MM:?}\nsigma_mm = {mm:?}\nsigma_deg = {deg:?}\n"
    )
}

/// Where the tool truly sits: off the drawing by what the drawing says of itself, turning about the tip.
pub(super) fn seat(dials: &Calibration, chance: Chance) -> Rigid<Base, Tool> {
    let drawn = |first: u64, size: f64| [0, 1, 2].map(|k| size * chance.normal(first + k));
    let [a, b, c] = drawn(0, dials.seat_deg.to_radians());
    let [x, y, z] = drawn(3, dials.seat_mm);
    let none = Vector::new(0.0, 0.0, 0.0);
    // Half a turn about x, as drawn; any vector of finite numbers is a rotation.
    let upside = Rigid::<Base, Tool>::from_rotation_vector(Vector::new(std::f64::consts::PI, 0.0, 0.0), none);
    let turn = Rigid::<Base, Base>::from_rotation_vector(Vector::new(a, b, c), none);
    let (upside, turn) = (upside.unwrap_or(Rigid::identity()), turn.unwrap_or(Rigid::identity()));
    let [sx, sy, sz] = SEAT_MM;
    Rigid::from_parts((turn * upside).rotation(), Vector::new(sx + x, sy + y, sz + z))
}

/// What is touched, in order: the name of the group, and the place, along the grooves and about the middle of the plane.
pub(super) fn touches() -> impl Iterator<Item = (&'static str, Point<Base>)> {
    PARTS.into_iter().enumerate().flat_map(|(part, (name, count))| {
        (0..count).map(move |k| {
            let share = (k as f64 * 0.381_966).fract();
            let groove = part.checked_sub(1).and_then(|groove| GROOVES.get(groove));
            let place = match groove {
                Some([start, end]) => point(*start).lerp(point(*end), 0.05 + 0.9 * share),
                None => {
                    let (sin, cos) = (2.4 * k as f64).sin_cos();
                    let far = 60.0 * (0.4 + 0.6 * share);
                    Point::new(far * cos, far * sin, 0.0)
                }
            };
            (name, place)
        })
    })
}

fn point([x, y, z]: [f64; 3]) -> Point<Base> {
    Point::new(x, y, z)
}
