//! An image where it stands on the screen: from points of the patient to places on the screen and back.

use egui::{Pos2, Rect, pos2};
use geometry::{Ct, Point, SlicePlane};

/// An image of a plane in a rectangle of the screen.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Placed {
    /// What it covers.
    pub(crate) rect: Rect,
    /// The plane of the image that is shown.
    pub(crate) plane: SlicePlane,
}

impl Placed {
    /// Screen pixels of a pixel of the image.
    fn scale(&self) -> f64 {
        f64::from(self.rect.width()) / f64::from(self.plane.size()[0])
    }

    /// Where a point is seen, and how far behind the plane it lies, mm.
    pub(crate) fn on_screen(&self, p: Point<Ct>) -> (Pos2, f64) {
        let at = self.plane.project(p);
        let scale = self.scale();
        // The middle of the first pixel is half a pixel from the border.
        let [x, y] = [at.x, at.y].map(|n| ((n + 0.5) * scale) as f32);
        (pos2(self.rect.left() + x, self.rect.top() + y), at.depth_mm)
    }

    /// The point of the plane under a place on the screen.
    pub(crate) fn in_patient(&self, at: Pos2) -> Point<Ct> {
        let scale = self.scale();
        let [x, y] = [at.x - self.rect.left(), at.y - self.rect.top()].map(|n| f64::from(n) / scale - 0.5);
        self.plane.point(x, y)
    }

    /// So many millimetres are so many pixels of the screen.
    pub(crate) fn px(&self, mm: f64) -> f32 {
        (mm / self.plane.pixel_mm() * self.scale()) as f32
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use egui::vec2;
    use geometry::Direction;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn what_is_under_the_pointer_is_seen_there(x in 100.0..580.0_f32, y in 50.0..530.0_f32, side in 200.0..1000.0_f32) {
            let centre = Point::new(10.0, -20.0, 30.0);
            let plane = SlicePlane::centred(centre, [Direction::Y, -Direction::Z], 0.4, [512, 512]).unwrap();
            let placed = Placed { rect: Rect::from_min_size(pos2(100.0, 50.0), vec2(side, side)), plane };
            let p = placed.in_patient(pos2(x, y));
            let (at, depth_mm) = placed.on_screen(p);
            // Places on the screen have 24 bits.
            prop_assert!((at - pos2(x, y)).length() < 1e-3 && depth_mm.abs() < 1e-12);
            // The middle of the image is the middle of its rectangle.
            let (middle, _) = placed.on_screen(centre);
            prop_assert!((middle - placed.rect.center()).length() < 1e-3);
            prop_assert!((placed.px(0.4 * 512.0) - side).abs() < 1e-2);
        }
    }
}
