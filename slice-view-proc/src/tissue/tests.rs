//! States over a real bus: which pose they are taken for, and what is refused.

use bus::clock::monotonic_ns;
use bus::message::{MeshOrgan, TissueState, ToolPose};
use bus::port::HeadedPublisher;
use bus::run::RunContext;

use super::*;

const HASH: [u8; 32] = [7; 32];

/// One cube of 27 nodes, wholly organ.
fn mesh(name: &str, volume_hash: [u8; 32]) -> (TissueMeshHeader, Vec<u8>) {
    let organ = MeshOrgan {
        name: name.to_owned(),
        nodes: 27,
        cubes: vec![bus::message::MeshCube {
            low: [0.0; 3],
            side: 10.0,
            nodes: std::array::from_fn(|k| k as u32),
        }],
        region_origin: [0.0; 3],
        region_step_mm: 10.0,
        region_dims: [2; 3],
        region: vec![-1.0; 8],
    };
    let mesh = TissueMesh {
        ct_from_model: Rigid::identity(),
        volume_hash,
        organs: vec![organ],
    };
    mesh.write()
}

/// States are late after 50 ms, and in balance to 1e-3.
fn spec() -> TissueSpec {
    let scene = scene::Scene::parse("[tissue]\norgans = \"o.toml\"", std::path::Path::new("s.toml"));
    scene.unwrap().tissue.unwrap()
}

fn pose() -> ToolPose {
    ToolPose {
        seq: 5,
        t_capture_ns: 1_000,
        registration_id: 9,
        ..ToolPose::EMPTY
    }
}

fn state(mesh_id: [u8; 32]) -> TissueHeader {
    TissueHeader {
        seq: 3,
        pose_seq: 5,
        t_capture_ns: 1_000,
        registration_id: 9,
        mesh_id,
        state: TissueState::Settled.code(),
        least_determinant: 0.5,
        ..TissueHeader::default()
    }
}

/// A place in the regions of two organs went with the one that comes first in the message, whichever it is of.
#[test]
fn a_place_that_two_organs_have_goes_with_none_and_nodes_are_those_of_their_own_organ() {
    use stage::{Block, shapes};
    let blocks = [Block([20.0; 3], 10.0), Block([29.0, 20.0, 20.0], 10.0)];
    let shapes = shapes(&blocks);
    let by = [[1.0, 0.0, 0.0], [0.0, 2.0, 0.0]];
    let places = [blocks[0].nodes(|_| by[0]), blocks[1].nodes(|_| by[1])].concat();
    let moved = Moved {
        shapes: &shapes,
        places: &places,
    };
    let found = |x: f64| moved.place(Point::new(x, 20.0, 20.0)).map(|place| place.mm());
    assert_eq!(found(18.0), Some([19.0, 20.0, 20.0]));
    assert_eq!(found(31.0), Some([31.0, 22.0, 20.0]));
    assert_eq!(found(24.5), None);
    assert_eq!(found(40.0), None);
}

/// Whoever joins late may be given the state first; and a mesh may come between the look for meshes and that for states.
#[test]
fn a_state_that_comes_before_its_mesh_waits_for_it() {
    let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
    let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
    let bus = Bus::join(&run).unwrap();
    let meshes = HeadedPublisher::<TissueMeshHeader, u8>::open(&bus, &TISSUE_MESH, 4096).unwrap();
    let sent = HeadedPublisher::<TissueHeader, f32>::open(&bus, &TISSUE, 81).unwrap();
    let states = states(&bus).unwrap();
    let mut tissue = Tissue::open(&bus, &spec()).unwrap();
    let (header, bytes) = mesh("kidney", HASH);
    sent.send(state(header.mesh_id), &[1.0; 81]).unwrap();
    assert_eq!(tissue.listen(&states, &HASH, 2_000).unwrap(), None);
    assert!(!tissue.answers.has(&pose()));
    meshes.send(header, &bytes).unwrap();
    assert_eq!(tissue.listen(&states, &HASH, 2_000).unwrap(), None);
    assert!(tissue.answers.has(&pose()));
    // The same mesh again, as for another late joiner, takes no state away.
    meshes.send(header, &bytes).unwrap();
    assert_eq!(tissue.listen(&states, &HASH, 2_000).unwrap(), None);
    assert!(tissue.answers.has(&pose()));
}

