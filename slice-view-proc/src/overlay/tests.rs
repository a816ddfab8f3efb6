use super::ruler::round_length;
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
        is_placed: true,
        views: &scene.views,
        pose: Some(pose),
        tool: &scene.tool,
        targets: &scene.targets,
        chosen: None,
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
        tissue: crate::tissue::Tissues::default(),
    };
    let mut canvas = Canvas::new(view.size[0], view.size[1]);
    overlay.draw(&mut canvas);
    canvas
}

/// How many pixels have the colour of replays.
fn replay_pixels(canvas: &Canvas) -> usize {
    pixels_of(canvas, palette::REPLAY)
}

/// How many pixels have this colour.
fn pixels_of(canvas: &Canvas, Rgb(r, g, b): Rgb) -> usize {
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

/// A local image of two targets, the near one at the tip, with this one chosen.
fn of_targets<T>(chosen: Option<&Chosen>, look: impl FnOnce(&Overlay<'_>) -> T) -> T {
    let text = "[[targets]]\nname = \"near\"\nct_mm = [51, 50, 50]\n[[targets]]\nname = \"far\"\nct_mm = [70, 50, 50]";
    let scene = scene::Scene::parse(text, std::path::Path::new("")).unwrap();
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let grid = VolumeGrid::checked([100; 3], affine).unwrap();
    let view = &scene.views[6];
    let pose = Rigid::from_rotation_vector(
        geometry::Vector::new(0.0, 0.0, 0.0),
        geometry::Vector::new(50.0, 50.0, 50.0),
    );
    let pose = pose.unwrap();
    look(&Overlay {
        view,
        plane: &view::plane(view, &grid, &pose).unwrap(),
        is_placed: true,
        views: &scene.views,
        pose: Some(pose),
        tool: &scene.tool,
        targets: &scene.targets,
        chosen,
        accuracy: None,
        outside: false,
        remarks: &[],
        notice: Notice::Requested,
        origin: Origin::Tracker,
        seq: 7,
        registration_id: 1,
        volume: "01234567",
        marks: Marks::default(),
        caution: "",
        tissue: crate::tissue::Tissues::default(),
    })
}

fn far() -> Chosen {
    Chosen {
        name: "far".to_owned(),
        centre: geometry::Point::new(70.0, 50.0, 50.0),
        radius_mm: 2.5,
        entry: None,
        stop_mm: 0.0,
    }
}

fn pixels(chosen: Option<&Chosen>) -> Vec<u8> {
    of_targets(chosen, |overlay| {
        let mut canvas = Canvas::new(overlay.view.size[0], overlay.view.size[1]);
        overlay.draw(&mut canvas);
        canvas.rgba().to_vec()
    })
}

/// How many pixels have the colour of targets, within this distance of the pixel where the image shows a target, to the left of it and
/// below: its name stands elsewhere.
fn target_pixels(rgba: &[u8], middle: [f64; 2], within: f64, width: usize) -> usize {
    let Rgb(r, g, b) = palette::TARGET;
    let is_near = |i: usize| {
        let [dx, dy] = [(i % width) as f64 - middle[0], (i / width) as f64 - middle[1]];
        dx < 0.0 && dy > 0.0 && dx.hypot(dy) <= within
    };
    let pixels = rgba.chunks_exact(4).enumerate();
    pixels
        .filter(|(i, pixel)| is_near(*i) && pixel[..3] == [r, g, b])
        .count()
}

#[test]
fn the_distance_is_that_to_the_chosen_target_and_the_nearest_never_takes_its_place() {
    let texts = |chosen: Option<&Chosen>| {
        of_targets(chosen, |overlay| {
            let placed = overlay.words().layout.placed;
            placed.into_iter().map(|word| word.text).collect::<Vec<_>>()
        })
    };
    let is_distance = |text: &String| text.ends_with(" mm") && (text.starts_with("near ") || text.starts_with("far "));
    assert!(!texts(None).iter().any(is_distance), "{:?}", texts(None));
    let far = far();
    let found: Vec<String> = texts(Some(&far)).into_iter().filter(is_distance).collect();
    assert_eq!(found, ["far 20.0 mm"]);
}

#[test]
fn the_chosen_target_has_a_second_ring_and_the_others_have_not() {
    let far = far();
    let (none, chosen) = (pixels(None), pixels(Some(&far)));
    // 100 mm on 512 pixels; a radius of 2.5 mm, and the second ring 5 pixels further out.
    let (at, ring) = of_targets(Some(&far), |overlay| {
        let seen = overlay.plane.project(far.centre);
        ([seen.x, seen.y], 2.5 / overlay.plane.pixel_mm() + 5.0)
    });
    let count = |rgba: &[u8], within| target_pixels(rgba, at, within, 512);
    assert_eq!(count(&none, ring - 3.0), count(&chosen, ring - 3.0));
    assert_eq!(count(&none, ring - 3.0), count(&none, ring + 2.0));
    assert!(count(&chosen, ring + 2.0) > count(&chosen, ring - 3.0) + 8);
}

#[test]
fn a_chosen_target_that_the_scene_does_not_list_is_drawn_with_both_rings() {
    let elsewhere = Chosen {
        centre: geometry::Point::new(50.0, 75.0, 50.0),
        ..far()
    };
    let (at, radius) = of_targets(Some(&elsewhere), |overlay| {
        let seen = overlay.plane.project(elsewhere.centre);
        ([seen.x, seen.y], 2.5 / overlay.plane.pixel_mm())
    });
    let drawn = pixels(Some(&elsewhere));
    let inner = target_pixels(&drawn, at, radius + 2.0, 512);
    assert!(
        inner > 5 && target_pixels(&drawn, at, radius + 8.0, 512) > inner + 8,
        "{inner}"
    );
}

/// An overview is measured on by nobody: no figure stands on it, whatever it says, and its letters always do.
#[test]
fn no_figure_stands_on_a_surface() {
    let text = "[[views]]\nname = \"s\"\nplane = \"surface\"\nextent = \"global\"\nsize = [260, 260]\n\
        surface = { from = \"left\" }\n[[targets]]\nname = \"node 1\"\nct_mm = [51, 50, 50]";
    let scene = scene::Scene::parse(text, std::path::Path::new("")).unwrap();
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]]);
    let grid = VolumeGrid::checked([100; 3], affine).unwrap();
    let message = bus::message::ToolPose {
        tip_mm: 0.93,
        flags: bus::message::ToolPose::TIP_KNOWN,
        delay_ns: 35_000_000,
        ..bus::message::ToolPose::EMPTY
    };
    let chosen = Chosen {
        name: "node 1".to_owned(),
        centre: geometry::Point::new(51.0, 50.0, 50.0),
        radius_mm: 2.5,
        entry: None,
        stop_mm: 0.0,
    };
    let notices = [
        Notice::Live,
        Notice::Requested,
        Notice::Stale(320_000_000),
        Notice::Lost(Lost::NotSeen, Some(2_000_000_000)),
        Notice::Lost(Lost::Frozen, None),
    ];
    let origins = [
        Origin::Tracker,
        Origin::Recording,
        Origin::RecordingOfAnother,
        Origin::SimulatedTime,
    ];
    for (notice, origin) in notices
        .into_iter()
        .flat_map(|notice| origins.map(|origin| (notice, origin)))
    {
        for drawn in [scene::Drawn::All, scene::Drawn::State] {
            let mut view = scene.views[0].clone();
            view.overlay = drawn;
            let pose = Rigid::identity();
            let overlay = Overlay {
                view: &view,
                plane: &view::plane(&view, &grid, &pose).unwrap(),
                is_placed: false,
                views: &scene.views,
                pose: Some(pose),
                tool: &scene.tool,
                targets: &scene.targets,
                chosen: Some(&chosen),
                accuracy: Some(Accuracy::of(&message, pose)),
                outside: true,
                remarks: &["REGISTRATION CHANGED"],
                notice,
                origin,
                seq: 7,
                registration_id: 1,
                volume: "01234567",
                marks: Marks::DOWNSAMPLED,
                caution: "NO BONE FOUND",
                tissue: crate::tissue::Tissues::default(),
            };
            let words = overlay.words();
            let said: Vec<&str> = words.layout.placed.iter().map(|word| word.text.as_str()).collect();
            let figures = said.iter().filter(|text| text.contains(|c: char| c.is_ascii_digit()));
            assert_eq!(figures.count(), 0, "{said:?}");
            assert!(!words.scale);
            for letter in [
                "A",
                "P",
                "S",
                "I",
                "NO BONE FOUND",
                "DOWNSAMPLED",
                "REGISTRATION CHANGED",
            ] {
                assert!(said.contains(&letter), "{letter}: {said:?}");
            }
            let alarm = match notice {
                Notice::Stale(_) => "POSE OLD",
                Notice::Lost(Lost::NotSeen, _) => "NO POSE: marker not seen",
                Notice::Requested => "HELD",
                Notice::Live => origin.word(),
                _ => "LOST",
            };
            assert!(said.contains(&alarm), "{alarm}: {said:?}");
        }
    }
}

