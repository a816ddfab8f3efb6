//! A calibration as a file holds it.

use geometry::motion::Pose;
use geometry::{Image, Probe, Rigid};
use nalgebra::{Matrix3, SMatrix, Vector3, Vector6};

use crate::solve::{State, Wall};

/// What a check takes of a calibration: what a file of it holds.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct KnownImage {
    /// Place of the image, mm from the centre of its first pixel.
    pub probe_from_image: Rigid<Probe, Image>,
    /// Size of a pixel along a row and along a column, mm.
    pub pixel_mm: [f64; 2],
    /// Covariance of (w, v) about the probe's origin and of the logarithms of both sizes.
    pub covariance: SMatrix<f64, 8, 8>,
    /// Lag of the poses, s; it counts where there is a track.
    pub lag_s: f64,
    /// Linear error of the tracker's shifts by rows, and the place in the reference, mm, that it is about.
    pub tracker: Option<([[f64; 3]; 3], [f64; 3])>,
}

impl KnownImage {
    /// The state of a fit that had found this, its middle being the first pixel.
    pub(crate) fn state(&self) -> State {
        let rows = self.tracker.map_or([[0.0; 3]; 3], |(rows, _)| rows);
        State {
            image: Pose {
                turn: self.probe_from_image.rotation(),
                shift: self.probe_from_image.translation_mm().into(),
            },
            size: self.pixel_mm,
            phantom: Vector6::zeros(),
            lag: self.lag_s,
            tracker: Matrix3::from_fn(|i, j| rows[i][j]),
            play: Vec::new(),
            wall: Wall {
                normal: Vector3::z(),
                distance: 0.0,
            },
        }
    }

    /// The covariance about the first pixel: `v_c = v + w x t`.
    pub(crate) fn about_first(&self) -> SMatrix<f64, 8, 8> {
        let mut carry = SMatrix::<f64, 8, 8>::identity();
        let shift = Vector3::from(self.probe_from_image.translation_mm());
        carry.fixed_view_mut::<3, 3>(3, 0).copy_from(&-shift.cross_matrix());
        carry * self.covariance * carry.transpose()
    }
}
