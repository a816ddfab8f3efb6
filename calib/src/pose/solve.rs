//! Emitters seen to a pose, or the reason why there is none.

use geometry::{Frame, Point};

use super::cloud::Cloud;
use super::{Body, Gates, Localizer, Lost, Pose, Sighting};

/// The pose of greatest likelihood of `body`, whose tip (the point that counts) is `tip` in its frame.
///
/// Of an emitter seen twice the first sighting counts. More than [`super::MAX_EMITTERS`] sightings are not looked at.
///
/// # Errors
/// Each variant of [`Lost`].
pub fn solve<F: Frame>(
    body: &Body<F>,
    tip: Point<F>,
    seen: &[Sighting],
    localizer: &Localizer,
    gates: &Gates,
) -> Result<Pose<F>, Lost> {
    let mut cloud = Cloud::collect(body, seen)?;
    // Two points leave the turn about their line free, whatever a gate says.
    let needed = gates.min_emitters.max(3);
    let all = cloud.count;
    loop {
        if cloud.count < needed {
            // What was left out was seen: then it is the residual that is wrong, and not the number.
            let too_few = Lost::TooFew {
                seen: cloud.count,
                needed,
            };
            return Err(match (all, cloud.last_residual) {
                (0, _) => Lost::NotSeen,
                (_, Some(residual)) if all >= needed => residual,
                _ => too_few,
            });
        }
        // Solved anew after each one left out: a gross error pulls the pose and with it the residuals of good emitters.
        let solved = cloud.solve(localizer).ok_or(Lost::Geometry {
            tip_95_mm: f64::INFINITY,
            allowed_mm: gates.max_tip_mm,
        })?;
        match cloud.worst(&solved, gates) {
            // Half of the emitters may not outvote the other half.
            Some((index, residual)) if 2 * (all - cloud.count + 1) < all => {
                cloud.last_residual = Some(residual);
                cloud.leave_out(index);
            }
            Some((_, residual)) => return Err(residual),
            None => return cloud.accept(&solved, all, tip, gates),
        }
    }
}
