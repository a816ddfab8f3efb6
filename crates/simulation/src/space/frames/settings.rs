//! What a frame may cost, when it counts as settled, and what is refused before any.

use super::report::Refused;
use crate::sparse::{NoOrder, Precision};

/// When a frame ends, and how old factors may be.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Settings {
    /// Free forces over the forces of contact (both as lengths of the vector of a solid's unknowns) at which a frame is settled: of each solid.
    pub tolerance: f64,
    /// The deepest that a point may be in the tube, and the farthest off it while it presses, in a settled frame, mm; at most a tenth of the tube's
    /// least radius.
    pub depth: f64,
    /// Steps at a pose at most; on the way to it four in each part, and once more in halves where that leads nowhere. Never a time: the same
    /// poses give the same bits.
    pub most_steps: usize,
    /// A pose farther away than this part of the tube's least radius is walked to in parts; so many of them in a frame at most.
    pub most_parts: usize,
    /// New second derivatives are asked for once the tube has gone so far, mm.
    pub refresh: f64,
    /// Frames later that they are taken up: in the meantime another thread factors them. 0: at once, in the same thread.
    pub delay: usize,
    /// How factors are stored for solutions; forces are always double.
    pub precision: Precision,
    /// The least force that free forces are measured by, in the system's unit of force: where nothing presses they have no other
    /// measure. `None`: of each solid its shear modulus times the square of a hundredth of its side.
    pub least_force: Option<f64>,
}

impl Default for Settings {
    /// A thousandth, as for pictures at 60 Hz.
    fn default() -> Self {
        Self {
            tolerance: 1e-3,
            depth: 1e-3,
            most_steps: 12,
            most_parts: 4,
            refresh: 1.0,
            delay: 2,
            precision: Precision::Double,
            least_force: None,
        }
    }
}

/// Why a system has no frames.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum NoFrames {
    /// Tubes are given by [`super::Frames::new`].
    #[error("the system has {found} contacts with tubes of its own; frames take the tube by itself: leave them out")]
    Tubes {
        /// How many.
        found: usize,
    },
    /// Contact between organs.
    #[error("the system has {found} contacts between organs, which frames do not settle yet: use `settle`")]
    Organs {
        /// How many.
        found: usize,
    },
    /// A term whose forces change from round to round.
    #[error(
        "term {term} of the system changes its forces from round to round, which frames do not do yet: use `settle`"
    )]
    Changing {
        /// Which, from 0.
        term: usize,
    },
    /// A solid whose points do not move as nodes do.
    #[error(
        "point {point} of the surface of solid {body} does not move with nodes: frames take deformable solids only"
    )]
    NotNodal {
        /// The solid.
        body: usize,
        /// The point.
        point: usize,
    },
    /// A solid that does not exist.
    #[error("there is no solid {body}: the system has {solids}")]
    NoBody {
        /// The number asked for.
        body: usize,
        /// How many there are.
        solids: usize,
    },
    /// A state of another size.
    #[error("the state has {found} numbers, the system {expected}")]
    Size {
        /// Numbers given.
        found: usize,
        /// Numbers of the system.
        expected: usize,
    },
    /// The tube, or bone, begins in tissue.
    #[error(
        "at the start a point of the tissue is {depth:.3} mm deep in the tube or bone; {most:.3} mm are the most that leads out again"
    )]
    TooDeep {
        /// Depth, mm.
        depth: f64,
        /// Half the radius, of a point of the surface; a fifth of one inside.
        most: f64,
    },
    /// The tube, or bone, begins where frames would be refused.
    #[error("at the start {0}")]
    Start(Refused),
    /// No point of the surface is wanted, or none that moves.
    #[error("no point of the surface of solid {body} that moves lies where the tube may press")]
    NoPoint {
        /// The solid.
        body: usize,
    },
    /// No energy, or a number that is none.
    #[error("the state at the start has no energy: it is not finite, or the law forbids it")]
    NoEnergy,
    /// The second derivatives at the start have no factor.
    #[error(
        "the second derivatives at the start are not positive definite, nor is a convex matrix near them: is the solid held?"
    )]
    NoFactor,
    /// No order of elimination.
    #[error(transparent)]
    Order(#[from] NoOrder),
    /// A setting out of range.
    #[error("{name} is {found}; it must be {allowed}")]
    Setting {
        /// Its name.
        name: &'static str,
        /// The number found.
        found: f64,
        /// What is allowed.
        allowed: &'static str,
    },
}

impl Settings {
    /// Refuses numbers that no frame could be found with.
    pub(super) fn check(&self, radius: f64) -> Result<(), NoFrames> {
        let above = |name, found: f64| match found.is_finite() && found > 0.0 {
            true => Ok(()),
            false => Err(NoFrames::Setting {
                name,
                found,
                allowed: "finite and above 0",
            }),
        };
        above("tolerance", self.tolerance)?;
        above("depth", self.depth)?;
        if self.depth > 0.1 * radius {
            return Err(NoFrames::Setting {
                name: "depth",
                found: self.depth,
                allowed: "at most a tenth of the tube's least radius",
            });
        }
        above("refresh", self.refresh)?;
        above("least_force", self.least_force.unwrap_or(1.0))?;
        above("most_steps", self.most_steps as f64)?;
        above("most_parts", self.most_parts as f64)
    }
}
