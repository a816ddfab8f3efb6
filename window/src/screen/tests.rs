//! The screen itself: where words stand, what they say, and what keys and touches do.

mod actions;
mod depth;
mod lost;
pub(crate) mod paint;
mod palette;
mod pictures;
mod rooms;
pub(in crate::screen) mod samples;
pub(crate) mod sheet;
mod stage;
mod steps;
mod tree;
mod views;

use bus::message::{Chosen, FrameState, Guide, Identity, IdentitySource, Lost};
use egui::{Event, RawInput, Rect, vec2};
use geometry::{Point, Tool};
use proptest::prelude::*;

use super::words::Placed;
use super::*;
use crate::model::sample::{CAPTURED_NS, Sample, VOLUME, pose};

const SCREENS: [[u32; 2]; 3] = [[1280, 800], [1920, 1080], [3840, 2160]];

/// A monitor of 24 inches.
pub(in crate::screen) fn monitor(pixels: [u32; 2]) -> Screen {
    Screen {
        pixels,
        pixel_mm: 531.0 / pixels[0] as f32,
    }
}

/// What a screen says and what is wished, after these events.
pub(in crate::screen) fn shown(model: &Model, screen: Screen, look: &Look, events: Vec<Event>) -> Outcome {
    let context = context();
    let [width, height] = screen.pixels.map(|n| n as f32);
    let mut outcome = Outcome::default();
    // The first frame tells egui where things are.
    for events in [Vec::new(), events] {
        let input = RawInput {
            screen_rect: Some(Rect::from_min_size(egui::Pos2::ZERO, vec2(width, height))),
            events,
            ..RawInput::default()
        };
        let mut output = context.run_ui(input, |ui| outcome = show(ui, model, screen, look));
        // Nothing is painted here, which egui holds for a mistake.
        output.textures_delta.clear();
    }
    outcome
}

/// A target so far along and across the tube of the sample.
fn sample(to_go: f64, off: f64) -> Sample {
    let pose = pose([0.3, 0.9, 0.1], [10.0, -5.0, 70.0]);
    Sample::new(pose, pose * Point::<Tool>::new(off, 0.0, to_go))
}

/// `free` is a name of any length, which may end in an ellipsis; nothing else may.
fn assert_in_their_rooms(words: &Words, free: Option<&str>) -> Result<(), TestCaseError> {
    for (i, a) in words.0.iter().enumerate() {
        // egui rounds what a line covers to whole pixels.
        prop_assert!(a.room.expand(1.0).contains_rect(ink(a)), "{a:?}");
        prop_assert!(a.covers.width() <= a.room.width() + 1.0, "{a:?}");
        let may_be_short = free.is_some_and(|free| !free.trim().is_empty() && a.text.contains(free.trim()));
        prop_assert!(a.painted == a.text || may_be_short, "{a:?}");
        for b in &words.0[i + 1..] {
            let common = ink(a).intersect(ink(b));
            prop_assert!(!(common.width() > 0.5 && common.height() > 0.5), "{a:?} over {b:?}");
        }
    }
    Ok(())
}

/// What the letters cover: a line is higher than they are.
fn ink(placed: &Placed) -> Rect {
    placed.covers.shrink2(vec2(0.0, 0.12 * placed.size))
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    /// H4: a digit was dropped on a navigator's screen in the field ("8_.5 mm").
    #[test]
    fn h4_no_number_is_cut_or_run_into_by_another(
        to_go in -999.9..999.9_f64, off in 0.0..999.9_f64, which in 0_usize..3, age_ms in 0_i64..99, stop in 0.0..99.9_f64
    ) {
        let mut sample = sample(to_go, off);
        sample.now_ns = CAPTURED_NS + age_ms * 1_000_000;
        // With an angle beside the distances where there is an entry.
        if age_ms % 2 == 0 {
            sample.guide = samples::planned().guide.map(|guide| Guide { target_mm: sample.guide.unwrap().target_mm, ..guide });
        }
        sample.guide.as_mut().unwrap().stop_mm = stop;
        let outcome = shown(&sample.model(), monitor(SCREENS[which]), &Look::default(), Vec::new());
        assert_in_their_rooms(&outcome.words, None)?;
        // The distances as they are, rebuilt from the screen.
        let says = |mm: f64| outcome.words.0.iter().any(|placed| placed.painted.parse::<f64>().is_ok_and(|said| (said - mm).abs() <= 0.5001));
        prop_assert!(says(to_go - stop), "{to_go} {stop}");
        prop_assert!(says(off), "{off}");
    }

    /// A target's name, a patient's name and a reason of any length leave the numbers alone.
    #[test]
    fn long_names_are_shortened_and_nothing_else(name in "[a-zA-Z\u{e9}\u{6587} ^-]{0,64}", which in 0_usize..3) {
        let mut sample = sample(30.0, 1.0);
        let chosen = Chosen {
            name: name.clone(),
            centre: Point::new(1.0, 2.0, 3.0),
            radius_mm: 2.5,
            entry: None,
            stop_mm: 0.0,
        };
        sample.guide = Some(Guide::default().choosing(Some(&chosen), 1));
        sample.identity = Some(Identity::new(VOLUME, IdentitySource::Examination, [&name, "1", "1950-01-01", "", ""]));
        let outcome = shown(&sample.model(), monitor(SCREENS[which]), &Look::default(), Vec::new());
        // On the bus a target's name is cut off at 64 bytes.
        let beginning = name.char_indices().nth(6).map_or(&*name, |(end, _)| &name[..end]);
        assert_in_their_rooms(&outcome.words, Some(beginning))?;
        prop_assert!(outcome.words.0.iter().any(|placed| placed.painted.contains("*1950-01-01  ID 1")));
    }
}

