//! A chain in the wrong order: tracker_from_tool * ct_from_tracker.

use geometry::{Ct, Rigid, Tool, Tracker};

fn main() {
    let ct_from_tracker = Rigid::<Ct, Tracker>::identity();
    let tracker_from_tool = Rigid::<Tracker, Tool>::identity();
    let _ = tracker_from_tool * ct_from_tracker;
}
