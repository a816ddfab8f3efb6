//! H6: a tip was shown short of a target that it had passed.

use bus::message::{Chosen, Guide};
use geometry::{Point, Rigid, Tool};

use super::{SCREENS, monitor, shown};
use crate::model::sample::{Sample, pose};
use crate::screen::Look;

/// A tool turned so, and a target that lies so far before its tip along the tube, at which it is to stop so far before the centre.
fn sample(turn: [f64; 3], ahead_mm: f64, stop_mm: f64) -> Sample {
    let ct_from_tool: Rigid<_, Tool> = pose(turn, [10.0, -5.0, 70.0]);
    let centre = ct_from_tool * Point::<Tool>::new(0.0, 0.0, ahead_mm);
    let chosen = Chosen {
        name: "node".to_owned(),
        centre,
        radius_mm: 2.5,
        entry: None,
        stop_mm,
    };
    Sample {
        guide: Some(Guide::default().choosing(Some(&chosen), 1)),
        ..Sample::new(ct_from_tool, centre)
    }
}

/// What is to go is counted along the tube from the tip to the stop: positive before it, zero at it, negative behind it, whichever way
/// the tube points; and a stop that is not the centre is named.
#[test]
fn h6_depth_has_its_sign_and_its_zero_at_the_stop() {
    for turn in [[0.0; 3], [0.3, 0.9, 0.1], [3.1, 0.0, 0.0], [0.0, -1.6, 0.0]] {
        for stop_mm in [0.0, 3.0] {
            for to_go_mm in [60.0, 0.4, 0.0, -0.4, -4.0, -60.0] {
                let model = sample(turn, to_go_mm + stop_mm, stop_mm).model();
                for screen in SCREENS {
                    let words = shown(&model, monitor(screen), &Look::default(), Vec::new()).words;
                    let says = |text: &str| words.0.iter().any(|placed| placed.painted == text);
                    assert!(says(&format!("{to_go_mm:.1}")), "{to_go_mm} {stop_mm} {turn:?}");
                    let caption = if stop_mm == 0.0 { "mm to go" } else { "mm to 3.0 before" };
                    assert!(says(caption), "{caption}");
                    // The verdict says it in words as well once the tip is behind the stop by more than the target's radius.
                    let is_past = to_go_mm < -2.5;
                    assert_eq!(says("PAST TARGET"), is_past, "{to_go_mm} {stop_mm}");
                }
            }
        }
    }
}
