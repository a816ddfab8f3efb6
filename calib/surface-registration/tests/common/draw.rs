//! Points drawn on a surface, with gross errors, noise, and a pose that is known.

use chance::Chance;
use geometry::rotation::{Rotation, RotationVector};
use geometry::{Ct, Direction, Point, Rigid, Tracker, Vector, checked};
use nalgebra::Vector3;
use surface_registration::{Beam, BeamNoise, Points, Priors, Surface, SurfacePoint, SurfaceRegistration};

use super::oracle::Triangles;

type V = Vector3<f64>;

/// Where points are taken, and what is wrong with them.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Sweep {
    /// Regions of the phantom: [`LEFT`], [`RIGHT`], [`PUBIS`], [`ALL`], together.
    pub(crate) regions: u8,
    pub(crate) points: usize,
    /// Share of gross errors: 70 % of them 3 to 20 mm nearer to the probe, the others off by up to 15 mm in each axis.
    pub(crate) outliers: f64,
    /// Axial, lateral, elevation, mm.
    pub(crate) sigma_mm: [f64; 3],
    /// By what share depths are read too long.
    pub(crate) speed: f64,
    /// By how much the true bone lies outside of the surface that is given, mm.
    pub(crate) offset_mm: f64,
    pub(crate) has_beams: bool,
}

pub(crate) const LEFT: u8 = 1;
pub(crate) const RIGHT: u8 = 2;
pub(crate) const PUBIS: u8 = 4;
pub(crate) const ALL: u8 = 8;

impl Default for Sweep {
    fn default() -> Self {
        Self {
            regions: LEFT | RIGHT | PUBIS,
            points: 200,
            outliers: 0.2,
            sigma_mm: [0.5, 1.0, 1.5],
            speed: 0.0,
            offset_mm: 0.0,
            has_beams: true,
        }
    }
}

/// Points with their truth.
pub(crate) struct Drawn {
    pub(crate) points: Vec<SurfacePoint<Tracker>>,
    pub(crate) is_outlier: Vec<bool>,
    pub(crate) ct_from_tracker: Rigid<Ct, Tracker>,
    /// Where the inliers are without noise.
    pub(crate) exact: Vec<Point<Ct>>,
}

/// What a probe reaches from the front, of the phantom of the UCL.
pub(crate) fn is_in(regions: u8, p: &V, n: &V) -> bool {
    let reached = n.y > 0.1;
    let left = p.x < 86.0 && p.y > 64.0 && (30.0..170.0).contains(&p.z);
    let right = p.x > 262.0 && p.y > 64.0 && (30.0..175.0).contains(&p.z);
    let pubis = (120.0..225.0).contains(&p.x) && p.y > 72.0 && p.z > 178.0;
    regions & ALL != 0
        || reached && (regions & LEFT != 0 && left || regions & RIGHT != 0 && right || regions & PUBIS != 0 && pubis)
}

/// The triangles of a surface, to draw points from.
pub(crate) struct Source {
    triangles: Vec<[V; 3]>,
}

impl Source {
    pub(crate) fn new((corners, triangles): &Triangles) -> Self {
        let at = |i: u32| V::from(corners[i as usize]);
        Self {
            triangles: triangles.iter().map(|t| t.map(at)).collect(),
        }
    }

