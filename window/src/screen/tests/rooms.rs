//! No word of any sample is cut, runs into another or leaves its room, on any screen.

use bus::message::{FrameState, Identity, IdentitySource, Lost};
use proptest::prelude::*;

use super::samples::{WIDE, all, planned, views};
use super::{SCREENS, assert_in_their_rooms, monitor, shown};
use crate::model::sample::{CAPTURED_NS, VOLUME};
use crate::screen::Look;
use crate::sizes::{SMALLEST, Screen};

fn enlarged() -> Look {
    Look {
        enlarged: Some(0),
        ..Look::default()
    }
}

fn only_sight() -> Look {
    Look {
        only_sight: true,
        ..Look::default()
    }
}

#[test]
fn every_sample_fits_on_every_screen() {
    let screens = SCREENS.into_iter().chain([SMALLEST]);
    for (pixels, look) in
        screens.flat_map(|pixels| [Look::default(), enlarged(), only_sight()].map(|look| (pixels, look)))
    {
        for (name, sample) in all() {
            let outcome = shown(&sample.model(), monitor(pixels), &look, Vec::new());
            let found = assert_in_their_rooms(&outcome.words, Some(&WIDE[..6]));
            assert!(found.is_ok(), "{name}, {pixels:?}, {look:?}: {found:?}");
        }
    }
}

/// A small display beside the tube, with the sight alone.
#[test]
fn the_sight_alone_fits_on_a_small_display() {
    for pixels in [[640, 480], [800, 480]] {
        for (name, sample) in all().into_iter().chain([("planned", planned())]) {
            let outcome = shown(&sample.model(), monitor(pixels), &only_sight(), Vec::new());
            let found = assert_in_their_rooms(&outcome.words, Some(&WIDE[..6]));
            assert!(found.is_ok(), "{name}, {pixels:?}: {found:?}");
        }
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(60))]
    /// On a screen of any size, with pixels of any size and any number of views, a number is whole or there is none.
    #[test]
    fn no_number_is_cut_on_any_screen(
        width in 64_u32..4000, height in 64_u32..2400, count in 1_usize..17, pixel_mm in 0.05_f32..1.0, is_alone: bool, is_lost: bool
    ) {
        let look = if is_alone { only_sight() } else { Look::default() };
        let mut sample = views(count);
        sample.guide = planned().guide;
        let words = ["Nguyen^Thi Minh Khai", "4711", "1950-01-01", "2026-11-02", ""];
        sample.identity = Some(Identity::new(VOLUME, IdentitySource::Examination, words));
        if is_lost {
            sample = sample.in_state(FrameState::Lost(Lost::Reference));
            sample.now_ns = CAPTURED_NS + 98_765_000_000;
        }
        let outcome = shown(&sample.model(), Screen { pixels: [width, height], pixel_mm }, &look, Vec::new());
        // What is too small has no numbers of the tool, and no room to say so in full.
        let is_told = |text: &str| outcome.code.is_some() && text.contains(|letter: char| letter.is_ascii_digit());
        for placed in outcome.words.0.iter().filter(|placed| is_told(&placed.text)) {
            prop_assert_eq!(&placed.painted, &placed.text, "{:?}", placed);
        }
    }
}
