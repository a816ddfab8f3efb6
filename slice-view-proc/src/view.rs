//! Which plane of the patient an image shows.

use geometry::{Ct, Direction, PlaneError, Point, Rigid, SlicePlane, Tool, VolumeGrid};
use scene::{Extent, Plane, Up, View};

/// Below this sine between the tube and the direction that should point up, "up" means nothing: 5 degrees.
const SINGULAR_SINE: f64 = 0.087;

/// The plane of `view` for a tool at `ct_from_tool`: through the inner tip, in radiological display; perpendicular local
/// images `ahead_mm` in front of it, if the view looks ahead. Of a surface its [`scene::Surface::camera`].
///
/// Axial planes are seen from the feet (patient's right on the left, front up), frontal ones from the front (head up),
/// sagittal ones from the patient's left (front on the left, head up), perpendicular ones along the tube from the
/// handle. Global images show the whole `grid`, centred on it; local ones `field_mm` centred on the tip.
///
/// # Errors
/// [`PlaneError`] for a grid so large that its pixels would be.
pub fn plane(view: &View, grid: &VolumeGrid, ct_from_tool: &Rigid<Ct, Tool>) -> Result<SlicePlane, PlaneError> {
    let tip = *ct_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    let Some(axes) = image_axes(view, ct_from_tool) else {
        return view.surface.camera(grid, view.size);
    };
    match view.extent {
        Extent::Local => {
            let shorter = f64::from(view.size[0].min(view.size[1]));
            let centre = tip + *ct_from_tool * Direction::<Tool>::Z * view.ahead_mm;
            SlicePlane::centred(centre, axes, view.field_mm / shorter, view.size)
        }
        Extent::Global => SlicePlane::covering(grid, tip, axes, view.size),
    }
}

/// Where the plane of `view` lies: a point of it, and the direction in which the viewer looks; `None` of a surface, which has no plane.
pub(crate) fn lies(view: &View, ct_from_tool: &Rigid<Ct, Tool>) -> Option<(Point<Ct>, Direction<Ct>)> {
    let tip = *ct_from_tool * Point::<Tool>::new(0.0, 0.0, 0.0);
    let along = *ct_from_tool * Direction::<Tool>::Z;
    Some(match view.plane {
        Plane::Axial => (tip, Direction::Z),
        Plane::Frontal => (tip, Direction::Y),
        Plane::Sagittal => (tip, -Direction::X),
        Plane::Perpendicular => (tip + along * view.ahead_mm, along),
        Plane::Surface => return None,
    })
}

/// The directions of growing columns and rows; `None` for a surface, which has those of its camera.
fn image_axes(view: &View, ct_from_tool: &Rigid<Ct, Tool>) -> Option<[Direction<Ct>; 2]> {
    Some(match view.plane {
        Plane::Axial => [Direction::X, Direction::Y],
        Plane::Frontal => [Direction::X, -Direction::Z],
        Plane::Sagittal => [Direction::Y, -Direction::Z],
        Plane::Perpendicular => perpendicular_axes(view.up, ct_from_tool),
        Plane::Surface => return None,
    })
}

