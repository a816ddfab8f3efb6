//! Floor 2: registration of points of a bone's surface, touched with a pointer or seen by ultrasound, to the surface itself (thesis,
//! part I, 2.2.1 and 2.3.3).
//!
//! Pure numerics: no file, no clock, no process. Lengths are mm, angles rad, frames are types. The same input gives the same bits.
//!
//! | step | where |
//! |---|---|
//! | triangles to a checked [`Surface`]: orientation, open ends, inner shells, unit | [`Surface::new`] |
//! | the signed distance on a lattice, which the search goes by | [`Field`] |
//! | points with their covariances, and the error that they share | [`Points`], [`SharedError`] |
//! | from a guess, from landmarks or from nothing to the pose of least cost | [`register`] |
//! | its error at targets, other minima, each point's part | [`SurfaceRegistration`] |
//! | motions that the points do not hold, in words | [`free`](fn@free) |
//! | where touching more would help most | [`next`](fn@next) |
//! | whether it may be used, and if not why, with numbers | [`Limits::judge`] |
//!
//! Minimised is, over the pose `(R, t)`, a depth scale `k` (the speed of sound) and an offset `o` of the surface (a threshold puts bone
//! too far out), with Tukey's biweight and what is known before of `k`, `o` and landmarks:
//!
//! ```text
//! s_i = (d(R (q_i - b_i z_i k) + t) - e_i - o) / sqrt(n' R C_i R' n + s_bone^2)
//! ```
//!
//! `q` is a point, `C` its covariance, `b` its beam, `z` its depth; `d` the signed distance and `n` its gradient; `e` by how much noise
//! carries a point off a bent surface on average. What comes out of [`register`] is not to be used before [`Limits::judge`] finds nothing
//! against it: wrong minima predict errors as small as the right one does.
//!
//! ```
//! use geometry::{Ct, Point, Rigid, Tracker, Vector};
//! use surface_registration::{Field, Limits, Options, Points, Refusal, Spacing, Start, Surface, SurfacePoint, register};
//!
//! // A box of 60 x 40 x 20 mm about the origin, touched at 60 places: it fits turned by half a turn as well.
//! let corner = |i: u32| [0, 1, 2].map(|k| [30.0, 20.0, 10.0][k] * if i >> k & 1 == 1 { 1.0 } else { -1.0 });
//! let corners: Vec<[f64; 3]> = (0..8).map(corner).collect();
//! let faces = [[0, 2, 3, 1], [4, 5, 7, 6], [0, 1, 5, 4], [2, 6, 7, 3], [0, 4, 6, 2], [1, 3, 7, 5]];
//! let triangles: Vec<[u32; 3]> = faces.iter().flat_map(|[a, b, c, d]| [[*a, *b, *c], [*a, *c, *d]]).collect();
//! let surface = Surface::<Ct>::new(&corners, &triangles)?;
//! let field = Field::new(&surface, Spacing::default())?;
//! let touched = |i: u32| {
//!     let (u, v) = (f64::from(i % 5) / 2.5 - 0.8, f64::from(i / 5 % 4) / 2.0 - 0.75);
//!     let [x, y, z] = [[30.0, 20.0 * u, 10.0 * v], [30.0 * u, 20.0, 10.0 * v], [30.0 * u, 20.0 * v, 10.0]][i as usize / 20];
//!     SurfacePoint::<Tracker>::touched(Point::new(x, y, z + 500.0), 0.3)
//! };
//! let points = Points::new(&(0..60).map(touched).collect::<Vec<_>>(), None, 0.0)?;
//! let pose: Rigid<Ct, Tracker> = Rigid::from_rotation_vector(Vector::new(0.05, 0.0, 0.02), Vector::new(1.0, 0.0, -480.0))?;
//! let start = Start::Guess { pose, turn_rad: 0.2, shift_mm: 30.0 };
//! let found = register(&surface, &field, &points, &start, &Options::default())?;
//! let target = Point::new(0.0, 0.0, 0.0);
//! assert!((found.transform.transform() * Point::new(0.0, 0.0, 500.0)).distance(target) < 0.1);
//! // Points without any error at all: the noise that was told is not there, and that is said.
//! let refusals = Limits::default().judge(&found, &[target]);
//! assert!(refusals.iter().any(|refusal| matches!(refusal, Refusal::Quiet { .. })));
//! # Ok::<(), Box<dyn std::error::Error>>(())
//! ```

mod field;
mod free;
mod kernel;
mod mesh;
mod next;
mod points;
mod register;
mod search;
#[cfg(test)]
#[allow(dead_code, reason = "each of its two users takes what it needs")]
mod shapes;
mod solve;
mod tail;
mod tree;
mod verdict;

pub use field::{Field, FieldError, MOST_NODES, Spacing};
pub use free::{Free, free};
pub use kernel::Kernel;
pub use mesh::{DIAGONAL_MM, Distance, Facts, MOST_TRIANGLES, OpenEnd, Surface, SurfaceError};
pub use next::{Next, Touches, next};
pub use points::{Beam, BeamNoise, LEAST_POINTS, MOST_POINTS, Points, PointsError, SharedError, SurfacePoint};
pub use register::{
    Class, GrossError, Halves, Landmark, Options, OrderCheck, Other, PointResult, RegisterError, SecondSurface, Start,
    SurfaceRegistration, Trend, refine, register,
};
pub use search::Effort;
pub use solve::Priors;
pub use tail::{Tail, tail};
pub use verdict::{Limits, Refusal};
