//! Painting a frame of egui: what goes in, what comes out, and the painter that needs no card.
//!
//! [`Painter`] is the door, so that another painter can stand beside [`CpuPainter`]. Sampling follows what egui's painter for
//! OpenGL does: a pixel is inside a triangle where its centre is, colours are premultiplied and blended as they are stored
//! (gamma space), textures are interpolated between the centres of their texels and clamped at their edges.
//!
//! The CPU painter: `cut` turns meshes into rectangles, images, glyphs and small groups of triangles; `tiles` finds what
//! of the screen differs from the last frame; each kind has a file that paints it.

mod area;
mod blend;
mod cpu;
mod cut;
mod image;
mod item;
mod map;
mod quad;
mod rectangle;
mod shot;
mod texture;
mod tiles;
mod triangle;

use egui::epaint::textures::TexturesDelta;
use egui::epaint::{ClippedPrimitive, Color32};

pub use area::Area;
pub use cpu::CpuPainter;
pub use shot::canvas;

/// Puts frames on a screen.
pub trait Painter {
    /// Where the pixels go: memory for [`CpuPainter`], a surface of a card for another.
    type Target<'t>;

    /// Paints one frame. Textures that it sets are applied before, those that it frees after painting, also where painting
    /// fails.
    ///
    /// # Errors
    /// [`PaintError`]; nothing was painted then.
    fn paint(&mut self, frame: Frame<'_>, target: Self::Target<'_>) -> Result<Painted<'_>, PaintError>;
}

/// One frame, as egui hands it over.
#[derive(Debug)]
pub struct Frame<'a> {
    /// Columns and rows of the screen, pixels.
    pub size: [u32; 2],
    /// Pixels in a point, egui's unit.
    pub pixels_per_point: f32,
    /// What lies under everything; its alpha does not count.
    pub clear: Color32,
    /// `FullOutput::textures_delta`; empty afterwards.
    pub textures: &'a mut TexturesDelta,
    /// What `Context::tessellate` gave, the lowest first.
    pub primitives: &'a [ClippedPrimitive],
    /// Images that meshes name as `TextureId::User(id)`.
    pub images: &'a [Image<'a>],
}

/// Pixels of somebody else, lent for one frame.
#[derive(Debug, Clone, Copy)]
pub struct Image<'a> {
    /// The number in `TextureId::User`.
    pub id: u64,
    /// Another number whenever the pixels are others: the painter does not look for changes itself.
    pub version: u64,
    /// Columns and rows.
    pub size: [u32; 2],
    /// RGBA, row by row from the top, 4 x columns x rows bytes. Taken as opaque: A is not read.
    pub rgba: &'a [u8],
}

/// Memory to paint into.
#[derive(Debug)]
pub struct Pixels<'a> {
    /// 0x00RRGGBB, row by row from the top, columns x rows of the frame.
    pub pixels: &'a mut [u32],
    /// How many frames ago this memory was painted last, as softbuffer counts: 1 if it holds the frame before this one, 0 if
    /// nobody knows what it holds.
    pub age: u8,
}

/// What a frame changed.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub struct Painted<'a> {
    /// Where the screen may differ from the frame before; disjoint.
    pub damage: &'a [Area],
    /// What could not be painted.
    pub skipped: Skipped,
}

/// Counts of what a frame asked for and did not get. Nothing is painted in its place.
#[derive(Debug, Clone, Copy, Default, PartialEq, Eq)]
pub struct Skipped {
    /// Triangles with an index beyond the vertices, or with numbers that are not finite or too large.
    pub triangles: u32,
    /// Meshes with a texture that nobody set, or an image of another length than it says.
    pub textures: u32,
    /// Callbacks, which only a card could run.
    pub callbacks: u32,
}

/// Why a frame was not painted.
#[derive(Debug, Clone, Copy, PartialEq, Eq, thiserror::Error)]
pub enum PaintError {
    /// The memory is not that of a screen of this size.
    #[error("a frame of {columns} x {rows} pixels was to be painted into memory of {found} pixels")]
    Size {
        /// Of the frame.
        columns: u32,
        /// Of the frame.
        rows: u32,
        /// Pixels of the memory.
        found: usize,
    },
}
