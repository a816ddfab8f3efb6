//! What is known of the pose before.

use calib::registration::{Method, Pairs as Landmarks, fit};
use chance::Chance;
use geometry::{Frame, Point, Rigid};
use nalgebra::{Matrix3, Matrix6, Vector3};

use super::RegisterError;
use crate::points::Cloud;
use crate::search::pairs::{Pairs, Spot};
use crate::search::{Effort, Seeds};
use crate::solve::{Anchor, State};
use crate::{Surface, tree::Triangle};

/// What is known of the pose before.
#[derive(Debug, Clone, PartialEq)]
pub enum Start<To: Frame, From: Frame> {
    /// A pose that is wrong by up to so much: all within is searched, nothing beyond. It is a place to look, and draws the result nowhere.
    Guess {
        /// The pose.
        pose: Rigid<To, From>,
        /// By how much it may be turned about the middle of the points, rad.
        turn_rad: f64,
        /// By how much the middle of the points may lie off, mm.
        shift_mm: f64,
    },
    /// Three points or more in both frames, with their errors: they are where the search begins, and count in the result as what they
    /// are.
    Landmarks(Vec<Landmark<To, From>>),
    /// Nothing: everywhere is searched.
    Nothing,
}

/// A point that is known in both frames, roughly.
#[derive(Debug)]
pub struct Landmark<To: Frame, From: Frame> {
    /// In the bone's frame.
    pub to: Point<To>,
    /// In the points' frame.
    pub from: Point<From>,
    /// Deviation of the one from the other, in each axis, mm.
    pub sigma_mm: f64,
}

/// How much wider than their errors say it is searched about landmarks.
const WIDER: f64 = 2.0;

/// A transform as a state about the cloud's centre.
pub(super) fn state<To: Frame, From: Frame>(pose: &Rigid<To, From>, cloud: &Cloud) -> State {
    let turn: Matrix3<f64> = pose.rotation().matrix().into();
    State {
        turn,
        shift: turn * cloud.centre + Vector3::from(pose.translation_mm()),
        scale: 0.0,
        offset: 0.0,
    }
}

impl<To: Frame, From: Frame> Start<To, From> {
    pub(super) fn anchors(&self, cloud: &Cloud) -> Vec<Anchor> {
        let Self::Landmarks(landmarks) = self else {
            return Vec::new();
        };
        let anchor = |landmark: &Landmark<To, From>| Anchor {
            from: Vector3::from(landmark.from.mm()) - cloud.centre,
            to: Vector3::from(landmark.to.mm()),
            sigma_mm: landmark.sigma_mm,
        };
        landmarks.iter().map(anchor).collect()
    }

    pub(super) fn seeds<'a>(
        &self,
        surface: &Surface<To>,
        cloud: &'a Cloud,
        anchors: &[Anchor],
        effort: &Effort,
    ) -> Result<Seeds<'a>, RegisterError> {
        match self {
            Self::Guess {
                pose,
                turn_rad,
                shift_mm,
            } => Ok(Seeds::Around {
                pose: state(pose, cloud),
                turn_rad: *turn_rad,
                shift_mm: *shift_mm,
            }),
            Self::Landmarks(landmarks) => about(landmarks, cloud, anchors),
            Self::Nothing => {
                let spots = spots(surface, effort);
                let spacing = (surface.facts().area_mm2 / spots.len() as f64).sqrt();
                Ok(Seeds::Anywhere(Pairs::new(cloud, spots, spacing)))
            }
        }
    }
}

/// Seeds within the errors of landmarks.
fn about<'a, To: Frame, From: Frame>(
    landmarks: &[Landmark<To, From>],
    cloud: &Cloud,
    anchors: &[Anchor],
) -> Result<Seeds<'a>, RegisterError> {
    for (landmark, mark) in landmarks.iter().enumerate() {
        if !(mark.sigma_mm > 0.0 && mark.sigma_mm.is_finite()) {
            return Err(RegisterError::LandmarkSigma {
                landmark,
                found: mark.sigma_mm,
            });
        }
    }
    let to: Vec<Point<To>> = landmarks.iter().map(|mark| mark.to).collect();
    let from: Vec<Point<From>> = landmarks.iter().map(|mark| mark.from).collect();
    let weights: Vec<f64> = landmarks.iter().map(|mark| mark.sigma_mm.powi(-2)).collect();
    let pose = state(
        &fit(Landmarks::new(&to, &from)?.weighted(&weights)?, Method::default())?.transform,
        cloud,
    );
    let mut information = Matrix6::zeros();
    for anchor in anchors {
        let cross = (pose.turn * anchor.from).cross_matrix();
        let sharp = anchor.sigma_mm.powi(-2);
        let mut lever = nalgebra::Matrix3x6::zeros();
        lever.fixed_view_mut::<3, 3>(0, 0).copy_from(&-cross);
        lever.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        information += lever.transpose() * lever * sharp;
    }
    // A pose was determined, so that this has an inverse; were it not to rounding, there would be no landmarks worth the name.
    let covariance = information.try_inverse().unwrap_or_else(Matrix6::zeros) * (WIDER * WIDER);
    let factor = covariance.cholesky().map_or_else(Matrix6::zeros, |c| c.l());
    Ok(Seeds::Normal {
        pose,
        factor: Box::new(factor),
    })
}

/// Places of the surface, even over its area, with their normals.
fn spots<F: Frame>(surface: &Surface<F>, effort: &Effort) -> Vec<Spot> {
    let area = |t: &Triangle| 0.5 * (t.b - t.a).cross(&(t.c - t.a)).norm();
    let total: f64 = surface.tree.triangles().map(area).sum();
    let step = total / effort.places as f64;
    let mut spots = Vec::with_capacity(effort.places);
    let (mut sum, mut next) = (0.0, 0.5 * step);
    // Triangles in the order of the tree, where neighbours follow one another: even steps along their area are even steps over the
    // surface.
    for t in surface.tree.triangles() {
        sum += area(t);
        while next < sum && spots.len() < effort.places {
            let chance = Chance::new(effort.seed, spots.len() as u64);
            let (u, v) = (chance.uniform(0).sqrt(), chance.uniform(1));
            let place = t.a * (1.0 - u) + t.b * (u * (1.0 - v)) + t.c * (u * v);
            let normal = (t.b - t.a).cross(&(t.c - t.a)).try_normalize(0.0);
            spots.extend(normal.map(|normal| Spot { place, normal }));
            next += step;
        }
    }
    spots
}
impl<To: Frame, From: Frame> Clone for Landmark<To, From> {
    fn clone(&self) -> Self {
        *self
    }
}
impl<To: Frame, From: Frame> Copy for Landmark<To, From> {}
impl<To: Frame, From: Frame> PartialEq for Landmark<To, From> {
    fn eq(&self, other: &Self) -> bool {
        (self.to, self.from, self.sigma_mm) == (other.to, other.from, other.sigma_mm)
    }
}
