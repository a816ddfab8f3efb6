//! Whether what fits a spot is a bead: step 4 of the crate's documentation, and what step 5 asks beyond.

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
const SURE_DEVIATIONS: f64 = 2.0;

/// How much larger in the ball than around it residuals may be ([`super::residuals`]) where only the refit on a field is a
/// bead: about 1 where ball and field are what is there. Of beads planted beside bone 0.5, of short rods 1.6 to 6.
const MOST_UNEVEN: f64 = 1.5;
/// HU over the ground that the field around such a ball may have: bone has less (1500 beside lung), metal more.
const MOST_AROUND_HU: f64 = 1800.0;

/// The greatest deviation of the centre as a share of the voxels' step, in the slices' plane and along their normal, of a ball
/// without clipped voxels: metal is so much brighter than what is around it that its centre is known better, even in bone. Of 259 knobs of bone
/// and calcium that passed for beads until then all but four had more, or were no metal on their field; of 64 planted beads, as dim
/// as is asked for, none (docs/beads.md).
const MOST_UNSURE: [f64; 2] = [0.065, 0.125];
/// The same of a ball with clipped voxels, whose flanks alone tell its centre: no knob of bone had any. In thick slices its
/// height may not be known at all.
const MOST_UNSURE_CLIPPED: [f64; 2] = [0.12, f64::INFINITY];

/// Whether a spot that step 4 refused is worth a refit, with what is around as a random field: beside bone a ball on sloping
/// ground takes the bone for its own blur. What is not bright enough is no bead on any ground.
pub(super) fn deserves_refit(reason: &Reason) -> bool {
    matches!(reason, Reason::Blur { .. } | Reason::Shape { .. } | Reason::NoFit)
}

/// The refit of a spot that step 4 refused, where it is a bead: it passes [`check_model`], and the field has not been made to
/// explain what is no ball.
pub(super) fn accept_refit(refined: &Refined, search: &Search, optics: &Optics) -> Option<Fitted> {
    let fitted = refined.fitted()?;
    check_model(&fitted, search, optics).ok()?;
    let leftover = refined.leftover()?;
    // The cheaper one first: the second inverts a matrix.
    let sound = leftover.brightest_hu() <= MOST_AROUND_HU && leftover.unevenness() <= MOST_UNEVEN;
    sound.then_some(fitted)
}

/// Whether what was fitted on a field is still metal, and its centre as well known as that of metal is: what has a wide
/// covariance is hardly brighter than what is around it.
pub(super) fn check_metal_and_centre(fitted: &Fitted, search: &Search, optics: &Optics) -> Result<(), Reason> {
    is_metal(fitted, search)?;
    let c = &fitted.covariance;
    // The greater eigenvalue of the plane's part: its axes need not be those of the covariance.
    let (mean, apart) = (0.5 * (c[(0, 0)] + c[(1, 1)]), 0.5 * (c[(0, 0)] - c[(1, 1)]));
    let variances = [mean + apart.hypot(c[(0, 1)]), c[(2, 2)]];
    let share = [0, 1].map(|k| variances[k].sqrt() / optics.step_mm[k]);
    let most = match fitted.clipped {
        0 => MOST_UNSURE,
        _ => MOST_UNSURE_CLIPPED,
    };
    // A NaN is refused.
    let is_known = (0..2).all(|k| share[k] <= most[k]);
    if is_known {
        Ok(())
    } else {
        Err(Reason::Unsure { share, most })
    }
}

/// Whether there is as much metal as in the dimmest bead looked for.
fn is_metal(fitted: &Fitted, search: &Search) -> Result<(), Reason> {
    let (radius_mm, [low, _]) = (fitted.blur.radius_mm, search.radius_mm);
    // Radius and HU of a small ball are nearly one number, but all its metal together is well known; it
    // must do for the smallest bead.
    let smallest_hu = fitted.metal_hu * (radius_mm / low).powi(3);
    // Without clipped voxels the HU are known, and a blurred knob of bone in bone must not pass by their uncertainty.
    let sure = if fitted.clipped > 0 { SURE_DEVIATIONS } else { 0.0 };
    let most = |hu: f64, deviation: f64| hu * (sure * deviation).exp();
    let surely = most(fitted.metal_hu, fitted.metal_deviation).min(most(smallest_hu, fitted.mass_deviation));
    let needed_hu = METAL_SHARE * search.metal_hu;
    if surely < needed_hu {
        return Err(Reason::NotMetal {
            found_hu: fitted.metal_hu.min(smallest_hu),
            needed_hu,
        });
    }
    Ok(())
}

