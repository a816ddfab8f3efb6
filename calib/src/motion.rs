//! A motion while it goes on: what it covers, by the poses that a result would be made of.

use geometry::{Direction, Frame, Rigid};

use crate::coverage::seen::Seen;
use crate::pivot::{self, Pivot};
use crate::spin::{self, Limits, Spin};

/// A picture of a motion, and why nothing can be made of it where that is known.
#[derive(Debug, Clone, PartialEq)]
pub struct Motion<R> {
    /// The picture; where there is a reason, with nothing reached.
    pub seen: Seen,
    /// Why no result can be made of it though it is wide.
    pub refused: Option<R>,
}

/// A pivoting: `solve` makes its result of the same poses, and is asked once the motion is wide enough, as poses that slipped count for
/// nothing. `None` without poses.
pub fn pivoted<To: Frame, From: Frame>(
    poses: &[Rigid<To, From>],
    (shaft, needed_rad): (Direction<From>, f64),
    solve: impl FnOnce() -> Result<Pivot<To, From>, pivot::Refused>,
) -> Option<Motion<pivot::Refused>> {
    let seen = Seen::cone(poses.iter().map(Rigid::rotation), shaft, needed_rad)?;
    if seen.reached_rad < needed_rad {
        return Some(Motion { seen, refused: None });
    }
    Some(match solve() {
        Ok(found) => {
            let kept = kept(poses, &found.weights);
            Motion {
                seen: again(seen, Seen::cone(kept, shaft, needed_rad)),
                refused: None,
            }
        }
        Err(refused) => refuse(seen, refused),
    })
}

/// A spinning about the shaft, in the same way. `needed_rad` is twice the root mean square turn.
pub fn spun<To: Frame, From: Frame>(
    poses: &[Rigid<To, From>],
    (hint, needed_rad): (Direction<From>, f64),
    limits: Limits,
) -> Option<Motion<spin::Refused>> {
    let seen = Seen::spin(poses.iter().map(Rigid::rotation), hint, needed_rad)?;
    if seen.reached_rad < needed_rad {
        return Some(Motion { seen, refused: None });
    }
    Some(match spin::calibrate(poses, hint, limits) {
        Ok(Spin { weights, axis, .. }) => Motion {
            seen: again(seen, Seen::spin(kept(poses, &weights), axis, needed_rad)),
            refused: None,
        },
        Err(refused) => refuse(seen, refused),
    })
}

fn kept<'a, To: Frame, From: Frame>(
    poses: &'a [Rigid<To, From>],
    weights: &'a [f64],
) -> impl Iterator<Item = geometry::rotation::Rotation> + Clone + 'a {
    let counted = poses.iter().zip(weights).filter(|(_, weight)| **weight > 0.0);
    counted.map(|(pose, _)| pose.rotation())
}

/// What the poses that count cover; the handle is where the newest pose of all has it.
fn again(all: Seen, counted: Option<Seen>) -> Seen {
    counted.map_or(all.without_reach(), |counted| Seen {
        now_rad: all.now_rad,
        ..counted
    })
}

fn refuse<R>(seen: Seen, refused: R) -> Motion<R> {
    Motion {
        seen: seen.without_reach(),
        refused: Some(refused),
    }
}
