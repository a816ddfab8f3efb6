//! The way of the tube: straight on, along its own axis.

use nalgebra::{Point3, Vector3};
use simulation::space::cells::{Field, LabelField};
use simulation::space::tube::{Tube, TubeError};

/// Where an axis enters an organ is looked for in such steps, mm, and at most so many.
const LOOK: f64 = 0.5;
const MOST_LOOKS: f64 = 1e5;

/// Points are laid for a surface stretched by so much; 1.7 was found on a kidney 10 mm deep. What a state stretches more may be refused.
const STRETCH: f64 = 4.0;
/// Points are so many to a side of a cube at least: pressures at fewer are no pressures of its polynomials, however wide the tube.
pub(crate) const POINTS: f64 = 4.0;
/// Points of the surface within so many radii of the tube's axis may come to be at it.
const REACH: f64 = 3.0;

/// A tube and the way that it is pushed, in the patient or, turned, in the label map's axes.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Way {
    /// Where the foremost point of the tip starts, mm.
    pub entry: Vector3<f64>,
    /// Of length 1.
    pub direction: Vector3<f64>,
    /// mm.
    pub radius: f64,
    /// From the middle of one round end to that of the other, mm.
    pub length: f64,
    /// From the first touch on, mm.
    pub stroke: f64,
    /// From state to state, mm.
    pub step: f64,
}

impl Way {
    /// The foremost point of the tip after so much of the way from the entry.
    pub fn tip(&self, gone: f64) -> Vector3<f64> {
        self.entry + self.direction * gone
    }

    /// The middle of its round tip.
    pub fn middle(&self, gone: f64) -> Vector3<f64> {
        self.tip(gone) - self.direction * self.radius
    }

    /// The tube after so much of the way.
    ///
    /// # Errors
    /// [`TubeError`], of numbers that no checked scene has.
    pub fn tube(&self, gone: f64) -> Result<Tube, TubeError> {
        Tube::straight(
            Point3::from(self.middle(gone)),
            -self.direction,
            self.length,
            self.radius,
        )
    }

    /// The distance of a place from the axis of the way, between the entry and what is `beyond` it.
    pub fn off_axis(&self, at: &Vector3<f64>, beyond: f64) -> f64 {
        let along = (at - self.entry).dot(&self.direction).clamp(-self.length, beyond);
        (at - self.tip(along)).norm()
    }

    /// How far from one another points of the surface may be in a cube that the tube may come to, mm: where it is stretched by 4, no place
    /// is farther from one than half of the tube's radius and a quarter more, and there are four to its side at least.
    pub fn spacing(&self, [low, high]: [&Vector3<f64>; 2], beyond: f64) -> Option<f64> {
        let near = self.off_axis(&(0.5 * (low + high)), beyond) - 0.5 * (high - low).norm();
        let most = (high.x - low.x) / POINTS;
        (near < REACH * self.radius).then_some((0.5 * self.radius / STRETCH).min(most))
    }

    /// How far the tip comes in an organ, from the entry: from where the axis enters it by the whole stroke. Where the axis
    /// passes it by, without end.
    pub fn last(&self, organ: &LabelField) -> f64 {
        let corners = organ.corners;
        let longest = (corners[0] - self.entry).norm() + (corners[1] - corners[0]).norm();
        let steps = (longest / LOOK).min(MOST_LOOKS) as usize;
        let entered = (0..steps)
            .map(|k| k as f64 * LOOK)
            .find(|gone| organ.value(&self.tip(*gone)) < 0.0);
        entered.map_or(f64::INFINITY, |gone| gone + self.stroke)
    }

    /// The strokes at which states are looked for: 0, the steps, and the whole.
    pub fn strokes(&self) -> Vec<f64> {
        let steps = (self.stroke / self.step - 1e-9).ceil().max(1.0) as usize;
        (0..=steps).map(|k| (k as f64 * self.step).min(self.stroke)).collect()
    }
}
