//! The line or the plane that most of some touches lie on, in spite of gross errors, and the separation of a cloud.
//!
//! Every pair, or triple, of a sample of the touches proposes one; the one with the least sum of squared distances, each
//! counted up to the limit, wins and is fitted to what lies within the limit. No chance is in it.

use geometry::{Frame, Point};
use nalgebra::{Matrix3, Vector3};

use super::{Group, Refused};

/// Touches that propose lines, and planes; more are thinned out evenly.
// 7140 pairs, and 9880 triples: about the same work, whatever the number of touches.
const LINE_SAMPLE: usize = 120;
const PLANE_SAMPLE: usize = 40;

/// The direction of a line, or the normal of a plane.
#[derive(Debug, Clone)]
pub(super) struct Flat {
    pub(super) axis: Vector3<f64>,
    /// Which of the touches lie on it.
    pub(super) on: Vec<bool>,
    /// Root mean square distance of these from their best line, mm.
    pub(super) width_mm: f64,
}

impl Flat {
    /// How many touches lie on it.
    pub(super) fn count(&self) -> usize {
        self.on.iter().filter(|x| **x).count()
    }
}

fn to_line(at: &Vector3<f64>, axis: &Vector3<f64>, p: &Vector3<f64>) -> f64 {
    (p - at).cross(axis).norm()
}

fn to_plane(at: &Vector3<f64>, axis: &Vector3<f64>, p: &Vector3<f64>) -> f64 {
    (p - at).dot(axis).abs()
}

type Distance = fn(&Vector3<f64>, &Vector3<f64>, &Vector3<f64>) -> f64;

/// The best line; `None` for fewer than two distinct points.
pub(super) fn line(points: &[Vector3<f64>], limit: f64) -> Option<Flat> {
    let sample = thinned(points, LINE_SAMPLE);
    let mut best = Best::new(points, limit, to_line);
    for (i, a) in sample.iter().enumerate() {
        for b in &sample[i + 1..] {
            best.propose(a, b - a);
        }
    }
    best.fitted(|values| values.imax())
}

/// The best plane; `None` where no three points are off a line.
pub(super) fn plane(points: &[Vector3<f64>], limit: f64) -> Option<Flat> {
    let sample = thinned(points, PLANE_SAMPLE);
    let mut best = Best::new(points, limit, to_plane);
    for (i, a) in sample.iter().enumerate() {
        for (j, b) in sample.iter().enumerate().skip(i + 1) {
            for c in &sample[j + 1..] {
                best.propose(a, (b - a).cross(&(c - a)));
            }
        }
    }
    best.fitted(|values| values.imin())
}

fn thinned(points: &[Vector3<f64>], most: usize) -> Vec<Vector3<f64>> {
    // Every k-th in the order of touching, so that the sample covers the whole feature.
    let step = points.len().div_ceil(most).max(1);
    points.iter().copied().step_by(step).collect()
}

/// The proposal with the least truncated sum.
struct Best<'a> {
    points: &'a [Vector3<f64>],
    limit: f64,
    distance: Distance,
    found: Option<(Vector3<f64>, Vector3<f64>)>,
    sum: f64,
}

impl<'a> Best<'a> {
    fn new(points: &'a [Vector3<f64>], limit: f64, distance: Distance) -> Self {
        Self {
            points,
            limit,
            distance,
            found: None,
            sum: f64::INFINITY,
        }
    }

    fn propose(&mut self, at: &Vector3<f64>, axis: Vector3<f64>) {
        // Two touches at one place propose no line, three on a line no plane.
        let Some(axis) = axis.try_normalize(0.0) else { return };
        let mut sum = 0.0;
        for p in self.points {
            sum += (self.distance)(at, &axis, p).min(self.limit).powi(2);
            // The sum only grows: most proposals are soon done with.
            if sum >= self.sum {
                return;
            }
        }
        (self.sum, self.found) = (sum, Some((*at, axis)));
    }