/// The image axes of a view along the tube. Where the wanted direction lies along the tube itself, the tool's own +y is
/// up: it is always perpendicular, so the image is always defined and never flips.
fn perpendicular_axes(up: Up, ct_from_tool: &Rigid<Ct, Tool>) -> [Direction<Ct>; 2] {
    let into = *ct_from_tool * Direction::<Tool>::Z;
    let tool_up = *ct_from_tool * Direction::<Tool>::Y;
    let wanted = match up {
        Up::Superior => Direction::Z,
        Up::Anterior => -Direction::Y,
        Up::Tool => tool_up,
    };
    let across = wanted.vector() - into * wanted.dot(into);
    let up = match across.direction() {
        Some(up) if across.norm() > SINGULAR_SINE => up,
        _ => tool_up,
    };
    // Orthogonal again to the last digit: `up` keeps a rounding error along the tube.
    let right = (-up)
        .cross(into)
        .direction()
        .unwrap_or(*ct_from_tool * -Direction::<Tool>::X);
    let down = into.cross(right).direction().unwrap_or(-up);
    [right, down]
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::{Affine, Vector, letters};
    use proptest::prelude::*;
    use scene::{Scene, Surface};
    use std::path::Path;

    fn views() -> Vec<View> {
        Scene::parse("", Path::new("")).unwrap().views
    }

    fn grid() -> VolumeGrid {
        let affine = Affine::from_rows([[1.0, 0.0, 0.0, -60.0], [0.0, 1.0, 0.0, -40.0], [0.0, 0.0, 2.0, 0.0]]);
        VolumeGrid::checked([120, 80, 100], affine).unwrap()
    }

    fn pose(r: [f64; 3]) -> Rigid<Ct, Tool> {
        Rigid::from_rotation_vector(Vector::new(r[0], r[1], r[2]), Vector::new(10.0, -5.0, 70.0)).unwrap()
    }

    proptest! {
        #[test]
        fn every_plane_goes_through_the_tip(r in prop::array::uniform3(-4.0..4.0)) {
            for view in views() {
                let plane = plane(&view, &grid(), &pose(r)).unwrap();
                let tip = plane.project(Point::new(10.0, -5.0, 70.0));
                // A few roundings of lengths below 300 mm.
                prop_assert!(tip.depth_mm.abs() < 1e-12 * 300.0, "{}", view.name);
            }
        }

        /// Global images too, which are centred elsewhere.
        #[test]
        fn a_plane_lies_where_it_is_said_to(r in prop::array::uniform3(-4.0..4.0), ahead in -20.0..20.0) {
            let mut all = views();
            all[6].ahead_mm = ahead;
            for view in all {
                let plane = plane(&view, &grid(), &pose(r)).unwrap();
                let (point, normal) = lies(&view, &pose(r)).unwrap();
                prop_assert!(plane.project(point).depth_mm.abs() < 1e-9, "{}", view.name);
                prop_assert!(plane.into_screen().dot(normal) > 1.0 - 1e-12, "{}", view.name);
            }
        }

        #[test]
        fn perpendicular_is_seen_along_the_tube(r in prop::array::uniform3(-4.0..4.0)) {
            let view = &views()[6];
            let pose = pose(r);
            let plane = plane(view, &grid(), &pose).unwrap();
            let along = pose * Direction::<Tool>::Z;
            prop_assert!(plane.into_screen().dot(along) > 1.0 - 1e-12);
        }
    }

    #[test]
    fn global_images_show_the_whole_volume() {
        let plane = plane(&views()[2], &grid(), &pose([0.0; 3])).unwrap();
        let (low, high) = grid().bounds();
        for corner in [low, high] {
            let p = plane.project(corner);
            assert!(p.x >= -0.51 && p.x <= 511.51 && p.y >= -0.51 && p.y <= 511.51, "{p:?}");
        }
    }

    /// Left, right, top and bottom of the image, and where the viewer is, as on a radiologist's screen; written down by hand.
    #[test]
    fn a_camera_sees_the_patient_from_where_it_is_said() {
        for (side, expected) in [
            ("anterior", ["R", "L", "S", "I", "A"]),
            ("left", ["A", "P", "S", "I", "L"]),
            ("posterior", ["L", "R", "S", "I", "P"]),
            ("right", ["P", "A", "S", "I", "R"]),
            ("head", ["L", "R", "A", "P", "S"]),
            ("feet", ["R", "L", "A", "P", "I"]),
        ] {
            let view = View {
                plane: Plane::Surface,
                extent: Extent::Global,
                surface: Surface::from(side, 300.0).unwrap(),
                ..views()[0].clone()
            };
            let seen = view.surface.camera(&grid(), view.size).unwrap();
            let (right, down, into) = (seen.right(), seen.down(), seen.into_screen());
            assert_eq!([-right, right, -down, down, -into].map(letters), expected, "{side}");
            assert_eq!(plane(&view, &grid(), &pose([0.1, 0.2, 0.3])).unwrap(), seen);
            let (low, high) = grid().bounds();
            for corner in [low, high].map(|corner| seen.project(corner)) {
                assert!(
                    corner.x >= -0.51 && corner.x <= 511.51 && corner.y >= -0.51 && corner.y <= 511.51,
                    "{side}"
                );
            }
        }
        let oblique = Surface {
            azimuth_rad: 0.5,
            elevation_rad: 0.3,
            field_mm: Some(256.0),
            ..Surface::default()
        };
        let view = View {
            plane: Plane::Surface,
            surface: oblique,
            ..views()[0].clone()
        };
        let seen = view.surface.camera(&grid(), view.size).unwrap();
        assert_eq!(seen.pixel_mm(), 0.5);
        assert_eq!(letters(-seen.into_screen()), "ALS");
    }

    #[test]
    fn a_tube_along_the_body_still_has_an_up() {
        let view = &views()[6];
        for r in [[0.0; 3], [std::f64::consts::PI, 0.0, 0.0], [0.01, 0.0, 0.0]] {
            assert!(plane(view, &grid(), &pose(r)).is_ok(), "{r:?}");
        }
    }
}
