//! Painting what changed is painting all.

use egui::epaint::textures::TexturesDelta;
use egui::epaint::{ClippedPrimitive, Mesh};
use egui::{Color32, TextureId};
use proptest::prelude::*;
use window::paint::{Area, Image};

use crate::made::{FONT, Hand, all, clipped, fill, font, picture, rect, set, triangles, unclipped};
use crate::screens::texels;

const SIZE: [u32; 2] = [150, 110];

/// A shape, by its kind, its place and its colour.
type Shape = (u8, [i16; 4], [u8; 4]);

fn mesh((kind, [x, y, w, h], [r, g, b, a]): Shape) -> Mesh {
    let colour = Color32::from_rgba_unmultiplied(r, g, b, if a > 150 { 255 } else { a });
    let [x, y, w, h] = [x, y, w, h].map(|v| f32::from(v) * 0.25);
    let place = rect(x, y, x + w, y + h);
    match kind % 6 {
        0 => fill(place, colour),
        1 => picture(TextureId::User(u64::from(r % 3)), place, all(), Color32::WHITE),
        2 => picture(TextureId::User(u64::from(r % 3)), place, all(), colour),
        3 => picture(FONT, place, all(), colour),
        4 => triangles(&[
            (x, y, colour),
            (x + w, y + 3.0, Color32::TRANSPARENT),
            (x, y + h, colour),
        ]),
        _ => {
            // At one to one, on whole pixels.
            let [x, y] = [x.round(), y.round()];
            picture(
                TextureId::User(0),
                rect(x, y, x + 40.0, y + 30.0),
                all(),
                Color32::WHITE,
            )
        }
    }
}

fn shape() -> impl Strategy<Value = Shape> {
    let place = (-80_i16..600, -80_i16..440, 1_i16..500, 1_i16..400).prop_map(|(x, y, w, h)| [x, y, w, h]);
    (any::<u8>(), place, any::<[u8; 4]>())
}

/// What happens between two frames.
#[derive(Debug, Clone)]
enum Change {
    Nothing,
    Add(Shape),
    Remove(usize),
    Replace(usize, Shape),
    Swap(usize, usize),
    Image(usize),
    Clip(u8),
    Font(usize),
}

fn change() -> impl Strategy<Value = Change> {
    prop_oneof![
        Just(Change::Nothing),
        shape().prop_map(Change::Add),
        any::<usize>().prop_map(Change::Remove),
        (any::<usize>(), shape()).prop_map(|(i, shape)| Change::Replace(i, shape)),
        (any::<usize>(), any::<usize>()).prop_map(|(i, j)| Change::Swap(i, j)),
        (0_usize..3).prop_map(Change::Image),
        any::<u8>().prop_map(Change::Clip),
        any::<usize>().prop_map(|seed| Change::Font(seed % 1000)),
    ]
}

/// What is shown.
#[derive(Default)]
struct World {
    shapes: Vec<Shape>,
    versions: [u64; 3],
    font: Option<usize>,
    /// How far the clip has moved, pixels.
    clip: u8,
}

impl World {
    fn apply(&mut self, change: Change) {
        let count = self.shapes.len().max(1);
        match change {
            Change::Nothing => {}
            Change::Add(shape) => self.shapes.push(shape),
            Change::Remove(i) if !self.shapes.is_empty() => drop(self.shapes.remove(i % count)),
            Change::Replace(i, shape) if !self.shapes.is_empty() => self.shapes[i % count] = shape,
            Change::Swap(i, j) if !self.shapes.is_empty() => self.shapes.swap(i % count, j % count),
            Change::Clip(moved) => self.clip = moved % 16,
            Change::Image(i) => self.versions[i] += 1,
            Change::Font(seed) => self.font = Some(seed),
            _ => {}
        }
    }

    fn primitives(&self) -> Vec<ClippedPrimitive> {
        let mut primitives: Vec<ClippedPrimitive> = Vec::new();
        for shape in &self.shapes {
            // Some clipped, the others without.
            let clip = match shape.2[1] % 3 {
                0 => rect(20.0 + f32::from(self.clip), 10.0, 101.0, 77.0 - f32::from(self.clip)),
                _ => egui::Rect::EVERYTHING,
            };
            primitives.push(clipped(mesh(*shape), clip));
        }
        primitives
    }

    fn texels(&self) -> [Vec<u8>; 3] {
        std::array::from_fn(|i| texels([40, 30], i as u32 + 7 * self.versions[i] as u32))
    }

