use super::shapes::round_length;
use super::words::{age_words, unusual};
use super::*;
use geometry::{Affine, VolumeGrid};
use scene::SlabMode;

use crate::view;

/// A perpendicular image of nothing, with all that is drawn over it.
fn drawn(notice: Notice, origin: Origin) -> Canvas {
    let scene = scene::Scene::parse("", std::path::Path::new("")).unwrap();
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let grid = VolumeGrid::checked([100; 3], affine).unwrap();
    let view = &scene.views[6];
    let pose = Rigid::identity();
    let overlay = Overlay {
        view,
        plane: &view::plane(view, &grid, &pose).unwrap(),
        pose: Some(pose),
        tool: &scene.tool,
        targets: &scene.targets,
        accuracy: None,
        outside: false,
        remarks: &[],
        notice,
        origin,
        seq: 7,
        registration_id: 1,
        volume: "01234567",
        marks: Marks::default(),
        caution: "",
    };
    let mut canvas = Canvas::new(view.size[0], view.size[1]);
    overlay.draw(&mut canvas);
    canvas
}

/// How many pixels have the colour of replays.
fn replay_pixels(canvas: &Canvas) -> usize {
    let Rgb(r, g, b) = palette::REPLAY;
    canvas
        .rgba()
        .chunks_exact(4)
        .filter(|pixel| pixel[..3] == [r, g, b])
        .count()
}

#[test]
fn whatever_moves_in_a_replay_says_so_and_nothing_else_does() {
    let moving = [
        Notice::Live,
        Notice::Stale(1_000_000_000),
        Notice::Lost(Lost::NotSeen, None),
    ];
    for notice in moving {
        // A frame of 5 pixels around 512 x 512; a stale or lost one has its own, and keeps the word: six letters 17 pixels
        // high, each with a stroke that covers at least one pixel across its width wholly.
        let least = if notice == Notice::Live { 4 * 5 * 500 } else { 6 * 16 };
        let found = replay_pixels(&drawn(notice, Origin::Recording));
        assert!(found > least, "{notice:?}: {found} pixels");
        assert_eq!(replay_pixels(&drawn(notice, Origin::Tracker)), 0, "{notice:?}");
    }
}

#[test]
fn a_held_image_is_the_same_in_a_replay_unless_the_examination_is_another() {
    let of = |origin| drawn(Notice::Requested, origin).rgba().to_vec();
    let live = of(Origin::Tracker);
    assert!(live == of(Origin::Recording));
    assert!(live != of(Origin::RecordingOfAnother) && live != of(Origin::RecordingOfUnknown));
}

#[test]
fn slabs_and_planes_ahead_are_said() {
    let scene = scene::Scene::parse("", std::path::Path::new("")).unwrap();
    let mut view = scene.views[6].clone();
    assert_eq!(unusual(&view), None);
    view.ahead_mm = 10.0;
    view.sampling.slab = Some(scene::Slab {
        mode: SlabMode::Maximum,
        thickness_mm: 5.0,
    });
    assert_eq!(unusual(&view).unwrap(), "MAX 5 mm, +10 mm AHEAD");
}

#[test]
fn scale_bars_are_round() {
    for (mm, expected) in [(25.0, 20.0), (100.0, 100.0), (0.9, 0.5), (60.0, 50.0), (199.0, 100.0)] {
        assert!((round_length(mm) - expected).abs() < 1e-9, "{mm}");
    }
}

#[test]
fn ages_are_words() {
    assert_eq!(age_words(320_000_000), "320\u{a0}ms");
    assert_eq!(age_words(2_340_000_000), "2.3\u{a0}s");
}
