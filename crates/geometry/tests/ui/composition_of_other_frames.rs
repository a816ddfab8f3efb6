//! A chain whose inner frames differ: ct_from_tracker * marker_from_tool.

use geometry::{Ct, Marker, Rigid, Tool, Tracker};

fn main() {
    let ct_from_tracker = Rigid::<Ct, Tracker>::identity();
    let marker_from_tool = Rigid::<Marker, Tool>::identity();
    let _: Rigid<Ct, Tool> = ct_from_tracker * marker_from_tool;
}
