//! Which axes the marker's frame has.

use geometry::rotation::RotationMatrix;
use geometry::{Marker, Point, Rigid, Tracker, Vector};
use nalgebra::{Matrix3, Vector3};

use super::Refused;
use super::chain::moved;
use super::error::Mislabelled;
use crate::registration::{Method, Pairs, fit, register_robust};

/// The axes and the origin of the marker's frame.
#[derive(Debug, Clone, PartialEq, Default)]
pub enum Gauge {
    /// Origin at the mean of the emitters; x along the direction in which they spread most, z least. On x and on y the
    /// first emitter at least half as far out as the farthest is positive; z completes a right-handed frame.
    ///
    /// Fixed by the emitters alone, and so only as steady as the axes are: where two directions spread alike, as on a
    /// ball, the next calibration of the same marker has other axes. Calibrate what is fixed to the marker anew with
    /// it, or give a drawing.
    #[default]
    PrincipalAxes,
    /// The frame of a drawing, laid on the emitters by paired points; each must be within the tolerance of its place.
    Design {
        /// Places in the drawing; `None` for emitters it does not show.
        places: Vec<Option<Point<Marker>>>,
        /// The largest distance allowed, mm.
        tolerance_mm: f64,
    },
}

impl Gauge {
    /// The transform that brings the body's axes to the marker's frame.
    pub(super) fn choose(&self, body: &[Option<Vector3<f64>>]) -> Result<Rigid<Marker, Tracker>, Refused> {
        match self {
            Self::PrincipalAxes => Ok(principal(body)),
            Self::Design { places, tolerance_mm } => drawn(body, places, *tolerance_mm),
        }
    }
}

fn principal(body: &[Option<Vector3<f64>>]) -> Rigid<Marker, Tracker> {
    let known: Vec<Vector3<f64>> = body.iter().flatten().copied().collect();
    let centre = known.iter().sum::<Vector3<f64>>() / known.len() as f64;
    let about: Vec<Vector3<f64>> = known.iter().map(|p| p - centre).collect();
    let spread = about.iter().map(|p| p * p.transpose()).sum::<Matrix3<f64>>();
    let eigen = spread.symmetric_eigen();
    let mut order = [0, 1, 2];
    order.sort_by(|a, b| eigen.eigenvalues[*b].total_cmp(&eigen.eigenvalues[*a]));
    let axis = |k: usize| signed(eigen.eigenvectors.column(order[k]).into_owned(), &about);
    let (x, y) = (axis(0), axis(1));
    // The third eigenvector is of either hand; the product makes the frame right-handed.
    let z = x.cross(&y);
    let rows = [x, y, z].map(|v| [v.x, v.y, v.z]);
    // Eigenvectors are orthonormal to rounding, so the door cannot be shut here.
    let turn = RotationMatrix::new(rows, 1e-9).map_or(geometry::rotation::Rotation::IDENTITY, |m| m.rotation());
    let [a, b, c] = turn.apply(centre.into());
    Rigid::from_parts(turn, Vector::new(-a, -b, -c))
}

/// The axis or its opposite.
fn signed(axis: Vector3<f64>, points: &[Vector3<f64>]) -> Vector3<f64> {
    // By an emitter well off the plane through the centre: the sign by one near it would be that of the noise.
    let farthest = points.iter().map(|p| p.dot(&axis).abs()).fold(0.0, f64::max);
    let first = points.iter().map(|p| p.dot(&axis)).find(|x| x.abs() >= 0.5 * farthest);
    if first.is_some_and(|x| x < 0.0) { -axis } else { axis }
}

fn drawn(
    body: &[Option<Vector3<f64>>],
    drawing: &[Option<Point<Marker>>],
    limit_mm: f64,
) -> Result<Rigid<Marker, Tracker>, Refused> {
    let both = |i: &usize| body[*i].is_some() && drawing.get(*i).is_some_and(Option::is_some);
    let shared: Vec<usize> = (0..body.len()).filter(both).collect();
    let to: Vec<Point<Marker>> = shared.iter().filter_map(|i| drawing[*i]).collect();
    let from: Vec<Point<Tracker>> = shared.iter().filter_map(|i| body[*i]).map(point).collect();
    let pairs = Pairs::new(&to, &from).map_err(Refused::NoDesign)?;
    let plain = fit(pairs, Method::default()).map_err(Refused::NoDesign)?;
    let off = |i: usize| plain.residual_mm(to[i], from[i]);
    let Some(worst) = (0..to.len()).max_by(|a, b| off(*a).total_cmp(&off(*b))) else {
        return Ok(plain.transform);
    };
    if off(worst) <= limit_mm {
        return Ok(plain.transform);
    }
    // Too far off the drawing: the two mistakes that people make are looked for, to be named.
    mirrored(pairs, plain.fre_rms_mm(pairs), limit_mm)?;
    exchanged(pairs, &shared, limit_mm)?;
    Err(Refused::OffDesign {
        emitter: shared[worst],
        found_mm: off(worst),
        limit_mm,
    })
}

fn point<F>(p: Vector3<f64>) -> Point<F> {
    Point::new(p.x, p.y, p.z)
}

/// Refuses a body that fits mirrored.
fn mirrored(pairs: Pairs<'_, Marker, Tracker>, residual_mm: f64, limit_mm: f64) -> Result<(), Refused> {
    let turned: Vec<Point<Tracker>> = pairs
        .from
        .iter()
        .map(|p| {
            let [x, y, z] = p.mm();
            Point::new(-x, y, z)
        })
        .collect();
    let image = Pairs::new(pairs.to, &turned).map_err(Refused::NoDesign)?;
    let mirrored_mm = fit(image, Method::default()).map_or(f64::INFINITY, |f| f.fre_rms_mm(image));
    // A mirror image is named only where it fits, and fits twice as well: a nearly flat marker fits both ways.
    if mirrored_mm > limit_mm || mirrored_mm > 0.5 * residual_mm {
        return Ok(());
    }
    Err(Refused::MirroredDesign {
        residual_mm,
        mirrored_mm,
    })
}

/// Refuses emitters that lie at another one's place in the drawing.
fn exchanged(pairs: Pairs<'_, Marker, Tracker>, shared: &[usize], limit_mm: f64) -> Result<(), Refused> {
    // A majority; below four, three that keep their distances by chance would do.
    let needed = (shared.len() / 2 + 1).max(4);
    let Ok(found) = register_robust(pairs, Method::default(), limit_mm, needed) else {
        return Ok(());
    };
    let laid = found.registration.fit.transform;
    let mut named = Vec::new();
    for i in (0..shared.len()).filter(|i| !found.inliers[*i]) {
        let p = moved(&laid, &Vector3::from(pairs.from[i].mm()));
        let off = |m: usize| pairs.to[m].distance(point(p));
        let nearest = (0..shared.len()).min_by(|a, b| off(*a).total_cmp(&off(*b)));
        if let Some(m) = nearest.filter(|m| *m != i && off(*m) <= limit_mm) {
            named.push(Mislabelled {
                emitter: shared[i],
                seems: shared[m],
                views: Vec::new(),
            });
        }
    }
    if named.is_empty() {
        return Ok(());
    }
    Err(Refused::Mislabelled(named))
}
