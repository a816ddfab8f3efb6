//! The patient, region by region, in the order of painting.

mod bowel;
mod kidneys;
mod organs;
mod pelvis;
mod ribs;
mod spine;
mod vessels;
mod wall;

use crate::canvas::Canvas;
use crate::plan::Plan;

pub(crate) use vessels::{aorta_at, cava_at, iliac_artery};

/// HU of the fat inside the trunk.
pub(crate) const FAT_HU: f64 = -95.0;
/// HU of muscle.
const MUSCLE_HU: f64 = 52.0;
/// Cortical and cancellous bone.
const BONE_HU: [f64; 2] = [720.0, 210.0];
/// HU of gas in the bowel.
const GAS_HU: f64 = -900.0;

/// Paints the whole patient but the landmarks.
pub(crate) fn paint(plan: &Plan) -> Canvas {
    let mut canvas = Canvas::default();
    wall::paint(plan, &mut canvas);
    pelvis::paint(plan, &mut canvas);
    organs::paint(plan, &mut canvas);
    kidneys::paint(plan, &mut canvas);
    bowel::paint(plan, &mut canvas);
    wall::paint_back_muscles(plan, &mut canvas);
    spine::paint(plan, &mut canvas);
    ribs::paint(plan, &mut canvas);
    vessels::paint(plan, &mut canvas);
    canvas
}
