use bus::message::TissueHeader;

use super::*;
use crate::testing;
use crate::wire::proto;
use crate::wire::schema::Source;
use crate::write::pose_log::Entry;

fn state(seq: u64) -> TissueFrame {
    let pose = testing::pose(seq);
    TissueFrame {
        header: TissueHeader {
            seq: seq + 1,
            pose_seq: seq,
            t_capture_ns: pose.t_capture_ns,
            t_publish_ns: pose.t_publish_ns + 7,
            registration_id: pose.registration_id,
            mesh_id: [3; 32],
            force: [0.5, 0.0, -1.0],
            ..TissueHeader::default()
        },
        nodes: vec![1.0, 2.0, 3.0 + seq as f32, 4.0, -0.0, 6.0],
    }
}

fn compared(a: &[TissueFrame], b: &[TissueFrame]) -> Option<Tissue> {
    let tmp = tempfile::tempdir().unwrap();
    let written = |name: &str, states: &[TissueFrame]| {
        let path = tmp.path().join(name);
        let mut log = testing::log(0, 1);
        log.pose(Source::Tool, &testing::pose(0)).unwrap();
        for state in states {
            log.put(Entry::Tissue(&proto::TissueState::from(state))).unwrap();
        }
        std::fs::write(&path, log.finish().unwrap().into_inner()).unwrap();
        path
    };
    compare(&written("a.mcap", a), &written("b.mcap", b)).unwrap()
}

#[test]
fn states_are_the_same_to_the_bit_or_said_to_differ() {
    let a: Vec<_> = (0..6).map(state).collect();
    assert_eq!(compared(&[], &[]), None);
    // When it was published is of the run, and no part of the state.
    let mut later = a.clone();
    later.iter_mut().for_each(|state| state.header.t_publish_ns += 1);
    let same = compared(&a, &later).unwrap();
    assert_eq!((same.common, same.identical, same.first_different), (6, 6, None));
    // Zeros of other signs are other bits, and no distance.
    let mut signed = a.clone();
    signed[2].nodes[4] = 0.0;
    let found = compared(&a, &signed).unwrap();
    assert_eq!(
        (found.identical, found.first_different, found.farthest_mm),
        (5, Some(2), 0.0)
    );
    let mut moved = a.clone();
    moved[4].nodes[5] += 0.25;
    moved[4].header.force[1] = 0.125;
    let found = compared(&a, &moved).unwrap();
    assert_eq!((found.farthest_mm, found.farthest_seq, found.force_n), (0.25, 4, 0.125));
    assert!(found.to_string().contains("5 the same to the bit") && found.to_string().contains("pose 4"));
}

#[test]
fn states_of_one_recording_alone_and_of_other_meshes_are_counted() {
    let a: Vec<_> = [0, 1, 3, 5].map(state).into();
    let mut b: Vec<_> = [1, 2, 3, 4].map(state).into();
    b[2].header.mesh_id = [4; 32];
    let found = compared(&a, &b).unwrap();
    assert_eq!((found.common, found.identical, found.other_mesh), (2, 1, 1));
    assert_eq!(found.alone, [2, 2]);
}
