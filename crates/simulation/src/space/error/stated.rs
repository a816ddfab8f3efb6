//! A stated error: what the step to cubes half as large changes, with a factor.
//!
//! Where errors fall with order `p` in the side of the cubes, that step takes `1 - 2^-p` of them away: half of them at order 1, that of a
//! corner or the edge of a contact, seven eighths at order 3. [`SAFETY`] covers order 1; tables of docs/solids-3d.md show what it gave where
//! the error is known.

use nalgebra::Vector3;

use super::halving::displacement;
use crate::space::cells::Mesh;

/// What differences are multiplied by.
pub const SAFETY: f64 = 2.0;

/// Bounds of errors, as far as they go.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Stated {
    /// Of displacements of places near the tip, mm.
    pub near: f64,
    /// Of displacements of all other places, mm.
    pub elsewhere: f64,
    /// Of the force on the tube.
    pub force: f64,
}

impl Stated {
    /// Of a state on a mesh, beside one of the same body in smaller cubes: each a mesh, the unknowns of the body and the force on the
    /// tube. Places count as near within `reach` of `tip`, in the reference configuration, mm. The largest difference at all
    /// points inside and on the surface of the finer mesh counts. What cannot be stated is NaN: of a class without places, and all of it where both meshes
    /// have the same unknowns or unknowns are not those of the mesh alone.
    pub fn new(
        coarse: (&Mesh, &[f64], Vector3<f64>),
        fine: (&Mesh, &[f64], Vector3<f64>),
        tip: &Vector3<f64>,
        reach: f64,
    ) -> Self {
        let own = [&coarse, &fine].iter().all(|(mesh, a, _)| a.len() == mesh.unknowns());
        // Of one mesh twice, or of another solid's unknowns, nothing is to be stated; nor of places that are not there.
        if !own || coarse.0.unknowns() == fine.0.unknowns() {
            return Self {
                near: f64::NAN,
                elsewhere: f64::NAN,
                force: f64::NAN,
            };
        }
        let (mut largest, mut found) = ([0.0_f64; 2], [false; 2]);
        // All points of the finer mesh, inside and on the surface: places in between are no farther off by much.
        let inside = fine.0.points().iter().map(|p| (p.at, fine.0.point_row(p)));
        let surface = fine.0.surface.iter().map(|p| (p.at, fine.0.surface_row(p)));
        for (at, row) in inside.chain(surface) {
            let mut off = -displacement(coarse.0, coarse.1, &at);
            for (node, weight) in row {
                (0..3).for_each(|k| off[k] += weight * fine.1[3 * node as usize + k]);
            }
            let number = usize::from((at - tip).norm() > reach);
            found[number] = true;
            let which = &mut largest[number];
            // A number that is none must not pass for a small one.
            *which = if off.norm() <= *which || which.is_nan() {
                *which
            } else {
                off.norm()
            };
        }
        // A class without places is not without error.
        (0..2).filter(|k| !found[*k]).for_each(|k| largest[k] = f64::NAN);
        Self {
            near: SAFETY * largest[0],
            elsewhere: SAFETY * largest[1],
            force: SAFETY * (fine.2 - coarse.2).norm(),
        }
    }
}
