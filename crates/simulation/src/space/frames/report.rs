//! What a frame says of itself.

use crate::space::level_set::Unproved;
use crate::space::term::TubeForce;

/// How far a frame came.
#[derive(Debug, Clone, Copy, PartialEq)]
pub enum State {
    /// Forces balance within the tolerance and no point is deeper than allowed, at the pose asked for; and no solid is turned inside out: at the points of
    /// all elements; and in cubes whose middle is within two of their sides of the tube everywhere, as is proved of whole ones, or, in those that the surface
    /// cuts, at the points of the surface and on a grid inside of an eighth of the side, between which nothing is proved.
    Settled,
    /// At the pose asked for, but forces do not balance, or points are too deep, within the steps of a frame, or the determinant of the deformation
    /// gradient is not proved to be above zero.
    Approximate,
    /// The tube is still on its way to the pose asked for: the state is that of where it is.
    CatchingUp {
        /// The way that is left at the point of the tube that has the longest, mm.
        left: f64,
    },
    /// No state was found for this pose; the state is that of the last frame, and so are the numbers of this report.
    Refused(Refused),
}

/// Why a frame was refused.
#[derive(Debug, Clone, Copy, PartialEq, thiserror::Error)]
pub enum Refused {
    /// A pose that is none, or out of all reach.
    #[error("the pose of the tube is not finite, its quaternion not of unit length, or it is a million radii away")]
    Pose,
    /// Whoever asked denies the state: see [`super::Frames::frame_where`].
    #[error("whoever asked for a state does not take the one that was found")]
    Denied,
    /// No step lowers the energy.
    #[error("no step lowers the energy: the tissue cannot follow the tube")]
    NoStep,
    /// A problem of contact without an answer.
    #[error("the forces of contact do not settle")]
    NoContact,
    /// A point came so deep into the tube, or bone, that it might leave on the other side.
    #[error(
        "a point is {depth:.3} mm deep in the tube or bone; deeper than {most:.3} mm it might leave on the other side"
    )]
    TooDeep {
        /// Depth, mm.
        depth: f64,
        /// Half the radius.
        most: f64,
    },
    /// The tube, or bone, is in tissue where no contact was prepared, or where nothing can move it.
    #[error(
        "the tube or bone is {depth:.3} mm deep in the surface where no contact was prepared for it, or nothing moves"
    )]
    OutOfReach {
        /// The deepest point, mm.
        depth: f64,
    },
    /// The tube, or bone, has come through the surface between its points.
    #[error(
        "a point inside the tissue is {depth:.3} mm deep in the tube or bone; more than {most:.3} mm says that this has come through the surface between its points"
    )]
    Through {
        /// The deepest point inside, mm.
        depth: f64,
        /// The most, a fifth of the radius.
        most: f64,
    },
    /// Points of the surface are so far apart that the tube, or bone, may lie between them.
    #[error(
        "points of the surface at the tube or bone are {gap:.3} mm from the middle between them; that may lie unseen there, more than {most:.3} mm are too many"
    )]
    TooCoarse {
        /// The widest gap, mm.
        gap: f64,
        /// The most, half the radius.
        most: f64,
    },
    /// The surface may have met what of bone was not looked at, or an edge of it that is thinner than its ball.
    #[error("{0}")]
    Unproved(Unproved),
}

/// A state of the tissue for a pose of the tube, with what certifies it.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Frame {
    /// How far it came.
    pub state: State,
    /// Free forces over the forces of contact, of the tube where it presses, or over [`super::Settings::least_force`] where those are less; of several
    /// solids, each by its own, that of the worst.
    pub residual: f64,
    /// What further steps would move the tissue, mm along an axis: an estimate of the algebraic part of the error, three times what one step more, contact
    /// included, moves any point of a surface or inside. It is of no other part: not of the mesh, nor of the model. Infinite where there is no
    /// such step. No bound is proved; measured beside converged states in docs/tissue.md. Nodes outside the tissue, of cubes that the surface
    /// cuts, may move by far more.
    pub unsettled: f64,
    /// What the tissue does to the tube.
    pub force: TubeForce,
    /// Energy of solids, weights, loads and springs.
    pub energy: f64,
    /// The work that the tube did in this frame by the mean of its forces before and after: it differs from the gain of energy by a part of third
    /// order in the way (in a frame of one part, between settled states). Much more means that tissue has slipped from one state to another.
    pub work: f64,
    /// The least determinant of the deformation gradient at the points of the elements.
    pub least_determinant: f64,
    /// The deepest that a point is in the tube or bone, and the farthest off it while it presses, mm.
    pub depth: f64,
    /// The deepest that a point inside the tissue is in the tube or bone, mm: much only where that has come through the surface between points.
    pub inside: f64,
    /// The widest gap between points of the surface at the tube or bone, as it is stretched there, mm: what is so thick may lie between them unseen.
    pub gap: f64,
    /// Steps made.
    pub steps: usize,
    /// Which second derivatives served, counted from 1: with the poses it fixes the bits.
    pub factor: u64,
    /// Steps of Newton's method in the small problems of contact.
    pub contact_steps: usize,
}
