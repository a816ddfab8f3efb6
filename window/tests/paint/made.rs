//! Frames made by hand.

use std::sync::Arc;

use egui::epaint::textures::TexturesDelta;
use egui::epaint::{ClippedPrimitive, ColorImage, ImageData, ImageDelta, Mesh, Primitive, Vertex};
use egui::{Color32, Pos2, Rect, TextureId, TextureOptions, pos2};
use window::paint::{Area, CpuPainter, Frame, Image, Painter, Pixels, Skipped};

/// The texture of egui's own that all frames by hand have: white in its corner, a ramp of cover elsewhere.
pub(crate) const FONT: TextureId = TextureId::Managed(0);
/// Columns and rows of it.
pub(crate) const FONT_SIZE: [usize; 2] = [16, 16];

/// Pixels of [`FONT`].
pub(crate) fn font(seed: usize) -> ColorImage {
    let cover = |i: usize| {
        if i == 0 {
            255
        } else {
            ((i * 37 + seed * 11) % 256) as u8
        }
    };
    let pixels = (0..FONT_SIZE[0] * FONT_SIZE[1]).map(|i| Color32::from_white_alpha(cover(i)));
    ColorImage::new(FONT_SIZE, pixels.collect())
}

/// Sets a texture, or the part at `pos`.
pub(crate) fn set(id: TextureId, image: ColorImage, pos: Option<[usize; 2]>) -> TexturesDelta {
    let mut delta = TexturesDelta::default();
    let change = ImageDelta {
        image: ImageData::Color(Arc::new(image)),
        options: TextureOptions::LINEAR,
        pos,
    };
    delta.push(id, change);
    delta
}

pub(crate) fn vertex(x: f32, y: f32, color: Color32) -> Vertex {
    Vertex {
        pos: pos2(x, y),
        uv: Pos2::ZERO,
        color,
    }
}

/// Triangles without a texture, three corners each.
pub(crate) fn triangles(corners: &[(f32, f32, Color32)]) -> Mesh {
    let mut mesh = Mesh::with_texture(FONT);
    mesh.vertices = corners.iter().map(|(x, y, colour)| vertex(*x, *y, *colour)).collect();
    mesh.indices = (0..corners.len() as u32).collect();
    mesh
}

/// A rectangle of one colour.
pub(crate) fn fill(rect: Rect, colour: Color32) -> Mesh {
    let mut mesh = Mesh::with_texture(FONT);
    mesh.add_colored_rect(rect, colour);
    mesh
}

/// A rectangle with a texture.
pub(crate) fn picture(id: TextureId, rect: Rect, uv: Rect, tint: Color32) -> Mesh {
    let mut mesh = Mesh::with_texture(id);
    mesh.add_rect_with_uv(rect, uv, tint);
    mesh
}

pub(crate) fn rect(x0: f32, y0: f32, x1: f32, y1: f32) -> Rect {
    Rect::from_min_max(pos2(x0, y0), pos2(x1, y1))
}

/// All of a texture.
pub(crate) fn all() -> Rect {
    rect(0.0, 0.0, 1.0, 1.0)
}

pub(crate) fn clipped(mesh: Mesh, clip_rect: Rect) -> ClippedPrimitive {
    ClippedPrimitive {
        clip_rect,
        primitive: Primitive::Mesh(mesh),
    }
}

pub(crate) fn unclipped(mesh: Mesh) -> ClippedPrimitive {
    clipped(mesh, Rect::EVERYTHING)
}

/// A painter with a screen.
pub(crate) struct Hand {
    painter: CpuPainter,
    pub(crate) size: [u32; 2],
    pub(crate) pixels: Vec<u32>,
    pub(crate) clear: Color32,
}

impl Hand {
    /// With [`FONT`] set.
    pub(crate) fn new(size: [u32; 2]) -> Self {
        let mut hand = Self {
            painter: CpuPainter::new(),
            size,
            pixels: vec![0x00AB_CDEF; (size[0] * size[1]) as usize],
            clear: Color32::BLACK,
        };
        hand.paint(&mut set(FONT, font(0), None), &[], &[], 0);
        hand
    }

    pub(crate) fn paint(
        &mut self,
        textures: &mut TexturesDelta,
        primitives: &[ClippedPrimitive],
        images: &[Image<'_>],
        age: u8,
    ) -> (Vec<Area>, Skipped) {
        let frame = Frame {
            size: self.size,
            pixels_per_point: 1.0,
            clear: self.clear,
            textures,
            primitives,
            images,
        };
        let target = Pixels {
            pixels: &mut self.pixels,
            age,
        };
        let painted = self.painter.paint(frame, target).expect("memory of this size");
        (painted.damage.to_vec(), painted.skipped)
    }

    /// The whole frame, nothing of it skipped.
    pub(crate) fn show(&mut self, primitives: &[ClippedPrimitive], images: &[Image<'_>]) -> &[u32] {
        let (_, skipped) = self.paint(&mut TexturesDelta::default(), primitives, images, 0);
        assert_eq!(skipped, Skipped::default());
        &self.pixels
    }

    pub(crate) fn at(&self, x: u32, y: u32) -> u32 {
        self.pixels[(y * self.size[0] + x) as usize]
    }
}
