//! Calibration bases, and touches on them.

use calib::base::{Drawing, Feature, Groove, Group};
use geometry::{Base, Direction, Point, Rigid, Tracker, Vector};

use super::Random;

/// A groove from `near` to `far` mm from the origin at `degrees`, its bottom 4 mm below the plate, walls at 45 degrees.
pub(crate) fn radial(degrees: f64, near: f64, far: f64) -> Groove {
    let (sin, cos) = degrees.to_radians().sin_cos();
    Groove {
        start: Point::new(near * cos, near * sin, -4.0),
        end: Point::new(far * cos, far * sin, -4.0),
        half_angle_rad: std::f64::consts::FRAC_PI_4,
    }
}

pub(crate) fn plate(grooves: [Groove; 3]) -> Result<Drawing, calib::base::Refused> {
    Drawing::new(Point::new(0.0, 0.0, 0.0), Direction::Z, grooves)
}

/// Three equal grooves at 120 degrees.
pub(crate) fn star() -> Drawing {
    plate([0.0, 120.0, 240.0].map(|a| radial(a, 15.0, 60.0))).unwrap()
}

/// Three grooves that no turn of the plate exchanges.
pub(crate) fn uneven() -> Drawing {
    plate([
        radial(0.0, 15.0, 60.0),
        radial(100.0, 15.0, 60.0),
        radial(225.0, 20.0, 60.0),
    ])
    .unwrap()
}

/// A pose about 2 m in front of the localizer.
pub(crate) fn pose(random: &mut Random) -> Rigid<Tracker, Base> {
    let shift = random.vector::<Tracker>(200.0) + Vector::new(0.0, 0.0, -2000.0);
    Rigid::from_rotation_vector(random.vector(1.8), shift).unwrap()
}

/// What is touched, with what, how often.
pub(crate) struct Touching<'a> {
    pub(crate) drawing: &'a Drawing,
    pub(crate) tip_radius: f64,
    pub(crate) sigma: f64,
    /// Touches on the plane and in each groove.
    pub(crate) counts: [usize; 2],
}

impl Touching<'_> {
    /// Places of the tip's centre, in the base, without noise: on a square of 120 mm, and along each groove.
    fn centre(&self, random: &mut Random, feature: Feature) -> Point<Base> {
        match feature {
            Feature::Plane => Point::new(60.0 * random.signed(), 60.0 * random.signed(), self.tip_radius),
            Feature::Groove(k) => {
                let groove = self.drawing.grooves()[k];
                let along = groove.start.lerp(groove.end, 0.05 + 0.9 * random.unit());
                along + Direction::Z * (self.tip_radius / groove.half_angle_rad.sin())
            }
        }
    }

    /// The plane, then the grooves in order, labelled.
    pub(crate) fn groups(&self, random: &mut Random, pose: Rigid<Tracker, Base>) -> Vec<Group<Tracker>> {
        let mut group = |feature: Feature| {
            let count = self.counts[usize::from(feature != Feature::Plane)];
            let touch = |_| pose * self.centre(random, feature) + random.noise([self.sigma; 3]);
            Group::of(feature, (0..count).map(touch).collect())
        };
        Feature::ALL.map(&mut group).into()
    }
}

/// The same groups without their labels.
pub(crate) fn unlabelled(groups: &[Group<Tracker>]) -> Vec<Group<Tracker>> {
    groups.iter().map(|g| Group::unlabelled(g.touches.clone())).collect()
}
