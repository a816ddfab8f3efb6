//! Checks of what a registration is asked to do.

use geometry::Frame;

use super::{Options, RegisterError, Start};
use crate::points::Points;
use crate::{Priors, Surface};

pub(super) fn check<To: Frame, From: Frame>(
    surface: &Surface<To>,
    points: &Points<From>,
    start: &Start<To, From>,
    options: &Options,
) -> Result<(), RegisterError> {
    let Priors {
        depth_scale,
        offset_mm,
        bone_mm,
        side_mm,
    } = options.priors;
    let effort = &options.effort;
    let counts = [
        effort.seeds,
        effort.pairs,
        effort.places,
        effort.sample,
        effort.tried,
        effort.polished,
        effort.ends,
    ];
    let least = counts.into_iter().min().unwrap_or(0) as f64;
    let most = counts.into_iter().max().unwrap_or(0) as f64;
    let (mut turn, mut shift) = (0.0, 0.0);
    if let Start::Guess { turn_rad, shift_mm, .. } = start {
        (turn, shift) = (*turn_rad, *shift_mm);
    }
    let ranges = [
        ("deviation of the depth scale", depth_scale, 0.0, 0.2, "0 to 0.2"),
        ("deviation of the surface's offset, mm", offset_mm, 0.0, 10.0, "0 to 10"),
        ("deviation of the bone's surface, mm", bone_mm, 0.0, 10.0, "0 to 10"),
        ("deviation of what lies on one side, mm", side_mm, 0.0, 10.0, "0 to 10"),
        ("kernel's end, deviations", options.kernel_end, 2.0, 20.0, "2 to 20"),
        ("cosine of beams that face away", options.facing, -1.0, 1.0, "-1 to 1"),
        ("the least count of the effort", least, 1.0, f64::MAX, "1 and more"),
        ("the greatest count of the effort", most, 1.0, 1e7, "up to 10 000 000"),
        ("places of the surface", effort.places as f64, 2.0, 5000.0, "2 to 5000"),
        ("turn of the guess, rad", turn, 0.0, std::f64::consts::PI, "0 to pi"),
        ("shift of the guess, mm", shift, 0.0, 1000.0, "0 to 1000"),
    ];
    for (what, found, least, most, allowed) in ranges {
        // A NaN is in no range.
        if !(least..=most).contains(&found) {
            return Err(RegisterError::Option { what, found, allowed });
        }
    }
    wide(surface, points)
}

/// Refuses points that are spread wider than the bone, but for a tenth of them which may be gross errors.
fn wide<To: Frame, From: Frame>(surface: &Surface<To>, points: &Points<From>) -> Result<(), RegisterError> {
    let [least, most] = surface.tree.bounds();
    let surface_mm = (most - least).norm();
    let mut radii: Vec<f64> = points.cloud.places.iter().map(|p| p.norm()).collect();
    radii.sort_by(f64::total_cmp);
    let points_mm = 2.0 * radii[radii.len() * 9 / 10 - usize::from(radii.len() < 2)];
    // Twice: the middle of the points need not be the middle of their extent.
    if points_mm > 2.0 * surface_mm {
        return Err(RegisterError::TooWide { points_mm, surface_mm });
    }
    Ok(())
}
