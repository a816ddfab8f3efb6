//! Organs that the tube moves, on a second machine: bit for bit, or at rest with the reason.

use std::path::Path;
use std::time::Duration;

use bus::message::{MeshCube, MeshOrgan, TissueHeader, TissueMesh, TissueMeshHeader, TissueState};
use bus::port::{HeadedPublisher, HeadedSubscriber};
use bus::topic::{TISSUE, TISSUE_MESH};
use geometry::Rigid;

use crate::rig::{Program, Room, Second, alone, free_endpoint, until, world};

/// Bytes of a mesh, at most, and coordinates of a state.
const MOST: usize = 1 << 20;

/// The room's model, made by hand so that it can lie.
struct Model {
    meshes: HeadedPublisher<TissueMeshHeader, u8>,
    states: HeadedPublisher<TissueHeader, f32>,
}

/// What others on the second machine are given.
struct Shown {
    meshes: HeadedSubscriber<TissueMeshHeader, u8>,
    states: HeadedSubscriber<TissueHeader, f32>,
}

/// Organs of more bytes than a piece has.
fn mesh(volume_hash: [u8; 32], shift: f32) -> TissueMesh {
    let organ = MeshOrgan {
        name: "right kidney".to_owned(),
        nodes: 27,
        cubes: vec![MeshCube {
            low: [1.0, 2.0, 3.0],
            side: 4.0,
            nodes: std::array::from_fn(|node| node as u32),
        }],
        region_origin: [0.5, 0.25, -7.0],
        region_step_mm: 1.5,
        region_dims: [40, 40, 40],
        region: (0..64_000).map(|k| k as f32 / 3.0 + shift).collect(),
    };
    TissueMesh {
        ct_from_model: Rigid::identity(),
        volume_hash,
        organs: vec![organ],
    }
}

fn state(seq: u64, mesh_id: [u8; 32]) -> (TissueHeader, Vec<f32>) {
    let header = TissueHeader {
        seq,
        pose_seq: 3 * seq,
        mesh_id,
        state: TissueState::Settled.code(),
        residual: 1e-4 * seq as f64,
        ..TissueHeader::default()
    }
    .because("none");
    (header, (0..81).map(|k| (k as f32 + seq as f32) / 7.0).collect())
}

impl Model {
    fn open(room: &Room) -> Self {
        Self {
            meshes: HeadedPublisher::open(&room.bus, &TISSUE_MESH, MOST).unwrap(),
            states: HeadedPublisher::open(&room.bus, &TISSUE, MOST).unwrap(),
        }
    }

    fn mesh(&self, mesh: &TissueMesh) -> TissueMeshHeader {
        let (header, bytes) = mesh.write();
        self.meshes.send(header, &bytes).unwrap();
        header
    }
}

impl Shown {
    fn open(second: &Second) -> Self {
        Self {
            meshes: HeadedSubscriber::open(&second.bus, &TISSUE_MESH, 1).unwrap(),
            states: HeadedSubscriber::open(&second.bus, &TISSUE, TISSUE.buffer).unwrap(),
        }
    }
}

/// Both runs, with the processes of the link.
struct Pair {
    room: Room,
    second: Second,
    receiver: Program,
    _sender: Program,
}

fn pair(world: &Path) -> Pair {
    let endpoint = free_endpoint();
    let room = Room::open(world, Duration::from_secs(9), [40, 30, 20], |_| {});
    let second = Second::open(world, "second", &endpoint);
    let sender = room.send(world, &endpoint);
    let receiver = second.receive(world, &endpoint, &room.id());
    let pair = Pair {
        room,
        second,
        receiver,
        _sender: sender,
    };
    let note = until("both ready", || {
        pair.room.serve_late_joiners();
        pair.second.note().filter(|note| note.contains("clock known"))
    });
    assert!(!note.contains("organs"), "{note}");
    pair
}

