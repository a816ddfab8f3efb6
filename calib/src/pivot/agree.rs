//! Whether the methods agree to within their errors.
//!
//! All methods see the same poses, so their tips differ by less than their errors together where the noise is what was
//! assumed and the tip stayed in its place. Where they differ by more, one of these does not hold: each method is drawn
//! another way by it, and none of their covariances knows of it.

use geometry::Frame;
use nalgebra::Vector3;

use super::{Method, Pivot};

/// How many deviations two tips may lie apart by noise. The deviation is that of the worse tip along the line between
/// them: both tips are of the same poses, and the variance of the difference of an efficient estimate and another one
/// is the difference of their variances (Hausman 1978), so that it is at most the larger of them.
const NOISE_DEVIATIONS: f64 = 2.5;

/// Two methods whose tips lie further apart than their errors allow.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Apart {
    /// The methods.
    pub methods: [Method; 2],
    /// Distance of their tips, mm.
    pub mm: f64,
    /// The most that is taken for noise, mm: 2.5 times the larger of both deviations along the line between the tips.
    pub most_mm: f64,
}

/// The two methods whose tips lie furthest apart in units of what is taken for noise; `None` where no two lie further
/// apart than that. Two-step and sphere have no covariance. Two-step is judged by that of algebraic, which minimises
/// nearly the same sum; sphere is left out, as its error is many times as large where cones are small.
pub fn apart<To: Frame, From: Frame>(found: &[Pivot<To, From>]) -> Option<Apart> {
    let linear = found.iter().find(|p| p.method == Method::Algebraic);
    let covariance = |p: &Pivot<To, From>| match p.method {
        Method::TwoStep => linear.and_then(Pivot::tip_covariance),
        _ => p.tip_covariance(),
    };
    let known: Vec<_> = found.iter().filter_map(|p| Some((p, covariance(p)?))).collect();
    let pairs = known
        .iter()
        .enumerate()
        .flat_map(|(i, a)| known[i + 1..].iter().map(move |b| (a, b)));
    let each = pairs.map(|((a, ca), (b, cb))| {
        let off = Vector3::from((a.tip - b.tip).mm());
        let line = off.try_normalize(0.0).unwrap_or_default();
        let sigma = |c: &nalgebra::Matrix3<f64>| line.dot(&(c * line)).max(0.0).sqrt();
        Apart {
            methods: [a.method, b.method],
            mm: off.norm(),
            most_mm: NOISE_DEVIATIONS * sigma(ca).max(sigma(cb)),
        }
    });
    let beyond = each.filter(|apart| apart.mm > apart.most_mm);
    beyond.max_by(|a, b| (a.mm / a.most_mm).total_cmp(&(b.mm / b.most_mm)))
}
