//! Words over random scenes, judged by the pixels that they ink and by nothing that placed them.

use super::words::Words;
use super::*;
use bus::message::ToolPose;
use geometry::{Affine, Point, Vector, VolumeGrid};
use proptest::prelude::*;
use scene::{Extent, Scene};

use crate::view;

/// Around the image, so that what leaves it is seen.
const MARGIN: u32 = 120;

#[derive(Debug, Clone)]
struct Drawn {
    view: usize,
    size: [u32; 2],
    turn: [f64; 3],
    tip: [f64; 3],
    targets: Vec<(String, [f64; 3], f64)>,
    notice: Notice,
    origin: Origin,
    outside: bool,
    tip_mm: f64,
    marks: bool,
    remarks: usize,
    text: f64,
    overlay: scene::Drawn,
}

fn notice() -> impl Strategy<Value = Notice> {
    let age = 0..4_000_000_000_000_i64;
    prop_oneof![
        Just(Notice::Live),
        Just(Notice::Requested),
        Just(Notice::Look),
        age.clone().prop_map(Notice::Stale),
        (prop::sample::select(&Lost::ALL[..]), prop::option::of(age))
            .prop_map(|(reason, age)| Notice::Lost(reason, age)),
    ]
}

fn drawn() -> impl Strategy<Value = Drawn> {
    let target = ("[a-zA-Z\u{e9} -]{1,38}", prop::array::uniform3(-60.0..60.0), 0.2..30.0);
    let origin = prop_oneof![
        Just(Origin::Tracker),
        Just(Origin::Recording),
        Just(Origin::RecordingOfAnother),
        Just(Origin::RecordingOfUnknown),
        Just(Origin::SimulatedTime)
    ];
    let scene = (
        0..7_usize,
        prop::array::uniform2(192_u32..640),
        prop::array::uniform3(-3.0..3.0),
    );
    let text = prop_oneof![3 => Just(1.0), 1 => 0.5..4.0];
    let overlay = prop_oneof![2 => Just(scene::Drawn::All), 1 => Just(scene::Drawn::State)];
    let told = (notice(), origin, any::<bool>(), 0.0..900.0, any::<bool>(), 0..3_usize);
    (
        scene,
        prop::array::uniform3(-50.0..50.0),
        prop::collection::vec(target, 0..20),
        told,
        (text, overlay),
    )
        .prop_map(
            |((view, size, turn), tip, targets, (notice, origin, outside, tip_mm, marks, remarks), (text, overlay))| {
                Drawn {
                    view,
                    size,
                    turn,
                    tip,
                    targets,
                    notice,
                    origin,
                    outside,
                    tip_mm,
                    marks,
                    remarks,
                    text,
                    overlay,
                }
            },
        )
}

fn with_overlay<T>(drawn: &Drawn, look: impl FnOnce(&Overlay<'_>) -> T) -> T {
    let mut scene = Scene::parse("", std::path::Path::new("")).unwrap();
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, -60.0], [0.0, 1.0, 0.0, -60.0], [0.0, 0.0, 1.0, -60.0]]);
    let grid = VolumeGrid::checked([120; 3], affine).unwrap();
    scene.views[drawn.view].size = drawn.size;
    scene.views[drawn.view].text = drawn.text;
    scene.views[drawn.view].overlay = drawn.overlay;
    let vector = |[x, y, z]: [f64; 3]| Vector::new(x, y, z);
    let pose = Rigid::from_rotation_vector(vector(drawn.turn), vector(drawn.tip)).unwrap();
    let target = |(name, at, diameter_mm): &(String, [f64; 3], f64)| Target {
        name: name.clone(),
        centre: Point::new(at[0], at[1], at[2]),
        diameter_mm: *diameter_mm,
        entry: None,
        stop_mm: 0.0,
    };
    let targets: Vec<Target> = drawn.targets.iter().map(target).collect();
    let chosen = targets.last().map(|target| Chosen {
        name: target.name.clone(),
        centre: target.centre,
        radius_mm: target.diameter_mm / 2.0,
        entry: None,
        stop_mm: 0.0,
    });
    let message = ToolPose {
        tip_mm: drawn.tip_mm,
        flags: ToolPose::TIP_KNOWN,
        delay_ns: 35_000_000,
        ..ToolPose::EMPTY
    };
    let lost = matches!(drawn.notice, Notice::Lost(..));
    let all = Marks::REGRIDDED.and(Marks::DOWNSAMPLED).and(Marks::PART);
    look(&Overlay {
        view: &scene.views[drawn.view],
        plane: &view::plane(&scene.views[drawn.view], &grid, &pose).unwrap(),
        is_placed: true,
        views: &scene.views,
        pose: (!lost).then_some(pose),
        tool: &scene.tool,
        targets: &targets,
        chosen: chosen.as_ref(),
        accuracy: (!lost).then(|| Accuracy::of(&message, pose)),
        outside: drawn.outside && !lost,
        remarks: &["REGISTRATION CHANGED", "POSES ARE COUNTED ANEW"][..drawn.remarks],
        notice: drawn.notice,
        origin: drawn.origin,
        seq: u64::from(u32::MAX),
        registration_id: u64::MAX,
        volume: "01234567",
        marks: if drawn.marks { all } else { Marks::NONE },
        caution: "GPU LOST, CPU DRAWS",
        tissue: crate::tissue::Tissues::default(),
    })
}

