//! Whole files whose states, meshes or report say what the recording denies: `verify` called each of them whole.

use bus::message::{MeshCube, MeshOrgan, TissueHeader, TissueState};
use geometry::Rigid;
use scene::Compression;

use crate::read::verify::verify;
use crate::testing;
use crate::wire::proto::{self, MeshFrame, TissueFrame};
use crate::wire::schema::{RunFacts, Source};
use crate::write::pose_log::{Entry, PoseLog};

const SCENE: &str = "seed = 5\n[tissue]\norgans = \"o.toml\"\ntolerance = 1e-3\n";
const HASH: [u8; 32] = [7; 32];

fn mesh(volume_hash: [u8; 32]) -> MeshFrame {
    let organ = MeshOrgan {
        name: "kidney".to_owned(),
        nodes: 27,
        cubes: vec![MeshCube {
            low: [0.0; 3],
            side: 10.0,
            nodes: std::array::from_fn(|k| k as u32),
        }],
        region_origin: [0.0; 3],
        region_step_mm: 10.0,
        region_dims: [2; 3],
        region: vec![-1.0; 8],
    };
    let mesh = bus::message::TissueMesh {
        ct_from_model: Rigid::identity(),
        volume_hash,
        organs: vec![organ],
    };
    let (header, bytes) = mesh.write();
    MeshFrame { header, bytes }
}

/// A change of a state, and what is said of it.
type Case<'a> = (&'a dyn Fn(&mut TissueFrame), &'a str);

/// What is altered of a good recording.
struct Altered<'a> {
    state: &'a dyn Fn(&mut TissueFrame),
    mesh: Option<[u8; 32]>,
    report: &'a str,
}

/// Four poses, each with its settled state; number 3 is altered.
fn findings(altered: &Altered<'_>) -> Vec<String> {
    let mut log = PoseLog::new(std::io::Cursor::new(Vec::new()), Compression::Zstd, &[]).unwrap();
    log.scene(SCENE, 0).unwrap();
    log.facts(&RunFacts {
        volume_hash: Some(bus::message::VolumeHash(HASH)),
        ..testing::facts()
    })
    .unwrap();
    let of = mesh(HASH).header.mesh_id;
    if let Some(hash) = altered.mesh {
        log.put(Entry::TissueMesh(&proto::TissueMesh::of(0, &mesh(hash))))
            .unwrap();
    }
    for seq in 1..=4 {
        let pose = testing::pose(seq);
        log.pose(Source::Tool, &pose).unwrap();
        let mut state = TissueFrame {
            header: TissueHeader {
                seq,
                pose_seq: seq,
                t_capture_ns: pose.t_capture_ns,
                mesh_id: of,
                state: TissueState::Settled.code(),
                residual: 1e-4,
                least_determinant: 0.4,
                ..TissueHeader::default()
            },
            nodes: vec![1.0; 81],
        };
        if seq == 3 {
            (altered.state)(&mut state);
        }
        log.put(Entry::Tissue(&proto::TissueState::from(&state))).unwrap();
    }
    log.attach("report.json", "application/json", altered.report.as_bytes(), 0)
        .unwrap();
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("s.mcap");
    std::fs::write(&path, log.finish().unwrap().into_inner()).unwrap();
    verify(&path).unwrap().findings
}

const GOOD: Altered<'_> = Altered {
    state: &|_| {},
    mesh: Some(HASH),
    report: REPORT,
};

const REPORT: &str = r#"{"trocar_version": "0.2.0", "seed": 5, "simulated_time": true, "volume": {"hash": "0707070707070707070707070707070707070707070707070707070707070707"},
    "poses": {"published": 4}, "views": [{}, {}], "recording": ["s.mcap"],
    "tissue": {"images": {"settled": 8, "refused": 1}, "refused_because": {"it cannot be drawn": 1}}}"#;

