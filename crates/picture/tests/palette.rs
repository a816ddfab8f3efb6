//! The palette as people with and without colour blindness see it.

use picture::{palette, vision};

/// The tube and a replay were 5.0 apart for a deuteranope, tip and target 6.1 for a protanope.
#[test]
fn colours_are_told_apart_with_every_kind_of_colour_blindness() {
    use palette::{ALARM, CUT, REPLAY, TARGET, TIP, TUBE, WARN};
    let colours = [TUBE, TIP, TARGET, CUT, WARN, ALARM, REPLAY];
    for (i, a) in colours.iter().enumerate() {
        for b in &colours[..i] {
            let apart = vision::least_difference(*a, *b);
            assert!(apart >= 14.0, "{a:?} {b:?}: {apart:.1}");
        }
    }
}
