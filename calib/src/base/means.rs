//! Whether features lie where their touches are, each as a whole: dirt, or a ball at the tip that nobody told of, moves all touches of one alike.

use geometry::Frame;
use geometry::motion::Pose;

use super::feature::OneSide;
use super::solve::HeldTouch;
use super::{Feature, Group, Refused};
use crate::registration::greatest_chi_squared;

/// Of the seven means of residuals, one of a plane and two of each groove, six go into the place, but for what the slopes of the grooves hold.
const MEANS_FREE: u32 = 2;
/// A base is made to its drawing to a deviation of so much, mm.
const MADE_MM: f64 = 0.05;

/// Refuses features whose touches lie to one side of them. The fit spreads what one is off over all of them, so that their means are judged together.
pub(super) fn even<F: Frame>(
    kept: &[Vec<HeldTouch>],
    (groups, assignment): (&[Group<F>], &[Feature]),
    pose: &Pose,
    sigma_mm: f64,
) -> Result<(), Refused> {
    let (mut sum, mut worst) = (0.0, None::<(f64, OneSide)>);
    for ((touches, group), feature) in kept.iter().zip(groups).zip(assignment) {
        let Some((off_mm, scatter_mm)) = one_side(touches, pose) else {
            continue;
        };
        let told = |touch: &HeldTouch| touch.noise.map_or(1.0, |c| c.trace() / 3.0);
        let told_mm = sigma_mm * (touches.iter().map(told).sum::<f64>() / touches.len() as f64).sqrt();
        // why: what touches share moves them all alike, and no number of them makes it less.
        let shared_mm = group.shared.iter().map(|u| u.norm()).fold(0.0, f64::max);
        // By their own scatter where that is more: it knows nothing of what moves them all.
        let own_mm = told_mm.max(scatter_mm) / (touches.len() as f64).sqrt();
        let squares = off_mm.powi(2) / (own_mm.powi(2) + shared_mm.powi(2) + MADE_MM.powi(2));
        sum += squares;
        if worst.is_none_or(|(most, _)| squares > most) {
            let (feature, touches) = (*feature, touches.len());
            worst = Some((
                squares,
                OneSide {
                    feature,
                    touches,
                    off_mm,
                },
            ));
        }
    }
    let allowed = greatest_chi_squared(MEANS_FREE);
    match worst {
        Some((_, worst)) if sum > allowed => Err(Refused::OneSide {
            worst,
            squares: sum,
            allowed,
        }),
        _ => Ok(()),
    }
}

/// How far the mean of a feature's touches lies off it, and how far they scatter about that mean along an axis, mm; `None` of fewer than two.
fn one_side(touches: &[HeldTouch], pose: &Pose) -> Option<(f64, f64)> {
    let r = pose.matrix();
    let residuals: Vec<[f64; 2]> = touches
        .iter()
        .map(|touch| {
            let off = touch.place - pose.shift - r * touch.hold.at;
            // The second axis of a plane does not count.
            std::array::from_fn(|k| touch.hold.axes().get(k).map_or(0.0, |e| (r * e).dot(&off)))
        })
        .collect();
    let (n, axes) = (residuals.len() as f64, touches.first()?.hold.count as f64);
    let mean: [f64; 2] = std::array::from_fn(|k| residuals.iter().map(|x| x[k]).sum::<f64>() / n);
    // What a groove's slope adds to the scatter makes the judgement milder, never stricter.
    let about = |x: &[f64; 2]| (x[0] - mean[0]).powi(2) + (x[1] - mean[1]).powi(2);
    let scatter = residuals.iter().map(about).sum::<f64>() / (axes * (n - 1.0));
    (n > 1.0).then(|| (mean[0].hypot(mean[1]), scatter.sqrt()))
}