#[test]
fn a_recording_that_agrees_with_its_states_and_its_report_has_no_findings() {
    assert_eq!(findings(&GOOD), [""; 0]);
}

#[test]
fn a_state_that_its_certificate_or_its_mesh_denies_is_named() {
    let cases: [Case<'_>; 8] = [
        (
            &|s| s.header.residual = 2e-3,
            "called settled, and its certificate denies it: residual is 0.002; 0 to 0.001 are allowed",
        ),
        (&|s| s.header.least_determinant = -1.0, "least_determinant is -1"),
        (&|s| s.header.depth_mm = 2.0, "depth_mm is 2; at most 0.001 mm"),
        (&|s| s.header.left_mm = 1.0, "left_mm is 1"),
        (&|s| s.header.state = 9, "state 9; known are 0 to 4"),
        (&|s| s.nodes.truncate(78), "78 coordinates; the mesh has 81"),
        (&|s| s.nodes[5] = f32::NAN, "coordinate 5 is NaN mm"),
        (
            &|s| s.header.state = TissueState::CatchingUp.code(),
            "called catching up",
        ),
    ];
    for (state, words) in cases {
        let found = findings(&Altered { state, ..GOOD });
        assert!(
            found[0].starts_with("message 3 of /tissue: tissue 3") && found[0].contains(words),
            "{words}: {found:?}"
        );
    }
    let found = findings(&Altered {
        state: &|s| s.header.mesh_id = [9; 32],
        ..GOOD
    });
    assert_eq!(
        found,
        ["tissue 3 and others are of mesh 09090909, which the recording does not hold"]
    );
    let found = findings(&Altered { mesh: None, ..GOOD });
    assert!(found[0].starts_with("tissue 1 and others are of mesh"), "{found:?}");
    let found = findings(&Altered {
        mesh: Some([8; 32]),
        ..GOOD
    });
    assert!(
        found[0].contains("the mesh of the tissue is of examination 0808") && found[0].contains("and the run of 0707"),
        "{found:?}"
    );
}

#[test]
fn a_report_that_the_recording_denies_is_named() {
    for (from, to, words) in [
        (
            "\"seed\": 5",
            "\"seed\": 6",
            "report.json says seed 6, and the recorded scene 5",
        ),
        ("\"0707", "\"0807", "report.json is of examination 0807"),
        (
            "\"published\": 4",
            "\"published\": 5",
            "report.json counts 5 poses, and the recording holds 4",
        ),
        (
            "\"settled\": 8",
            "\"settled\": 9",
            "counts 9 first images of organs that are settled, and the recording holds 4 such states for 2 views",
        ),
        (
            "\"settled\": 8",
            "\"approximate\": 1",
            "counts 1 first images of organs that are approximate, and the recording holds 0",
        ),
        (
            "\"refused\": 1",
            "\"refused\": 3",
            "counts 3 first images of organs that are refused, and reasons for 1",
        ),
    ] {
        assert!(REPORT.contains(from));
        let report = REPORT.replace(from, to);
        let found = findings(&Altered {
            report: &report,
            ..GOOD
        });
        assert!(found.len() == 1 && found[0].contains(words), "{words}: {found:?}");
    }
    // Nothing is held against what is no report, or that of a replay; counts not where a process was started again, or by the machine's time.
    for (from, to) in [
        ("\"trocar_version\"", "\"version\""),
        ("\"seed\": 5", "\"seed\": 6, \"replay\": {}"),
        (
            "\"published\": 4",
            "\"published\": 5, \"more\": []}, \"restarts\": [{}], \"x\": {",
        ),
        ("\"simulated_time\": true, ", ""),
    ] {
        let report = REPORT.replace(from, to).replace("\"published\": 4", "\"published\": 5");
        assert_eq!(
            findings(&Altered {
                report: &report,
                ..GOOD
            }),
            [""; 0],
            "{to}"
        );
    }
    assert_eq!(findings(&Altered { report: "[", ..GOOD }), [""; 0]);
}
