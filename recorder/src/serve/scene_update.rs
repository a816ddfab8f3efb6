//! Tool, targets and planes as Foxglove draws them: along the axes of the CT (LPS), in metres.

use foxglove::messages::{
    Color, Duration, LinePrimitive, Point3, Pose, Quaternion, SceneEntity, SceneEntityDeletion, SceneUpdate,
    SpherePrimitive, TextPrimitive, Timestamp, Vector3, line_primitive,
};
use geometry::{Ct, Point, Rigid, SlicePlane, Tool};
use picture::Rgb;
use picture::palette::{ALARM, QUIET, TARGET, TUBE, WARN};
use scene::{Scene, Target};

use super::NOTICE;
use super::standing::Standing;

/// The frame that everything is in, as the transforms of a recording name it.
const FRAME: &str = "ct";

/// How long Foxglove draws what follows the tool unless it is told again, seconds: ten scenes later nobody knows that it is still there.
const LIFETIME_S: i32 = 1;

/// The scene at a time: the tool and the slices are there as long as they may be claimed.
///
/// `sent` is on the wall's clock, by which Foxglove judges how long an entity lives. `marks` stand beside
/// whatever is shown: what the poses come from, what was not checked.
pub(super) fn of(
    scene: &Scene,
    sent: Timestamp,
    standing: &Standing,
    marks: &[&str],
    planes: &[(String, SlicePlane)],
) -> SceneUpdate {
    let mut entities = vec![
        entity(sent, "targets", |entity| targets(entity, &scene.targets)),
        entity(sent, "notice", |entity| {
            entity.texts.push(notice(scene, sent, standing, marks))
        }),
    ];
    // What is not there any more is taken away: a picture that stays would be believed.
    let mut deletions = Vec::new();
    match tool(scene, standing) {
        Some(line) => entities.push(mortal(sent, "tool", vec![line])),
        None => deletions.push(deletion(sent, "tool")),
    }
    match planes.is_empty() || !standing.has_pose() {
        true => deletions.push(deletion(sent, "planes")),
        false => {
            let lines = planes.iter().map(|(_, plane)| outline(plane)).collect();
            entities.push(mortal(sent, "planes", lines));
        }
    }
    SceneUpdate { deletions, entities }
}

/// What follows the tool.
fn mortal(sent: Timestamp, id: &str, lines: Vec<LinePrimitive>) -> SceneEntity {
    entity(sent, id, |entity| {
        entity.lifetime = Some(Duration::new(LIFETIME_S, 0));
        entity.lines = lines;
    })
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
fn tool(scene: &Scene, standing: &Standing) -> Option<LinePrimitive> {
    let (colour, ct_from_tool): (_, &Rigid<Ct, Tool>) = match standing {
        Standing::Live(_, pose) => (TUBE, pose),
        Standing::Old(_, pose) => (WARN, pose),
        Standing::Lost(_) | Standing::NoImage | Standing::Withheld(_) | Standing::Ended(_) => return None,
    };
    let ends = [0.0, -scene.tool.length_mm].map(|z| *ct_from_tool * Point::<Tool>::new(0.0, 0.0, z));
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
        entity.texts.push(words(place, &one_line(&target.name), TARGET));
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

/// What this is, when it was sent, and what may be claimed; at the first target, else at the origin.
fn notice(scene: &Scene, sent: Timestamp, standing: &Standing, marks: &[&str]) -> TextPrimitive {
    let colour = match standing {
        Standing::Live(..) => WARN,
        Standing::Old(..) | Standing::Lost(_) | Standing::NoImage | Standing::Withheld(_) | Standing::Ended(_) => ALARM,
    };
    let place = scene
        .targets
        .first()
        .map_or(Point::new(0.0, 0.0, 0.0), |target| target.centre);
    let [hour, minute, second] = [3600, 60, 1].map(|unit| sent.sec() / unit % if unit == 3600 { 24 } else { 60 });
    let at = format!("{NOTICE} {hour:02}:{minute:02}:{second:02}Z");
    let state = standing.words();
    let lines: Vec<_> = [at.as_str()]
        .into_iter()
        .chain(marks.iter().copied())
        .chain([state.as_str()])
        .collect();
    let mut text = words(pose_at(place), &lines.join("\n"), colour);
    text.font_size = 20.0;
    text
}

/// A name in one line: one that breaks it, or turns its direction, could write what looks like a line of ours.
fn one_line(name: &str) -> String {
    let breaks = |c: char| {
        c.is_control() || matches!(c, '\u{2028}'..='\u{202e}' | '\u{2066}'..='\u{2069}' | '\u{200e}' | '\u{200f}')
    };
    name.chars().map(|c| if breaks(c) { ' ' } else { c }).collect()
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

#[cfg(test)]
mod tests;
