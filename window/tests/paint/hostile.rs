//! Numbers that no tessellator should give.

use egui::epaint::textures::TexturesDelta;
use egui::epaint::{ColorImage, Mesh};
use egui::{Color32, Rect, TextureId, pos2};
use proptest::prelude::*;
use window::paint::{CpuPainter, Frame, Image, PaintError, Painter, Pixels, Skipped};

use crate::made::{FONT, Hand, all, clipped, fill, picture, rect, set, triangles, unclipped, vertex};

const RED: Color32 = Color32::RED;

fn skipped(hand: &mut Hand, mesh: Mesh) -> Skipped {
    let (_, skipped) = hand.paint(&mut TexturesDelta::default(), &[unclipped(mesh)], &[], 0);
    assert!(hand.pixels.iter().all(|pixel| *pixel == 0), "something was painted");
    skipped
}

#[test]
fn what_cannot_be_painted_is_counted_and_not_painted() {
    let mut hand = Hand::new([40, 40]);
    let triangles_of = |count| Skipped {
        triangles: count,
        ..Skipped::default()
    };
    for bad in [f32::NAN, f32::INFINITY, f32::NEG_INFINITY, 1e30] {
        let mesh = triangles(&[(0.0, 0.0, RED), (bad, 9.0, RED), (3.0, 30.0, RED)]);
        assert_eq!(skipped(&mut hand, mesh), triangles_of(1), "{bad}");
        let mut mesh = picture(FONT, rect(1.0, 1.0, 9.0, 9.0), all(), RED);
        mesh.vertices[3].uv.x = bad;
        mesh.vertices[1].uv.x = bad;
        assert_eq!(skipped(&mut hand, mesh), triangles_of(2), "{bad}");
    }
    let infinite = fill(rect(f32::NEG_INFINITY, 0.0, f32::INFINITY, 9.0), RED);
    assert_eq!(skipped(&mut hand, infinite), triangles_of(2));
    let mut mesh = fill(rect(1.0, 1.0, 9.0, 9.0), RED);
    mesh.indices = vec![0, 1, 4, 2, u32::MAX, 3, 1];
    assert_eq!(skipped(&mut hand, mesh), triangles_of(2));
    let unknown = picture(TextureId::User(3), rect(1.0, 1.0, 9.0, 9.0), all(), RED);
    assert_eq!(skipped(&mut hand, unknown).textures, 1);
}

#[test]
fn images_that_are_not_what_they_say_are_counted() {
    let mut hand = Hand::new([40, 40]);
    let mesh = || unclipped(picture(TextureId::User(3), rect(1.0, 1.0, 9.0, 9.0), all(), RED));
    for (size, bytes) in [([4, 4], 63), ([4, 4], 68), ([0, 4], 0), ([u32::MAX, u32::MAX], 4)] {
        let image = Image {
            id: 3,
            version: 0,
            size,
            rgba: &vec![9; bytes],
        };
        let (_, skipped) = hand.paint(&mut TexturesDelta::default(), &[mesh()], &[image], 0);
        assert_eq!((skipped.textures, hand.at(5, 5)), (1, 0), "{size:?}");
    }
    let empty = ColorImage::new([0, 0], Vec::new());
    let mesh = unclipped(picture(TextureId::Managed(4), rect(1.0, 1.0, 9.0, 9.0), all(), RED));
    let (_, skipped) = hand.paint(&mut set(TextureId::Managed(4), empty, None), &[mesh], &[], 0);
    assert_eq!((skipped.textures, hand.at(5, 5)), (1, 0));
}

#[test]
fn a_clip_outside_or_inside_out_shows_nothing() {
    let mut hand = Hand::new([40, 40]);
    let mesh = fill(rect(0.0, 0.0, 40.0, 40.0), RED);
    let nan = Rect::from_min_max(pos2(f32::NAN, 0.0), pos2(f32::NAN, 9.0));
    for clip in [
        rect(50.0, 0.0, 90.0, 40.0),
        rect(-9.0, -9.0, -1.0, 90.0),
        Rect::NOTHING,
        nan,
    ] {
        hand.show(&[clipped(mesh.clone(), clip)], &[]);
        assert!(hand.pixels.iter().all(|pixel| *pixel == 0), "{clip:?}");
    }
}

#[test]
fn memory_of_another_size_is_refused() {
    let mut delta = TexturesDelta::default();
    let frame = Frame {
        size: [4, 4],
        pixels_per_point: 1.0,
        clear: RED,
        textures: &mut delta,
        primitives: &[],
        images: &[],
    };
    let mut pixels = [7; 15];
    let target = Pixels {
        pixels: &mut pixels,
        age: 0,
    };
    let refused = CpuPainter::new().paint(frame, target).unwrap_err();
    let expected = PaintError::Size {
        columns: 4,
        rows: 4,
        found: 15,
    };
    assert_eq!((refused, pixels), (expected, [7; 15]));
}

fn wild() -> impl Strategy<Value = f32> {
    prop_oneof![
        4 => -20.0_f32..60.0,
        1 => any::<f32>(),
        1 => prop_oneof![Just(f32::NAN), Just(f32::INFINITY), Just(-0.0), Just(524_288.0), Just(1e7), Just(1e-40)],
    ]
}

proptest! {
    #[test]
    fn no_numbers_make_it_panic(
        corners in prop::collection::vec((wild(), wild(), wild(), wild(), any::<[u8; 4]>()), 0..12),
        indices in prop::collection::vec(0_u32..14, 0..40),
        clip in prop::array::uniform4(wild()),
        density in wild(),
        user in any::<bool>(),
    ) {
        let mut mesh = Mesh::with_texture(if user { TextureId::User(1) } else { FONT });
        for (x, y, u, v, [r, g, b, a]) in corners {
            let mut corner = vertex(x, y, Color32::from_rgba_premultiplied(r, g, b, a));
            corner.uv = pos2(u, v);
            mesh.vertices.push(corner);
        }
        mesh.indices = indices;
        let rgba = vec![100; 4 * 35];
        let mut delta = set(FONT, crate::made::font(0), None);
        let frame = Frame {
            size: [37, 41],
            pixels_per_point: density,
            clear: Color32::BLACK,
            textures: &mut delta,
            primitives: &[clipped(mesh, rect(clip[0], clip[1], clip[2], clip[3]))],
            images: &[Image { id: 1, version: 0, size: [5, 7], rgba: &rgba }],
        };
        let mut pixels = vec![0; 37 * 41];
        let target = Pixels { pixels: &mut pixels, age: 0 };
        CpuPainter::new().paint(frame, target).expect("memory of this size");
    }
}
