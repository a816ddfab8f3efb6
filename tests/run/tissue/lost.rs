//! Without a pose there is no tissue: neither a state nor an image with organs moved.

use bus::message::{FrameState, TissueShown, TissueState};

use super::watch::Watch;
use super::{alone, scene};
use crate::support::World;

#[test]
fn a_lost_pose_has_neither_nodes_nor_an_image_of_moved_organs() {
    let _alone = alone();
    let world = World::new();
    let file = scene(&world);
    let text = std::fs::read_to_string(&file).unwrap();
    // About every second a third of a second without a pose.
    let dropouts = "rate_hz = 20.0\ndropout = 0.05\ndropout_samples = 6";
    assert!(text.contains("rate_hz = 20.0\n"));
    std::fs::write(&file, text.replace("rate_hz = 20.0", dropouts)).unwrap();
    let pilot = world.start(&file, &world.path("out"), "default");
    pilot.wait_live();
    let mut watch = Watch::open(&world);
    let (mut lost, mut moved) = (0, 0);
    // Each time it comes back there are states of its poses again.
    while lost < 30 || moved < 30 {
        let stamp = watch.until("an image", |_, _| true);
        let is_lost = matches!(stamp.frame_state(), Some(FrameState::Lost(_)));
        match TissueShown::from_code(stamp.tissue).unwrap() {
            TissueShown::Settled => moved += 1,
            TissueShown::Rigid if is_lost => {
                assert_eq!(
                    (stamp.tissue_seq, stamp.target_shown_mm),
                    (0, stamp.target_mm),
                    "{stamp:?}"
                );
                lost += 1;
            }
            // Also of a pose for which no state came in time.
            shown => assert!(!is_lost, "{shown:?}: {stamp:?}"),
        }
    }
    let states = watch.came.values();
    let without: Vec<_> = states
        .filter(|(header, _)| header.state_of() == Ok(TissueState::Lost))
        .collect();
    assert!(without.len() > 5, "{}", without.len());
    for (header, coordinates) in without {
        assert_eq!(
            (*coordinates, header.force, header.residual),
            (0, [0.0; 3], 0.0),
            "{header:?}"
        );
    }
    assert!(
        watch
            .came
            .values()
            .any(|(header, coordinates)| header.state_of() == Ok(TissueState::Settled) && *coordinates > 0)
    );
    assert!(pilot.stop().code().is_some());
}
