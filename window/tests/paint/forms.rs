//! What has a closed form.

use egui::epaint::textures::TexturesDelta;
use egui::{Color32, TextureId};
use window::paint::Image;

use crate::made::{FONT, FONT_SIZE, Hand, all, clipped, fill, font, picture, rect, set, triangles, unclipped};
use crate::reference::{Reference, difference};
use crate::screens::texels;

const RED: Color32 = Color32::from_rgb(200, 10, 20);

fn image(id: u64, size: [u32; 2], rgba: &[u8]) -> Image<'_> {
    Image {
        id,
        version: 0,
        size,
        rgba,
    }
}

#[test]
fn a_fill_has_the_pixels_whose_centres_it_holds() {
    let mut hand = Hand::new([70, 50]);
    // The centre of column 10 is at 10.5, on the left side: inside. That of 40 is on the right side: outside.
    hand.show(&[unclipped(fill(rect(10.5, 3.2, 40.5, 9.7), RED))], &[]);
    for y in 0..50 {
        for x in 0..70 {
            let inside = (10..40).contains(&x) && (3..10).contains(&y);
            assert_eq!(hand.at(x, y), if inside { 0x00C8_0A14 } else { 0 }, "{x} {y}");
        }
    }
}

#[test]
fn a_clip_is_rounded_to_pixels() {
    let mut hand = Hand::new([70, 50]);
    let everywhere = fill(rect(-1e7, -1e7, 1e7, 1e7), RED);
    hand.show(&[clipped(everywhere, rect(9.6, 4.4, 30.4, 8.5))], &[]);
    for y in 0..50 {
        for x in 0..70 {
            let inside = (10..30).contains(&x) && (4..9).contains(&y);
            assert_eq!(hand.at(x, y) != 0, inside, "{x} {y}");
        }
    }
}

#[test]
fn half_over_a_colour_is_the_mean_and_light_is_cut_at_white() {
    let mut hand = Hand::new([8, 8]);
    hand.clear = Color32::from_rgb(100, 200, 50);
    let glass = Color32::from_rgba_premultiplied(60, 0, 30, 128);
    let light = Color32::from_rgb_additive(0, 100, 7);
    let shapes = [
        fill(rect(0.0, 0.0, 8.0, 4.0), glass),
        fill(rect(0.0, 4.0, 8.0, 8.0), light),
    ];
    hand.show(&shapes.map(unclipped), &[]);
    let level = |source: f64, below: f64| (source + below * (127.0 / 255.0)).round() as u32;
    let glass = (level(60.0, 100.0) << 16) | (level(0.0, 200.0) << 8) | level(30.0, 50.0);
    assert_eq!(hand.at(3, 2), glass);
    assert_eq!(hand.at(3, 6), (100 << 16) | (255 << 8) | 57);
}

#[test]
fn an_image_at_one_to_one_is_copied() {
    let size = [40, 30];
    let pixels = texels(size, 3);
    let mut hand = Hand::new([64, 64]);
    let mesh = picture(TextureId::User(5), rect(7.0, 9.0, 47.0, 39.0), all(), Color32::WHITE);
    hand.show(&[unclipped(mesh)], &[image(5, size, &pixels)]);
    for y in 0..30 {
        for x in 0..40 {
            let at = 4 * (y * 40 + x) as usize;
            let [r, g, b] = [pixels[at], pixels[at + 1], pixels[at + 2]];
            assert_eq!(hand.at(x + 7, y + 9), u32::from_be_bytes([0, r, g, b]), "{x} {y}");
        }
    }
    assert_eq!(
        (hand.at(6, 20), hand.at(47, 20), hand.at(20, 8), hand.at(20, 39)),
        (0, 0, 0, 0)
    );
}

#[test]
fn an_image_of_another_size_is_within_a_level_of_exact_interpolation() {
    // The bound is derived where images are painted: less than 1.02 before rounding, so one level after it.
    let tints = [Color32::WHITE, Color32::from_gray(90), Color32::from_rgb(255, 128, 3)];
    for (size, tint) in [[64, 48], [50, 50], [3, 2], [2, 9], [1, 7], [200, 300]]
        .into_iter()
        .zip(tints.iter().cycle())
    {
        let pixels = texels(size, 8);
        let mut reference = Reference::default();
        reference.lend(&image(1, size, &pixels));
        for uv in [all(), rect(1.0, 1.0, 0.0, 0.0), rect(0.2, 0.1, 0.7, 1.4)] {
            let mut hand = Hand::new([90, 80]);
            let primitives = [unclipped(picture(
                TextureId::User(1),
                rect(3.25, 2.0, 81.5, 78.0),
                uv,
                *tint,
            ))];
            hand.show(&primitives, &[image(1, size, &pixels)]);
            let exact = reference.paint(hand.size, 1.0, Color32::BLACK, &primitives);
            let worst = difference(&hand.pixels, &exact);
            assert!(worst <= 1.0, "{worst} levels: {size:?} {uv:?} {tint:?}");
        }
    }
}