    /// Points of a sweep; everything follows from the seed.
    pub(crate) fn draw(&self, sweep: &Sweep, seed: u64) -> Drawn {
        let cross = |t: &[V; 3]| (t[1] - t[0]).cross(&(t[2] - t[0]));
        let chosen: Vec<&[V; 3]> = self
            .triangles
            .iter()
            .filter(|t| {
                let n = cross(t).try_normalize(0.0).unwrap_or_else(V::zeros);
                is_in(sweep.regions, &((t[0] + t[1] + t[2]) / 3.0), &n)
            })
            .collect();
        let mut sums = Vec::with_capacity(chosen.len());
        let mut total = 0.0;
        for t in &chosen {
            total += cross(t).norm();
            sums.push(total);
        }
        let pose = chance_pose(seed);
        let inverse = pose.inverse();
        let mut drawn = Drawn {
            points: Vec::new(),
            is_outlier: Vec::new(),
            ct_from_tracker: pose,
            exact: Vec::new(),
        };
        for i in 0..sweep.points {
            let c = Chance::new(seed, i as u64);
            let t = chosen[sums
                .partition_point(|s| *s < c.uniform(0) * total)
                .min(chosen.len() - 1)];
            let (u, v) = (c.uniform(1).sqrt(), c.uniform(2));
            let on = t[0] * (1.0 - u) + t[1] * (u * (1.0 - v)) + t[2] * (u * v);
            let n = cross(t).try_normalize(0.0).unwrap();
            let tilt = V::from_fn(|k, _| 0.18 * c.normal(10 + k as u64));
            let beam = (tilt - n).try_normalize(0.0).unwrap();
            let depth = 15.0 + 30.0 * c.uniform(3);
            drawn.exact.push(point(on + n * sweep.offset_mm));
            let mut p = on + n * sweep.offset_mm;
            let is_outlier = c.uniform(4) < sweep.outliers;
            if is_outlier && c.uniform(5) < 0.7 {
                p -= beam * (3.0 + 17.0 * c.uniform(6));
            } else if is_outlier {
                p += V::from_fn(|k, _| 30.0 * c.uniform(20 + k as u64) - 15.0);
            }
            let to_tracker = |v: V| V::from((inverse * Vector::<Ct>::new(v.x, v.y, v.z)).mm());
            let b = to_tracker(beam);
            let other = if b.z.abs() < 0.9 { V::z() } else { V::x() };
            let lateral = b.cross(&other).try_normalize(0.0).unwrap();
            let elevation = b.cross(&lateral);
            let noise = [7, 8, 9].map(|k| c.normal(k * 5));
            let [axial, wide, high] = sweep.sigma_mm;
            let mut q = V::from((inverse * point(p)).mm());
            q += b * (axial * noise[0] + depth * sweep.speed)
                + lateral * (wide * noise[1])
                + elevation * (high * noise[2]);
            let place = Point::new(q.x, q.y, q.z);
            drawn.points.push(if sweep.has_beams {
                let beam = Beam {
                    direction: checked::direction(b.into()).unwrap(),
                    depth_mm: Some(depth * (1.0 + sweep.speed)),
                };
                let noise = BeamNoise {
                    axial_mm: axial,
                    lateral_mm: wide,
                    elevation_mm: high,
                };
                SurfacePoint::seen(place, beam, across(beam.direction), noise)
            } else {
                SurfacePoint::touched(place, axial)
            });
            drawn.is_outlier.push(is_outlier);
        }
        drawn
    }
}

/// The direction across a beam that the oracle's lateral axis is.
pub(crate) fn across(beam: Direction<Tracker>) -> Direction<Tracker> {
    let b = beam.components();
    let other = if b[2].abs() < 0.9 { Direction::Z } else { Direction::X };
    beam.cross(other).direction().unwrap()
}

pub(crate) fn point(v: V) -> Point<Ct> {
    Point::new(v.x, v.y, v.z)
}

fn way(c: Chance, first: u64) -> [f64; 3] {
    let v = V::from_fn(|k, _| c.normal(first + k as u64));
    v.try_normalize(0.0).unwrap().into()
}

fn turn(way: [f64; 3], angle: f64) -> Rotation {
    Rotation::from_vector(RotationVector::new(way.map(|x| x * angle)).unwrap())
}

/// Any pose.
fn chance_pose(seed: u64) -> Rigid<Ct, Tracker> {
    let c = Chance::new(seed, 1 << 40);
    let angle = std::f64::consts::PI * c.uniform(50);
    Rigid::from_parts(
        turn(way(c, 0), angle),
        Vector::new(100.0, 2000.0 * c.uniform(51), -500.0),
    )
}

/// The truth, turned and shifted by so much about the middle of the points, in directions that follow from the seed.
pub(crate) fn off(drawn: &Drawn, turn_deg: f64, shift_mm: f64, seed: u64) -> Rigid<Ct, Tracker> {
    let c = Chance::new(seed, 1 << 41);
    let n = drawn.points.len() as f64;
    let mut middle = V::zeros();
    for p in &drawn.points {
        middle += V::from((drawn.ct_from_tracker * p.place).mm()) / n;
    }
    let turn = turn(way(c, 0), turn_deg.to_radians());
    let shift = V::from(way(c, 10)) * shift_mm;
    let about = middle - V::from(turn.apply(middle.into())) + shift;
    Rigid::from_parts(turn, Vector::new(about.x, about.y, about.z)) * drawn.ct_from_tracker
}

