//! Colours of the screen: words are read on what they stand on, and no two meanings look alike to anybody.

use egui::Color32;
use picture::{Rgb, palette, vision};

use super::samples::all;
use super::{monitor, shown};
use crate::model::Tone;
use crate::screen::Look;
use crate::screen::words::colour;

fn rgb(colour: Color32) -> Rgb {
    Rgb(colour.r(), colour.g(), colour.b())
}

#[test]
fn words_have_a_contrast_of_seven_on_what_they_stand_on() {
    for (name, sample) in all() {
        let outcome = shown(&sample.model(), monitor([1920, 1080]), &Look::default(), Vec::new());
        for placed in &outcome.words.0 {
            let found = palette::contrast(rgb(placed.colours[0]), rgb(placed.colours[1]));
            assert!(found >= 7.0, "{name}: {found:.1}: {placed:?}");
        }
    }
}

/// The bands are other colours than those of the same meaning on images, which lie beside them: each is told apart from all other
/// meanings. Until 2026 the violet was 9.3 from the tube for a deuteranope, and the red 11.8 from the amber for a tritanope.
#[test]
fn no_two_meanings_look_alike_with_any_kind_of_colour_blindness() {
    use palette::{ALARM, CUT, REPLAY, TARGET, TIP, TUBE, WARN};
    let tone = |tone| rgb(colour(tone));
    let meanings = [
        ("tube", vec![TUBE]),
        ("tip", vec![TIP]),
        ("cut", vec![CUT]),
        ("target", vec![TARGET, tone(Tone::Live)]),
        ("old", vec![WARN, tone(Tone::Warning)]),
        ("alarm", vec![ALARM, tone(Tone::Alarm)]),
        ("replay", vec![REPLAY, tone(Tone::Replay)]),
    ];
    for (i, (name, colours)) in meanings.iter().enumerate() {
        for (other, others) in &meanings[..i] {
            for (a, b) in colours.iter().flat_map(|a| others.iter().map(move |b| (*a, *b))) {
                let apart = vision::least_difference(a, b);
                assert!(apart >= 14.0, "{name} {a:?}, {other} {b:?}: {apart:.1}");
            }
        }
    }
}
