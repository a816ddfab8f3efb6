//! Screens as they are painted on the glass: the layout with made-up images, through the painter that needs no card.

use egui::epaint::ClippedShape;
use egui::{RawInput, Rect, vec2};

use crate::colours;
use crate::model::Model;
use crate::paint::{CpuPainter, Frame, Image, Painter as _, Pixels, Skipped};
use crate::screen::{Look, context, show};
use crate::sizes::Screen;

/// Side of the images, pixels.
const SIDE: u32 = 512;

/// A smooth image, another for each view: a bright body on black, so that letters stand on both.
fn image(view: usize) -> Vec<u8> {
    let middle = SIDE as i64 / 2 + 8 * (view as i64 % 4 - 2);
    let pixel = |i: u32| {
        let (x, y) = (i64::from(i % SIDE) - middle, i64::from(i / SIDE) - middle);
        let off = (x * x + 2 * y * y) / 96;
        let level = if off < 600 { 60 + (600 - off) / 5 } else { 0 };
        [level as u8, level as u8, level as u8, 255]
    };
    (0..SIDE * SIDE).flat_map(pixel).collect()
}

/// The pixels 0x00RRGGBB of a screen; `change` may do to its shapes what a mistake would.
pub(super) fn paint(
    model: &Model,
    screen: Screen,
    look: &Look,
    change: impl FnOnce(&mut Vec<ClippedShape>),
) -> Vec<u32> {
    let context = context();
    let [width, height] = screen.pixels.map(|n| n as f32);
    let input = RawInput {
        screen_rect: Some(Rect::from_min_size(egui::Pos2::ZERO, vec2(width, height))),
        ..RawInput::default()
    };
    let mut output = context.run_ui(input, |ui| drop(show(ui, model, screen, look)));
    change(&mut output.shapes);
    let shown = model.cells.iter().filter(|cell| cell.size.is_some());
    painted(&context, output, screen, shown.map(|cell| cell.view))
}

/// The pixels 0x00RRGGBB of what was laid out, with made-up images of these views.
pub(crate) fn painted(
    context: &egui::Context,
    mut output: egui::FullOutput,
    screen: Screen,
    views: impl Iterator<Item = usize>,
) -> Vec<u32> {
    let primitives = context.tessellate(std::mem::take(&mut output.shapes), output.pixels_per_point);
    let rgba: Vec<(usize, Vec<u8>)> = views.map(|view| (view, image(view))).collect();
    let images = rgba.iter().map(|(view, rgba)| Image {
        id: *view as u64,
        version: 1,
        size: [SIDE, SIDE],
        rgba,
    });
    let mut pixels = vec![0; (screen.pixels[0] * screen.pixels[1]) as usize];
    let frame = Frame {
        size: screen.pixels,
        pixels_per_point: output.pixels_per_point,
        clear: colours::GROUND,
        textures: &mut output.textures_delta,
        primitives: &primitives,
        images: &images.collect::<Vec<_>>(),
    };
    let target = Pixels {
        pixels: &mut pixels,
        age: 0,
    };
    let skipped = CpuPainter::new().paint(frame, target).unwrap().skipped;
    assert_eq!(skipped, Skipped::default());
    pixels
}