#[test]
fn two_triangles_of_glass_are_blended_once_everywhere() {
    // Not a rectangle for the painter: the sides lean. The corners lie on pixel centres, where sides are shared exactly.
    let glass = Color32::from_rgba_premultiplied(40, 40, 40, 100);
    let (a, b, c, d) = (
        (4.5, 2.5, glass),
        (60.5, 6.5, glass),
        (58.5, 50.5, glass),
        (2.5, 44.5, glass),
    );
    let once = u32::from_be_bytes([0, 40, 40, 40]);
    for split in [[a, b, c, a, c, d], [a, b, d, b, c, d], [c, b, a, d, a, c]] {
        let mut hand = Hand::new([64, 64]);
        hand.show(&[unclipped(triangles(&split))], &[]);
        let inside = |x: u32, y: u32| (5..57).contains(&x) && (7..44).contains(&y);
        for y in 0..64 {
            for x in 0..64 {
                let pixel = hand.at(x, y);
                assert!(pixel == once || (pixel == 0 && !inside(x, y)), "{x} {y}: {pixel:06x}");
            }
        }
    }
}

#[test]
fn a_fan_is_its_disc() {
    let [cx, cy, radius] = [50.3_f32, 47.8, 40.0];
    let around = |i: u32| {
        let angle = std::f32::consts::TAU * i as f32 / 96.0;
        (cx + radius * angle.cos(), cy + radius * angle.sin(), RED)
    };
    let fan: Vec<_> = (0..96)
        .flat_map(|i| [(cx, cy, RED), around(i), around(i + 1)])
        .collect();
    let mut hand = Hand::new([100, 100]);
    hand.show(&[unclipped(triangles(&fan))], &[]);
    // The sagitta of 96 sides is 40 (1 - cos(pi / 96)) = 0.02 pixel, the grid moves corners by 0.003 at most.
    let slack = 0.03;
    for y in 0..100 {
        for x in 0..100 {
            let away = f64::from((x as f32 + 0.5 - cx).hypot(y as f32 + 0.5 - cy)) - f64::from(radius);
            let expected = if away < 0.0 { 0x00C8_0A14 } else { 0 };
            assert!(away.abs() < slack || hand.at(x, y) == expected, "{x} {y}: {away}");
        }
    }
}

#[test]
fn a_colour_goes_evenly_from_corner_to_corner() {
    let (black, white) = (Color32::BLACK, Color32::WHITE);
    let corners = [(0.0, 0.0, black), (256.0, 0.0, white), (0.0, 64.0, black)];
    let mut hand = Hand::new([256, 64]);
    hand.show(&[unclipped(triangles(&corners))], &[]);
    for x in 0..252 {
        let exact = ((f64::from(x) + 0.5) * 255.0 / 256.0).round() as u32;
        assert_eq!(hand.at(x, 0) & 0xFF, exact, "{x}");
    }
}

#[test]
fn a_part_of_a_texture_is_replaced_and_no_more() {
    let mut hand = Hand::new([16, 16]);
    let glyphs = [unclipped(picture(
        FONT,
        rect(0.0, 0.0, 16.0, 16.0),
        all(),
        Color32::WHITE,
    ))];
    hand.show(&glyphs, &[]);
    let before = hand.pixels.clone();
    let patch = egui::ColorImage::new([3, 2], vec![Color32::from_white_alpha(77); 6]);
    // Also one that hangs over the border, and one of a texture that nobody set.
    hand.paint(&mut set(FONT, patch.clone(), Some([4, 5])), &glyphs, &[], 1);
    hand.paint(&mut set(FONT, patch.clone(), Some([15, 15])), &glyphs, &[], 1);
    hand.paint(&mut set(TextureId::Managed(9), patch, Some([0, 0])), &glyphs, &[], 1);
    for y in 0..16 {
        for x in 0..16 {
            let is_patched = ((4..7).contains(&x) && (5..7).contains(&y)) || (x, y) == (15, 15);
            let expected = if is_patched {
                77 * 0x0001_0101
            } else {
                before[(y * 16 + x) as usize]
            };
            assert_eq!(hand.at(x, y), expected, "{x} {y}");
        }
    }
}

#[test]
fn glyphs_and_turned_pictures_are_those_of_the_reference() {
    let mut reference = Reference::default();
    let mut delta = set(FONT, font(0), None);
    reference.set(&delta);
    delta.clear();
    let [w, h] = FONT_SIZE.map(|n| n as f32);
    let colour = Color32::from_rgba_premultiplied(90, 30, 120, 140);
    let exact = picture(FONT, rect(5.0, 6.0, 5.0 + w, 6.0 + h), all(), colour);
    let scaled = picture(FONT, rect(30.2, 3.0, 59.9, 30.7), rect(0.1, 0.2, 0.8, 0.9), colour);
    let mut turned = picture(FONT, rect(10.0, 30.0, 40.0, 60.0), all(), colour);
    turned.rotate(egui::emath::Rot2::from_angle(0.4), egui::pos2(25.0, 45.0));
    let primitives = [exact, scaled, turned].map(unclipped);
    let mut hand = Hand::new([64, 64]);
    hand.clear = Color32::from_rgb(20, 120, 60);
    hand.paint(&mut TexturesDelta::default(), &primitives, &[], 0);
    let worst = difference(&hand.pixels, &reference.paint(hand.size, 1.0, hand.clear, &primitives));
    // A level each for two layers, each of a texel, a product and a sum that are rounded on their own.
    assert!(worst <= 2.0, "{worst} levels");
}
