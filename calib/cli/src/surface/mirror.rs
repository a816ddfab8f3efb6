//! Whether the picture of a probe was mirrored since its calibration: the same points as they would lie then, registered too.
//!
//! A switch on the scanner turns rows round. No number in a run says so, and a registration of the wrong points may look like any other. But
//! points that were seen from several sides fit the bone in one way alone: where the mirrored ones fit as well and put a target elsewhere,
//! nothing says which of both pictures it was.

use geometry::{Image, Marker, Point, Rigid};
use nalgebra::{Matrix3, Vector3};
use surface_registration::{
    Beam, Field, Options, Points, SharedError, Start, Surface, SurfacePoint, SurfaceRegistration, register,
};

use crate::register::solve::{From, To};

/// So many times the error predicted at a target both may be apart there: no more than what is promised anyhow.
const WITHIN: f64 = 2.0;

/// And no more than this where the mirrored points fit better, mm.
const WRONG_MM: f64 = 0.5;

/// Points of a probe's images, with the poses of its marker.
pub(super) struct Sounded<'a> {
    pub(super) points: &'a [SurfacePoint<From>],
    pub(super) poses: &'a [Rigid<From, Marker>],
    pub(super) marker_from_image: Rigid<Marker, Image>,
    /// The column about which a scanner mirrors, mm.
    pub(super) axis_mm: f64,
}

impl Sounded<'_> {
    /// Where the points lie if each image was mirrored, and their places on the marker.
    pub(super) fn mirrored(&self) -> (Vec<SurfacePoint<From>>, Vec<Point<Marker>>) {
        let turned = self.points.iter().zip(self.poses).map(|(point, pose)| {
            let from_image = *pose * self.marker_from_image;
            let on_axis = from_image * Point::new(self.axis_mm, 0.0, 0.0);
            let along = Vector3::from((from_image * geometry::Direction::<Image>::X).components());
            let point = reflected(point, Vector3::from(on_axis.mm()), along);
            (point, pose.inverse() * point.place)
        });
        turned.unzip()
    }
}

/// A point with its error and its beam behind the plane through `at` that is square to `normal`.
fn reflected(point: &SurfacePoint<From>, at: Vector3<f64>, normal: Vector3<f64>) -> SurfacePoint<From> {
    let turn = Matrix3::identity() - 2.0 * normal * normal.transpose();
    let place = at + turn * (Vector3::from(point.place.mm()) - at);
    let beam = point.beam.and_then(|beam| {
        let direction = turn * Vector3::from(beam.direction.components());
        let direction = geometry::checked::direction(direction.into()).ok()?;
        Some(Beam { direction, ..beam })
    });
    SurfacePoint {
        place: Point::new(place.x, place.y, place.z),
        covariance_mm2: turn * point.covariance_mm2 * turn,
        beam,
    }
}

/// What the mirrored points say.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) struct Mirror {
    /// By how much their best pose costs more, squares of deviations; infinite where they have none.
    margin: f64,
    /// How far it puts the target where it differs most, mm, and what it may differ there.
    apart_mm: f64,
    within_mm: f64,
}

impl Mirror {
    /// Registers the mirrored points as the others were.
    pub(super) fn of(
        (surface, field): (&Surface<To>, &Field),
        mirrored: &Points<From>,
        (start, options): (&Start<To, From>, &Options),
        found: &SurfaceRegistration<To, From>,
        targets: &[Point<To>],
    ) -> Self {
        let nowhere = Self {
            margin: f64::INFINITY,
            apart_mm: 0.0,
            within_mm: 0.0,
        };
        let Ok(other) = register(surface, field, mirrored, start, options) else {
            return nowhere;
        };
        let between = other.transform.transform() * found.transform.transform().inverse();
        let each = targets.iter().map(|target| Self {
            margin: found.margin_over(&other),
            apart_mm: (between * *target).distance(*target),
            within_mm: WITHIN * found.predicted_tre_mm(*target),
        });
        let beyond = |mirror: &Self| mirror.apart_mm - mirror.within_mm;
        each.max_by(|a, b| beyond(a).total_cmp(&beyond(b))).unwrap_or(nowhere)
    }

    /// Why the result must not be used, in words. A NaN falls short.
    pub(super) fn refused(&self, least: f64) -> Option<String> {
        let Self {
            margin,
            apart_mm,
            within_mm,
        } = self;
        // Where the mirrored ones fit better, what these points predict is that of the wrong pose.
        let within_mm = if *margin < 0.0 {
            within_mm.min(WRONG_MM)
        } else {
            *within_mm
        };
        let is_held = *margin >= least || *apart_mm <= within_mm;
        (!is_held).then(|| {
            let other = match *margin < 0.0 {
                true => format!("mirrored back, its images fit better, by {:.1}", -margin),
                false => format!("mirrored, its images fit nearly as well, by {margin:.1} less; at least {least:.1} is accepted"),
            };
            format!(
                "{other}, and put a target {apart_mm:.1} mm elsewhere: was the picture mirrored on the scanner since the probe was calibrated? Look at \
                 that, and sweep also with the probe turned by half about its beam"
            )
        })
    }
}

/// The error that all mirrored points share.
pub(super) fn points(
    sounded: &Sounded<'_>,
    covariance: nalgebra::Matrix6<f64>,
    held_mm: f64,
) -> Result<Points<From>, surface_registration::PointsError> {
    let (points, places) = sounded.mirrored();
    let shared = SharedError::of_tool(covariance, sounded.poses, &places);
    Points::new(&points, Some(shared), held_mm)
}

