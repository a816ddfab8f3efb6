//! How large the image is and where it lies: the scale bar, the ruler along the left side, and the place of the slice in words.

use geometry::SlicePlane;
use picture::{Canvas, palette};

use super::Overlay;

/// From one tick of the ruler to the next: the smallest of these that has room, mm.
const TICKS_MM: [f64; 8] = [0.1, 0.5, 1.0, 5.0, 10.0, 50.0, 100.0, 500.0];
/// That room, and the length of a long tick, pixels of 512; a short one has half of it.
const TICK_ROOM: f64 = 8.0;
const LONG: f64 = 8.0;
/// Off an axis by less than this, a plane lies across it: its place is one number, the same to 0.1 mm all over an image of 2 m.
const ACROSS: f64 = 1e-9;

impl Overlay<'_> {
    /// The scale bar: its ends, and its length in mm; a round length, about a quarter of the width.
    pub(super) fn scale(&self) -> ([[f64; 2]; 2], f64) {
        let [width, height] = self.plane.size().map(f64::from);
        let mm = round_length(width * self.plane.pixel_mm() / 4.0);
        let (x0, y) = (14.0 * self.unit(), height - 16.0 * self.unit());
        ([[x0, y], [x0 + mm / self.plane.pixel_mm(), y]], mm)
    }

    pub(super) fn draw_scale(&self, canvas: &mut Canvas) {
        let ([from, to], _) = self.scale();
        let tick = 4.0 * self.unit();
        let line = self.line(palette::WORDS, 1.8, false);
        canvas.line(from, to, line);
        for [x, y] in [from, to] {
            canvas.line([x, y - tick], [x, y + tick], line);
        }
        self.draw_ruler(canvas);
    }

    /// The ruler's ticks: rows, and whether it is a long one. They count from the image's middle, which in local images is the tip.
    pub(super) fn ruler(&self) -> Vec<(f64, bool)> {
        let pixel_mm = self.plane.pixel_mm();
        let room = TICK_ROOM * self.unit();
        let Some(every) = TICKS_MM.into_iter().find(|mm| mm / pixel_mm >= room) else {
            return Vec::new();
        };
        let middle = (f64::from(self.plane.size()[1]) - 1.0) / 2.0;
        let most = (middle * pixel_mm / every).floor() as i32;
        // A long one at each 1, 10, 100 mm: two or ten of the short ones.
        let is_half = TICKS_MM
            .iter()
            .position(|mm| *mm == every)
            .is_some_and(|place| place % 2 == 1);
        let long = if is_half { 2 } else { 10 };
        let tick = |k: i32| (middle + f64::from(k) * every / pixel_mm, k % long == 0);
        (-most..=most).map(tick).collect()
    }

    /// Between the frame, which stays whole, and the words.
    pub(super) fn draw_ruler(&self, canvas: &mut Canvas) {
        // A line begins with half its width and its rim before its end.
        let start = self
            .frame()
            .map_or(0.0, |(_, width)| width + 2.0 * self.unit().max(1.0));
        let long = (LONG * self.unit()).min(self.beside_words() - start);
        if long < 1.0 {
            return;
        }
        let line = self.line(palette::WORDS, 1.0, false);
        let tick = |(row, is_long)| {
            let reach = if is_long { long } else { long / 2.0 };
            (vec![[start, row], [start + reach, row]], None)
        };
        let ticks: Vec<_> = self.ruler().into_iter().map(tick).collect();
        canvas.polylines(&ticks, line);
    }
}

/// Where a plane across one of the patient's axes lies, with the letter of the side: `z +12.5 mm S`. Nothing for an oblique one.
pub(super) fn place_words(plane: &SlicePlane) -> Option<String> {
    const AXES: [(&str, [&str; 2]); 3] = [("x", ["L", "R"]), ("y", ["P", "A"]), ("z", ["S", "I"])];
    let normal = plane.into_screen().components();
    let axis = (0..3).find(|&i| 1.0 - normal[i].abs() < ACROSS)?;
    let (name, [positive, negative]) = AXES[axis];
    // Rounded as it is written: -0.04 lies on neither side.
    let mm = (plane.origin().mm()[axis] * 10.0).round() / 10.0;
    Some(match mm {
        mm if mm > 0.0 => format!("{name} +{mm:.1} mm {positive}"),
        mm if mm < 0.0 => format!("{name} {mm:.1} mm {negative}"),
        _ => format!("{name} 0.0 mm"),
    })
}

/// The largest of 1, 2, 5 x 10^n mm up to `mm`.
pub(super) fn round_length(mm: f64) -> f64 {
    let power = 10_f64.powf(mm.log10().floor());
    let digit = mm / power;
    power
        * if digit >= 5.0 {
            5.0
        } else if digit >= 2.0 {
            2.0
        } else {
            1.0
        }
}