/// Draws each text by itself on the image with a margin; an error names one that leaves the image, or two that ink one pixel.
fn inked(words: &Words, [width, height]: [u32; 2]) -> Result<(), String> {
    let (w, h) = (width + 2 * MARGIN, height + 2 * MARGIN);
    let mut owner: Vec<Option<usize>> = vec![None; (w * h) as usize];
    for (i, word) in words.layout.placed.iter().enumerate() {
        let mut canvas = Canvas::new(w, h);
        canvas.fill([0.0, 0.0], [f64::from(w), f64::from(h)], Rgb(1, 2, 3), 255);
        let at = word.at.map(|x| x + f64::from(MARGIN));
        canvas.text(at, &word.text, word.size, word.colour, word.anchor);
        for (at, pixel) in canvas.rgba().chunks_exact(4).enumerate() {
            if pixel[..3] == [1, 2, 3] {
                continue;
            }
            let (x, y) = (at as u32 % w, at as u32 / w);
            let inside = (MARGIN..MARGIN + width).contains(&x) && (MARGIN..MARGIN + height).contains(&y);
            if !inside {
                return Err(format!("{:?} leaves the image at {x}, {y}", word.text));
            }
            if let Some(other) = owner[at].replace(i).filter(|other| *other != i) {
                return Err(format!(
                    "{:?} runs into {:?}",
                    word.text, words.layout.placed[other].text
                ));
            }
        }
    }
    Ok(())
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(256))]

    /// `+10 mm` read `+1`, and `ght -6 mm` stood on the image of the demonstration.
    #[test]
    fn every_word_lies_whole_in_the_image_and_over_no_other(drawn in drawn()) {
        with_overlay(&drawn, |overlay| {
            let words = overlay.words();
            prop_assert_eq!(inked(&words, drawn.size), Ok(()));
            let texts: Vec<&str> = words.layout.placed.iter().map(|word| word.text.as_str()).collect();
            // Whatever has no room is counted on the image.
            let counted = texts.iter().find_map(|text| text.split_once(" LABEL")).map(|(n, _)| n.parse::<usize>().unwrap());
            prop_assert_eq!(counted.unwrap_or(0), words.layout.left_out);
            // What a person must not miss is always there.
            let all = texts.join(" ");
            match drawn.notice {
                Notice::Lost(reason, _) => prop_assert!(all.contains(&format!("NO POSE: {}", reason.words())), "{}", all),
                Notice::Stale(_) => prop_assert!(all.contains("\u{a0}OLD"), "{}", all),
                Notice::Look => prop_assert!(all.contains("NOT FOLLOWING"), "{}", all),
                Notice::Live | Notice::Requested => {}
            }
            let expected = drawn.outside && !matches!(drawn.notice, Notice::Lost(..));
            let said = ["TIP OUTSIDE THE CT", "TIP OUTSIDE THE LOADED PART"][usize::from(drawn.marks)];
            prop_assert_eq!(all.contains("TIP OUTSIDE"), expected, "{}", all);
            prop_assert_eq!(all.contains(said), expected, "{}", all);
            prop_assert_eq!(all.contains("seq 4294967295"), drawn.notice != Notice::Look, "{}", all);
            let expected = match drawn.origin {
                _ if matches!(drawn.notice, Notice::Requested | Notice::Look) => "",
                Origin::Tracker => "",
                Origin::SimulatedTime => "SIMULATED TIME",
                _ => "REPLAY",
            };
            prop_assert!(all.contains(expected), "{}", all);
            let (right, down) = (overlay.plane.right(), overlay.plane.down());
            let says_all = drawn.overlay == scene::Drawn::All;
            for direction in [right, -right, down, -down] {
                prop_assert_eq!(texts.contains(&crate::letters(direction).as_str()), says_all, "{}", all);
            }
            if !says_all {
                let others = ["global", "local", "vol 0"];
                // Where the window of HU finds no room, that is counted.
                let is_told = all.contains(" C ") || all.contains("LEFT OUT");
                prop_assert!(is_told || drawn.notice == Notice::Look, "{}", all);
                prop_assert!(!all.contains(" C ") || drawn.notice != Notice::Look, "{}", all);
                // A reason may have one of them in a word: localizer.
                let rest = match drawn.notice {
                    Notice::Lost(reason, _) => all.replace(reason.words(), ""),
                    _ => all.clone(),
                };
                prop_assert!(!others.iter().any(|other| rest.contains(other)), "{}", all);
                return Ok(());
            }
            // A target near the plane whose label is not there is among those left out.
            let labels = overlay.outlines().filter(|_| overlay.view.extent == Extent::Local);
            let missing = labels.filter(|o| !texts.iter().any(|text| text.starts_with(o.target.name.trim_end()))).count();
            prop_assert!(missing <= words.layout.left_out, "{missing}: {}", all);
            Ok(())
        })?;
    }
}

