//! The place of the base with its error.

use geometry::{Base, Frame, Point, Rigid, Uncertain, Vector};
use nalgebra::{Matrix3, Matrix6, Matrix6x3, Vector3};

use super::means::even;
use super::search::{Found, Touched, chosen};
use super::solve::{HeldTouch, normal, open, row};
use super::{Drawing, Feature, FreeMotion, Group, Options, Refused};
use crate::gate::Reached;

/// The residuals on one feature.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct FeatureResiduals {
    /// Which.
    pub feature: Feature,
    /// Touches that took part.
    pub touches: usize,
    /// Root mean square distance, mm: divides by the touches.
    pub rms_mm: f64,
    /// The largest distance, mm.
    pub worst_mm: f64,
}

/// A touch that was left out.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct RejectedTouch {
    /// Its group.
    pub group: usize,
    /// Its place in the group.
    pub touch: usize,
    /// Its distance from the feature, mm.
    pub distance_mm: f64,
}

/// The place of the base with all that is known of its error.
#[derive(Debug, Clone)]
pub struct Located<F: Frame> {
    /// `f_from_base`, with the covariance that the noise makes, the given or what the residuals show where that is more, and what touches
    /// share.
    pub place: Uncertain<F, Base>,
    /// The feature of each group, as given or as found.
    pub assignment: Vec<Feature>,
    /// The residuals of the plane and the three grooves.
    pub residuals: [FeatureResiduals; 4],
    /// Root mean square distance of all touches kept, mm.
    pub rms_mm: f64,
    /// The residuals' size in units of the noise given: the root of chi-square over its degrees of freedom.
    pub noise_ratio: f64,
    /// One per touch on the plane, two in a groove, less 6.
    pub degrees_of_freedom: usize,
    /// Ratio of the largest deviation of any motion to the least, turns counted at the touches' radius.
    pub condition: f64,
    /// The motion of the largest deviation.
    pub weakest: FreeMotion,
    /// Touches that were left out.
    pub rejected: Vec<RejectedTouch>,
}

impl<F: Frame> Located<F> {
    /// What [`crate::gate::Gates`] judge.
    pub fn reached(&self) -> Reached {
        let count: usize = self.residuals.iter().map(|r| r.touches).sum();
        Reached {
            rms_mm: Some(self.rms_mm),
            condition: Some(self.condition),
            noise_ratio: Some(self.noise_ratio),
            rejected: Some(self.rejected.len() as f64 / (count + self.rejected.len()) as f64),
            count: Some(count),
            ..Reached::default()
        }
    }
}

/// The best place with its normal equations.
pub(super) struct Solved<'a> {
    found: &'a Found,
    touches: Vec<Vec<HeldTouch>>,
    radius: f64,
    sigma_mm: f64,
    matrix: Matrix6<f64>,
    count: usize,
    condition: f64,
    weakest: FreeMotion,
}

impl<'a> Solved<'a> {
    pub(super) fn new(touched: &Touched, found: &'a Found, drawing: &Drawing, options: &Options) -> Self {
        let holds = Feature::ALL.map(|f| drawing.hold(f, options.tip_radius_mm));
        let touches = touched.held(&found.assignment, &holds);
        let kept = chosen(&touches, &found.kept);
        let (matrix, _, _) = normal(&kept, &found.pose, &found.pose.matrix(), touched.radius);
        let (condition, free) = open(&matrix);
        let back = found.pose.turn.inverse();
        Self {
            found,
            touches,
            radius: touched.radius,
            sigma_mm: options.sigma_mm,
            matrix,
            count: kept.iter().map(|t| t.hold.count).sum(),
            condition,
            weakest: FreeMotion {
                // From the touches' axes to the base's, in which a person finds the motion.
                turn: back.apply(free.turn),
                shift: back.apply(free.shift),
            },
        }
    }

    pub(super) fn held(&self, options: &Options) -> Result<(), Refused> {
        if self.condition <= options.max_condition {
            return Ok(());
        }
        Err(Refused::Unsolvable {
            free: self.weakest,
            condition: self.condition,
            allowed: options.max_condition,
        })
    }

    /// See [`even`].
    pub(super) fn even<F: Frame>(&self, groups: &[Group<F>]) -> Result<(), Refused> {
        let kept = (0..groups.len()).map(|group| chosen(&self.touches[group..=group], &self.found.kept[group..=group]));
        let kept: Vec<Vec<HeldTouch>> = kept.collect();
        even(&kept, (groups, &self.found.assignment), &self.found.pose, self.sigma_mm)
    }

    fn degrees_of_freedom(&self) -> usize {
        self.count.saturating_sub(6)
    }

