//! Floor 1: drawing lines, circles and text on an RGBA image, [`chart`]s of them, and writing it as a PNG that carries
//! its stamp.
//!
//! Lines are antialiased by the distance of pixels from them (`strokes`), other shapes by tiny-skia, text is the Hack typeface through ab_glyph; both are exact from run to run, so
//! that the same pose gives the same bytes.

mod animation;
pub mod base64;
mod canvas;
pub mod chart;
pub mod palette;
mod png_file;
mod strokes;
mod text;
pub mod vision;

pub use animation::{encode_animation, write_animation};
pub use canvas::{Canvas, DASHED, Dashes, Line};
pub use palette::Rgb;
pub use png_file::{PngError, encode_png, write_png};
pub use text::{Anchor, PixelBox, text_box, text_width};
