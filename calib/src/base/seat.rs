//! The tool in its seat: `marker_from_tool`, the constant that the calibration base is for.

use geometry::{Base, Frame, Marker, Point, Reference, Tool, Tracker, Uncertain};
use nalgebra::{Matrix6, Vector6};

use super::{Refused, mean};

/// The tool in the frame of the marker it carries.
#[derive(Debug, Clone, Copy)]
pub struct Seated {
    /// With the covariance of the frames' mean, of the base's place and of the seat.
    pub marker_from_tool: Uncertain<Marker, Tool>,
    /// Frames that took part.
    pub frames: usize,
    /// The frames' scatter in units of their covariances; NaN for a single frame.
    pub ratio: f64,
    /// The frame furthest from the mean, deviations.
    pub worst: f64,
    /// Root mean square distance of the tool's tip at single frames from where the mean has it, mm.
    pub rms_mm: f64,
    /// Ratio of the largest deviation of any motion of the marker in the frames' mean to the least, turns counted at the tip's
    /// distance from the marker: how unevenly the frames hold the tool.
    pub condition: f64,
}

/// The base's reference marker as seen from the tool's marker, in one frame of the localizer. The errors of both poses
/// are taken as independent.
pub fn seen_from_marker(
    tracker_from_marker: &Uncertain<Tracker, Marker>,
    tracker_from_reference: &Uncertain<Tracker, Reference>,
) -> Uncertain<Marker, Reference> {
    tracker_from_marker.inverse() * *tracker_from_reference
}

/// `marker_from_tool = mean(marker_from_f) f_from_base base_from_tool`, the tool sitting in the base as drawn.
///
/// `F` is the [`Reference`] marker on the base, with frames by [`seen_from_marker`]; or the [`Tracker`] where the base
/// stood still, with frames `tracker_from_marker.inverse()`. The frames' noise is averaged; the error of the base's place
/// and that of the seat are common to all frames and enter once.
///
/// # Errors
/// Those of [`mean()`].
pub fn seated<F: Frame>(
    marker_from_f: &[Uncertain<Marker, F>],
    f_from_base: &Uncertain<F, Base>,
    base_from_tool: &Uncertain<Base, Tool>,
    gate: f64,
) -> Result<Seated, Refused> {
    let found = mean(marker_from_f, gate)?;
    // The tool's frame has its origin at the tip.
    let tip = (f_from_base.transform() * base_from_tool.transform()) * Point::<Tool>::new(0.0, 0.0, 0.0);
    let at = found.mean.transform() * tip;
    let squares = marker_from_f
        .iter()
        .map(|frame| (frame.transform() * tip).distance(at).powi(2));
    Ok(Seated {
        rms_mm: (squares.sum::<f64>() / marker_from_f.len() as f64).sqrt(),
        condition: condition(&found.mean.covariance(), at),
        marker_from_tool: found.mean * *f_from_base * *base_from_tool,
        frames: marker_from_f.len(),
        ratio: found.ratio,
        worst: found.deviations.iter().copied().fold(0.0, f64::max),
    })
}

/// Of a covariance of (turn, shift) about the marker's origin, turns counted at the distance of `tip`; at 1 mm, where that is
/// nearer.
fn condition(covariance: &Matrix6<f64>, tip: Point<Marker>) -> f64 {
    // A tool frame at the marker's origin would make turns count nothing at all, and the ratio infinite.
    let lever = tip.distance(Point::new(0.0, 0.0, 0.0)).max(1.0);
    let scale = Matrix6::from_diagonal(&Vector6::new(lever, lever, lever, 1.0, 1.0, 1.0));
    let values = (scale * covariance * scale).symmetric_eigen().eigenvalues;
    // A covariance is semidefinite to rounding: at zero or below, the ratio is infinite.
    (values.max() / values.min().max(0.0)).sqrt()
}

#[cfg(test)]
mod tests {
    use geometry::{Rigid, Vector};

    use super::*;

    /// Frames whose marker is off along its x axis by these, mm, all with 0.1 mm and 0.001 rad.
    fn frames(off: &[f64]) -> Vec<Uncertain<Marker, Tracker>> {
        let variances = Matrix6::from_diagonal(&Vector6::new(1e-6, 1e-6, 1e-6, 0.01, 0.01, 0.01));
        let one = |x: &f64| {
            let at = Rigid::from_parts(
                Rigid::<Marker, Tracker>::identity().rotation(),
                Vector::new(*x, 0.0, 0.0),
            );
            Uncertain::new(at, variances).unwrap()
        };
        off.iter().map(one).collect()
    }

    #[test]
    fn frames_pass_no_gate_that_is_no_number() {
        let mean = |gate: f64| super::super::mean::mean(&frames(&[-0.1, 0.0, 0.1]), gate);
        assert!(mean(6.0).is_ok());
        assert!(matches!(mean(f64::NAN), Err(Refused::Moved { .. })));
    }

    #[test]
    fn residuals_and_condition_are_those_planted() {
        let base = Rigid::<Tracker, Base>::identity().into();
        let tip = Vector::new(0.0, 0.0, 300.0);
        let seat: Uncertain<Base, Tool> = Rigid::from_parts(Rigid::<Base, Tool>::identity().rotation(), tip).into();
        let found = seated(&frames(&[-0.1, 0.0, 0.1]), &base, &seat, 6.0).unwrap();
        // The mean is the middle one; rounding of 300 mm.
        assert!((found.rms_mm - (0.02_f64 / 3.0).sqrt()).abs() < 1e-12, "{found:?}");
        // 0.001 rad at 300 mm are 0.3 mm, three times 0.1 mm, in each frame and in the mean.
        assert!((found.condition - 3.0).abs() < 1e-9, "{found:?}");
    }
}
