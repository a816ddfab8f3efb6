//! Which images have organs where a state has them, and which have the examination as it was taken.

use bus::message::{Lost, TissueState};
use geometry::Point;

use super::*;
use crate::reslice::Cpu;
use crate::tissue::stage::{Block, answers, rendered, scene, volume};

const BLOCK: Block = Block([68.0, 50.0, 50.0], 16.0);

fn sample() -> ToolPose {
    ToolPose {
        seq: 5,
        t_capture_ns: 1_000,
        registration_id: 9,
        ..ToolPose::EMPTY
    }
}

/// A state of that sample with a good certificate.
fn settled() -> TissueHeader {
    TissueHeader {
        seq: 3,
        pose_seq: 5,
        t_capture_ns: 1_000,
        registration_id: 9,
        state: TissueState::Settled.code(),
        least_determinant: 0.5,
        ..TissueHeader::default()
    }
}

/// What is chosen lies in the organ.
fn chosen() -> Chosen {
    Chosen {
        name: "in it".to_owned(),
        centre: Point::new(68.0, 50.0, 50.0),
        radius_mm: 1.0,
        entry: None,
        stop_mm: 0.0,
    }
}

/// The pixels of an image with this notice, its stamp, and how many nodes it has moved.
fn shot(tissue: Option<&Answers>, notice: Notice) -> (Vec<u8>, FrameStamp, usize) {
    let (scene, volume, sample, chosen) = (scene(), volume(), sample(), chosen());
    let images = Images::default();
    let shot = Shot {
        sample: &sample,
        now_ns: Some(2_000),
        scene: &scene,
        images: &images,
        tissue,
    };
    let mut what = rendered(&volume, notice);
    what.chosen = Some(&chosen);
    let mut renderer = Renderer::new(scene.views[0].clone());
    let mut cpu = Cpu::default();
    cpu.prepare(&what.volume, &[renderer.view().sampling], &mut || {})
        .unwrap();
    let stamp = shot.take(&mut renderer, &mut what, &mut cpu).unwrap();
    let nodes = what.tissue.moved.map_or(0, |moved| moved.places.len());
    (renderer.canvas().rgba().to_vec(), stamp, nodes)
}

#[test]
fn a_lost_pose_has_no_tissue_though_there_is_a_state_of_it() {
    let nodes = BLOCK.nodes(|_| [6.0, 0.0, 0.0]);
    let answers = answers(BLOCK, settled(), &nodes);
    let (moved, stamp, count) = shot(Some(&answers), Notice::Live);
    assert_eq!(
        (stamp.tissue, stamp.tissue_seq, count),
        (TissueShown::Settled.code(), 3, 27)
    );
    assert_eq!(stamp.target, TargetShown::Model.code());

    for notice in [
        Notice::Lost(Lost::NotSeen, Some(1_000_000)),
        Notice::Lost(Lost::Silent, None),
        Notice::Look,
    ] {
        let (pixels, stamp, count) = shot(Some(&answers), notice);
        assert_eq!(
            (stamp.tissue, stamp.tissue_seq, count),
            (TissueShown::Rigid.code(), 0, 0),
            "{notice:?}"
        );
        assert_eq!(
            (stamp.target, stamp.target_shown_mm),
            (TargetShown::AtRest.code(), [68.0, 50.0, 50.0])
        );
        // To the byte what a scene shows whose model never said anything.
        let (without, ..) = shot(None, notice);
        assert!(pixels == without && pixels != moved, "{notice:?}");
    }
    // An old pose is one all the same.
    let (_, stamp, count) = shot(Some(&answers), Notice::Stale(400_000_000));
    assert_eq!((stamp.tissue, count), (TissueShown::Settled.code(), 27));
}

#[test]
fn a_state_that_says_that_there_was_no_pose_moves_nothing() {
    let header = TissueHeader {
        state: TissueState::Lost.code(),
        ..settled()
    };
    let answers = answers(BLOCK, header, &[]);
    let (pixels, stamp, count) = shot(Some(&answers), Notice::Live);
    assert_eq!((stamp.tissue, count), (TissueShown::Rigid.code(), 0));
    let (without, ..) = shot(None, Notice::Live);
    assert!(pixels == without);
}

/// Its certificate is of the elements: what is drawn may be inside out all the same, and only some pixels told it.
#[test]
fn a_folded_model_is_named_in_the_stamp_of_a_settled_state() {
    let middle = [68.0, 50.0, 50.0];
    let nodes = BLOCK.nodes(|at| [if at == middle { 14.0 } else { 0.0 }, 0.0, 0.0]);
    let (_, stamp, _) = shot(Some(&answers(BLOCK, settled(), &nodes)), Notice::Live);
    assert_eq!(stamp.tissue, TissueShown::Settled.code());
    let why = stamp.tissue_why();
    let pixels = why
        .strip_prefix("TISSUE COVERED TWICE: ")
        .and_then(|rest| rest.strip_suffix(" px"));
    assert!(pixels.unwrap().parse::<usize>().unwrap() > 20, "{why}");
    assert!(stamp.texts().contains(&("tissue_why", why.to_owned())));
    let whole = BLOCK.nodes(|_| [6.0, 0.0, 0.0]);
    let (_, stamp, _) = shot(Some(&answers(BLOCK, settled(), &whole)), Notice::Live);
    assert_eq!(stamp.tissue_why(), "");
}
