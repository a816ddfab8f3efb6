//! Tip and axis together: the instrument's frame in its marker.

use geometry::uncertain::Uncertain;
use geometry::{Direction, Frame, Point, Rigid, Tool as ToolFrame, Vector};
use nalgebra::{Matrix3, Matrix6};

use super::Refused;

/// Above this cosine the marker's x axis is too near to the shaft to give the roll: 45 degrees.
const TOO_NEAR: f64 = std::f64::consts::FRAC_1_SQRT_2;

/// `marker_from_tool` and what it rests on.
#[derive(Debug, Clone, Copy)]
pub struct Tool<From: Frame> {
    /// Origin at the tip, +z along the shaft from the handle to the tip; with its covariance in the marker, of which the
    /// roll about z is none: it is chosen.
    pub marker_from_tool: Uncertain<From, ToolFrame>,
    /// The axis of the marker to which the tool's x axis is as near as it can be: `x`, or `y` where x lies within 45
    /// degrees of the shaft.
    pub roll_by: &'static str,
    /// Distance of the tip from the axis, mm; of meaning where the axis kept its place while it was found.
    pub tip_off_axis_mm: f64,
}

/// The frame of an instrument of revolution: origin at the tip, +z along the axis. The roll is free and set by a rule:
/// the tool's x axis is as near to the marker's x axis as it can be, or to its y axis where x lies within 45 degrees of
/// the shaft.
///
/// `tip` with its covariance (mm^2) is a pivot calibration's; `axis` with its covariance (rad^2) and `point` are a spin
/// calibration's; the two are independent.
///
/// # Errors
/// [`Refused::NoFrame`] where a number is not finite or a covariance is none.
pub fn marker_from_tool<From: Frame>(
    (tip, tip_covariance): (Point<From>, Matrix3<f64>),
    (axis, axis_covariance): (Direction<From>, Matrix3<f64>),
    point: Point<From>,
) -> Result<Tool<From>, Refused> {
    let near_x = axis.dot(Direction::X).abs() > TOO_NEAR;
    let (roll_by, along) = if near_x {
        ("y", Direction::Y)
    } else {
        ("x", Direction::X)
    };
    // The second axis is the vector product of z and the axis to be followed, so that the first follows it.
    let second = axis.cross(along).direction().ok_or(Refused::NoFrame)?;
    let frame: Rigid<From, ToolFrame> = Rigid::from_axes(tip, axis, second).ok_or(Refused::NoFrame)?;
    let away: Vector<From> = tip - point;
    let mut covariance = Matrix6::zeros();
    // A change du of the axis is the turn axis x du.
    let cross = nalgebra::Vector3::from(axis.components()).cross_matrix();
    let tilt = cross * axis_covariance * cross.transpose();
    covariance.fixed_view_mut::<3, 3>(0, 0).copy_from(&tilt);
    // About the tip the shift is the error of the tip itself; pivot and spin are independent, so nothing is off the
    // diagonal.
    covariance.fixed_view_mut::<3, 3>(3, 3).copy_from(&tip_covariance);
    let covariance = (covariance + covariance.transpose()) * 0.5;
    let marker_from_tool = Uncertain::from_covariance_about(tip, frame, covariance).map_err(|_| Refused::NoFrame)?;
    Ok(Tool {
        marker_from_tool,
        roll_by,
        tip_off_axis_mm: axis.vector().cross(away).norm(),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Marker;

    #[test]
    fn the_frame_has_its_origin_at_the_tip_and_z_along_the_shaft() {
        let tip = Point::<Marker>::new(5.0, -3.0, 150.0);
        for (v, roll_by) in [([0.1, -0.2, 1.0], "x"), ([1.0, 0.3, 0.2], "y"), ([-1.0, 0.0, 0.0], "y")] {
            let axis = Vector::<Marker>::new(v[0], v[1], v[2]).direction().unwrap();
            let point = tip - axis * 40.0;
            let tool = marker_from_tool((tip, Matrix3::identity() * 0.01), (axis, Matrix3::zeros()), point).unwrap();
            let frame = tool.marker_from_tool.transform();
            assert_eq!(tool.roll_by, roll_by);
            assert!((frame * Point::new(0.0, 0.0, 0.0)).distance(tip) < 1e-12);
            assert!(((frame * Direction::Z).vector() - axis.vector()).norm() < 8.0 * f64::EPSILON);
            let followed = if roll_by == "x" { Direction::X } else { Direction::Y };
            let x = frame * Direction::X;
            // As near as it can be: in the plane of z and that axis, and on its side.
            assert!(x.dot(followed) >= TOO_NEAR && x.cross(followed).dot(axis.vector()).abs() < 1.0);
            assert!(x.vector().dot(axis.cross(followed)).abs() < 1e-14);
            assert!(tool.tip_off_axis_mm < 1e-12, "{tool:?}");
        }
    }

    #[test]
    fn the_covariance_is_that_of_tip_and_axis() {
        let tip = Point::<Marker>::new(5.0, -3.0, 150.0);
        let axis = Direction::<Marker>::Z;
        let flat = Matrix3::from_diagonal(&nalgebra::Vector3::new(4e-6, 1e-6, 0.0));
        let tips = Matrix3::from_diagonal(&nalgebra::Vector3::new(0.01, 0.02, 0.03));
        let tool = marker_from_tool((tip, tips), (axis, flat), tip).unwrap();
        let at_tip = tool.marker_from_tool * Point::new(0.0, 0.0, 0.0);
        assert!((at_tip.covariance() - tips).norm() < 1e-12);
        // At 100 mm up the shaft a tilt of the axis along x moves x.
        let up = tool.marker_from_tool * Point::new(0.0, 0.0, -100.0);
        let expected = tips + flat * 1e4;
        assert!((up.covariance() - expected).norm() < 1e-12, "{}", up.covariance());
    }
}
