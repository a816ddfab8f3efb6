//! Screens of egui for tests and the benchmark: image cells with lines, circles and words, and rows of words below.

use egui::epaint::ClippedPrimitive;
use egui::epaint::textures::TexturesDelta;
use egui::{Align2, Color32, Context, FontId, RawInput, Rect, Stroke, StrokeKind, TextureId, pos2, vec2};
use window::paint::Image;

/// Image cells of a screen.
pub(crate) const CELLS: usize = 8;

/// Pixels of an image of `size`: waves and specks, so that neighbours differ by little and by much.
pub(crate) fn texels(size: [u32; 2], seed: u32) -> Vec<u8> {
    let pixel = |i: u32| {
        let (x, y) = (i % size[0], i / size[0]);
        let speck = i.wrapping_add(seed).wrapping_mul(0x9E37_79B9) >> 24;
        let wave = 127.0 + 120.0 * (f64::from(x + 3 * seed) * 0.05).sin() * (f64::from(y) * 0.07).cos();
        let level = if speck < 6 { 255 - wave as u8 } else { wave as u8 };
        [level, level.wrapping_add((seed * 9) as u8), speck as u8, 255]
    };
    (0..size[0] * size[1]).flat_map(pixel).collect()
}

/// A screen of egui that goes on from frame to frame.
pub(crate) struct Screen {
    context: Context,
    /// Columns and rows, pixels.
    pub(crate) size: [u32; 2],
    pub(crate) pixels_per_point: f32,
}

/// What egui made of a frame.
pub(crate) struct Made {
    pub(crate) textures: TexturesDelta,
    pub(crate) primitives: Vec<ClippedPrimitive>,
}

/// What is on the screen.
#[derive(Debug, Clone, Copy)]
pub(crate) struct Content {
    /// Turns the tool, changes the words.
    pub(crate) moment: u32,
    /// The tint of the images.
    pub(crate) tint: Color32,
}

impl Screen {
    pub(crate) fn new(size: [u32; 2], pixels_per_point: f32) -> Self {
        let context = Context::default();
        context.set_pixels_per_point(pixels_per_point);
        Self {
            context,
            size,
            pixels_per_point,
        }
    }

    /// The cells of the images, pixels: [left, top, side].
    pub(crate) fn cells(&self) -> [[u32; 3]; CELLS] {
        let side = (self.size[0] / 4).min((self.size[1] - self.size[1] / 9) / 2);
        let [column, row] = [side, side];
        std::array::from_fn(|i| [(i as u32 % 4) * column, (i as u32 / 4) * row, side])
    }

    /// One frame.
    pub(crate) fn make(&self, content: Content) -> Made {
        let points = |pixels: u32| pixels as f32 / self.pixels_per_point;
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(
                pos2(0.0, 0.0),
                vec2(points(self.size[0]), points(self.size[1])),
            )),
            ..RawInput::default()
        };
        let mut output = self.context.run_ui(input, |ui| {
            let painter = ui.ctx().layer_painter(egui::LayerId::background());
            let screen = painter.clip_rect();
            painter.rect_filled(screen, 0.0, Color32::from_rgb(18, 20, 24));
            for (i, [x, y, side]) in self.cells().into_iter().enumerate() {
                let cell = Rect::from_min_size(pos2(points(x), points(y)), vec2(points(side), points(side)));
                draw_cell(&painter.with_clip_rect(cell), cell, i, content);
            }
            let top = points(2 * self.cells()[0][2]);
            draw_words(&painter, Rect::from_min_max(pos2(0.0, top), screen.max), content);
        });
        Made {
            textures: std::mem::take(&mut output.textures_delta),
            primitives: self.context.tessellate(output.shapes, self.pixels_per_point),
        }
    }
}

fn draw_cell(painter: &egui::Painter, cell: Rect, i: usize, content: Content) {
    let uv = Rect::from_min_max(pos2(0.0, 0.0), pos2(1.0, 1.0));
    painter.image(TextureId::User(i as u64), cell, uv, content.tint);
    let middle = cell.center();
    let turn = content.moment as f32 * 0.02 + i as f32;
    let along = vec2(turn.cos(), turn.sin()) * cell.width() * 0.4;
    painter.line_segment(
        [middle, middle + along],
        Stroke::new(2.5, Color32::from_rgb(90, 200, 250)),
    );
    painter.circle_stroke(middle, 12.0, Stroke::new(1.5, Color32::YELLOW));
    painter.circle_filled(middle + along, 4.0, Color32::from_rgba_unmultiplied(255, 80, 60, 180));
    painter.rect_stroke(
        cell.shrink(2.0),
        4.0,
        Stroke::new(2.0, Color32::from_rgb(60, 160, 90)),
        StrokeKind::Inside,
    );
    let words = ["AXIAL", "FRONTAL", "SAGITTAL", "TUBE"];
    let font = FontId::proportional(15.0);
    let white = Color32::from_rgb(230, 230, 230);
    painter.text(
        cell.left_top() + vec2(10.0, 8.0),
        Align2::LEFT_TOP,
        words[i % 4],
        font.clone(),
        white,
    );
    let age = format!("{} ms  0.70 mm/px  W 400 L 40", 12 + (content.moment + i as u32) % 7);
    painter.text(
        cell.left_bottom() + vec2(10.0, -8.0),
        Align2::LEFT_BOTTOM,
        age,
        font,
        white,
    );
}

fn draw_words(painter: &egui::Painter, strip: Rect, content: Content) {
    let panel = strip.shrink(4.0);
    painter.rect(
        panel,
        6.0,
        Color32::from_rgb(32, 36, 42),
        Stroke::new(1.0, Color32::GRAY),
        StrokeKind::Inside,
    );
    let colour = Color32::from_rgb(200, 205, 210);
    let value = f64::from(content.moment) * 0.01;
    for column in 0..4 {
        for row in 0..3 {
            let at = panel.min + vec2(12.0 + panel.width() * 0.25 * column as f32, 8.0 + 22.0 * row as f32);
            let words = match (column, row) {
                (0, 0) => format!("target 1: {:.1} mm to go", 43.2 - value),
                _ => format!("registration 0.8 mm, tracker 60 Hz, row {row}.{column}"),
            };
            painter.text(at, Align2::LEFT_TOP, words, FontId::proportional(14.0), colour);
        }
    }
}

/// Images for all cells, of 512 x 512 pixels or as large as the cells.
pub(crate) fn lend<'a>(pixels: &'a [Vec<u8>], side: u32, version: u64) -> Vec<Image<'a>> {
    let image = |(i, rgba): (usize, &'a Vec<u8>)| Image {
        id: i as u64,
        version,
        size: [side, side],
        rgba,
    };
    pixels.iter().enumerate().map(image).collect()
}