#[test]
fn organs_come_bit_for_bit_before_their_states_and_others_after_them() {
    let _alone = alone();
    let world = world();
    let pair = pair(world.path());
    let (model, shown) = (Model::open(&pair.room), Shown::open(&pair.second));
    let mut seq = 0;
    for shift in [0.0, 0.5] {
        let mesh = mesh(pair.room.hash.0, shift);
        let header = model.mesh(&mesh);
        let first = until("a state", || {
            seq += 1;
            let (sent, nodes) = state(seq, header.mesh_id);
            model.states.send(sent, &nodes).unwrap();
            let mut came = None;
            while let Some(one) = shown.states.next().unwrap() {
                // Of the organs before, some may still be under way.
                let is_new = one.header().mesh_id == header.mesh_id;
                came = came.or(is_new.then_some(one.header().seq));
            }
            came
        });
        let came = shown.meshes.next().unwrap().expect("organs come before their states");
        assert_eq!(TissueMesh::read(came.header(), came.values()), Ok(mesh));
        assert!(first <= seq);
    }
    while shown.states.next().unwrap().is_some() {}
    let id = mesh(pair.room.hash.0, 0.5).write().0.mesh_id;
    // No nodes where there is no state of the pose; every bit of the others.
    let (lost, _) = state(seq + 1, id);
    let lost = TissueHeader {
        state: TissueState::Lost.code(),
        ..lost
    };
    let (settled, nodes) = state(seq + 2, id);
    for (header, nodes) in [(lost, &[][..]), (settled, &nodes)] {
        model.states.send(header, nodes).unwrap();
        until("a state", || {
            let one = shown.states.next().unwrap()?;
            if one.header().seq < header.seq {
                return None;
            }
            assert_eq!((one.header(), one.values()), (&header, nodes));
            Some(())
        });
    }
}

#[test]
fn organs_that_lie_are_not_shown_and_their_reason_is() {
    let _alone = alone();
    let world = world();
    let pair = pair(world.path());
    let (model, shown) = (Model::open(&pair.room), Shown::open(&pair.second));
    let refused = |id: [u8; 32], words: &str| {
        let mut seq = 0;
        until(words, || {
            seq += 1;
            let (header, nodes) = state(seq, id);
            model.states.send(header, &nodes).unwrap();
            let note = pair.second.note()?;
            note.contains(words).then_some(())
        });
        assert!(shown.states.next().unwrap().is_none(), "{words}");
        assert!(shown.meshes.next().unwrap().is_none(), "{words}");
    };
    let other = model.mesh(&mesh([9; 32], 0.0));
    refused(other.mesh_id, "ORGANS AT REST: the organs are of another examination");
    let (mut header, bytes) = mesh(pair.room.hash.0, 0.0).write();
    header.t_mm[1] += 0.5;
    model.meshes.send(header, &bytes).unwrap();
    refused(
        header.mesh_id,
        "ORGANS AT REST: the mesh of the tissue is not the one that its id names",
    );
    // Nothing is published of organs that are not the states'.
    refused([5; 32], "organs: 0 of 0 KiB (the run has other organs by now)");
    // What is true then is shown, and of a state that lies nothing.
    let good = model.mesh(&mesh(pair.room.hash.0, 0.0));
    let mut seq = 100;
    until("a state", || {
        seq += 1;
        let (header, nodes) = state(seq, good.mesh_id);
        model.states.send(header, &nodes).unwrap();
        shown.states.next().unwrap().map(drop)
    });
    let (header, mut nodes) = state(10_000, good.mesh_id);
    model.states.send(header, &nodes[..78]).unwrap();
    nodes[7] = f32::NAN;
    model.states.send(header, &nodes).unwrap();
    let (next, nodes) = state(10_001, good.mesh_id);
    model.states.send(next, &nodes).unwrap();
    until("the next state", || {
        let one = shown.states.next().unwrap()?;
        assert_ne!(one.header().seq, 10_000);
        (one.header().seq == 10_001).then_some(())
    });
    assert!(
        pair.receiver.said().contains("78 coordinates; the mesh has 81"),
        "{}",
        pair.receiver.said()
    );
}