/// A shape that nothing is drawn of: only that there is one matters to the words.
fn shapes() -> crate::tissue::Shapes {
    crate::tissue::Shapes {
        mesh_id: [0; 32],
        ct_from_model: Rigid::identity(),
        organs: Vec::new(),
    }
}

#[test]
fn what_an_image_shows_of_the_tissue_stands_on_it() {
    use bus::message::TissueShown;
    let shapes = shapes();
    let moved = Some(crate::tissue::Moved {
        shapes: &shapes,
        places: &[],
    });
    let words = |shown, notice, late_ns| {
        of_targets(None, |overlay| {
            let is_moved = matches!(shown, TissueShown::Settled | TissueShown::Approximate);
            let overlay = Overlay {
                notice,
                tissue: crate::tissue::Tissues {
                    errors: None,
                    covered_twice: 0,
                    shown,
                    moved: moved.filter(|_| is_moved),
                    late_ns,
                    seq: 1,
                    force_n: (shown == TissueShown::Settled).then_some((0.523, Some(0.301))),
                },
                ..*overlay
            };
            let placed = overlay.words().layout.placed;
            let all: Vec<String> = placed.into_iter().map(|word| word.text).collect();
            (all.join("|"), overlay.frame().map(|(colour, _)| colour))
        })
    };
    let live = |shown| words(shown, Notice::Live, Some(123_400_000));
    assert!(!live(TissueShown::None).0.contains("MODEL") && live(TissueShown::None).1.is_none());
    let (settled, frame) = live(TissueShown::Settled);
    assert!(
        settled.contains("MODEL|")
            && settled.contains("0.52\u{a0}N \u{b1}0.30 (95\u{a0}%) ON THE TUBE")
            && !settled.contains("REST")
            && frame.is_none()
    );
    for (shown, said) in [
        (TissueShown::Approximate, "MODEL NOT SETTLED"),
        (TissueShown::Late, "TISSUE LATE 123\u{a0}ms: ORGANS AT REST"),
        (TissueShown::CatchingUp, "TISSUE CATCHING UP: ORGANS AT REST"),
        (TissueShown::Refused, "TISSUE REFUSED: ORGANS AT REST"),
        (TissueShown::Rigid, "ORGANS AT REST"),
    ] {
        let (found, frame) = live(shown);
        assert!(found.contains(said), "{found}");
        assert_eq!(frame, Some(palette::WARN), "{said}");
    }
    // Where there is no room for words, a replay keeps its own colour, and says by another line that organs are at rest.
    for (shown, is_said) in [(TissueShown::Late, true), (TissueShown::Settled, false)] {
        let counts = of_targets(None, |overlay| {
            let view = &View {
                size: [96, 96],
                ..overlay.view.clone()
            };
            let tissue = crate::tissue::Tissues {
                shown,
                ..crate::tissue::Tissues::default()
            };
            let small = Overlay {
                view,
                tissue,
                notice: Notice::Live,
                origin: Origin::Recording,
                ..*overlay
            };
            let mut canvas = Canvas::new(96, 96);
            small.draw(&mut canvas);
            [palette::REPLAY, palette::WARN].map(|colour| pixels_of(&canvas, colour))
        });
        assert!(counts[0] > 0 && (counts[1] > 0) == is_said, "{shown:?} {counts:?}");
    }
    let (held, _) = words(TissueShown::Late, Notice::Requested, None);
    assert!(held.contains("NO TISSUE OF THIS POSE"), "{held}");
}
