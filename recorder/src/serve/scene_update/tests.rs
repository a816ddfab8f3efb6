use std::path::Path;

use bus::message::Tracked;

use super::*;
use crate::testing;

const SENT: (u32, u32) = (1_700_000_000, 5);

fn scene(more: &str) -> Scene {
    let text = format!("[[targets]]\nname = \"node\"\nct_mm = [10, -20, 30]\n{more}");
    Scene::parse(&text, Path::new("s.toml")).unwrap()
}

fn update(scene: &Scene, standing: &Standing, marks: &[&str]) -> SceneUpdate {
    let axes = [geometry::Direction::X, geometry::Direction::Y];
    let plane = SlicePlane::centred(Point::new(1.0, 2.0, 3.0), axes, 0.5, [4, 2]).unwrap();
    of(
        scene,
        Timestamp::new(SENT.0, SENT.1),
        standing,
        marks,
        &[("axial".to_owned(), plane)],
    )
}

fn ids(update: &SceneUpdate) -> (Vec<&str>, Vec<&str>) {
    (
        update.entities.iter().map(|entity| entity.id.as_str()).collect(),
        update.deletions.iter().map(|deletion| deletion.id.as_str()).collect(),
    )
}

fn notice_of(update: &SceneUpdate) -> &str {
    let notice = update.entities.iter().find(|entity| entity.id == "notice").unwrap();
    &notice.texts[0].text
}

#[test]
fn the_scene_lies_along_the_axes_of_the_ct_in_metres() {
    let pose = testing::pose(7);
    let Ok(Tracked::Valid(place)) = pose.tracked() else {
        panic!()
    };
    let scene = scene("");
    let update = update(&scene, &Standing::Live(7, place), &[]);
    let entity = |id| update.entities.iter().find(|entity| entity.id == id).unwrap();
    assert!(update.entities.iter().all(|entity| entity.frame_id == "ct"));
    let [tip, handle] = &entity("tool").lines[0].points[..] else {
        panic!()
    };
    for (found, mm) in [tip.x, tip.y, tip.z].into_iter().zip(pose.t_mm) {
        assert!((1000.0 * found - mm).abs() < 1e-9, "{found} {mm}");
    }
    let length = (tip.x - handle.x).hypot(tip.y - handle.y).hypot(tip.z - handle.z);
    assert!((1000.0 * length - scene.tool.length_mm).abs() < 1e-9, "{length}");
    let target = entity("targets").spheres[0].pose.unwrap().position.unwrap();
    assert_eq!((target.x, target.y, target.z), (0.01, -0.02, 0.03));
    // Four by two pixels of half a millimetre about (1, 2, 3): from border to border, not from centre to centre.
    let corners: Vec<_> = entity("planes").lines[0]
        .points
        .iter()
        .map(|p| [p.x, p.y, p.z])
        .collect();
    let expected = [[0.0, 1.5, 3.0], [2.0, 1.5, 3.0], [2.0, 2.5, 3.0], [0.0, 2.5, 3.0]];
    for (found, expected) in corners.iter().flatten().zip(expected.iter().flatten()) {
        assert!((1000.0 * found - expected).abs() < 1e-9, "{corners:?}");
    }
}

/// Where messages stop, what stands on the screen would stay for ever.
#[test]
fn what_follows_the_tool_is_drawn_for_a_second_and_taken_away_with_the_pose() {
    let Ok(Tracked::Valid(place)) = testing::pose(7).tracked() else {
        panic!()
    };
    let scene = scene("");
    for standing in [Standing::Live(7, place), Standing::Old(7, place)] {
        let update = update(&scene, &standing, &[]);
        assert_eq!(ids(&update), (vec!["targets", "notice", "tool", "planes"], vec![]));
        for entity in &update.entities {
            let seconds = entity.lifetime.map(|lifetime| lifetime.sec());
            let follows = ["tool", "planes"].contains(&entity.id.as_str());
            assert_eq!(seconds, follows.then_some(1), "{}", entity.id);
            assert_eq!(entity.timestamp, Some(Timestamp::new(SENT.0, SENT.1)));
        }
    }
    for standing in [
        Standing::Lost("silent".to_owned()),
        Standing::NoImage,
        Standing::Withheld("pushed"),
        Standing::Ended("over"),
    ] {
        let update = update(&scene, &standing, &[]);
        assert_eq!(
            ids(&update),
            (vec!["targets", "notice"], vec!["tool", "planes"]),
            "{standing:?}"
        );
    }
}

/// The words of a replay stood in the place of those of a pose that was lost.
#[test]
fn a_replay_that_lost_its_pose_says_both() {
    let lost = Standing::Lost("the marker is hidden".to_owned());
    let update = update(&scene(""), &lost, &["REPLAY, NOT LIVE", "NOT CHECKED"]);
    assert_eq!(
        notice_of(&update),
        "RESEARCH DISPLAY 22:13:20Z\nREPLAY, NOT LIVE\nNOT CHECKED\nNO POSE: the marker is hidden"
    );
}

/// A target may have any name: in two lines it could say what looks like a line of ours.
#[test]
fn the_name_of_a_target_writes_no_line_of_ours() {
    let scene = scene("[[targets]]\nname = \"b\\nlive, pose 9\\u202Eesop\"\nct_mm = [1, 2, 3]\n");
    let update = update(&scene, &Standing::NoImage, &[]);
    let targets = update.entities.iter().find(|entity| entity.id == "targets").unwrap();
    let names: Vec<_> = targets.texts.iter().map(|text| text.text.as_str()).collect();
    assert_eq!(names, ["node", "b live, pose 9 esop"]);
}
