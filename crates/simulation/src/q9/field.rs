//! What a solid shows at a point of its inside: for pictures and reports, not for the search.

use nalgebra::{Matrix2, Vector2};

use super::{GaussPoint, Mesh, NODES, values};
use crate::law::{Material, Stress};

/// The state of a solid at one of its points.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FieldPoint {
    /// Where it is.
    pub position: Vector2<f64>,
    /// The displacement gradient `G = F - I`.
    pub gradient: Matrix2<f64>,
    /// Energy by reference area and Cauchy's stress; `None` where the law has none.
    pub state: Option<(f64, Stress)>,
}

/// The combination of nodal values at a local point.
pub(crate) fn interpolated(nodes: &[Vector2<f64>; NODES], [u, v]: [f64; 2]) -> Vector2<f64> {
    nodes.iter().zip(values(u, v)).map(|(x, w)| x * w).sum()
}

impl Mesh {
    /// The state at the local point `at` of an element, from the displacements of its nodes. `None` without that element.
    ///
    /// In the mixed form the pressure is that of the element, linear in it.
    pub fn field(&self, element: usize, material: &Material, a: &[f64], at: [f64; 2]) -> Option<FieldPoint> {
        let it = self.elements.get(element)?;
        let (corners, u) = (self.corners(element), it.displacements(a));
        let gradient = GaussPoint::of(&corners, at, 1.0)?.gradient(&u);
        let reference = interpolated(&corners, at);
        let theta = match &it.pressure {
            None => Some(None),
            Some(pressure) => pressure.theta(&it.points, material, &u, reference).map(Some),
        };
        Some(FieldPoint {
            position: reference + interpolated(&u, at),
            gradient,
            state: theta.and_then(|theta| material.state(&gradient, theta)),
        })
    }
}

#[cfg(test)]
mod tests {
    use super::super::rectangle;
    use super::*;
    use crate::law::Law;

    /// Displacements `G x` of a distorted mesh: every point has the gradient `G`, in both forms.
    #[test]
    fn a_uniform_stretch_is_uniform_everywhere() {
        let g = Matrix2::new(0.1, 0.2, -0.05, -0.15);
        let material = Material::new(Law::NeoHookean, 1.0, 0.3).unwrap();
        let mesh = rectangle(Vector2::new(1.0, 2.0), Vector2::new(2.0, 1.0), [2, 1]).unwrap();
        let a: Vec<f64> = mesh.nodes.iter().flat_map(|x| [(g * x).x, (g * x).y]).collect();
        let expected = (material.density(&g).unwrap(), material.cauchy(&g).unwrap());
        for mesh in [mesh.clone(), mesh.mixed()] {
            for at in [[0.0, 0.0], [1.0, -1.0], [0.3, 0.9]] {
                let found = mesh.field(1, &material, &a, at).unwrap();
                assert!((found.gradient - g).amax() < 1e-14);
                let reference = Vector2::new(2.5 + 0.5 * at[0], 2.5 + 0.5 * at[1]);
                assert!((found.position - reference - g * reference).amax() < 1e-14);
                let (density, stress) = found.state.unwrap();
                assert!((density - expected.0).abs() < 1e-14);
                assert!((stress.von_mises() - expected.1.von_mises()).abs() < 1e-13);
            }
        }
        let mesh = rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [1, 1]).unwrap();
        assert!(mesh.field(1, &material, &[0.0; 18], [0.0, 0.0]).is_none());
    }

    /// The energy that pictures show is the energy that is minimised: its Gauss sum is the solid's.
    #[test]
    fn densities_sum_to_the_energy() {
        let material = Material::new(Law::NeoHookean, 1.0, 0.49).unwrap();
        let mesh = rectangle(Vector2::zeros(), Vector2::new(1.0, 1.0), [1, 1]).unwrap();
        let a: Vec<f64> = (0..18).map(|k| 0.05 * (1.7 * f64::from(k)).sin()).collect();
        for mesh in [mesh.clone(), mesh.mixed()] {
            let element = &mesh.elements[0];
            let energy = element.energy(&material, &element.displacements(&a)).unwrap();
            let points = element.points.iter();
            let sum: f64 = points
                .map(|p| p.weight * mesh.field(0, &material, &a, p.local).unwrap().state.unwrap().0)
                .sum();
            assert!((sum / energy - 1.0).abs() < 1e-12, "{sum} {energy}");
        }
    }
}
