//! The colours of the screen: those of the images, with the same meanings.

use egui::Color32;
use picture::Rgb;

/// Behind everything.
pub const GROUND: Color32 = Color32::from_rgb(8, 10, 14);
/// Behind an image that there is not, and behind the sight.
pub const CELL: Color32 = Color32::from_rgb(14, 17, 22);
/// Lines between cells, rings of the sight.
pub const LINE: Color32 = Color32::from_rgb(88, 98, 112);
/// A button.
pub const BUTTON: Color32 = Color32::from_rgb(38, 46, 58);

/// A colour of the images.
pub const fn of(Rgb(r, g, b): Rgb) -> Color32 {
    Color32::from_rgb(r, g, b)
}
