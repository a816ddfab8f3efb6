//! Covariances in frames that do not meet.

use geometry::{Ct, Marker, Rigid, Tool, Tracker, Uncertain};

fn main() {
    let ct_from_tracker = Uncertain::from(Rigid::<Ct, Tracker>::identity());
    let marker_from_tool = Uncertain::from(Rigid::<Marker, Tool>::identity());
    let _ = ct_from_tracker * marker_from_tool;
}
