//! Every sample's screen as it is painted, against pictures that are kept: one sheet of thumbnails for each size of screen.
//!
//! A screen that is meant to look different needs new sheets: `TROCAR_RENEW_PICTURES=1 cargo test -p window pictures` writes them. Look
//! at them before they are kept.

use egui::epaint::{ClippedShape, Shape};
use egui::{Color32, vec2};

use super::paint::paint;
use super::sheet::{self, TOLERANCE, Thumbnail};
use super::{SCREENS, monitor, sample, samples, steps};
use crate::model::Tone;
use crate::model::sample::Sample;
use crate::screen::Look;
use crate::screen::words::colour;

/// The samples with the looks that are painted of them.
fn screens() -> Vec<(&'static str, Sample, Look)> {
    let plain = |(name, sample): (&'static str, Sample)| (name, sample, Look::default());
    let mut all: Vec<(&'static str, Sample, Look)> = samples::all().into_iter().map(plain).collect();
    let enlarged = Look {
        enlarged: Some(1),
        ..Look::default()
    };
    let noted = Look {
        only_sight: true,
        note: "no answer within 150 ms".to_owned(),
        ..Look::default()
    };
    all.push(("enlarged", samples::planned(), enlarged));
    all.push(("sight alone", samples::planned(), noted));
    all.extend(steps::pictured());
    all
}

fn thumbnail(sample: &Sample, look: &Look, pixels: [u32; 2], change: impl FnOnce(&mut Vec<ClippedShape>)) -> Thumbnail {
    let painted = paint(&sample.model(), monitor(pixels), look, change);
    Thumbnail::of(&painted, pixels)
}

fn assert_as_kept(pixels: [u32; 2]) {
    let found = screens()
        .into_iter()
        .map(|(name, sample, look)| (name.to_owned(), thumbnail(&sample, &look, pixels, |_| {})));
    sheet::assert_as_kept("src/screen/tests/pictures", pixels, &found.collect::<Vec<_>>());
}

#[test]
fn screens_of_1280_columns_are_as_kept() {
    assert_as_kept(SCREENS[0]);
}

#[test]
fn screens_of_1920_columns_are_as_kept() {
    assert_as_kept(SCREENS[1]);
}

#[test]
fn screens_of_3840_columns_are_as_kept() {
    assert_as_kept(SCREENS[2]);
}

/// All shapes that the screen consists of.
fn each(shapes: &mut [ClippedShape], mut change: impl FnMut(&mut Shape)) {
    shapes.iter_mut().for_each(|clipped| change(&mut clipped.shape));
}

/// Moves a word to the right by this part of its height.
fn move_word(shapes: &mut [ClippedShape], word: &str, by: f32) {
    let mut moved = 0;
    each(shapes, |shape| {
        if let Shape::Text(text) = shape
            && text.galley.text() == word
        {
            let height = text.galley.size().y;
            text.pos += vec2(by * height, 0.0);
            moved += 1;
        }
    });
    assert!(moved > 0, "{word}");
}

fn drop_word(shapes: &mut Vec<ClippedShape>, word: &str) {
    let before = shapes.len();
    shapes.retain(|clipped| !matches!(&clipped.shape, Shape::Text(text) if text.galley.text() == word));
    assert!(shapes.len() < before, "{word}");
}

fn recolour(shapes: &mut [ClippedShape], from: Color32, to: Color32) {
    let mut changed = 0;
    each(shapes, |shape| {
        if let Shape::Rect(rect) = shape
            && rect.fill == from
        {
            rect.fill = to;
            changed += 1;
        }
    });
    assert!(changed > 0);
}

/// A comparison that lets a moved word or another colour pass would be none.
#[test]
fn a_moved_word_another_colour_and_another_digit_are_found() {
    let look = Look::default();
    let (live, lost) = (
        sample(37.4, 1.3),
        samples::views(16).in_state(bus::message::FrameState::Lost(bus::message::Lost::Reference)),
    );
    let alarm = colour(Tone::Alarm);
    let redder = Color32::from_rgb(alarm.r(), alarm.g().saturating_sub(8), alarm.b());
    type Mutant<'a> = (&'a str, &'a Sample, Box<dyn Fn(&mut Vec<ClippedShape>)>);
    let mutants: [Mutant<'_>; 5] = [
        (
            "state moved",
            &live,
            Box::new(|shapes| move_word(shapes, "NAVIGATING", 0.1)),
        ),
        (
            "small word moved",
            &live,
            Box::new(|shapes| move_word(shapes, "20 mm", 0.4)),
        ),
        (
            "side of the patient missing",
            &live,
            Box::new(|shapes| drop_word(shapes, "L")),
        ),
        (
            "a mark missing",
            &live,
            Box::new(|shapes| drop_word(shapes, "NOT CHECKED")),
        ),
        (
            "another red",
            &lost,
            Box::new(move |shapes| recolour(shapes, alarm, redder)),
        ),
    ];
    for pixels in SCREENS {
        for (name, sample, change) in &mutants {
            let right = thumbnail(sample, &look, pixels, |_| {});
            let (levels, _) = right.difference(&thumbnail(sample, &look, pixels, change));
            println!("{pixels:?} {name}: {levels}");
            assert!(levels > TOLERANCE, "{pixels:?} {name}: {levels}");
        }
        let right = thumbnail(&live, &look, pixels, |_| {});
        let (levels, _) = right.difference(&thumbnail(&super::sample(37.5, 1.3), &look, pixels, |_| {}));
        println!("{pixels:?} another digit: {levels}");
        assert!(levels > TOLERANCE, "{pixels:?} another digit: {levels}");
    }
}