/// The targets of the oracle in the phantom.
pub(crate) fn targets() -> [Point<Ct>; 6] {
    [
        [110.0, 60.0, 130.0],
        [235.0, 60.0, 130.0],
        [172.0, 50.0, 150.0],
        [125.0, 75.0, 165.0],
        [220.0, 75.0, 165.0],
        [172.0, 60.0, 110.0],
    ]
    .map(|[x, y, z]| Point::new(x, y, z))
}

/// Target registration errors, mm.
pub(crate) fn tre_mm(found: &Rigid<Ct, Tracker>, truth: &Rigid<Ct, Tracker>, targets: &[Point<Ct>]) -> Vec<f64> {
    targets
        .iter()
        .map(|t| (*found * (truth.inverse() * *t)).distance(*t))
        .collect()
}

pub(crate) fn rms(values: &[f64]) -> f64 {
    (values.iter().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt()
}

/// The points, checked.
pub(crate) fn checked_points(drawn: &Drawn) -> Points<Tracker> {
    Points::new(&drawn.points, None, 0.5).unwrap()
}

/// First-order bound of the TRE rms over targets, mm: of the inliers with their true normals; pose, depth scale and offset are unknown with
/// these priors (0 holds a number).
pub(crate) fn bound_mm(surface: &Surface<Ct>, drawn: &Drawn, targets: &[Point<Ct>], priors: &Priors) -> f64 {
    use nalgebra::{Matrix3, Matrix3x6, RowSVector, SMatrix};
    let turn: Matrix3<f64> = drawn.ct_from_tracker.rotation().matrix().into();
    let mut h = SMatrix::<f64, 8, 8>::zeros();
    for (k, sigma) in [(6, priors.depth_scale), (7, priors.offset_mm)] {
        h[(k, k)] = if sigma > 0.0 { sigma.powi(-2) } else { 1e12 };
    }
    for (i, p) in drawn.points.iter().enumerate() {
        if drawn.is_outlier[i] {
            continue;
        }
        let n = V::from(surface.distance(drawn.exact[i]).normal);
        let own = turn.tr_mul(&n);
        let variance = own.dot(&(p.covariance_mm2 * own));
        let w = V::from(drawn.exact[i].mm()).cross(&n);
        let deep = p.beam.map_or(0.0, |b| {
            own.dot(&V::from(b.direction.components())) * b.depth_mm.unwrap()
        });
        let j = RowSVector::<f64, 8>::from([w.x, w.y, w.z, n.x, n.y, n.z, -deep, -1.0]);
        h += j.transpose() * j / variance;
    }
    let c: SMatrix<f64, 6, 6> = h.try_inverse().unwrap().fixed_view::<6, 6>(0, 0).into_owned();
    let mut sum = 0.0;
    for t in targets {
        let mut lever = Matrix3x6::zeros();
        lever
            .fixed_view_mut::<3, 3>(0, 0)
            .copy_from(&-V::from(t.mm()).cross_matrix());
        lever.fixed_view_mut::<3, 3>(0, 3).copy_from(&Matrix3::identity());
        sum += (lever * c * lever.transpose()).trace() / targets.len() as f64;
    }
    sum.sqrt()
}

/// Square of the error at a target in its predicted covariance: chi-square of three degrees of freedom.
pub(crate) fn chi2(found: &SurfaceRegistration<Ct, Tracker>, truth: &Rigid<Ct, Tracker>, target: Point<Ct>) -> f64 {
    let shown = found.transform.transform() * (truth.inverse() * target);
    let miss = V::from((shown - target).mm());
    let c = found.at(target).covariance();
    miss.dot(
        &c.try_inverse()
            .map_or(V::repeat(f64::INFINITY), |inverse| inverse * miss),
    )
}

/// The points of a patch: those of `drawn` within `radius_mm` of the first of them.
pub(crate) fn patch(mut drawn: Drawn, radius_mm: f64, most: usize) -> Drawn {
    let middle = drawn.exact[0];
    let near: Vec<usize> = (0..drawn.points.len())
        .filter(|i| drawn.exact[*i].distance(middle) < radius_mm)
        .take(most)
        .collect();
    drawn.points = near.iter().map(|i| drawn.points[*i]).collect();
    drawn.is_outlier = near.iter().map(|i| drawn.is_outlier[*i]).collect();
    drawn.exact = near.iter().map(|i| drawn.exact[*i]).collect();
    drawn
}
