//! The very points of some rows as text, for other programs, with what this one makes of them.

use std::fmt::Write as _;
use std::path::Path;

use geometry::{Ct, Rigid, Tracker};
use serde_json::json;
use surface_registration::{Options, Points, Start, refine, register};

use super::common::draw::{off, targets};
use super::common::oracle::Triangles;
use super::rows::{From, rows};
use super::run::{Scene, drawn, seconds};

/// Rows, and the guess of each, degrees and mm off.
const ROWS: [(&str, f64, f64); 5] = [
    ("pose only 200, 0 %, 10/10", 10.0, 10.0),
    ("pose only 200, 20 %, 10/10", 10.0, 10.0),
    ("crests + pubis 200, 20 %, 30/30", 30.0, 30.0),
    ("crests + pubis 200, 40 %, 20/20", 20.0, 20.0),
    ("one crest 100, 10 %, 10/10", 10.0, 10.0),
];

fn matrix(pose: &Rigid<Ct, Tracker>) -> [[f64; 4]; 3] {
    let rows: nalgebra::Matrix3<f64> = pose.rotation().matrix().into();
    let shift = pose.translation_mm();
    [0, 1, 2].map(|i| [rows[(i, 0)], rows[(i, 1)], rows[(i, 2)], shift[i]])
}

pub(crate) fn dump((corners, triangles): &Triangles, scene: &Scene, runs: u64, folder: &str) {
    let folder = Path::new(folder);
    std::fs::create_dir_all(folder).unwrap();
    let mut obj = String::new();
    corners
        .iter()
        .for_each(|[x, y, z]| writeln!(obj, "v {x} {y} {z}").unwrap());
    for t in triangles {
        let [a, b, c] = t.map(|i| i + 1);
        writeln!(obj, "f {a} {b} {c}").unwrap();
    }
    std::fs::write(folder.join("bone.obj"), obj).unwrap();
    let mut all = Vec::new();
    for (name, deg, mm) in ROWS {
        let row = rows().into_iter().find(|row| row.name == name).unwrap();
        assert!(matches!(row.from, From::Guess(..)));
        let mut options = Options::default();
        options.priors.bone_mm = 0.0;
        // As the others are, which know of no depth scale and no offset.
        (options.priors.depth_scale, options.priors.offset_mm) = (0.0, 0.0);
        for seed in 0..runs {
            let (drawn, _) = drawn(scene, &row, 7_000_000 + seed);
            let pose = off(&drawn, deg, mm, 7_000_000 + seed);
            let points = Points::new(&drawn.points, None, 0.5).unwrap();
            let one = seconds(|| refine(&scene.surface, &scene.field, &points, &pose, &options));
            let start = Start::Guess {
                pose,
                turn_rad: (1.2 * deg).to_radians(),
                shift_mm: 1.2 * mm,
            };
            let searched = seconds(|| register(&scene.surface, &scene.field, &points, &start, &options));
            let ours = [("one start", one), ("search", searched)].map(|(name, (time, found))| {
                let found = found.map(|found| matrix(&found.transform.transform()));
                json!({"name": name, "ms": time * 1e3, "ct_from_tracker": found.ok()})
            });
            all.push(json!({
                "row": name,
                "points_mm": drawn.points.iter().map(|p| p.place.mm()).collect::<Vec<_>>(),
                "guess_ct_from_tracker": matrix(&pose),
                "ct_from_tracker": matrix(&drawn.ct_from_tracker),
                "ours": ours,
            }));
        }
    }
    let targets = targets().map(|target| target.mm());
    let text = json!({"targets_ct_mm": targets, "runs": all}).to_string();
    std::fs::write(folder.join("runs.json"), text).unwrap();
}
