//! Whether the points stop fitting towards the end of their order: the bone moved, or the tool left it.
//!
//! Two poses of the two parts ([`crate::Halves`]) need enough points behind the change to hold a pose. The last few do not, and a fit that leaves
//! them out looks perfect. What they show is that almost none of them fits, while those before do.

use crate::register::{Class, PointResult};

/// The last points of the order, of which hardly any fits.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Tail {
    /// How many points that is.
    pub points: usize,
    /// Share of them that is left out.
    pub left_out: f64,
    /// Share of those before that is left out.
    pub left_out_before: f64,
    /// Logarithm of how much likelier two shares are than one for all (Wilks: half a square of deviations).
    pub likelihood: f64,
}

/// Fewer points that are left out are no sign of anything: a tool is lifted.
const LEAST_POINTS: usize = 8;
/// Of a bone that moved far hardly any point fits; a smaller share is echoes.
const LEAST_LEFT_OUT: f64 = 0.7;

/// The tail that differs most from what is before it; `None` where the last points fit like the others.
///
/// Only tails of at most half of the points are looked at: of which part the pose is, the larger one decides.
pub fn tail(points: &[PointResult]) -> Option<Tail> {
    let count = points.len();
    let is_out = |point: &PointResult| point.class != Class::Kept;
    let all = points.iter().filter(|point| is_out(point)).count();
    let mut out = 0;
    let mut found: Option<Tail> = None;
    for (place, point) in points.iter().rev().enumerate() {
        out += usize::from(is_out(point));
        let length = place + 1;
        if out < LEAST_POINTS || 2 * length > count {
            continue;
        }
        let (left_out, left_out_before) = (share(out, length), share(all - out, count - length));
        // Wilks: twice this is a chi-square of one degree, of which the greatest of some dozens that overlap is looked for.
        let likelihood = own(out, length) + own(all - out, count - length) - own(all, count);
        let is_tail = left_out >= LEAST_LEFT_OUT && left_out_before < 0.5 * left_out;
        if is_tail && found.is_none_or(|found| likelihood > found.likelihood) {
            found = Some(Tail {
                points: length,
                left_out,
                left_out_before,
                likelihood,
            });
        }
    }
    found
}

fn share(out: usize, of: usize) -> f64 {
    out as f64 / of as f64
}

/// Logarithm of the likelihood of so many left out by their own share.
fn own(out: usize, of: usize) -> f64 {
    let p = share(out, of);
    let part = |count: usize, p: f64| if count == 0 { 0.0 } else { count as f64 * p.ln() };
    part(out, p) + part(of - out, 1.0 - p)
}

#[cfg(test)]
mod tests {
    use super::*;
    use chance::Chance;

    fn points(out: impl Fn(usize) -> bool, count: usize) -> Vec<PointResult> {
        let point = |i: usize| PointResult {
            residual_mm: 0.0,
            deviations: 0.0,
            weight: 1.0,
            class: if out(i) { Class::InFront } else { Class::Kept },
        };
        (0..count).map(point).collect()
    }

    #[test]
    fn a_tail_that_does_not_fit_is_found_with_its_length() {
        for (count, from) in [(200, 160), (200, 188), (60, 50), (60, 31)] {
            let found = tail(&points(|i| i >= from || i % 10 == 0, count)).unwrap();
            // A point before that happens to be left out belongs to it.
            let (least, most) = (count - from, count - from + 1);
            assert!(
                (least..=most).contains(&found.points) && found.likelihood > 10.0,
                "{found:?}"
            );
        }
        // Seven points of the air are a lifted tool, and the first ones decide nothing.
        assert_eq!(tail(&points(|i| i >= 193, 200)), None);
        assert_eq!(tail(&points(|i| i < 40, 200)), None);
    }

    /// Shares of echoes that have nothing to do with the order: refused once in some thousands.
    #[test]
    fn echoes_are_no_tail() {
        for share in [0.1, 0.3, 0.45] {
            let seen = (0..2000).filter(|&run| {
                let found = tail(&points(|i| Chance::new(run, i as u64).uniform(0) < share, 120));
                found.is_some_and(|found| found.likelihood > 10.0)
            });
            let seen = seen.count();
            // At a true rate of 1 in 2000 six and more come once in two thousand tries of this.
            assert!(seen <= 5, "{share}: {seen} of 2000");
        }
    }
}
