//! The sight on the chosen target, of the very pose that the images show.

use bus::gather::PoseId;
use bus::message::{Chosen, FrameHeader, FrameStamp, FrameState, TargetShown, ToolPose, Tracked, Workflow};
use geometry::{Ct, Direction, Point, checked};
use guidance::sight::{Aim, Covariance, NoSight, Pose, Sight, SightAxes, Thresholds, ToolShape, sight};
use scene::Scene;

use super::state::other_recording;
use super::{Known, ScreenState};

/// The tip may be so far off the planned line while it advances, mm.
const CORRIDOR_MM: f64 = 10.0;
/// The axis may be so far off the planned direction while it advances, rad: 5 degrees.
const ALIGN_RAD: f64 = 0.087;

/// The sight with what it aims at.
#[derive(Debug, Clone, PartialEq)]
pub struct Aimed {
    /// The target, with its entry and stop; its centre is where the image beside has it.
    pub target: Chosen,
    /// Where that is.
    pub whereabouts: TargetShown,
    /// What is shown of the pose.
    pub sight: Sight,
    /// The pose that it is of.
    pub pose: PoseId,
}

/// The sight, or why there is none, in words.
///
/// # Errors
/// In words for the screen: nothing to be followed, nothing chosen, not navigating, a pose that is not here, numbers that are no sight.
pub fn aimed(known: &Known<'_>, state: &ScreenState) -> Result<Aimed, String> {
    if !state.follows {
        return Err(state.word.clone());
    }
    if let Some(why) = other_recording(known) {
        return Err(why.to_owned());
    }
    let guide = known.guide.ok_or("no target chosen: what is aimed at is not known")?;
    let target = guide.chosen().map_err(|e| e.to_string())?.ok_or("no target chosen")?;
    let workflow = known.workflow.ok_or("how far the run has come is not known")?;
    if !workflow.has(Workflow::SIGHT) {
        let stage = workflow.stage().map_or("not known", |stage| stage.word());
        return Err(format!("not navigating: {stage}"));
    }
    let header = known.sighted().ok_or("no image to be in step with")?;
    let pose_id = PoseId::of(&header.stamp);
    let is_live = header.stamp.state_at(known.now_ns, known.ages()) == Some(FrameState::Live);
    if !is_live {
        return Err("the image beside it is not live".to_owned());
    }
    let pose = known.pose_of(&header);
    let pose = pose.ok_or("the pose of the images has not come")?;
    let (centre, whereabouts) = shown(known.scene, &header.stamp, target.centre)?;
    let target = Chosen { centre, ..target };
    let sight = of_pose(pose, &header, &target, whereabouts)?;
    Ok(Aimed {
        target,
        whereabouts,
        sight,
        pose: pose_id,
    })
}

/// Where the image of a stamp has the chosen target.
fn shown(scene: &Scene, stamp: &FrameStamp, planned: Point<Ct>) -> Result<(Point<Ct>, TargetShown), String> {
    if scene.tissue.is_none() {
        return Ok((planned, TargetShown::Planned));
    }
    let whereabouts = TargetShown::from_code(stamp.target).filter(|shown| *shown != TargetShown::Planned);
    let whereabouts = whereabouts.ok_or("the image beside it does not say where it has the target")?;
    if whereabouts == TargetShown::None || stamp.target_mm != planned.mm() {
        return Err("the image beside it does not show this target yet".to_owned());
    }
    let centre = checked::point(stamp.target_shown_mm).map_err(|e| e.to_string())?;
    Ok((centre, whereabouts))
}

/// Whether nobody knows how far off the target's place is: a model's error is not told, and organs that are shown at rest may be elsewhere.
fn is_uncertain(whereabouts: TargetShown) -> bool {
    match whereabouts {
        TargetShown::None | TargetShown::Planned | TargetShown::Beside => false,
        TargetShown::Model | TargetShown::NotSettled | TargetShown::AtRest => true,
    }
}

fn of_pose(pose: &ToolPose, header: &FrameHeader, target: &Chosen, whereabouts: TargetShown) -> Result<Sight, String> {
    let ct_from_tool = match pose.tracked() {
        Ok(Tracked::Valid(pose)) => pose,
        Ok(Tracked::Lost(reason)) => return Err(reason.words().to_owned()),
        Err(error) => return Err(error.to_string()),
    };
    // No verdict but that the error is not known.
    let covariance = match is_uncertain(whereabouts) {
        true => Covariance::Missing,
        false => covariance(pose),
    };
    let tool = ToolShape {
        tip_in_tool: Point::new(0.0, 0.0, 0.0),
        axis_in_tool: Direction::Z,
    };
    let aim = Aim {
        target: target.centre,
        radius_mm: target.radius_mm,
        // The way to a place that has moved is not the planned one: nobody is led off that to it.
        entry: target.entry.filter(|_| !whereabouts.is_moved()),
        stop_mm: target.stop_mm,
    };
    let thresholds = Thresholds {
        corridor_mm: CORRIDOR_MM,
        align_rad: ALIGN_RAD,
    };
    let pose = Pose::Valid {
        ct_from_tool,
        covariance,
    };
    let shown: Result<Sight, NoSight<bus::message::Lost>> =
        sight(pose, &tool, &aim, &axes(header, ct_from_tool), &thresholds);
    shown.map_err(|no_sight| match no_sight {
        NoSight::Lost(reason) => reason.words().to_owned(),
        NoSight::Refused(why) => why.to_string(),
    })
}

/// What is known of the pose's error. A source without noise may stand on a registration with one: exact is only what has no variance
/// and says that its tip is known without an error.
fn covariance(pose: &ToolPose) -> Covariance {
    let is_zero = pose.covariance.iter().all(|variance| *variance == 0.0);
    match pose.tip_95_mm() {
        None => Covariance::Missing,
        Some(0.0) if is_zero && pose.flags & ToolPose::NOISELESS != 0 => Covariance::Exact,
        Some(_) => Covariance::Upper(pose.covariance),
    }
}

/// Right and down of the image across the tube, where there is one along this axis; else the tool's own.
fn axes(header: &FrameHeader, ct_from_tool: geometry::Rigid<geometry::Ct, geometry::Tool>) -> SightAxes {
    let along = ct_from_tool * Direction::Z;
    let across = header
        .slice_plane()
        .ok()
        .flatten()
        .filter(|plane| plane.into_screen().dot(along) > 1.0 - 1e-9);
    match across {
        Some(plane) => SightAxes {
            right: plane.right(),
            down: plane.down(),
        },
        // As an image with the tool's own up: +y of the tool.
        None => SightAxes {
            right: ct_from_tool * -Direction::X,
            down: ct_from_tool * -Direction::Y,
        },
    }
}
