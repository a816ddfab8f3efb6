//! A right chain that is called by a wrong name.

use geometry::{Ct, Reference, Rigid, Tool, Tracker};

fn main() {
    let ct_from_tracker = Rigid::<Ct, Tracker>::identity();
    let tracker_from_tool = Rigid::<Tracker, Tool>::identity();
    let _: Rigid<Reference, Tool> = ct_from_tracker * tracker_from_tool;
}
