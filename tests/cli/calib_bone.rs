//! `calib bone` and `calib surface` on a patient's CT: the surface that the one writes is what the other registers to.

#![allow(clippy::print_stdout, reason = "the figures of the registration")]

use std::fs;

use crate::support::{World, shared, stderr, stdout};
use calib::file::{Registered, RegistrationFile};
use chance::Chance;
use geometry::{Ct, Point, Rigid, Tracker, Vector};

const NOISE_MM: f64 = 0.4;
/// Label of the left hip in the map.
const HIP: &str = "77";

/// Corners and triangles of a surface as OBJ has them.
fn obj(text: &str) -> (Vec<[f64; 3]>, Vec<[usize; 3]>) {
    let (mut corners, mut triangles) = (Vec::new(), Vec::new());
    for line in text.lines() {
        let words: Vec<&str> = line.split_whitespace().collect();
        match words[..] {
            ["v", x, y, z] => corners.push([x, y, z].map(|x| x.parse().unwrap())),
            ["f", a, b, c] => {
                let corner = |word: &str| word.split('/').next().unwrap().parse::<usize>().unwrap() - 1;
                triangles.push([a, b, c].map(corner));
            }
            _ => {}
        }
    }
    (corners, triangles)
}

/// Points of the bone as a localizer would have them.
fn touched(surface: &str, ct_from_tracker: Rigid<Ct, Tracker>) -> String {
    let (corners, triangles) = obj(surface);
    let mut text = "x,y,z\n".to_owned();
    for i in 0..200 {
        let c = Chance::new(77, i);
        let triangle = triangles[(c.uniform(0) * triangles.len() as f64) as usize];
        let (u, v) = (c.uniform(1).sqrt(), c.uniform(2));
        let weights = [1.0 - u, u * (1.0 - v), u * v];
        let place = |k: usize| {
            (0..3)
                .map(|corner| weights[corner] * corners[triangle[corner]][k])
                .sum::<f64>()
        };
        let [x, y, z] = [0, 1, 2].map(|k| place(k) + NOISE_MM * c.normal(3 + k as u64));
        let [x, y, z] = (ct_from_tracker.inverse() * Point::<Ct>::new(x, y, z)).mm();
        text += &format!("{x},{y},{z}\n");
    }
    text
}

/// The surface of a hip is in pieces where a joint was cut and where nothing is known: a piece of seven triangles that turned its back was
/// no bone to register with.
#[test]
fn the_hip_of_a_patient_is_registered_to() {
    let Some(data) = shared("data/ct-abdopelvis-nifti") else {
        return;
    };
    let world = World::new();
    let path = |name: &str| world.path(name).to_str().unwrap().to_owned();
    let file = |name: &str| data.join(name).to_str().unwrap().to_owned();
    let (ct, labels) = (file("example_ct.nii.gz"), file("example_seg_fast_force_split.nii.gz"));
    let (ply, text, out) = (path("hip.ply"), path("hip.obj"), path("registration.json"));
    let calib = |words: &[&str]| {
        let output = world.output("calib", words);
        assert!(output.status.success(), "{words:?}: {}", stderr(&output));
        stdout(&output)
    };
    let said = calib(&["bone", &ct, "--labels", &labels, "--label", HIP, "--out", &ply]);
    assert!(said.contains("a small piece that stands alone"), "{said}");
    calib(&["mesh", &ply, "--out", &text, "--axes", "lps"]);
    let turn = Vector::new(0.4, -1.1, 0.7);
    let ct_from_tracker = Rigid::from_rotation_vector(turn, Vector::new(120.0, -60.0, 900.0)).unwrap();
    let points = world.file(
        "points.csv",
        &touched(&fs::read_to_string(&text).unwrap(), ct_from_tracker),
    );
    let said = calib(&[
        "surface",
        "--bone",
        &ply,
        "--points",
        points.to_str().unwrap(),
        "--noise-mm",
        "0.4",
        "--shared-mm",
        "0",
        "--target",
        "70,-120,200",
        "--out",
        &out,
    ]);
    let read = RegistrationFile::parse(&fs::read_to_string(&out).unwrap()).unwrap();
    // Which CT it is of is in the file, as the bone's own file says.
    assert!(
        read.ct_hash
            .is_some_and(|hash| said.contains("nothing speaks against it") && hash.len() == 64)
    );
    let Registered::Fixed(found) = read.registered else {
        panic!("{said}")
    };
    let target = Point::<Ct>::new(70.0, -120.0, 200.0);
    let seen: Point<Tracker> = ct_from_tracker.inverse() * target;
    let (off, predicted) = ((found.transform() * seen).distance(target), (found * seen).rms_mm());
    println!("the target is off by {off:.2} mm, {predicted:.2} mm predicted");
    // Beyond four times its root mean square an error has a chance of 1e-6, in whichever directions it may be.
    assert!(
        off < 4.0 * predicted && predicted < 1.0,
        "{off} mm, {predicted} predicted"
    );
}
