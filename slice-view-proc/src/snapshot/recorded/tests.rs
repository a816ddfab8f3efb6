//! What of a recording is drawn, and what is refused by name, before there is a file.

use bus::message::{MeshCube, MeshOrgan, TissueMesh, TissueState};
use geometry::{Point, Rigid, Vector};

use super::*;

const SCENE: &str = "seed = 1\n[volume]\nsource = \"phantom\"\nspacing_mm = 8.0\n[tissue]\norgans = \"o.toml\"\n\
    [[views]]\nname = \"across\"\nplane = \"axial\"\nextent = \"local\"\nfield_mm = 60.0\nsize = [200, 200]\n";

fn scene() -> Scene {
    Scene::parse(SCENE, Path::new("s.toml")).unwrap()
}

fn volume() -> OwnedVolume {
    let scene = scene();
    volume_loader::load_seeded(&scene.volume, scene.seed).unwrap()
}

/// A cube of 20 mm about the tip as an organ, all of it moved by 3 mm along x.
fn organs(volume_hash: [u8; 32]) -> (TissueMeshHeader, Vec<u8>, Vec<f32>) {
    let low = [-10.0, -10.0, 90.0];
    let organ = MeshOrgan {
        name: "cube".to_owned(),
        nodes: 27,
        cubes: vec![MeshCube {
            low,
            side: 20.0,
            nodes: std::array::from_fn(|k| k as u32),
        }],
        region_origin: low,
        region_step_mm: 20.0,
        region_dims: [2; 3],
        region: vec![-1.0; 8],
    };
    let mesh = TissueMesh {
        ct_from_model: Rigid::identity(),
        volume_hash,
        organs: vec![organ],
    };
    let node = |k: usize| {
        let at: [f64; 3] = std::array::from_fn(|a| low[a] + 10.0 * [k % 3, k / 3 % 3, k / 9][a] as f64);
        [at[0] + 3.0, at[1], at[2]].map(|x| x as f32)
    };
    let (header, bytes) = mesh.write();
    (header, bytes, (0..27).flat_map(node).collect())
}

/// A recording by the name of what is wrong with it.
fn read(_: &Path, at: At<'_>) -> Result<Recorded, Box<dyn std::error::Error + Send + Sync>> {
    let At::Time(case) = at else {
        return Err("a case has a name".into());
    };
    let hash = volume().hash;
    let mut pose = ToolPose {
        seq: 5,
        t_capture_ns: 1_000,
        registration_id: 9,
        ..ToolPose::EMPTY
    };
    let turned = Rigid::from_rotation_vector(Vector::new(0.3, 0.2, 0.1), Vector::new(0.0, 0.0, 100.0));
    pose.set(Tracked::Valid(turned.unwrap()));
    let (mesh, bytes, mut nodes) = organs(match case {
        "other examination" => [1; 32],
        _ => hash.0,
    });
    let mut header = TissueHeader {
        seq: 3,
        pose_seq: 5,
        t_capture_ns: 1_000,
        registration_id: 9,
        mesh_id: mesh.mesh_id,
        state: TissueState::Settled.code(),
        least_determinant: 0.5,
        ..TissueHeader::default()
    };
    match case {
        "inside out" => header.least_determinant = -0.5,
        "no number" => nodes[7] = f32::NAN,
        "short" => nodes.truncate(80),
        "other mesh" => header.mesh_id = [4; 32],
        "other pose" => header.t_capture_ns = 999,
        "no such state" => header.state = 17,
        "refused" => {
            header.state = TissueState::Refused.code();
            header = header.because("draw it back");
        }
        _ => {}
    }
    let guide = Guide {
        target_mm: [f64::NAN; 3],
        ..Guide::default().choosing(
            Some(&bus::message::Chosen {
                name: "a".to_owned(),
                centre: Point::new(0.0, 0.0, 0.0),
                radius_mm: 1.0,
                entry: None,
                stop_mm: 0.0,
            }),
            1,
        )
    };
    Ok(Recorded {
        scene: scene(),
        volume_hash: match case {
            "other volume" => "ab".repeat(32),
            _ => hash.to_string(),
        },
        pose,
        behind_s: 1.5,
        standstill_judged: case != "not judged",
        guide: (case == "no choice").then_some(guide),
        tissue: (case != "no state").then_some(((mesh, bytes), (header, nodes))),
    })
}

/// The words of the picture, or of the refusal.
fn drawn(case: &str, view: &str) -> Result<Vec<u8>, String> {
    let folder = tempfile::tempdir().unwrap();
    let out = folder.path().join("p.png");
    let what = OfRecording {
        recording: Path::new("s.mcap"),
        at: At::Time(case),
        view,
        moved_to: None,
        out: &out,
    };
    let loads: (LoadVolume, LoadLabels) = (volume_loader::load_seeded, volume_loader::load_labels);
    recorded(&what, loads, read).map_err(|error| {
        assert!(!out.exists());
        error.to_string()
    })?;
    Ok(std::fs::read(out).unwrap())
}

#[test]
fn what_is_no_state_of_this_examination_leaves_no_picture_and_no_state_one_that_says_so() {
    let says = |png: &[u8], words: &str| png.windows(words.len()).any(|part| part == words.as_bytes());
    let moved = drawn("moved", "across").unwrap();
    assert!(says(&moved, "settled") && says(&moved, "tissue_mesh"));
    // Why a model refused a pose was in the recording, and in no image.
    let refused = drawn("refused", "across").unwrap();
    assert!(says(&refused, "tissue_why") && says(&refused, "draw it back"));
    assert!(!says(&moved, "tissue_why"));
    // A pose that no state answers, or one of another run does, is drawn at rest.
    for case in ["no state", "other pose"] {
        let rest = drawn(case, "across").unwrap();
        assert!(says(&rest, "late") && !says(&rest, "tissue_seq"), "{case}");
    }
    for (case, words) in [
        ("no number", ["tissue 3: coordinate 7 is NaN mm", "pose 5"]),
        ("short", ["80 coordinates; the mesh has 81", "pose 5"]),
        ("other mesh", ["of mesh 04040404; that in use is", "pose 5"]),
        ("no such state", ["state 17; known are 0 to 4", "pose 5"]),
        (
            "inside out",
            [
                "called settled, and its certificate denies it: least_determinant is -0.5",
                "pose 5",
            ],
        ),
        ("other examination", ["of another examination", "pose 5"]),
        ("other volume", ["was recorded in examination abab", "--volume PATH"]),
        ("no choice", ["what was chosen at pose 5", "target"]),
    ] {
        let why = drawn(case, "across").unwrap_err();
        assert!(words.iter().all(|word| why.contains(word)), "{case}: {why}");
    }
    let why = drawn("moved", "along").unwrap_err();
    assert!(
        why.contains("\"along\"") && why.contains("has the views across"),
        "{why}"
    );
}

/// A pose of a cut that had stood still before the cut was drawn like one that was judged.
#[test]
fn a_pose_whose_standstill_nobody_judged_says_so_on_its_image() {
    let [judged, unjudged] = ["moved", "not judged"].map(|case| drawn(case, "across").unwrap());
    assert!(judged != unjudged);
}