    /// The distances of a feature's touches, those kept or those left out, with group and touch.
    fn distances(&self, kept: bool) -> Vec<(Feature, RejectedTouch)> {
        let mut list = Vec::new();
        for (group, touches) in self.touches.iter().enumerate() {
            for (touch, held) in touches.iter().enumerate() {
                if self.found.kept[group][touch] == kept {
                    let distance_mm = held.off(&self.found.pose);
                    let one = RejectedTouch {
                        group,
                        touch,
                        distance_mm,
                    };
                    list.push((self.found.assignment[group], one));
                }
            }
        }
        list
    }

    /// `N^-1 (q (N - sum P P^T) + S S^T) N^-1 sigma^2`, with turns in radians: `N = J^T J`; `P` of a touch is `J^T U`, with `U` what it
    /// shares with all others, and `S` the sum of all. What is shared adds up, and errors of its own do not: of these `q` is the square of
    /// the noise ratio, 1 at least.
    fn covariance<F: Frame>(&self, groups: &[Group<F>]) -> Option<Matrix6<f64>> {
        let inverse = self.matrix.cholesky()?.inverse();
        let (mut sum, mut alone) = (Matrix6x3::zeros(), Matrix6::zeros());
        for part in self.parts(groups) {
            sum += part;
            alone += part * part.transpose();
        }
        // The noise given holds the shared part as if each touch had drawn its own: that goes out again.
        // Residuals show what touches do not share: that alone may be more than was given.
        let own = (self.matrix - alone) * self.found.noise_ratio.max(1.0).powi(2);
        let middle = own + sum * sum.transpose();
        let whole = inverse * middle * inverse * self.sigma_mm.powi(2);
        let inverse = (whole + whole.transpose()) * 0.5;
        let mut scale = Matrix6::identity();
        // The unknowns were turns times the radius: w = w' / radius.
        let turns = Matrix3::identity() / self.radius;
        scale.fixed_view_mut::<3, 3>(0, 0).copy_from(&turns);
        Some(scale * inverse * scale)
    }

    /// `J^T U` of each touch kept that shares something, in units of the noise given.
    fn parts<F: Frame>(&self, groups: &[Group<F>]) -> Vec<Matrix6x3<f64>> {
        let turn = self.found.pose.matrix();
        let mut parts = Vec::new();
        for ((held, kept), group) in self.touches.iter().zip(&self.found.kept).zip(groups) {
            for ((touch, kept), shared) in held.iter().zip(kept).zip(&group.shared) {
                let rows = &touch.rows(&turn)[..touch.hold.count];
                let one = |e: &Vector3<f64>| row(e, &touch.place, self.radius) * (e.transpose() * shared);
                parts.extend(kept.then(|| rows.iter().map(one).sum::<Matrix6x3<f64>>() / self.sigma_mm));
            }
        }
        parts
    }

    pub(super) fn located<F: Frame>(
        &self,
        centre: Vector3<f64>,
        groups: &[Group<F>],
        options: &Options,
    ) -> Result<Located<F>, Refused> {
        // The fit was about the mean of all touches.
        let shift = centre + self.found.pose.shift;
        let place: Rigid<F, Base> = Rigid::from_parts(self.found.pose.turn, Vector::new(shift.x, shift.y, shift.z));
        let covariance = self.covariance(groups).ok_or(Refused::Unsolvable {
            free: self.weakest,
            condition: self.condition,
            allowed: options.max_condition,
        })?;
        // In those axes the motion turned about their origin, so that v is what the mean of the touches moves by: the
        // convention (6) of `geometry::uncertain` about that point.
        let about = Point::new(centre.x, centre.y, centre.z);
        let kept = self.distances(true);
        let squares: f64 = kept.iter().map(|(_, t)| t.distance_mm.powi(2)).sum();
        Ok(Located {
            place: Uncertain::from_covariance_about(about, place, covariance)?,
            assignment: self.found.assignment.clone(),
            residuals: Feature::ALL.map(|f| summary(f, &kept)),
            rms_mm: (squares / kept.len() as f64).sqrt(),
            noise_ratio: self.found.noise_ratio,
            degrees_of_freedom: self.degrees_of_freedom(),
            condition: self.condition,
            weakest: self.weakest,
            rejected: self.distances(false).into_iter().map(|(_, t)| t).collect(),
        })
    }
}

fn summary(feature: Feature, kept: &[(Feature, RejectedTouch)]) -> FeatureResiduals {
    let of = kept.iter().filter(|(f, _)| *f == feature).map(|(_, t)| t.distance_mm);
    let distances: Vec<f64> = of.collect();
    let squares: f64 = distances.iter().map(|x| x * x).sum();
    FeatureResiduals {
        feature,
        touches: distances.len(),
        rms_mm: (squares / distances.len() as f64).sqrt(),
        worst_mm: distances.iter().copied().fold(0.0, f64::max),
    }
}
