//! Whole screens of egui against the reference.

use egui::Color32;
use window::paint::{CpuPainter, Frame, Painter, Pixels, Skipped};

use crate::reference::{Reference, difference};
use crate::screens::{CELLS, Content, Screen, lend, texels};

/// Both round after each layer, at most half a level apart in what they round; a layer that covers in part leaves part of
/// what was there. Two levels are kept where no more than a few layers of half cover lie on one another, as here.
const BOUND: f64 = 2.0;

const CLEAR: Color32 = Color32::from_rgb(10, 0, 30);

/// The largest difference of a screen's first frames, painted one after the other with what changed.
fn worst(size: [u32; 2], pixels_per_point: f32, side: u32, tint: Color32) -> f64 {
    let screen = Screen::new(size, pixels_per_point);
    let pixels: Vec<Vec<u8>> = (0..CELLS as u32).map(|i| texels([side, side], i)).collect();
    let (mut painter, mut reference) = (CpuPainter::new(), Reference::default());
    let mut memory = vec![0; (size[0] * size[1]) as usize];
    let mut worst = 0.0_f64;
    for moment in 0..3 {
        let mut made = screen.make(Content { moment, tint });
        let images = lend(&pixels, side, 1);
        reference.set(&made.textures);
        images.iter().for_each(|image| reference.lend(image));
        let frame = Frame {
            size,
            pixels_per_point,
            clear: CLEAR,
            textures: &mut made.textures,
            primitives: &made.primitives,
            images: &images,
        };
        let target = Pixels {
            pixels: &mut memory,
            age: u8::from(moment > 0),
        };
        let painted = painter.paint(frame, target).expect("memory of this size");
        assert_eq!(painted.skipped, Skipped::default());
        let exact = reference.paint(size, pixels_per_point, CLEAR, &made.primitives);
        worst = worst.max(difference(&memory, &exact));
    }
    worst
}

#[test]
fn a_screen_is_that_of_the_reference() {
    // Images made smaller and larger, at one to one, dimmed, on screens of other densities.
    for (size, pixels_per_point, side, tint) in [
        ([640, 400], 1.0, 200, Color32::WHITE),
        ([640, 400], 1.0, 160, Color32::WHITE),
        ([640, 400], 1.0, 90, Color32::from_gray(140)),
        ([640, 400], 1.5, 177, Color32::from_rgb(255, 180, 90)),
        ([641, 403], 1.25, 64, Color32::from_white_alpha(150)),
    ] {
        let worst = worst(size, pixels_per_point, side, tint);
        assert!(
            worst <= BOUND,
            "{worst} levels: {size:?} {pixels_per_point} {side} {tint:?}"
        );
    }
}

#[test]
fn the_reference_and_the_painter_are_told_apart() {
    // Another screen differs, so that the comparison above can fail.
    let screen = Screen::new([320, 200], 1.0);
    let pixels: Vec<Vec<u8>> = (0..CELLS as u32).map(|i| texels([80, 80], i)).collect();
    let mut made = screen.make(Content {
        moment: 0,
        tint: Color32::WHITE,
    });
    let mut reference = Reference::default();
    reference.set(&made.textures);
    made.textures.clear();
    lend(&pixels, 80, 1).iter().for_each(|image| reference.lend(image));
    let exact = reference.paint([320, 200], 1.0, CLEAR, &made.primitives);
    assert!(difference(&vec![0; 320 * 200], &exact) > 100.0);
}

#[test]
fn the_same_frames_give_the_same_bytes() {
    let bytes = || {
        let size = [400, 300];
        let screen = Screen::new(size, 1.0);
        let pixels: Vec<Vec<u8>> = (0..CELLS as u32).map(|i| texels([64, 64], i)).collect();
        let mut painter = CpuPainter::new();
        let mut memory = vec![0; 400 * 300];
        for moment in 0..2 {
            let mut made = screen.make(Content {
                moment,
                tint: Color32::WHITE,
            });
            let frame = Frame {
                size,
                pixels_per_point: 1.0,
                clear: CLEAR,
                textures: &mut made.textures,
                primitives: &made.primitives,
                images: &lend(&pixels, 64, 1),
            };
            let target = Pixels {
                pixels: &mut memory,
                age: 0,
            };
            painter.paint(frame, target).expect("memory of this size");
        }
        picture::encode_png(&window::paint::canvas(&memory, size), &[]).expect("a usual image")
    };
    assert!(bytes() == bytes());
}