#[cfg(test)]
mod tests {
    use chance::Chance;
    use geometry::Vector;
    use nalgebra::Matrix6;
    use surface_registration::Spacing;

    use super::super::tests::bone::{NOISE_MM, mesh, radius_mm};
    use super::*;

    const AXIS_MM: f64 = 20.0;

    fn bone() -> (Surface<To>, Field) {
        let mesh = mesh();
        let places: Vec<[f64; 3]> = mesh.points.iter().map(|point| point.mm()).collect();
        let surface = Surface::<To>::new(&places, &mesh.triangles).unwrap();
        let field = Field::new(&surface, Spacing::default()).unwrap();
        (surface, field)
    }

    /// A probe that looks at the bone's middle from 24 sides, each time turned otherwise about its beam, and what it sees: parallel beams
    /// 5 mm apart, and the marker's pose at each.
    fn swept() -> (Vec<SurfacePoint<From>>, Vec<Rigid<From, Marker>>) {
        let (mut points, mut poses) = (Vec::new(), Vec::new());
        for number in 0..24_u64 {
            let chance = Chance::new(11, number);
            let (z, turn) = (2.0 * chance.uniform(0) - 1.0, std::f64::consts::TAU * chance.uniform(1));
            let out = Vector3::new((1.0 - z * z).sqrt() * turn.cos(), (1.0 - z * z).sqrt() * turn.sin(), z);
            let any = Vector3::new(chance.normal(2), chance.normal(3), chance.normal(4));
            let along = out.cross(&any).try_normalize(1e-9).unwrap();
            // Columns: rows of the image, its beams, and what is square to both.
            let axes = [along, -out, along.cross(&-out)];
            let rows: [[f64; 3]; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|j| axes[j][i]));
            let turn = geometry::rotation::RotationMatrix::new(rows, 1e-9).unwrap().rotation();
            let face = 70.0 * out - AXIS_MM * along;
            let pose: Rigid<From, Marker> = Rigid::from_parts(turn, Vector::new(face.x, face.y, face.z));
            for column in 0..9_u64 {
                let begin = face + 5.0 * column as f64 * along;
                let is_bone = |mm: &f64| {
                    let place = begin - *mm * out;
                    place.norm() < radius_mm((place / place.norm()).into())
                };
                let Some(depth) = (0..1400).map(|i| 0.05 * f64::from(i)).find(is_bone) else {
                    continue;
                };
                let noise = [0, 1, 2].map(|k| NOISE_MM * chance.normal(10 + 3 * column + k));
                let place = begin - depth * out + Vector3::from(noise);
                points.push(SurfacePoint {
                    place: Point::new(place.x, place.y, place.z),
                    covariance_mm2: Matrix3::identity() * (NOISE_MM * NOISE_MM),
                    beam: Some(Beam {
                        direction: geometry::checked::direction((-out).into()).unwrap(),
                        depth_mm: None,
                    }),
                });
                poses.push(pose);
            }
        }
        (points, poses)
    }

    fn sounded<'a>(points: &'a [SurfacePoint<From>], poses: &'a [Rigid<From, Marker>]) -> Sounded<'a> {
        Sounded {
            points,
            poses,
            marker_from_image: Rigid::identity(),
            axis_mm: AXIS_MM,
        }
    }

    #[test]
    fn a_picture_that_was_mirrored_is_found_by_the_points_alone_and_a_right_one_is_left_alone() {
        let (surface, field) = bone();
        let (seen, poses) = swept();
        let (turned, _) = sounded(&seen, &poses).mirrored();
        // Twice is as it was.
        let (back, _) = sounded(&turned, &poses).mirrored();
        assert!(back.iter().zip(&seen).all(|(a, b)| a.place.distance(b.place) < 1e-9));
        assert!(turned.iter().zip(&seen).any(|(a, b)| a.place.distance(b.place) > 20.0));
        let start = Start::Guess {
            pose: Rigid::identity(),
            turn_rad: 0.3,
            shift_mm: 15.0,
        };
        let options = Options::default();
        let targets = [Point::<To>::new(10.0, -20.0, 15.0)];
        let refused = |taken: &[SurfacePoint<From>]| {
            let own = Points::new(taken, None, 0.5).unwrap();
            let found = register(&surface, &field, &own, &start, &options).unwrap();
            let rival = points(&sounded(taken, &poses), Matrix6::identity() * 1e-12, 0.5).unwrap();
            Mirror::of((&surface, &field), &rival, (&start, &options), &found, &targets).refused(15.0)
        };
        assert_eq!(refused(&seen), None);
        let words = refused(&turned).unwrap();
        assert!(words.starts_with("mirrored back, its images fit better"), "{words}");
    }

    #[test]
    fn what_fits_as_well_is_refused_where_a_target_is_elsewhere_and_no_number_is_no_answer() {
        let mirror = |margin, apart_mm| Mirror {
            margin,
            apart_mm,
            within_mm: 1.0,
        };
        assert_eq!(mirror(15.0, 30.0).refused(15.0), None);
        assert_eq!(mirror(14.0, 0.9).refused(15.0), None);
        assert_eq!(mirror(-40.0, 0.4).refused(15.0), None);
        assert!(mirror(-40.0, 0.9).refused(15.0).unwrap().starts_with("mirrored back"));
        assert!(
            mirror(14.0, 1.1)
                .refused(15.0)
                .unwrap()
                .starts_with("mirrored, its images fit nearly")
        );
        assert!(mirror(f64::NAN, 1.1).refused(15.0).is_some());
        assert!(mirror(3.0, f64::NAN).refused(15.0).is_some());
    }
}
