//! The calibration base ("socle"): a plate with a plane and three grooves, touched with the pointer, in which the tool has
//! one seat (thesis, part I, 2.2.1 and 2.3.2).
//!
//! 1. [`locate`]: touches of the plane and the grooves give `tracker_from_base`, or `reference_from_base` where a marker on
//!    the base serves as reference and the touches are given in its frame.
//! 2. [`seated`]: the tool sits in the base as drawn, `base_from_tool`; frames that show both markers give
//!    `marker_from_tool = (tracker_from_marker)^-1 tracker_from_base base_from_tool`.
//!
//! A touch on the plane is held along the normal, one in a groove across the groove: minimised is the sum of the squared
//! distances over the base's pose. The tip is a ball of radius `r`, whose centre lies `r` above the plane and
//! `r / sin(half angle)` above a groove's bottom line; a sharp tip has `r = 0`. The noise is that of the tip's place, the
//! same along every axis, or a covariance for each touch ([`Group::with_covariances`]), whose part along the axes that hold
//! the touch weighs it: touches of which the localizer's depth runs along the groove count for more. An error of the tip's calibration, common to all touches, is not in the covariance.
//!
//! Three grooves at 120 degrees, noise 0.2 mm, 80 mm above the plate, over many drawings of the noise:
//!
//! | touches | root mean square error, mm |
//! |---|---|
//! | 20 on the plane, 10 in each groove | 0.13 |
//! | 100 and 50 | 0.06 |
//!
//! Groups without a label are assigned by trying: every assignment that uses each feature and whose lines and planes
//! exist, each in the four ways in which a normal and a line can be laid on one another. What fits twice is refused.
//!
//! A groove must be deep and wide enough for the ball to rest on both walls; that is not checked.
//!
//! ```
//! use calib::base::{Drawing, Feature, Groove, Group, Options, locate};
//! use geometry::{Base, Direction, Point, Tracker, Vector};
//!
//! // Along +x, +y and -y, 4 mm deep.
//! let groove = |from: [f64; 2], to: [f64; 2]| Groove {
//!     start: Point::new(from[0], from[1], -4.0),
//!     end: Point::new(to[0], to[1], -4.0),
//!     half_angle_rad: 0.785,
//! };
//! let grooves = [groove([10.0, 0.0], [60.0, 0.0]), groove([0.0, 10.0], [0.0, 60.0]), groove([0.0, -60.0], [0.0, -30.0])];
//! let drawing = Drawing::new(Point::new(0.0, 0.0, 0.0), Direction::Z, grooves)?;
//! // The base lies 100 mm beside the localizer's origin.
//! let seen = |p: Point<Base>| Point::<Tracker>::new(p.mm()[0] + 100.0, p.mm()[1], p.mm()[2]);
//! let along = |g: Groove| [0.1, 0.5, 0.9].map(|s| seen(g.start.lerp(g.end, s))).to_vec();
//! let plane = [[50.0, 50.0], [-50.0, 50.0], [-50.0, -50.0], [50.0, -50.0]].map(|[x, y]| seen(Point::new(x, y, 0.0)));
//! let [a, b, c] = grooves.map(|g| Group::unlabelled(along(g)));
//! let found = locate(&drawing, &[Group::of(Feature::Plane, plane.to_vec()), a, b, c], &Options::new(0.2))?;
//! assert_eq!(found.assignment, Feature::ALL);
//! assert!((found.place.transform().translation() - Vector::new(100.0, 0.0, 0.0)).norm() < 1e-10);
//! # Ok::<(), calib::base::Refused>(())
//! ```

mod consensus;
mod drawing;
mod error;
mod feature;
mod free_motion;
mod locate;
mod mean;
mod means;
mod result;
mod search;
mod seat;
mod solve;
mod touches;

pub use consensus::{separate, separated};
pub use drawing::{Drawing, Groove};
pub use error::Refused;
pub use feature::{Feature, OneSide};
pub use free_motion::FreeMotion;
pub use locate::locate;
pub use mean::{Mean, mean};
pub use result::{FeatureResiduals, Located, RejectedTouch};
pub use seat::{Seated, seated, seen_from_marker};
pub use touches::{Group, Options};
