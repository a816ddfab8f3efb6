//! The planning screen as it is painted, against pictures that are kept: one sheet for each size of screen, as of the operator's screen.

use egui::{Event, Key, Modifiers, PointerButton, Pos2};

use super::{SCREENS, Stage, key, plan};
use crate::planning::camera::CUTS;
use crate::screen::tests::paint::painted;
use crate::screen::tests::sheet::{self, TOLERANCE, Thumbnail};

/// A screen with so many targets, after these events, each in a frame of its own.
fn thumbnail(targets: usize, pixels: [u32; 2], events: &[Event]) -> Thumbnail {
    let mut some = plan();
    some.targets.truncate(targets);
    let mut stage = Stage::new(some, pixels);
    let mut output = egui::FullOutput::default();
    for event in std::iter::once(Event::PointerMoved(Pos2::new(120.0, 200.0))).chain(events.iter().cloned()) {
        let (_, mut newer) = stage.laid_out(vec![event]);
        // Textures that came with the frames before are still to be made.
        output.textures_delta.append(std::mem::take(&mut newer.textures_delta));
        newer.textures_delta = output.textures_delta;
        output = newer;
    }
    let cuts = CUTS.map(|cut| cut.place());
    let drawn = painted(&stage.context, output, stage.screen, cuts.into_iter());
    Thumbnail::of(&drawn, pixels)
}

fn assert_as_kept(pixels: [u32; 2]) {
    let measuring = [key(Key::M), Event::PointerMoved(Pos2::new(240.0, 260.0))];
    let level = [key(Key::W)];
    let renaming = [key(Key::N)];
    let screens: [(&str, usize, &[Event]); 6] = [
        ("empty", 0, &[]),
        ("a target", 1, &[]),
        ("twenty targets", 20, &[]),
        ("measuring", 1, &measuring),
        ("window by dragging", 1, &level),
        ("a name is typed", 1, &renaming),
    ];
    let found = screens.map(|(name, targets, events)| (name.to_owned(), thumbnail(targets, pixels, events)));
    sheet::assert_as_kept("src/planning/screen/tests/pictures", pixels, &found);
}

#[test]
fn planning_on_1024_columns_is_as_kept() {
    assert_as_kept(SCREENS[0]);
}

#[test]
fn planning_on_1920_columns_is_as_kept() {
    assert_as_kept(SCREENS[2]);
}

/// A comparison that lets a point that moved pass would be none.
#[test]
fn a_crosshair_that_moved_is_found() {
    let at = Pos2::new(300.0, 300.0);
    let button = |pressed| Event::PointerButton {
        pos: at,
        button: PointerButton::Primary,
        pressed,
        modifiers: Modifiers::NONE,
    };
    let moved = [Event::PointerMoved(at), button(true), button(false)];
    let (before, after) = (thumbnail(1, SCREENS[2], &[]), thumbnail(1, SCREENS[2], &moved));
    assert!(before.difference(&after).0 > TOLERANCE);
}
