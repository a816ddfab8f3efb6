//! Registration in the plane, in closed form (4.14).

use nalgebra::Vector2;

use super::Refused;

/// The rigid transform of the plane that brings `b_i` nearest to `a_i`: `a = R(angle) b + translation`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct PlanarFit {
    /// Angle of the rotation, -pi to pi, radians.
    pub angle_rad: f64,
    /// Translation, mm.
    pub translation_mm: [f64; 2],
    /// Root mean square distance after registration, mm: divides by the number of pairs.
    pub fre_rms_mm: f64,
    /// The criterion 4.8 over the root of both energies: 1 for a perfect fit, 0 where every angle is equally good.
    pub correlation: f64,
}

/// Fits in the plane. Coordinates up to 1e150 mm in size.
///
/// # Errors
/// [`Refused::Unpaired`], [`Refused::TooFew`] below two pairs, [`Refused::NotFinite`], [`Refused::Coincident`], and
/// [`Refused::Reflected`] where one cloud mirrors the other so that every angle is equally good.
pub fn fit_planar(to: &[[f64; 2]], from: &[[f64; 2]]) -> Result<PlanarFit, Refused> {
    check(to, from)?;
    let (a, centre_a) = centred(to);
    let (b, centre_b) = centred(from);
    let (ea, eb) = (energy(&a), energy(&b));
    let n = to.len() as f64;
    refuse_coincident(ea.min(eb), n, [centre_a, centre_b], [ea, eb])?;
    // In the plane 4.8 is cos(angle) sum a.b + sin(angle) sum b x a: largest at the angle of (cosine, sine), where it
    // is their length.
    let cosine: f64 = a.iter().zip(&b).map(|(a, b)| a.dot(b)).sum();
    let sine: f64 = a.iter().zip(&b).map(|(a, b)| b.perp(a)).sum();
    let length = cosine.hypot(sine);
    let correlation = length / (ea.sqrt() * eb.sqrt());
    // Both sums are rounded by some eps of their size, so that below this the angle is noise.
    if correlation <= 20.0 * f64::EPSILON {
        // In the plane there is no 3 x 3 matrix; these values stand for an even mirror image, s2 + s3 = 0.
        return Err(Refused::Reflected(super::SingularValues([0.5, 0.5, -0.5])));
    }
    let (c, s) = (cosine / length, sine / length);
    let turn = |p: &Vector2<f64>| Vector2::new(c * p.x - s * p.y, s * p.x + c * p.y);
    let squares: f64 = a.iter().zip(&b).map(|(a, b)| (a - turn(b)).norm_squared()).sum();
    Ok(PlanarFit {
        angle_rad: s.atan2(c),
        translation_mm: (centre_a - turn(&centre_b)).into(),
        fre_rms_mm: (squares / n).sqrt(),
        correlation,
    })
}

fn check(to: &[[f64; 2]], from: &[[f64; 2]]) -> Result<(), Refused> {
    let (a, b) = (to.len(), from.len());
    if a != b {
        return Err(Refused::Unpaired { to: a, from: b });
    }
    if a < 2 {
        return Err(Refused::TooFew { found: a, needed: 2 });
    }
    for (pair, [x, y]) in to.iter().chain(from).enumerate() {
        if !(x.is_finite() && y.is_finite()) {
            let found = [*x, *y, 0.0];
            return Err(Refused::NotFinite { pair: pair % a, found });
        }
    }
    Ok(())
}

/// The points about their centre, in two passes, and the centre.
fn centred(points: &[[f64; 2]]) -> (Vec<Vector2<f64>>, Vector2<f64>) {
    let n = points.len() as f64;
    // The first mean is rounded by ulps of the offset; the mean of what is left takes that off (as `Moments` do).
    let rough = points.iter().map(|p| Vector2::from(*p)).sum::<Vector2<f64>>() / n;
    let mut about: Vec<Vector2<f64>> = points.iter().map(|p| Vector2::from(*p) - rough).collect();
    let rest = about.iter().sum::<Vector2<f64>>() / n;
    about.iter_mut().for_each(|p| *p -= rest);
    (about, rough + rest)
}

fn energy(points: &[Vector2<f64>]) -> f64 {
    points.iter().map(|p| p.norm_squared()).sum()
}

fn refuse_coincident(least: f64, n: f64, centres: [Vector2<f64>; 2], energies: [f64; 2]) -> Result<(), Refused> {
    // Points that differ by less than 8 ulp of their centre are one, as in `Moments`.
    let floor = |i: usize| n * (centres[i].norm() * 8.0 * f64::EPSILON).powi(2);
    if energies[0] > floor(0) && energies[1] > floor(1) {
        return Ok(());
    }
    Err(Refused::Coincident {
        radius_mm: (least / n).sqrt(),
    })
}