    fn images<'a>(&self, texels: &'a [Vec<u8>; 3]) -> Vec<Image<'a>> {
        let image = |i: usize| Image {
            id: i as u64,
            version: self.versions[i],
            size: [40, 30],
            rgba: &texels[i],
        };
        (0..3).map(image).collect()
    }

    fn delta(&mut self) -> TexturesDelta {
        match self.font.take() {
            Some(seed) => set(FONT, font(seed), None),
            None => TexturesDelta::default(),
        }
    }
}

fn is_inside(areas: &[Area], x: i32, y: i32) -> bool {
    areas
        .iter()
        .any(|a| (a.x0..a.x1).contains(&x) && (a.y0..a.y1).contains(&y))
}

/// Every pixel that differs is in `damage`, and no two areas overlap.
fn check_damage(damage: &[Area], before: &[u32], after: &[u32]) {
    for (i, (old, new)) in before.iter().zip(after).enumerate() {
        let (x, y) = (i as i32 % SIZE[0] as i32, i as i32 / SIZE[0] as i32);
        assert!(
            old == new || is_inside(damage, x, y),
            "{x} {y} changed outside {damage:?}"
        );
    }
    for (i, a) in damage.iter().enumerate() {
        assert!(
            damage[..i].iter().all(|b| a.intersect(*b).is_empty()),
            "{damage:?} overlap"
        );
    }
}

proptest! {
    #[test]
    fn painting_what_changed_is_painting_all(
        changes in prop::collection::vec((change(), 0_u8..4), 1..14),
        start in prop::collection::vec(shape(), 0..8),
    ) {
        let mut world = World { shapes: start, ..World::default() };
        let (mut part, mut whole) = (Hand::new(SIZE), Hand::new(SIZE));
        // What the screen showed, the newest last; a buffer of some age holds one of these.
        let mut shown = vec![part.pixels.clone()];
        for (change, age) in changes {
            world.apply(change);
            let (mut delta, primitives, texels) = (world.delta(), world.primitives(), world.texels());
            let images = world.images(&texels);
            let age = age.min(shown.len() as u8);
            part.pixels = match age {
                0 => vec![0x00FF_00FF; part.pixels.len()],
                age => shown[shown.len() - usize::from(age)].clone(),
            };
            let (damage, _) = part.paint(&mut delta.clone(), &primitives, &images, age);
            whole.paint(&mut delta, &primitives, &images, 0);
            prop_assert!(part.pixels == whole.pixels, "another picture at age {age}");
            check_damage(&damage, shown.last().expect("one at least"), &part.pixels);
            shown.push(part.pixels.clone());
        }
    }
}

#[test]
fn what_did_not_change_is_no_damage() {
    let mut hand = Hand::new([640, 400]);
    let pixels = texels([40, 30], 0);
    let image = |version| Image {
        id: 1,
        version,
        size: [40, 30],
        rgba: &pixels,
    };
    let shapes = |x: f32| {
        let mark = triangles(&[
            (x, 300.0, Color32::RED),
            (x + 9.0, 300.0, Color32::RED),
            (x, 309.0, Color32::BLUE),
        ]);
        let cell = picture(
            TextureId::User(1),
            rect(64.0, 64.0, 192.0, 160.0),
            all(),
            Color32::WHITE,
        );
        [fill(rect(0.0, 0.0, 640.0, 400.0), Color32::GRAY), cell, mark].map(unclipped)
    };
    let mut damage = |x, version| {
        let mut none = TexturesDelta::default();
        hand.paint(&mut none, &shapes(x), &[image(version)], 1).0
    };
    let area = |x0, y0, x1, y1| Area { x0, y0, x1, y1 };
    assert_eq!(damage(400.0, 0), [area(0, 0, 640, 400)]);
    assert_eq!(damage(400.0, 0), []);
    assert_eq!(damage(400.0, 1), [area(64, 64, 192, 160)]);
    // The mark's old and new place, in tiles of 32 pixels.
    assert_eq!(damage(420.0, 1), [area(384, 288, 448, 320)]);
    // What lies hidden below changes nothing that shows.
    assert_eq!(damage(420.0, 1), []);
}

#[test]
fn what_is_hidden_is_no_damage() {
    let mut hand = Hand::new([128, 96]);
    let mut damage = |below: Color32| {
        let shapes = [(below, 20.0), (Color32::GRAY, 0.0)];
        let shapes =
            shapes.map(|(colour, inset)| unclipped(fill(rect(inset, inset, 128.0 - inset, 96.0 - inset), colour)));
        hand.paint(&mut TexturesDelta::default(), &shapes, &[], 1).0
    };
    assert_eq!(damage(Color32::RED).len(), 1);
    assert_eq!(damage(Color32::BLUE), []);
}
