//! The procedure on a simulated localizer: a ball of diodes on a pointer, seen with noise, its pose solved as a tracker
//! does ([`crate::pose`]).

use geometry::rotation::{Rotation, RotationVector};
use geometry::{Direction, Marker, Point, Rigid, Tracker, Vector};

use super::{Phantom, Refused, Sample, Test};
use crate::marker::even_directions;
use crate::pose::{Body, Emitter, Gates, Localizer, Sighting, solve};

/// Diodes on the ball, as in the thesis.
const DIODES: usize = 24;
/// Half-angle in which a diode is seen, rad: 60 degrees.
const CONE_RAD: f64 = std::f64::consts::FRAC_PI_3;

/// The middle of the volume and its edges, mm: the localizer at the origin looks along -z.
const PLACES: [[f64; 3]; 5] = [
    [0.0, 0.0, -2000.0],
    [-450.0, 0.0, -2000.0],
    [450.0, 350.0, -2200.0],
    [0.0, -300.0, -1500.0],
    [0.0, 0.0, -2700.0],
];

/// The divots of the phantom: a block of 200 mm x 150 mm with steps of up to 60 mm, mm.
pub fn phantom() -> Vec<Point<Phantom>> {
    let divot = |i: usize| {
        let (column, row) = ((i % 5) as f64, (i / 5) as f64);
        let step = ((i * 7) % 4) as f64;
        Point::new(50.0 * column - 100.0, 50.0 * row - 75.0, 20.0 * step)
    };
    (0..20).map(divot).collect()
}

/// What is simulated. The same numbers give the same samples.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Simulation {
    /// Of everything drawn by chance.
    pub seed: u64,
    /// Standard deviation of a diode across the line of sight at 2 m, mm; grows with the distance.
    pub across_mm: f64,
    /// The same along it, growing with the square of the distance, mm.
    pub depth_mm: f64,
    /// Error of the tip's calibration along each axis, mm: drawn once.
    pub tip_error_mm: f64,
    /// Radius of the ball of diodes, mm.
    pub ball_mm: f64,
    /// Distance of the tip from the ball's centre, mm.
    pub tip_mm: f64,
    /// Touches of the single point, and rounds of the distance test.
    pub counts: [usize; 2],
}

impl Default for Simulation {
    /// Noise of 0.1 and 0.15 mm, a tip calibrated to 0.1 mm, a ball of 30 mm 160 mm from the tip; 100 touches, 3 rounds.
    fn default() -> Self {
        Self {
            seed: 1,
            across_mm: 0.1,
            depth_mm: 0.15,
            tip_error_mm: 0.1,
            ball_mm: 30.0,
            tip_mm: 160.0,
            counts: [100, 3],
        }
    }
}

impl Simulation {
    /// All samples, and how many touches gave none because the pose was lost.
    ///
    /// # Errors
    /// [`Refused::BadNumber`].
    pub fn samples(&self) -> Result<(Vec<Sample>, usize), Refused> {
        self.check()?;
        let body = self
            .body()
            .map_err(|_| bad("ball_mm", self.ball_mm, "a ball that can be tracked"))?;
        // Multiplied, so that neighbouring seeds differ in many bits; odd, as xorshift stays at zero for ever.
        let mut chance = Chance(self.seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1);
        let tip = Point::<Marker>::new(0.0, 0.0, self.tip_mm);
        let error = chance.vector::<Marker>(self.tip_error_mm);
        let mut pointer = Pointer {
            localizer: self.localizer(),
            calibrated: tip + error,
            body,
            tip,
            chance,
            samples: Vec::new(),
            lost: 0,
        };
        for (place, centre) in PLACES.into_iter().enumerate() {
            pointer.measure_at(place, centre, self.counts);
        }
        Ok((pointer.samples, pointer.lost))
    }

    fn check(&self) -> Result<(), Refused> {
        for (what, found) in [
            ("across_mm", self.across_mm),
            ("depth_mm", self.depth_mm),
            ("ball_mm", self.ball_mm),
        ] {
            if !(1e-6..=1000.0).contains(&found) {
                return Err(bad(what, found, "a number from 1e-6 to 1000"));
            }
        }
        for (what, found) in [("tip_error_mm", self.tip_error_mm), ("tip_mm", self.tip_mm)] {
            if !(0.0..=1000.0).contains(&found) {
                return Err(bad(what, found, "a number from 0 to 1000"));
            }
        }
        for (what, found) in [("touches", self.counts[0]), ("rounds", self.counts[1])] {
            if !(1..=1000).contains(&found) {
                return Err(bad(what, found as f64, "1 to 1000"));
            }
        }
        Ok(())
    }

    fn localizer(&self) -> Localizer {
        Localizer {
            eye: Point::new(0.0, 0.0, 0.0),
            across_mm: self.across_mm,
            depth_mm: self.depth_mm,
            at_mm: 2000.0,
            growth_across: 1.0,
            growth_depth: 2.0,
            step_mm: 0.0,
        }
    }

    fn body(&self) -> Result<Body<Marker>, crate::pose::BodyError> {
        let origin = Point::new(0.0, 0.0, 0.0);
        let emitter = |d: &Direction<Marker>| Emitter {
            place: origin + *d * self.ball_mm,
            normal: Some(*d),
            covariance_mm2: nalgebra::Matrix3::zeros(),
        };
        Body::new(even_directions(DIODES).iter().map(emitter).collect())
    }
}

const fn bad(what: &'static str, found: f64, expected: &'static str) -> Refused {
    Refused::BadNumber { what, found, expected }
}

