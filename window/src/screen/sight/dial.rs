//! Where the sight's drawing lies on the screen, for whoever reads it back off the pixels.

use egui::Rect;

use super::{rim, rooms, thin};
use crate::sizes::Sizes;

/// The sight's drawing, pixels.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Dial {
    /// What it lies in; its middle is the tool's axis.
    pub room: Rect,
    /// From the middle to the rim.
    pub rim_px: f64,
    /// The bar of the way to go.
    pub bar: Rect,
    /// Which part of the bar's height is below its zero.
    pub below_zero: f64,
    /// Half of the white line at zero, which lies over the bar.
    pub hidden_px: f64,
    /// Radius of the dot in the target's middle.
    pub dot_px: f64,
    /// The band of the verdict.
    pub verdict: Rect,
}

impl Dial {
    /// That of a screen.
    pub fn of(sizes: &Sizes) -> Self {
        let rooms = rooms(sizes.cells[sizes.sight], sizes);
        Self {
            room: rooms.sight,
            rim_px: rim(rooms.sight),
            bar: rooms.bar,
            below_zero: super::readout::BELOW_ZERO,
            hidden_px: f64::from(1.5 * sizes.line),
            dot_px: f64::from(3.0 * thin(rooms.sight, sizes)),
            verdict: rooms.verdict,
        }
    }
}
