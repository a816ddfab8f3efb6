//! Why the base was not found, or the tool's place in it.

use super::feature::{Feature, OneSide};
use super::free_motion::FreeMotion;

/// Features by group, in the order of the groups.
fn named(features: &[Feature]) -> String {
    if features.is_empty() {
        return "none keeps a majority of the touches".to_owned();
    }
    let list: Vec<String> = features.iter().map(Feature::to_string).collect();
    list.join(", ")
}

/// Why touches, or a drawing, were refused. Groups, touches, grooves and frames count from 0.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum Refused {
    /// A number of the drawing is not finite.
    #[error("the drawing's {0} holds a number that is not finite")]
    DrawingNotFinite(Feature),
    /// A groove without length, with an impossible angle, or along the plane's normal.
    #[error(
        "groove {groove} is {length_mm:.3} mm long, has half an angle of {half_angle_rad:.4} rad and makes \
         {to_normal_rad:.4} rad with the plane's normal: a length, 0.01 to 1.56 rad and at least 0.2 rad are needed"
    )]
    BadGroove {
        /// The groove.
        groove: usize,
        /// Its length, mm.
        length_mm: f64,
        /// Half the angle between its walls, rad.
        half_angle_rad: f64,
        /// The angle between its line and the normal, rad.
        to_normal_rad: f64,
    },
    /// The noise, the radius or a limit is not usable.
    #[error("{what} is {found}, which is not a usable number")]
    BadOption {
        /// Which.
        what: &'static str,
        /// The number found.
        found: f64,
    },
    /// The touches leave a motion of the base open, whatever their number.
    #[error(
        "the base is not held: {free} stays open, condition {condition:.3e} where at most {allowed:.3e} is allowed"
    )]
    Unsolvable {
        /// The motion.
        free: FreeMotion,
        /// Ratio of the largest deviation to the least.
        condition: f64,
        /// The largest allowed.
        allowed: f64,
    },
    /// A touch is NaN or infinite.
    #[error("group {group}, touch {touch}: {found:?} holds a number that is not finite")]
    NotFinite {
        /// The group.
        group: usize,
        /// The touch.
        touch: usize,
        /// The place found, mm.
        found: [f64; 3],
    },
    /// There is not one covariance per touch.
    #[error("group {group} has {found} covariances for {touches} touches")]
    Unmatched {
        /// The group.
        group: usize,
        /// Covariances given.
        found: usize,
        /// Touches.
        touches: usize,
    },
    /// The noise of a touch is no covariance, or has none in some direction.
    #[error("group {group}, touch {touch}: the noise is not symmetric positive definite")]
    BadNoise {
        /// The group.
        group: usize,
        /// The touch.
        touch: usize,
    },
    /// A groove that the drawing does not have.
    #[error("group {group} is said to be groove {groove}; the base has grooves 0 to 2")]
    NoSuchGroove {
        /// The group.
        group: usize,
        /// The groove named.
        groove: usize,
    },
    /// There are not groups enough, or too many for a search.
    #[error("{found} groups of touches; the plane and three grooves need 4, and at most {most} are sorted out")]
    GroupCount {
        /// Groups that came.
        found: usize,
        /// The largest number.
        most: usize,
    },
    /// A group has too few touches.
    #[error("group {group} has {found} touches; {needed} are needed")]
    TooFew {
        /// The group.
        group: usize,
        /// Touches in it.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// A cloud of touches does not separate into three lines and a plane.
    #[error("among {touches} touches the line with the most has {found}; a groove needs {needed}")]
    NoLine {
        /// Touches left.
        touches: usize,
        /// Touches on the best line.
        found: usize,
        /// The least number.
        needed: usize,
    },
    /// No way of assigning the groups to the drawing fits.
    #[error(
        "the touches do not fit the drawing: at best ({}) {rejected} of {touches} lie more than {limit_mm:.3} mm off, where \
         {allowed} may, and the others are {noise_ratio:.2} times the noise off, where {max_noise_ratio} are allowed",
        named(.best)
    )]
    NoFit {
        /// The best assignment tried, by group.
        best: Vec<Feature>,
        /// Touches too far off.
        rejected: usize,
        /// All touches.
        touches: usize,
        /// How many may be left out.
        allowed: usize,
        /// The gate, mm.
        limit_mm: f64,
        /// Residuals of the others in units of the noise given; NaN where nothing was fitted.
        noise_ratio: f64,
        /// The largest accepted.
        max_noise_ratio: f64,
    },
    /// The groups were touched in another order than said.
    #[error("touched in another order than said: said ({}), but the touches fit ({})", named(.said), named(.found))]
    WrongOrder {
        /// The labels given, by group.
        said: Vec<Feature>,
        /// Those that fit.
        found: Vec<Feature>,
    },
    /// Two places of the base fit equally well.
    #[error(
        "two places of the base fit: ({}) and ({}), {apart_mm:.1} mm apart, chi-square {:.1} and {:.1}; label the groups, \
         or touch what tells them apart", named(&.assignments[0]), named(&.assignments[1]), .chi_squared[0],
        .chi_squared[1]
    )]
    Ambiguous {
        /// Both assignments, by group.
        assignments: [Vec<Feature>; 2],
        /// Largest distance between the two places of a groove's end, mm.
        apart_mm: f64,
        /// Sum of squared residuals in units of the noise given.
        chi_squared: [f64; 2],
    },
    /// The mirror image of the touches fits better.
    #[error(
        "the mirror image of the touches fits the drawing better, chi-square {:.1} against {:.1}: the localizer's axes are left-handed, or \
         one has the wrong sign", .chi_squared[1], .chi_squared[0]
    )]
    Mirrored {
        /// Sum of squared residuals in units of the noise given: of the touches, and of their mirror image.
        chi_squared: [f64; 2],
    },
    /// The touches of features lie off them all together.
    #[error(
        "the touches lie to one side of features as a whole (squares of their means over the noise {squares:.0}, at most {allowed:.0}), most of all the \
         {} touches of the {}, by {:.2} mm: dirt on it, a tip of another radius than was told, or a base that is not as it is drawn",
        .worst.touches, .worst.feature, .worst.off_mm
    )]
    OneSide {
        /// The feature that is farthest off by its noise.
        worst: OneSide,
        /// Squares of the means over the noise of means.
        squares: f64,
        /// The most.
        allowed: f64,
    },
    /// The covariance that came out is not one.
    #[error(transparent)]
    Covariance(#[from] geometry::uncertain::CovarianceError),
    /// No frame shows the tool in its seat.
    #[error("no frame shows the tool in its seat")]
    NoFrame,
    /// The mean of the frames does not settle: they are too far apart for one.
    #[error("the mean of the frames does not settle in {steps} steps: they are not of one place")]
    NoConvergence {
        /// Steps made.
        steps: usize,
    },
    /// A frame's pose has no error in some direction, so that frames cannot be weighed.
    #[error("frame {frame}: the covariance of the pose is singular, so that frames cannot be weighed")]
    Singular {
        /// The frame.
        frame: usize,
    },
    /// The tool was not still, or not in its seat, in a frame.
    #[error("frame {frame} is {found:.1} deviations from the mean of {frames}; {gate} are allowed: the tool moved")]
    Moved {
        /// The frame.
        frame: usize,
        /// Root of its chi-square, deviations.
        found: f64,
        /// How many frames there are.
        frames: usize,
        /// The largest allowed.
        gate: f64,
    },
}