/// The pointer in somebody's hand.
struct Pointer {
    localizer: Localizer,
    body: Body<Marker>,
    tip: Point<Marker>,
    /// Where the calibration says the tip is.
    calibrated: Point<Marker>,
    chance: Chance,
    samples: Vec<Sample>,
    lost: usize,
}

fn turn(v: [f64; 3]) -> Rotation {
    RotationVector::new(v).map_or(Rotation::IDENTITY, Rotation::from_vector)
}

impl Pointer {
    fn measure_at(&mut self, place: usize, centre: [f64; 3], counts: [usize; 2]) {
        let standing = turn([0.0, 0.3 * place as f64, 0.0]);
        let divots: Vec<Point<Tracker>> = phantom()
            .iter()
            .map(|p| {
                let [x, y, z] = standing.apply(p.mm());
                Point::new(x + centre[0], y + centre[1], z + centre[2])
            })
            .collect();
        // Turns are made in the divot in the middle, as the standard has it.
        let middle = divots.len() / 2;
        for _ in 0..counts[0] {
            let held = self.held();
            self.touch(place, Test::Single, (middle, divots[middle]), (held, 0.0));
        }
        for (test, most_deg) in [(Test::Roll, 180.0), (Test::Pitch, 60.0), (Test::Yaw, 60.0)] {
            for step in -40..=40 {
                let angle = (most_deg * f64::from(step) / 40.0_f64).to_radians();
                let held = match test {
                    Test::Roll => upright() * turn([0.0, 0.0, angle]),
                    Test::Pitch => turn([angle, 0.0, 0.0]) * upright(),
                    _ => turn([0.0, 0.0, angle]) * upright(),
                };
                self.touch(place, test, (middle, divots[middle]), (held, angle));
            }
        }
        for _ in 0..counts[1] {
            for (divot, at) in divots.iter().enumerate() {
                let held = self.held();
                self.touch(place, Test::Distance, (divot, *at), (held, 0.0));
            }
        }
    }

    /// As a hand holds it: tilted by up to 30 degrees about each of the tracker's x and z axes, turned any way about
    /// the shaft.
    fn held(&mut self) -> Rotation {
        let most = 30.0_f64.to_radians();
        let tilt = [most * self.chance.signed(), 0.0, most * self.chance.signed()];
        turn(tilt) * upright() * turn([0.0, 0.0, std::f64::consts::PI * self.chance.signed()])
    }

    /// One touch of a divot, as far as the pose is not lost.
    fn touch(&mut self, place: usize, test: Test, (divot, at): (usize, Point<Tracker>), held: (Rotation, f64)) {
        let (rotation, angle_rad) = held;
        let lever: Rigid<Tracker, Marker> = Rigid::from_parts(rotation, Vector::new(0.0, 0.0, 0.0));
        // The true tip is in the divot; what is told is where the calibrated one is.
        let origin = at - (lever * self.tip - Point::new(0.0, 0.0, 0.0));
        let pose = Rigid::from_parts(rotation, origin - Point::new(0.0, 0.0, 0.0));
        let seen = self.seen(&pose);
        match solve(&self.body, self.calibrated, &seen, &self.localizer, &Gates::default()) {
            Ok(found) => self.samples.push(Sample {
                place,
                test,
                divot,
                angle_rad,
                at: found.transform.transform() * self.calibrated,
            }),
            Err(_) => self.lost += 1,
        }
    }

    /// The diodes that face the localizer, with their noise.
    fn seen(&mut self, pose: &Rigid<Tracker, Marker>) -> Vec<Sighting> {
        let mut seen = Vec::with_capacity(DIODES);
        for (emitter, e) in self.body.emitters().iter().enumerate() {
            let at = *pose * e.place;
            let sight = self.localizer.eye - at;
            let faces = e
                .normal
                .is_none_or(|n| (*pose * n).vector().dot(sight) >= CONE_RAD.cos() * sight.norm());
            if !faces {
                continue;
            }
            // L n of normal numbers n has the covariance L L^T.
            let factor = self.localizer.covariance_mm2(at).cholesky();
            let drawn = nalgebra::Vector3::from_fn(|_, _| self.chance.normal());
            let noise = factor.map_or_else(nalgebra::Vector3::zeros, |f| f.l() * drawn);
            let place = at + Vector::new(noise.x, noise.y, noise.z);
            seen.push(Sighting { emitter, place });
        }
        seen
    }
}

/// The tip, which is along +z of the marker, points down, -y of the tracker.
fn upright() -> Rotation {
    turn([std::f64::consts::FRAC_PI_2, 0.0, 0.0])
}

/// Uniform and normal numbers from a seed (xorshift64*; Box and Muller 1958).
struct Chance(u64);

impl Chance {
    /// In 0..1.
    fn unit(&mut self) -> f64 {
        self.0 ^= self.0 >> 12;
        self.0 ^= self.0 << 25;
        self.0 ^= self.0 >> 27;
        (self.0.wrapping_mul(0x2545_f491_4f6c_dd1d) >> 11) as f64 / (1_u64 << 53) as f64
    }

    fn signed(&mut self) -> f64 {
        2.0 * self.unit() - 1.0
    }

    fn normal(&mut self) -> f64 {
        // 1 - unit() is above zero, and its logarithm finite.
        let radius = (-2.0 * (1.0 - self.unit()).ln()).sqrt();
        radius * (std::f64::consts::TAU * self.unit()).cos()
    }

    fn vector<F>(&mut self, sigma: f64) -> Vector<F> {
        Vector::new(self.normal(), self.normal(), self.normal()) * sigma
    }
}
