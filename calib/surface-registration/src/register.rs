//! A registration from points, a surface and what is known of where they lie.

mod check;
mod error;
mod margin;
mod moved;
mod normal;
mod parts;
mod result;
mod rows;
mod second;
mod sensitivity;
mod start;
mod suspect;
mod trend;

use geometry::rotation::RotationMatrix;
use geometry::{Frame, Rigid, Vector};

pub use error::RegisterError;
pub use moved::{Halves, OrderCheck};
pub use parts::{Class, PointResult};
pub use result::{Other, SurfaceRegistration};
pub use second::SecondSurface;
pub use sensitivity::GrossError;
pub use start::{Landmark, Start};
pub(crate) use trend::ONE_IN_1000;
pub use trend::Trend;

use crate::points::Points;
use crate::search::{Effort, search};
use crate::solve::{Exact, Priors, Solver};
use crate::{Field, Surface};

/// How it is done. Each is a dial; what came of it is in the result.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Options {
    /// What is known before of depth scale, offset and bone.
    pub priors: Priors,
    /// Tukey's constant: residuals beyond so many deviations have no say.
    pub kernel_end: f64,
    /// Cosine between a beam and the outward normal from which on its point faces away from the bone and has no say: -1 to 1; 0 is a
    /// beam along the surface.
    pub facing: f64,
    /// How much is tried.
    pub effort: Effort,
}

impl Default for Options {
    fn default() -> Self {
        Self {
            priors: Priors::default(),
            kernel_end: 4.5,
            facing: 0.0,
            effort: Effort::default(),
        }
    }
}

/// Registers points to a surface: the pose of least cost that the search finds, and what is known of its error. Whether it may be used is
/// for [`crate::Limits::judge`] to say.
///
/// # Errors
/// Each variant of [`RegisterError`].
pub fn register<To: Frame, From: Frame>(
    surface: &Surface<To>,
    field: &Field,
    points: &Points<From>,
    start: &Start<To, From>,
    options: &Options,
) -> Result<SurfaceRegistration<To, From>, RegisterError> {
    check::check(surface, points, start, options)?;
    let cloud = &points.cloud;
    let anchors = start.anchors(cloud);
    let solver = Solver {
        tree: &surface.tree,
        field,
        anchors: &anchors,
        priors: &options.priors,
        end: options.kernel_end,
        facing: options.facing,
    };
    let seeds = start.seeds(surface, cloud, &anchors, &options.effort)?;
    let exact = Exact::new(&surface.tree, field, cloud.len());
    let searched = search(&solver, &exact, cloud, &seeds, &options.effort);
    result::result(&solver, &exact, points, searched)
}

/// Registers from one start alone, without a search: the minimum that a narrowing kernel leads to from there. It knows of no other
/// minimum, so that no verdict accepts it; for what moved a little since a registration was accepted.
///
/// # Errors
/// Each variant of [`RegisterError`].
pub fn refine<To: Frame, From: Frame>(
    surface: &Surface<To>,
    field: &Field,
    points: &Points<From>,
    start: &Rigid<To, From>,
    options: &Options,
) -> Result<SurfaceRegistration<To, From>, RegisterError> {
    let cloud = &points.cloud;
    let solver = Solver {
        tree: &surface.tree,
        field,
        anchors: &[],
        priors: &options.priors,
        end: options.kernel_end,
        facing: options.facing,
    };
    // From afar to near in one go: without other starts the kernel alone must find the way.
    let state = start::state(start, cloud);
    let [afar, narrowing, near] = crate::search::long_stages(options.kernel_end);
    let nowhere = || RegisterError::Nowhere { seeds: 1 };
    let sample = cloud.thinned(AFAR_POINTS);
    let (state, _) = solver
        .through(&sample, &solver.blunt(&sample), state, &afar)
        .and_then(|(state, _)| solver.through(cloud, &solver.blunt(cloud), state, &narrowing))
        .and_then(|(state, _)| solver.near(cloud, state, &near))
        .ok_or_else(nowhere)?;
    let exact = Exact::new(&surface.tree, field, cloud.len());
    let ended = solver.end(cloud, &exact, state).ok_or_else(nowhere)?;
    result::result(&solver, &exact, points, crate::search::Searched::of_one(ended))
}

/// Points by which one start finds its way from afar: a share of gross errors among so many is within some per cent that of all.
const AFAR_POINTS: usize = 80;

/// The pose of a state.
pub(crate) fn transform<To: Frame, From: Frame>(
    state: &crate::solve::State,
    points: &Points<From>,
) -> Result<Rigid<To, From>, RegisterError> {
    let rows: [[f64; 3]; 3] = [0, 1, 2].map(|i| [0, 1, 2].map(|j| state.turn[(i, j)]));
    // A product of some dozen turns, each exact to rounding.
    let matrix = RotationMatrix::new(rows, 1e-9).map_err(|_| RegisterError::Nowhere { seeds: 1 })?;
    let rotation = matrix.rotation();
    let turned = rotation.apply(points.cloud.centre.into());
    let shift = [0, 1, 2].map(|k| state.shift[k] - turned[k]);
    Ok(Rigid::from_parts(rotation, Vector::new(shift[0], shift[1], shift[2])))
}