    /// The least squares fit to what lies on the winner; `axis` says which principal axis.
    fn fitted(self, axis: fn(&Vector3<f64>) -> usize) -> Option<Flat> {
        let (mut at, mut direction) = self.found?;
        let mut on = self.within(&at, &direction);
        let mut width_mm = 0.0;
        // What lies within the limit changes with the fit; the proposal by two or three touches is only roughly the
        // best.
        for _ in 0..3 {
            let kept = self.points.iter().zip(&on).filter(|(_, on)| **on).map(|(p, _)| *p);
            let kept: Vec<Vector3<f64>> = kept.collect();
            let (centre, eigen) = principal(&kept);
            // Rounding may leave the two lesser moments below zero for touches on a line.
            width_mm = (eigen.eigenvalues.sum() - eigen.eigenvalues.max()).max(0.0).sqrt();
            at = centre;
            direction = eigen.eigenvectors.column(axis(&eigen.eigenvalues)).into_owned();
            on = self.within(&at, &direction);
        }
        Some(Flat {
            axis: direction,
            on,
            width_mm,
        })
    }

    fn within(&self, at: &Vector3<f64>, axis: &Vector3<f64>) -> Vec<bool> {
        let near = |p: &Vector3<f64>| (self.distance)(at, axis, p) <= self.limit;
        self.points.iter().map(near).collect()
    }
}

type Eigen = nalgebra::SymmetricEigen<f64, nalgebra::Const<3>>;

fn principal(points: &[Vector3<f64>]) -> (Vector3<f64>, Eigen) {
    let n = points.len().max(1) as f64;
    let centre = points.iter().sum::<Vector3<f64>>() / n;
    let outer = |p: &Vector3<f64>| (p - centre) * (p - centre).transpose();
    (
        centre,
        (points.iter().map(outer).sum::<Matrix3<f64>>() / n).symmetric_eigen(),
    )
}

/// The fewest touches of a groove in a cloud: fewer line up by chance.
const LEAST_ON_LINE: usize = 4;

/// Separates a cloud of touches into the three lines with the most touches on them and the rest, the plane.
///
/// For touches that come without any order. `limit_mm` is the largest distance of a touch from its line, some six
/// deviations of the pointer. Each groove needs more touches than line up on the plane by chance: ten are safe with
/// twenty on the plane. Groups come unlabelled, the rest last; gross errors are in the rest.
///
/// # Errors
/// [`Refused::NotFinite`], [`Refused::NoLine`].
pub fn separate<F: Frame>(touches: &[Point<F>], limit_mm: f64) -> Result<Vec<Group<F>>, Refused> {
    let group = |list: Vec<usize>| Group::unlabelled(list.into_iter().map(|i| touches[i]).collect());
    Ok(separated(touches, limit_mm)?.into_iter().map(group).collect())
}

/// As [`separate`], by the touches' places in the list: three lines, and the rest.
///
/// # Errors
/// [`Refused::NotFinite`], [`Refused::NoLine`].
pub fn separated<F: Frame>(touches: &[Point<F>], limit_mm: f64) -> Result<[Vec<usize>; 4], Refused> {
    let finite = |p: &Point<F>| p.mm().iter().all(|x| x.is_finite());
    if let Some(touch) = touches.iter().position(|p| !finite(p)) {
        let found = touches[touch].mm();
        return Err(Refused::NotFinite { group: 0, touch, found });
    }
    let mut left: Vec<usize> = (0..touches.len()).collect();
    let mut groups: [Vec<usize>; 4] = Default::default();
    // The best line first, and out of the list: what lies on none is the plane's.
    for group in &mut groups[..3] {
        let places: Vec<Vector3<f64>> = left.iter().map(|i| Vector3::from(touches[*i].mm())).collect();
        let line = line(&places, limit_mm).filter(|l| l.count() >= LEAST_ON_LINE);
        let Some(line) = line else {
            return Err(Refused::NoLine {
                touches: left.len(),
                found: left.len().min(2),
                needed: LEAST_ON_LINE,
            });
        };
        let part = |wanted: bool| {
            let both = left.iter().zip(&line.on).filter(|(_, on)| **on == wanted);
            both.map(|(i, _)| *i).collect::<Vec<_>>()
        };
        *group = part(true);
        left = part(false);
    }
    groups[3] = left;
    Ok(groups)
}
