//! Whether the model that fits a spot is a bead.

use super::fit::Fitted;
use super::optics::Optics;
use super::profile::Blur;
use super::refine::Refined;
use super::{Reason, Search};

/// Root mean square residual as a share of the contrast.
const MOST_RESIDUAL: f64 = 0.12;
/// Fitted blur over expected: kernels for bone are sharp.
const BLUR_RANGE: [f64; 2] = [0.45, 1.8];
/// Share of the metal's HU that a fitted ball must have.
const METAL_SHARE: f64 = 0.6;
/// How far beyond the range of radii a fitted one may lie.
const RADIUS_SLACK: f64 = 1.15;
/// Deviations of the logarithms of metal and radius by which they must miss their bounds: where a ball is clipped or
/// small the voxels do not tell.
const SURE: f64 = 2.0;

/// How much larger than around it the residuals of a ball may be ([`super::leftover`]) that only the second look takes for
/// a bead: about 1 where ball and field are what is there. Of beads planted beside bone 0.5, of short rods 1.6 to 6.
const MOST_UNEVEN: f64 = 1.5;
/// HU over the ground that the field around such a ball may have: bone has less (1500 beside lung), metal more.
const MOST_AROUND_HU: f64 = 1800.0;

/// Whether a spot that stage 2 refused is worth a second look, with what is around as a random field: beside bone a ball on
/// sloping ground takes the bone for its own blur. What is not bright enough is none with any ground.
pub(super) fn is_open(reason: &Reason) -> bool {
    matches!(reason, Reason::Blur { .. } | Reason::Shape { .. } | Reason::NoFit)
}

/// As [`judge_fit`], of a spot that stage 2 refused: there the field may have been made to explain what is no ball.
pub(super) fn judge_again(refined: &Refined, search: &Search, optics: &Optics) -> Option<Fitted> {
    let fitted = refined.fitted()?;
    judge_fit(&fitted, search, optics).ok()?;
    let left = refined.leftover()?;
    // The second inverts a matrix.
    let sound = left.brightest_hu() <= MOST_AROUND_HU && left.unevenness() <= MOST_UNEVEN;
    sound.then_some(fitted)
}

/// Nothing, or why it is none.
pub(super) fn judge_fit(fitted: &Fitted, search: &Search, optics: &Optics) -> Result<(), Reason> {
    let Blur {
        radius_mm, plane_mm, ..
    } = fitted.blur;
    let axial_mm = fitted.blur.profile_mm();
    let [low, high] = search.radius_mm;
    let strayed = fitted.centre.norm() > high.max(optics.step_mm[1]);
    if strayed {
        return Err(Reason::NoFit);
    }
    // Radius and HU of a small ball are nearly one number, but all its metal together is well known; it
    // must do for the smallest bead.
    let smallest_hu = fitted.metal_hu * (radius_mm / low).powi(3);
    // Unclipped voxels tell the HU; a blurred knob of bone in bone must not gain by what they leave open.
    let sure = if fitted.clipped > 0 { SURE } else { 0.0 };
    let most = |hu: f64, deviation: f64| hu * (sure * deviation).exp();
    let surely = most(fitted.metal_hu, fitted.metal_deviation).min(most(smallest_hu, fitted.mass_deviation));
    let needed_hu = METAL_SHARE * search.metal_hu;
    if surely < needed_hu {
        return Err(Reason::NotMetal {
            found_hu: fitted.metal_hu.min(smallest_hu),
            needed_hu,
        });
    }
    let ratio = [plane_mm / optics.sigma_mm[0], axial_mm / optics.sigma_mm[1]];
    if ratio.iter().any(|r| *r < BLUR_RANGE[0] || *r > BLUR_RANGE[1]) {
        return Err(Reason::Blur {
            ratio,
            range: BLUR_RANGE,
        });
    }
    let range_mm = [low / RADIUS_SLACK, high * RADIUS_SLACK];
    let unsure = (SURE * fitted.radius_deviation).exp();
    if radius_mm * unsure < range_mm[0] || radius_mm / unsure > range_mm[1] {
        return Err(Reason::Radius {
            found_mm: radius_mm,
            range_mm,
        });
    }
    let residual = fitted.residual_hu / fitted.signal_hu;
    if residual > MOST_RESIDUAL {
        return Err(Reason::Shape {
            residual,
            most: MOST_RESIDUAL,
        });
    }
    Ok(())
}