#[test]
fn a_lost_tool_leaves_no_distance_on_the_screen() {
    let lost = sample(30.0, 1.0).in_state(FrameState::Lost(Lost::NotSeen)).model();
    let outcome = shown(&lost, monitor([1920, 1080]), &Look::default(), Vec::new());
    assert!(outcome.words.say("NO POSE") && outcome.words.say("marker not seen") && outcome.words.say("NO SIGHT"));
    assert!(!outcome.words.say("mm"), "{:?}", outcome.words);
    // The one number of each image is its age.
    let numbers = outcome
        .words
        .0
        .iter()
        .filter(|placed| placed.text.parse::<f64>().is_ok());
    assert_eq!(numbers.count(), 0);
}

#[test]
fn a_research_run_says_so_on_every_screen() {
    for look in [
        Look::default(),
        Look {
            only_sight: true,
            ..Look::default()
        },
        Look {
            enlarged: Some(3),
            ..Look::default()
        },
    ] {
        for pixels in SCREENS {
            let outcome = shown(&sample(30.0, 1.0).model(), monitor(pixels), &look, Vec::new());
            assert!(
                outcome.words.say("RESEARCH") && outcome.words.say("PHANTOM"),
                "{look:?}"
            );
            // A watcher that found a cell on the sight alone read that one, covered the sight, and left a window with images that
            // froze as it was: the sight has none.
            assert_eq!(outcome.code.is_none(), look.only_sight, "{look:?}");
        }
    }
}

#[test]
fn a_screen_that_is_too_small_says_so() {
    let outcome = shown(
        &sample(30.0, 1.0).model(),
        monitor([640, 480]),
        &Look::default(),
        Vec::new(),
    );
    assert!(outcome.words.say("SCREEN TOO SMALL: 640 x 480") && outcome.words.say("1024 x 640"));
    assert!(outcome.code.is_none());
}

#[test]
fn the_sight_points_where_the_target_is() {
    // Right and up on the sight are right and up on the screen, and further off is further out.
    assert!(super::sight::drawn(1.0) < super::sight::drawn(2.0) && super::sight::drawn(0.0) == 0.0);
    assert!((super::sight::drawn(100.0) - 1.0).abs() < 1e-12);
    for (mm, words) in [
        (0.04, "0.0"),
        (-0.04, "0.0"),
        (99.94, "99.9"),
        (-99.96, "-100"),
        (1e300, ">9999"),
        (-1e300, "<-999"),
    ] {
        assert_eq!(super::sight::readout::millimetres(mm), words);
    }
}

/// A name in letters that the screen's type does not have is said to be one: boxes would be the same for every patient.
#[test]
fn a_name_without_letters_is_said_to_be_one() {
    let strange = |name: &str| {
        let words = [name, "4711", "1950-01-01", "", ""];
        let identity = Some(Identity::new(VOLUME, IdentitySource::Examination, words));
        let sample = Sample {
            identity,
            ..sample(30.0, 1.0)
        };
        shown(&sample.model(), monitor([1920, 1080]), &Look::default(), Vec::new())
    };
    for name in ["\u{9234}\u{6728}", "Suzuki=\u{9234}\u{6728}"] {
        let outcome = strange(name);
        assert!(
            outcome.words.say("NAME IN OTHER LETTERS") && !outcome.words.say(name),
            "{name}"
        );
        assert!(outcome.words.say("*1950-01-01  ID 4711"));
    }
    for name in [
        "M\u{fc}ller^J\u{e9}r\u{f4}me",
        "\u{418}\u{432}\u{430}\u{43d}",
        "\u{393}\u{3b9}\u{3ce}\u{3c1}\u{3b3}\u{3bf}\u{3c2}",
    ] {
        assert!(strange(name).words.say(name), "{name}");
    }
}

/// The longest reasons leave the age and the marks whole.
#[test]
fn a_reason_of_any_length_leaves_the_age_and_the_marks_their_room() {
    let mut model = samples::replay().model();
    model.state.detail = "a reason that goes on and on ".repeat(9);
    for pixels in SCREENS {
        let outcome = shown(&model, monitor(pixels), &Look::default(), Vec::new());
        for word in ["20 ms", "RESEARCH", "NOT CHECKED"] {
            let placed = outcome.words.0.iter().find(|placed| placed.painted == word);
            assert!(
                placed.is_some_and(|placed| placed.size >= 15.0),
                "{pixels:?} {word}: {placed:?}"
            );
        }
    }
}
