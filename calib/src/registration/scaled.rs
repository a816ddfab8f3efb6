//! Registration with an unknown scale: the best direct similarity (Umeyama 1991).

use geometry::{Affine, Frame};

use super::{Fit, Method, Moments, Pairs, Refused, fit};

/// The similarity `a = scale R b + t` that fits best in the sense of least squares in `To`.
#[derive(Debug, Clone, Copy)]
pub struct Scaled<To: Frame, From: Frame> {
    /// Lengths in `To` per length in `From`; above zero.
    pub scale: f64,
    /// `to_from_from` with the scale.
    pub transform: Affine<To, From>,
    /// The rotation's fit; its own transform has no scale.
    pub rigid: Fit<To, From>,
    /// Root of the weighted mean of the squared distances, mm: divides by N, or by the sum of the weights.
    pub fre_rms_mm: f64,
}

/// Fits rotation, translation and scale. The rotation is that of [`fit()`]; `scale = tr(R^T Psi) / tr B`.
///
/// The scale is biased low by noise in `From`: by its variance over the mean squared radius. Domain: clouds whose sizes
/// differ by a factor below 1e250.
///
/// # Errors
/// Those of [`fit()`].
pub fn fit_scaled<To: Frame, From: Frame>(
    pairs: Pairs<'_, To, From>,
    method: Method,
) -> Result<Scaled<To, From>, Refused> {
    let rigid = fit(pairs, method)?;
    let moments = &rigid.moments;
    let r = rigid.rotation();
    let scale = best_scale(moments, &r);
    let linear = r * scale;
    let t = moments.mean(0) - linear * moments.mean(1);
    let rows = std::array::from_fn(|i| [linear[(i, 0)], linear[(i, 1)], linear[(i, 2)], t[i]]);
    Ok(Scaled {
        scale,
        transform: Affine::from_rows(rows),
        rigid,
        fre_rms_mm: residual(pairs, moments, &linear),
    })
}

fn best_scale(moments: &Moments, r: &nalgebra::Matrix3<f64>) -> f64 {
    // `psi` was formed from clouds times sa and sb, `energy[1]` from one times sb twice: sb / sa takes that out again.
    let [sa, sb] = moments.scale;
    let scaled = r.dot(&moments.psi) / moments.energy[1];
    scaled * (sb / sa)
}

fn residual<To, From>(pairs: Pairs<'_, To, From>, moments: &Moments, linear: &nalgebra::Matrix3<f64>) -> f64 {
    // Scaled as the moments were, so that squares neither overflow nor vanish.
    let unit = moments.scale[0];
    let (mut sum, mut total) = (0.0, 0.0);
    for (i, (a, b)) in pairs.to.iter().zip(pairs.from).enumerate() {
        let r = moments.centred(0, *a) - linear * moments.centred(1, *b);
        sum += pairs.weight(i) * (r * unit).norm_squared();
        total += pairs.weight(i);
    }
    (sum / total).sqrt() / unit
}

#[cfg(test)]
mod tests {
    use super::super::quaternion::matrix;
    use super::*;
    use geometry::{Ct, Point, Tracker};

    #[test]
    fn finds_the_planted_scale() {
        let from: [Point<Tracker>; 4] =
            [[1.0, 2.0, 3.0], [-4.0, 0.5, 1.0], [2.0, -7.0, 0.0], [0.0, 1.0, 9.0]].map(|[x, y, z]| Point::new(x, y, z));
        let q = [0.5, 0.5, -0.5, 0.5];
        let to = from.map(|p| {
            let v = matrix(&q) * nalgebra::Vector3::from(p.mm()) * 3.5;
            Point::<Ct>::new(v.x + 10.0, v.y, v.z - 4.0)
        });
        let found = fit_scaled(Pairs::new(&to, &from).unwrap(), Method::Newton).unwrap();
        // Sums of four products, relative.
        assert!((found.scale - 3.5).abs() < 3.5 * 16.0 * f64::EPSILON, "{}", found.scale);
        assert!(found.fre_rms_mm < 1e-13, "{}", found.fre_rms_mm);
        assert!((found.transform * from[2]).distance(to[2]) < 1e-13);
        let [tiny, huge] = [2.0_f64.powi(-400), 2.0_f64.powi(400)];
        let to = to.map(|p| Point::<Ct>::new(p.mm()[0] * tiny, p.mm()[1] * tiny, p.mm()[2] * tiny));
        let from = from.map(|p| Point::<Tracker>::new(p.mm()[0] * huge, p.mm()[1] * huge, p.mm()[2] * huge));
        let found = fit_scaled(Pairs::new(&to, &from).unwrap(), Method::Newton).unwrap();
        assert!((found.scale / tiny * huge - 3.5).abs() < 3.5 * 16.0 * f64::EPSILON);
    }
}