/// Whether the ball that fits is a bead: metal, blurred as the scanner blurs, of the radius, and round. Else why not.
pub(super) fn check_model(fitted: &Fitted, search: &Search, optics: &Optics) -> Result<(), Reason> {
    let Blur {
        radius_mm, plane_mm, ..
    } = fitted.blur;
    let axial_mm = fitted.blur.profile_mm();
    let [low, high] = search.radius_mm;
    // A fit that has left its spot describes something else: no reason beyond that would mean anything.
    let strayed = fitted.centre.norm() > high.max(optics.step_mm[1]);
    if strayed {
        return Err(Reason::NoFit);
    }
    is_metal(fitted, search)?;
    let ratio = [plane_mm / optics.sigma_mm[0], axial_mm / optics.sigma_mm[1]];
    if ratio.iter().any(|r| *r < BLUR_RANGE[0] || *r > BLUR_RANGE[1]) {
        return Err(Reason::Blur {
            ratio,
            range: BLUR_RANGE,
        });
    }
    let range_mm = [low / RADIUS_SLACK, high * RADIUS_SLACK];
    // A radius that is hardly known is refused only where even its nearer end is out of the range.
    let unsure = (SURE_DEVIATIONS * fitted.radius_deviation).exp();
    if radius_mm * unsure < range_mm[0] || radius_mm / unsure > range_mm[1] {
        return Err(Reason::Radius {
            found_mm: radius_mm,
            range_mm,
        });
    }
    // Whatever is no ball (wire, clip, tooth) leaves its own shape in the residuals.
    let residual = fitted.residual_hu / fitted.signal_hu;
    if residual > MOST_RESIDUAL {
        return Err(Reason::Shape {
            residual,
            most: MOST_RESIDUAL,
        });
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use geometry::{Affine, VolumeGrid};
    use nalgebra::{Matrix3, Rotation3, Vector3};

    use super::*;

    fn fitted(covariance: Matrix3<f64>, metal_hu: f64, clipped: usize) -> Fitted {
        Fitted {
            centre: Vector3::zeros(),
            covariance,
            blur: Blur {
                radius_mm: 1.0,
                plane_mm: 0.6,
                axial_mm: 0.6,
                slice_mm: 0.0,
            },
            radius_deviation: 0.1,
            metal_deviation: 0.1,
            mass_deviation: 0.1,
            metal_hu,
            ground_hu: 300.0,
            residual_hu: 1.0,
            signal_hu: 900.0,
            clipped,
            unlikelihood: None,
        }
    }

    /// A knob of bone is refused by its centre's deviation in whatever direction of the slice it lies, along the normal, and by its
    /// metal on the field; a bead is not.
    #[test]
    fn what_is_not_held_as_metal_is_is_no_bead() {
        let rows = [[1.5, 0.0, 0.0, 0.0], [0.0, 1.5, 0.0, 0.0], [0.0, 0.0, 3.0, 0.0]];
        let grid = VolumeGrid::checked([9; 3], Affine::from_rows(rows)).unwrap();
        let (optics, search) = (Optics::of(&grid).unwrap(), Search::of_radius(1.0));
        let of = |across: f64, along: f64, metal: f64, clipped| {
            let flat = Matrix3::from_diagonal(&Vector3::new(across * across, 1e-4, along * along));
            let turn = Rotation3::from_axis_angle(&Vector3::z_axis(), 0.7);
            check_metal_and_centre(
                &fitted(turn * flat * turn.transpose(), metal, clipped),
                &search,
                &optics,
            )
        };
        assert!(of(0.09, 0.36, 6000.0, 0).is_ok());
        let wide = of(0.12, 0.03, 6000.0, 0).unwrap_err();
        let Reason::Unsure { share, most } = wide else {
            unreachable!("{wide}")
        };
        assert!((share[0] - 0.08).abs() < 1e-12 && (share[1] - 0.01).abs() < 1e-12 && most == MOST_UNSURE);
        assert!(wide.to_string().contains("8.0 and 1.0 % of a voxel"), "{wide}");
        assert!(matches!(of(0.03, 0.42, 6000.0, 0), Err(Reason::Unsure { .. })));
        assert!(matches!(of(f64::NAN, 0.1, 6000.0, 0), Err(Reason::Unsure { .. })));
        assert!(matches!(of(0.03, 0.1, 3500.0, 0), Err(Reason::NotMetal { .. })));
        // Of clipped ones only the flanks tell.
        assert!(of(0.12, 0.9, 6000.0, 40).is_ok());
        assert!(of(0.2, 0.1, 6000.0, 40).is_err());
    }
}