/// The line that said how many labels are left out took the corner's line at which the label then found room, so nothing was
/// left out, so the line went, so the label was left out and nobody said so.
#[test]
fn how_many_labels_are_left_out_does_not_move_the_labels() {
    let drawn = Drawn {
        view: 3,
        size: [392, 599],
        turn: [0.0; 3],
        tip: [-29.983_081_152_806_886, 20.183_240_701_058_06, 39.040_558_742_269_03],
        targets: vec![(
            "aAAaAaA--AaAA-a-A\u{e9}\u{e9}".to_owned(),
            [0.0, 11.470_985_199_315_031, -30.442_588_833_438_52],
            9.445_599_163_224_616,
        )],
        notice: Notice::Live,
        origin: Origin::RecordingOfUnknown,
        outside: false,
        tip_mm: 0.0,
        marks: true,
        remarks: 0,
        text: 1.0,
        overlay: scene::Drawn::All,
    };
    with_overlay(&drawn, |overlay| {
        let layout = overlay.words().layout;
        let said = layout.placed.iter().any(|word| word.text == "1 LABEL LEFT OUT");
        assert_eq!(said, layout.left_out == 1, "{:?}", layout.placed);
        assert_eq!(inked(&overlay.words(), drawn.size), Ok(()));
    });
}

#[test]
fn an_image_too_small_for_words_has_none_and_keeps_its_frame() {
    let mut drawn = Drawn {
        view: 1,
        size: [191, 400],
        turn: [0.1; 3],
        tip: [0.0; 3],
        targets: Vec::new(),
        notice: Notice::Lost(Lost::Silent, None),
        origin: Origin::Tracker,
        outside: false,
        tip_mm: 1.0,
        marks: false,
        remarks: 0,
        text: 1.0,
        overlay: scene::Drawn::All,
    };
    let pixels = |drawn: &Drawn, colour: Rgb| {
        let mut canvas = Canvas::new(drawn.size[0], drawn.size[1]);
        with_overlay(drawn, |overlay| overlay.draw(&mut canvas));
        let Rgb(r, g, b) = colour;
        canvas.rgba().chunks_exact(4).filter(|p| p[..3] == [r, g, b]).count()
    };
    assert_eq!(pixels(&drawn, palette::WORDS), 0);
    assert!(pixels(&drawn, palette::ALARM) > 191 * 2);
    // What words would say on a larger image.
    drawn.notice = Notice::Requested;
    assert_eq!(pixels(&drawn, palette::WARN), 0);
    drawn.outside = true;
    assert!(pixels(&drawn, palette::WARN) > 191 * 2);
    drawn.origin = Origin::RecordingOfAnother;
    assert!(pixels(&drawn, palette::ALARM) > 191 * 2);
    drawn.size = [192, 400];
    assert!(pixels(&drawn, palette::WORDS) > 0);
}

#[test]
fn nothing_is_left_out_of_the_images_as_shipped() {
    for view in 0..7 {
        let drawn = Drawn {
            view,
            size: [512; 2],
            turn: [0.4, -0.2, 0.9],
            tip: [3.0, 4.0, 5.0],
            targets: vec![
                ("para-aortic-left".to_owned(), [10.0, 0.0, 5.0], 5.0),
                ("para-aortic-right".to_owned(), [49.0, 9.0, 0.0], 5.0),
            ],
            notice: Notice::Stale(320_000_000),
            origin: Origin::RecordingOfUnknown,
            outside: true,
            tip_mm: 0.9,
            marks: true,
            remarks: 1,
            text: 1.0,
            overlay: scene::Drawn::All,
        };
        let left_out = with_overlay(&drawn, |overlay| overlay.words().layout.left_out);
        assert_eq!(left_out, 0, "view {view}");
    }
}
