//! Turns of a solid as steps of its parameters.

use nalgebra::Vector2;

use crate::solid::Solid;

/// The largest angle of a step, radians, that is made whole.
const MAX_TURN_RAD: f64 = 1.0;

/// What a step of a solid's parameters lacks of the rotation that it is the beginning of: `(R - 1 - angle J) (x - c)` of every point, about the
/// middle of the boundary, where the step turns the boundary by the angle in the mean.
pub(crate) fn bent(solid: &dyn Solid, a: &[f64], step: &[f64]) -> Vec<f64> {
    let places: Vec<Vector2<f64>> = solid.outline(a).into_iter().flatten().collect();
    let moves: Vec<Vector2<f64>> = solid.velocities(a, step).into_iter().flatten().collect();
    let count = places.len().max(1) as f64;
    let centre = places.iter().sum::<Vector2<f64>>() / count;
    let (mut spin, mut square) = (0.0, 0.0);
    for (place, by) in places.iter().zip(&moves) {
        let arm = place - centre;
        spin += arm.perp(by);
        square += arm.norm_squared();
    }
    // The angle of least squares, `min sum |by - angle J arm|^2`; a translation drops out, as the arms sum to zero.
    let angle = if square > 0.0 { spin / square } else { 0.0 };
    // No turn, no numbers, or a step too wild for its beginning to stand for a rotation: the straight step stays.
    if angle == 0.0 || angle.is_nan() || angle.abs() > MAX_TURN_RAD {
        return vec![0.0; a.len()];
    }
    let at = |angle: f64| {
        let mut turned = a.to_vec();
        solid.rotate(&mut turned, angle, centre);
        turned
    };
    // The odd half of the turn is `sin(angle) J (x - c)`.
    let part = 0.5 * angle / angle.sin();
    let both = at(angle).into_iter().zip(at(-angle));
    both.zip(a).map(|((on, back), a)| on - a - part * (on - back)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::law::{Law, Material};
    use crate::q9::rectangle;
    use crate::solid::Deformable;

    #[test]
    fn a_turned_step_does_not_stretch() {
        let mesh = rectangle(Vector2::new(3.0, -1.0), Vector2::new(2.0, 1.0), [2, 1]).expect("a mesh");
        let material = Material::new(Law::NeoHookean, 1e9, 0.3).expect("a material");
        let solid = Deformable::new(mesh, material, Vector2::zeros()).expect("a solid");
        let centre = Vector2::new(4.0, -0.5);
        for angle in [1e-6, 0.01, -0.3] {
            // Already turned by as much.
            let mut a = solid.initial();
            solid.rotate(&mut a, angle, centre);
            let spin = |p: Vector2<f64>| Vector2::new(-(p.y - centre.y), p.x - centre.x) * angle;
            let nodes = 0..solid.mesh().nodes.len();
            let step: Vec<f64> = nodes.flat_map(|n| <[f64; 2]>::from(spin(solid.point(&a, n)))).collect();
            let more = bent(&solid, &a, &step);
            let next: Vec<f64> = a.iter().zip(&step).zip(more).map(|((a, s), m)| a + s + m).collect();
            // Strains of rounding: 1e-16 squared times the stiffness.
            assert!(solid.energy(&next).expect("an energy") < 1e-19, "{angle}");
        }
    }
}
