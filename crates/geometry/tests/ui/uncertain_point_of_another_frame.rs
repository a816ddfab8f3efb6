//! A covariance about a point that is not in the frame of the covariance.

use geometry::{Ct, Point, Rigid, Tool, Uncertain};

fn main() {
    let ct_from_tool = Uncertain::from(Rigid::<Ct, Tool>::identity());
    let _ = ct_from_tool.covariance_about(Point::<Tool>::new(0.0, 0.0, 0.0));
}
