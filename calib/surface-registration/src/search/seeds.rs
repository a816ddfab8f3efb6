//! Where fits begin.

use chance::Chance;
use nalgebra::{Matrix6, Vector3, Vector6};

use super::Effort;
use super::pairs::Pairs;
use crate::solve::{State, turned};

/// Poses to begin with.
pub(crate) enum Seeds<'a> {
    /// In a ball about a pose: turned by up to `turn_rad` about the points' centre, and shifted by up to `shift_mm`.
    Around { pose: State, turn_rad: f64, shift_mm: f64 },
    /// Normal about a pose, `factor` times its transpose being the covariance of turn and shift in place.
    Normal { pose: State, factor: Box<Matrix6<f64>> },
    /// Wherever two points may lie.
    Anywhere(Pairs<'a>),
}

impl Seeds<'_> {
    pub(super) fn each(&self, effort: &Effort, take: &mut dyn FnMut(State)) {
        match self {
            Self::Around {
                pose,
                turn_rad,
                shift_mm,
            } => {
                // What was told first: where it is right, no other seed is nearer.
                take(*pose);
                for i in 1..effort.seeds {
                    let chance = Chance::new(effort.seed, i as u64);
                    let w = in_ball(chance, 0) * *turn_rad;
                    let v = in_ball(chance, 10) * *shift_mm;
                    take(moved(pose, &w, &v));
                }
            }
            Self::Normal { pose, factor } => {
                take(*pose);
                for i in 1..effort.seeds {
                    let chance = Chance::new(effort.seed, i as u64);
                    let step = **factor * Vector6::from_fn(|k, _| chance.normal(k as u64));
                    let (w, v) = (
                        step.fixed_rows::<3>(0).into_owned(),
                        step.fixed_rows::<3>(3).into_owned(),
                    );
                    take(moved(pose, &w, &v));
                }
            }
            Self::Anywhere(pairs) => pairs.each(effort, take),
        }
    }
}

fn moved(pose: &State, w: &Vector3<f64>, v: &Vector3<f64>) -> State {
    State {
        turn: turned(w) * pose.turn,
        shift: pose.shift + v,
        ..*pose
    }
}

/// Even in the ball of radius 1, from the draws `first` to `first + 4`.
fn in_ball(chance: Chance, first: u64) -> Vector3<f64> {
    // The direction of normal numbers is even on the sphere; the cube root makes the radius even in volume.
    let way = Vector3::from_fn(|k, _| chance.normal(first + k as u64));
    let radius = chance.uniform(2 * first + 8).cbrt();
    way.try_normalize(1e-12).unwrap_or_else(Vector3::x) * radius
}
