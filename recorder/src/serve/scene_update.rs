//! Tool, targets and planes as Foxglove draws them: along the axes of the CT (LPS), in metres.

use bus::message::{FrameState, Lost, ToolPose, Tracked};
use foxglove::messages::{
    Color, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate, SpherePrimitive,
    TextPrimitive, Timestamp, Vector3, line_primitive,
};
use geometry::{Ct, Point, SlicePlane, Tool};
use picture::Rgb;
use picture::palette::{ALARM, QUIET, TARGET, TUBE, WARN};
use scene::{Scene, Target};

use super::NOTICE;
use super::views::Claim;
use crate::wire::proto::file_time;

/// The frame that everything is in, as the transforms of a recording name it.
const FRAME: &str = "ct";

/// The scene at a time; the tool is there as long as an image may claim `pose`.
pub(super) fn of(
    scene: &Scene,
    now_ns: i64,
    claim: Option<&Claim>,
    pose: Option<&ToolPose>,
    planes: Vec<(String, SlicePlane)>,
) -> SceneUpdate {
    let at = stamp(now_ns);
    let tool = tool(scene, claim, pose);
    let mut entities = vec![
        entity(at, "targets", |entity| targets(entity, &scene.targets)),
        entity(at, "notice", |entity| entity.texts.push(notice(scene, claim))),
    ];
    // What is not there any more is taken away: a picture that stays would be believed.
    let mut deletions = Vec::new();
    match tool {
        Some(line) => entities.push(entity(at, "tool", |entity| entity.lines.push(line))),
        None => deletions.push(deletion(at, "tool")),
    }
    match planes.is_empty() {
        true => deletions.push(deletion(at, "planes")),
        false => entities.push(entity(at, "planes", |entity| {
            entity.lines.extend(planes.iter().map(|(_, plane)| outline(plane)));
        })),
    }
    SceneUpdate { deletions, entities }
}

fn entity(at: Timestamp, id: &str, fill: impl FnOnce(&mut SceneEntity)) -> SceneEntity {
    let mut entity = SceneEntity {
        timestamp: Some(at),
        frame_id: FRAME.to_owned(),
        id: id.to_owned(),
        ..SceneEntity::default()
    };
    fill(&mut entity);
    entity
}

fn deletion(at: Timestamp, id: &str) -> SceneEntityDeletion {
    SceneEntityDeletion {
        timestamp: Some(at),
        id: id.to_owned(),
        // MATCHING_ID.
        r#type: 0,
    }
}

/// The tube from its tip to its handle.
fn tool(scene: &Scene, claim: Option<&Claim>, pose: Option<&ToolPose>) -> Option<LinePrimitive> {
    let colour = match claim?.state? {
        FrameState::Live => TUBE,
        FrameState::Stale => WARN,
        FrameState::Requested | FrameState::Look | FrameState::Lost(_) => return None,
    };
    let Ok(Tracked::Valid(ct_from_tool)) = pose?.tracked() else {
        return None;
    };
    let ends = [0.0, -scene.tool.length_mm].map(|z| ct_from_tool * Point::<Tool>::new(0.0, 0.0, z));
    Some(LinePrimitive {
        r#type: line_primitive::Type::LineStrip as i32,
        pose: Some(identity()),
        thickness: scene.tool.diameter_mm / 1e3,
        points: ends.map(point).into(),
        color: Some(rgba(colour, 1.0)),
        ..LinePrimitive::default()
    })
}

fn targets(entity: &mut SceneEntity, targets: &[Target]) {
    for target in targets {
        let place = pose_at(target.centre);
        let side = target.diameter_mm / 1e3;
        entity.spheres.push(SpherePrimitive {
            pose: Some(place),
            size: Some(Vector3 {
                x: side,
                y: side,
                z: side,
            }),
            color: Some(rgba(TARGET, 0.8)),
        });
        entity.texts.push(words(place, &target.name, TARGET));
    }
}

fn outline(plane: &SlicePlane) -> LinePrimitive {
    let [width, height] = plane.size().map(f64::from);
    let corners = [[0.0, 0.0], [width, 0.0], [width, height], [0.0, height]];
    // A pixel's centre is half a pixel from its corner.
    let corner = |[x, y]: [f64; 2]| point(plane.point(x - 0.5, y - 0.5));
    LinePrimitive {
        r#type: line_primitive::Type::LineLoop as i32,
        pose: Some(identity()),
        thickness: 2.0,
        scale_invariant: true,
        points: corners.map(corner).into(),
        color: Some(rgba(QUIET, 0.8)),
        ..LinePrimitive::default()
    }
}

/// What this is, and what may be claimed; at the first target, else at the origin.
fn notice(scene: &Scene, claim: Option<&Claim>) -> TextPrimitive {
    let (state, colour) = match claim.map(|claim| (claim.state, claim.stamp.replay, claim.stamp.seq)) {
        None => ("NO IMAGE YET".to_owned(), QUIET),
        Some((_, 1, seq)) => (format!("REPLAY, pose {seq}"), WARN),
        Some((_, 2, seq)) => (format!("SIMULATED TIME, pose {seq}"), WARN),
        Some((Some(FrameState::Live), _, seq)) => (format!("live, pose {seq}"), WARN),
        Some((Some(FrameState::Stale), _, seq)) => (format!("POSE OLD, pose {seq}"), ALARM),
        Some((Some(FrameState::Lost(why)), ..)) => (format!("NO POSE: {}", Lost::words(why)), ALARM),
        Some(_) => ("NO POSE".to_owned(), ALARM),
    };
    let place = scene
        .targets
        .first()
        .map_or(Point::new(0.0, 0.0, 0.0), |target| target.centre);
    let mut text = words(pose_at(place), &format!("{NOTICE}\n{state}"), colour);
    text.font_size = 20.0;
    text
}

fn words(place: Pose, text: &str, colour: Rgb) -> TextPrimitive {
    TextPrimitive {
        pose: Some(place),
        billboard: true,
        font_size: 12.0,
        scale_invariant: true,
        color: Some(rgba(colour, 1.0)),
        text: text.to_owned(),
    }
}

fn point(p: Point<Ct>) -> Point3 {
    let [x, y, z] = p.mm().map(|mm| mm / 1e3);
    Point3 { x, y, z }
}

fn pose_at(p: Point<Ct>) -> Pose {
    let Point3 { x, y, z } = point(p);
    Pose {
        position: Some(Vector3 { x, y, z }),
        ..identity()
    }
}

fn identity() -> Pose {
    Pose {
        position: Some(Vector3::default()),
        orientation: Some(Quaternion {
            w: 1.0,
            ..Quaternion::default()
        }),
    }
}

fn rgba(Rgb(r, g, b): Rgb, a: f64) -> Color {
    let [r, g, b] = [r, g, b].map(|level| f64::from(level) / 255.0);
    Color { r, g, b, a }
}

fn stamp(now_ns: i64) -> Timestamp {
    const SECOND: u64 = 1_000_000_000;
    let t_ns = file_time(now_ns);
    // 136 years of a run's clock.
    Timestamp::new((t_ns / SECOND) as u32, (t_ns % SECOND) as u32)
}
