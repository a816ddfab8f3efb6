//! From a generated CT to the registration: bone taken by `extract`, points drawn on the true bone.

use bone::{Bone, Options, Region, extract};
use chance::SplitMix64;
use geometry::{Ct, Direction, Point, Rigid, Tracker, Vector};
use surface_registration::{
    Beam, BeamNoise, Field, Options as Registering, Points, Spacing, Start, Surface, SurfacePoint, register,
};

use super::common::{Body, Scene, grid, scan};

const POINTS: usize = 200;
const RUNS: u64 = 10;
/// Axial, lateral, elevation, mm.
const NOISE_MM: [f64; 3] = [0.5, 1.0, 1.5];
const ECHOES: f64 = 0.2;
/// Targets, mm: as far from the bone as a pelvis's vessels are.
const TARGETS: [[f64; 3]; 6] = [
    [0.0, 30.0, 0.0],
    [0.0, 50.0, 20.0],
    [-30.0, 40.0, -10.0],
    [30.0, 30.0, -30.0],
    [0.0, 20.0, 40.0],
    [-20.0, 60.0, 0.0],
];

/// Root mean square TRE of each run, mm: of the bone, and of the surface of the threshold.
pub(crate) fn chain(scene: &Scene) {
    let ct = scan(scene, grid(scene));
    let mut options = Options::of(Region::Number(1));
    options.threads = 2;
    match extract(&ct, &options) {
        Ok(bone) => {
            let mut tre: Vec<f64> = (0..RUNS).map(|seed| run(scene.body, &bone, seed)).collect();
            tre.sort_by(f64::total_cmp);
            let predicted = bone.shared_rms_mm();
            println!(
                "{} mm voxels, cortex {:?}: TRE rms of {RUNS} runs, mm: median {:.2}, worst {:.2}; offset prior {predicted:.2}",
                scene.step_mm[0],
                scene.cortex,
                tre[tre.len() / 2],
                tre[tre.len() - 1]
            );
        }
        Err(refused) => println!("{refused}"),
    }
}

fn run(body: Body, bone: &Bone, seed: u64) -> f64 {
    let corners: Vec<[f64; 3]> = bone.places.iter().map(|p| p.mm.into()).collect();
    let surface = Surface::<Ct>::new(&corners, &bone.triangles).unwrap();
    let field = Field::new(&surface, Spacing::default()).unwrap();
    let mut random = SplitMix64::new(100 + seed);
    let mut turn = |size: f64| {
        Vector::new(
            random.around(0.0, size),
            random.around(0.0, size),
            random.around(0.0, size),
        )
    };
    let ct_from_tracker: Rigid<Ct, Tracker> = Rigid::from_rotation_vector(turn(1.0), turn(200.0)).unwrap();
    let wrong: Rigid<Ct, Ct> = Rigid::from_rotation_vector(turn(0.1), turn(6.0)).unwrap();
    let tracker_from_ct = ct_from_tracker.inverse();
    let seen = points(body, &mut random).into_iter().map(|(p, beam)| {
        let [place, depth] =
            [p, [0, 1, 2].map(|k| p[k] + beam[k])].map(|q| (tracker_from_ct * Point::<Ct>::new(q[0], q[1], q[2])).mm());
        let direction = Vector::new(depth[0] - place[0], depth[1] - place[1], depth[2] - place[2])
            .direction()
            .unwrap();
        let across: Direction<Tracker> = Vector::new(direction.components()[1], -direction.components()[0], 0.1)
            .direction()
            .unwrap();
        let beam = Beam {
            direction,
            depth_mm: Some(30.0),
        };
        let noise = BeamNoise {
            axial_mm: NOISE_MM[0],
            lateral_mm: NOISE_MM[1],
            elevation_mm: NOISE_MM[2],
        };
        SurfacePoint::seen(Point::new(place[0], place[1], place[2]), beam, across, noise)
    });
    let points = Points::new(&seen.collect::<Vec<_>>(), None, 0.0).unwrap();
    let mut options = Registering::default();
    options.priors.depth_scale = 0.0;
    options.priors.offset_mm = bone.shared_rms_mm().max(0.05);
    options.priors.bone_mm = bone.deviation_rms_mm();
    let start = Start::Guess {
        pose: wrong * ct_from_tracker,
        turn_rad: 0.3,
        shift_mm: 20.0,
    };
    let found = register(&surface, &field, &points, &start, &options).unwrap();
    let squares = TARGETS.iter().map(|t| {
        let target = Point::<Ct>::new(t[0], t[1], t[2]);
        (found.transform.transform() * (tracker_from_ct * target))
            .distance(target)
            .powi(2)
    });
    (squares.sum::<f64>() / TARGETS.len() as f64).sqrt()
}

/// Measured places and beams in the CT: of the side that looks to the front (against y), all over the bone.
fn points(body: Body, random: &mut SplitMix64) -> Vec<([f64; 3], [f64; 3])> {
    let mut found = Vec::new();
    while found.len() < POINTS {
        let p = [
            random.around(0.0, 90.0),
            random.around(30.0, 60.0),
            random.around(0.0, 80.0),
        ];
        if body.distance(p).abs() > 8.0 {
            continue;
        }
        let p = body.led(p);
        let normal = body.gradient(p);
        let length = normal.iter().map(|x| x * x).sum::<f64>().sqrt();
        let normal = normal.map(|x| x / length);
        if normal[1] > -0.25 || body.distance(p).abs() > 1e-4 {
            continue;
        }
        let mut normal_number = || (0..12).map(|_| random.around(0.0, 0.5)).sum::<f64>();
        // A beam that goes to the back, and the two directions across it.
        let noise = [
            normal_number() * NOISE_MM[1],
            normal_number() * NOISE_MM[0],
            normal_number() * NOISE_MM[2],
        ];
        let is_echo = random.around(0.5, 0.5) < ECHOES;
        let nearer = if is_echo { random.around(11.5, 8.5) } else { 0.0 };
        found.push((
            [p[0] + noise[0], p[1] + noise[1] - nearer, p[2] + noise[2]],
            [0.0, 1.0, 0.0],
        ));
    }
    found
}
