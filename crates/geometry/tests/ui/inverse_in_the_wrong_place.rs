//! The registration turned round: tracker_from_ct * tracker_from_tool.

use geometry::{Ct, Rigid, Tool, Tracker};

fn main() {
    let ct_from_tracker = Rigid::<Ct, Tracker>::identity();
    let tracker_from_tool = Rigid::<Tracker, Tool>::identity();
    let _ = ct_from_tracker.inverse() * tracker_from_tool;
}