#[test]
fn a_state_is_taken_for_its_own_pose_mesh_and_examination_alone() {
    let folder = tempfile::Builder::new().prefix("tc").tempdir_in("/tmp").unwrap();
    let run = RunContext::new(folder.path(), monotonic_ns()).unwrap();
    let bus = Bus::join(&run).unwrap();
    let meshes = HeadedPublisher::<TissueMeshHeader, u8>::open(&bus, &TISSUE_MESH, 4096).unwrap();
    let sent = HeadedPublisher::<TissueHeader, f32>::open(&bus, &TISSUE, 81).unwrap();
    let states = states(&bus).unwrap();
    let mut tissue = Tissue::open(&bus, &spec()).unwrap();
    let listen = |tissue: &mut Tissue| tissue.listen(&states, &HASH, 2_000).unwrap();
    // Before there is any: nothing is said of how late.
    assert_eq!(tissue.answers.shown(&pose(), Some(9_000)).late_ns, None);

    let (header, bytes) = mesh("kidney", HASH);
    meshes.send(header, &bytes).unwrap();
    sent.send(state(header.mesh_id), &[1.0; 81]).unwrap();
    assert_eq!(listen(&mut tissue), None);
    let shown = tissue.answers.shown(&pose(), Some(9_000));
    assert_eq!((shown.shown, shown.seq), (TissueShown::Settled, 3));
    assert_eq!(shown.moved.unwrap().organs()[0].places, [[1.0; 3]; 27]);
    // Of a source that counts anew, of another registration, of another number: none of them.
    for other in [
        ToolPose {
            t_capture_ns: 1_001,
            ..pose()
        },
        ToolPose {
            registration_id: 8,
            ..pose()
        },
        ToolPose { seq: 6, ..pose() },
    ] {
        let shown = tissue.answers.shown(&other, Some(9_000));
        assert!(shown.shown == TissueShown::Late && shown.moved.is_none() && !tissue.answers.has(&other));
        // The last state is of a pose 8 us old, whatever the age of the one that is shown.
        assert_eq!(shown.late_ns, Some(8_000));
    }

    // What is no state, or of another mesh, is refused and takes nothing's place.
    let mut bad = [1.0; 81];
    bad[7] = f32::NAN;
    sent.send(
        TissueHeader {
            pose_seq: 6,
            ..state(header.mesh_id)
        },
        &bad,
    )
    .unwrap();
    assert!(matches!(
        listen(&mut tissue),
        Some(NoTissue::State(TissueError::Place { at: 7, .. }))
    ));
    sent.send(
        TissueHeader {
            pose_seq: 6,
            ..state([1; 32])
        },
        &[1.0; 81],
    )
    .unwrap();
    listen(&mut tissue);
    assert_eq!(tissue.refused, 2);
    assert!(!tissue.answers.has(&ToolPose { seq: 6, ..pose() }) && tissue.answers.has(&pose()));

    // Organs of another examination change nothing; another mesh takes the old one's states with it.
    let (foreign, bytes) = mesh("kidney", [8; 32]);
    meshes.send(foreign, &bytes).unwrap();
    listen(&mut tissue);
    assert!(tissue.refused == 3 && tissue.answers.has(&pose()));
    let (again, bytes) = mesh("spleen", HASH);
    meshes.send(again, &bytes).unwrap();
    listen(&mut tissue);
    assert!(!tissue.answers.has(&pose()) && tissue.answers.mesh().to_be_bytes()[..] == again.mesh_id[..8]);
    drop((states, tissue, meshes, sent, bus));
    run.sweep();
}

/// An altered message was drawn as a settled state, whatever certified it.
#[test]
fn a_state_whose_certificate_denies_it_is_shown_as_refused_and_named() {
    let mut answers = Answers::new(5.0, 1e-3);
    let (header, bytes) = mesh("kidney", HASH);
    answers.take_mesh((&header, &bytes), &HASH).unwrap();
    let good = state(header.mesh_id);
    for (bad, words) in [
        (
            TissueHeader { residual: 2e-3, ..good },
            "residual is 0.002; 0 to 0.001 are allowed",
        ),
        (
            TissueHeader {
                least_determinant: -0.1,
                ..good
            },
            "least_determinant is -0.1",
        ),
        (
            TissueHeader { depth_mm: 0.5, ..good },
            "depth_mm is 0.5; at most 0.001 mm",
        ),
        (TissueHeader { left_mm: 3.0, ..good }, "left_mm is 3"),
    ] {
        let why = answers.take_state(&bad, &[1.0; 81]).unwrap_err().to_string();
        assert!(why.contains(words), "{why}");
        let shown = answers.shown(&pose(), Some(9_000));
        assert!(shown.shown == TissueShown::Refused && shown.moved.is_none() && shown.force_n.is_none());
        assert!(shown.errors.unwrap().why().contains(words));
    }
    answers.take_state(&good, &[1.0; 81]).unwrap();
    assert_eq!(answers.shown(&pose(), Some(9_000)).shown, TissueShown::Settled);
}
