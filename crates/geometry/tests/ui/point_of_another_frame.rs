//! A point that is already in the patient, put through a transform from the tool.

use geometry::{Ct, Point, Rigid, Tool};

fn main() {
    let ct_from_tool = Rigid::<Ct, Tool>::identity();
    let tip_in_ct = Point::<Ct>::new(0.0, 0.0, 0.0);
    let _ = ct_from_tool * tip_in_ct;
}
