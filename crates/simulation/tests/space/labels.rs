//! Regions of labels: their surfaces beside the bodies that were cut into voxels, and refusals.

use nalgebra::Vector3;
use simulation::space::cells::{LabelField, LabelMap, Mesh, NoMesh, NoRegion, Parts, Settings, Smoothing};

use crate::random;

const SIZE: [usize; 3] = [40, 38, 30];

/// A label map of what `inside` says of each voxel's centre.
fn map(spacing: Vector3<f64>, inside: impl Fn(&Vector3<f64>) -> bool) -> Vec<u16> {
    let place = |n: usize| {
        let at = [n % SIZE[0], n / SIZE[0] % SIZE[1], n / SIZE[0] / SIZE[1]];
        Vector3::from_fn(|k, _| spacing[k] * at[k] as f64)
    };
    (0..SIZE.iter().product())
        .map(|n| if inside(&place(n)) { 7 } else { 3 })
        .collect()
}

fn field(labels: &[u16], spacing: Vector3<f64>, smoothing: &Smoothing) -> Result<LabelField, NoRegion> {
    let map = LabelMap {
        size: SIZE,
        origin: Vector3::zeros(),
        spacing,
        labels,
    };
    LabelField::new(&map, 7, smoothing)
}

#[test]
fn the_surface_of_a_ball_of_voxels_is_the_balls() {
    let mut state = 11;
    for spacing in [Vector3::repeat(3.0), Vector3::new(2.0, 2.0, 4.0)] {
        for _ in 0..3 {
            let centre = Vector3::new(40.0, 38.0, 45.0) + Vector3::from_fn(|_, _| 4.0 * random(&mut state));
            let radius = 25.0;
            let labels = map(spacing, |x| (x - centre).norm() < radius);
            let smoothing = Smoothing {
                sigma: 3.0,
                ..Smoothing::default()
            };
            let field = field(&labels, spacing, &smoothing).unwrap();
            let mesh = Mesh::new(&field, field.corners, &Settings::of_side(9.0), &|_, _| false).unwrap();
            let (mut mean, mut worst, mut area) = (0.0, 0.0_f64, 0.0);
            for point in &mesh.surface {
                let off = (point.at - centre).norm() - radius;
                mean += off * point.area;
                worst = worst.max(off.abs());
                area += point.area;
            }
            mean /= area;
            let volume = mesh.volume() / field.facts.volume;
            println!(
                "spacing {:?}: off by {mean:.3} mm, at most {worst:.3} mm; volume {volume:.4}",
                spacing.as_slice()
            );
            // The voxels themselves are off by half of one, which a wide flat cap of them keeps however it is smoothed; on
            // the whole they are not.
            assert!(
                mean.abs() < 0.05 * spacing.max() && worst < 0.5 * spacing.max(),
                "{mean} {worst}"
            );
            assert!((volume - 1.0).abs() < 0.005, "{volume}");
        }
    }
}

#[test]
fn parts_holes_and_thin_labels_are_named() {
    let spacing = Vector3::repeat(3.0);
    let centre = Vector3::new(58.0, 56.0, 45.0);
    let far = |x: &Vector3<f64>| (x - centre).norm();
    let plain = Smoothing {
        sigma: 2.0,
        ..Smoothing::default()
    };
    let speck = map(spacing, |x| far(x) < 20.0 || *x == Vector3::new(3.0, 3.0, 3.0));
    assert!(matches!(
        field(&speck, spacing, &plain),
        Err(NoRegion::Parts { count: 2, next: 1, .. })
    ));
    let largest = Smoothing {
        parts: Parts::Largest,
        ..plain
    };
    let facts = field(&speck, spacing, &largest).unwrap().facts;
    assert_eq!((facts.parts, facts.dropped), (2, 1));
    let hollow = map(spacing, |x| (9.0..20.0).contains(&far(x)));
    let open = field(&hollow, spacing, &plain).unwrap();
    let filled = field(
        &hollow,
        spacing,
        &Smoothing {
            fill_holes: true,
            ..plain
        },
    )
    .unwrap();
    assert!(open.facts.holes > 50 && !open.facts.filled && open.facts.holes == filled.facts.holes);
    assert_eq!(filled.facts.voxels, open.facts.voxels + open.facts.holes);
    let voxel = map(spacing, |x| *x == Vector3::new(60.0, 60.0, 45.0));
    let one = field(&voxel, spacing, &plain).unwrap();
    assert_eq!(one.facts.voxels, 1);
    let mesh = |side: f64| Mesh::new(&one, one.corners, &Settings::of_side(side), &|_, _| false);
    assert!(matches!(mesh(20.0), Err(NoMesh::Thin { .. })));
    // Its 27 samples do not tell its volume to a tenth.
    assert!(matches!(mesh(2.0), Err(NoMesh::Lost { expected: 27.0, .. })));
    let rod = map(spacing, |x| x.x == 60.0 && x.y == 60.0 && (9.0..80.0).contains(&x.z));
    let coarse = Smoothing { sigma: 10.0, ..plain };
    assert!(matches!(field(&rod, spacing, &coarse), Err(NoRegion::Lost { .. })));
    let cut = field(&map(spacing, |x| x.norm() < 40.0), spacing, &plain).unwrap();
    assert_eq!(cut.facts.cut, [[true, false]; 3]);
}

#[test]
fn bad_label_maps_are_refused_by_name() {
    let labels = map(Vector3::repeat(1.0), |_| false);
    let plain = Smoothing::default();
    assert!(matches!(
        field(&labels, Vector3::repeat(1.0), &plain),
        Err(NoRegion::Missing { label: 7 })
    ));
    assert!(matches!(
        field(&labels[1..], Vector3::repeat(1.0), &plain),
        Err(NoRegion::Size { .. })
    ));
    for spacing in [0.0, -3.0, f64::NAN, f64::INFINITY] {
        assert!(matches!(
            field(&labels, Vector3::new(1.0, spacing, 1.0), &plain),
            Err(NoRegion::Place { .. })
        ));
    }
    for sigma in [-1.0, f64::NAN, 1e3] {
        let smoothing = Smoothing { sigma, ..plain };
        assert!(
            matches!(
                field(&labels, Vector3::repeat(1.0), &smoothing),
                Err(NoRegion::Smoothing { .. })
            ),
            "{sigma}"
        );
    }
    let map = LabelMap {
        size: [usize::MAX, 2, 2],
        origin: Vector3::zeros(),
        spacing: Vector3::repeat(1.0),
        labels: &labels,
    };
    assert!(matches!(LabelField::new(&map, 7, &plain), Err(NoRegion::Size { .. })));
}

#[test]
fn a_block_of_voxels_has_all_of_its_surface() {
    // Flat faces that meet in rounded edges, within one cube.
    let spacing = Vector3::repeat(3.0);
    let inside = |x: &Vector3<f64>| (0..3).all(|k| (12.0..=69.0).contains(&x[k]));
    let field = field(
        &map(spacing, inside),
        spacing,
        &Smoothing {
            sigma: 3.0,
            ..Smoothing::default()
        },
    )
    .unwrap();
    let mesh = Mesh::new(&field, field.corners, &Settings::of_side(12.0), &|_, _| false).unwrap();
    let volume = mesh.volume() / 60_f64.powi(3);
    assert!((volume - 1.0).abs() < 1e-3, "{volume}");
    for axis in 0..3 {
        let faces = [1.0, -1.0].map(|sign: f64| {
            let each = mesh.surface.iter().map(|p| (sign * p.normal[axis]).max(0.0) * p.area);
            each.sum::<f64>() / 3600.0
        });
        println!("axis {axis}: {faces:.5?}");
        // Seen along an axis it is a square of 60.2 mm, as much as its rounded edges take away; a wall that stands upright over
        // the base of a box is a sixth of that where boxes are not cut for it.
        assert!(faces.iter().all(|f| (f - 1.0067).abs() < 2e-3), "{faces:?}");
    }
}

#[test]
fn what_is_lost_or_comes_apart_is_refused() {
    let spacing = Vector3::repeat(3.0);
    let apart = |x: &Vector3<f64>, at: f64| (x - Vector3::new(at, 54.0, 45.0)).norm();
    // Two balls with a bridge of one voxel, which smoothing by two voxels takes away.
    let dumbbell = |x: &Vector3<f64>| {
        let bridge = x.y == 54.0 && x.z == 45.0 && (30.0..90.0).contains(&x.x);
        apart(x, 27.0) < 16.0 || apart(x, 93.0) < 16.0 || bridge
    };
    let field = field(
        &map(spacing, dumbbell),
        spacing,
        &Smoothing {
            sigma: 6.0,
            ..Smoothing::default()
        },
    )
    .unwrap();
    assert_eq!(field.facts.parts, 1);
    let mesh = Mesh::new(&field, field.corners, &Settings::of_side(6.0), &|_, _| false).map(|m| m.nodes.len());
    assert!(matches!(mesh, Err(NoMesh::Apart { count: 2, .. })), "{mesh:?}");
}

/// The most memory that this process has had, MiB, as Linux tells.
fn peak() -> Option<usize> {
    let status = std::fs::read_to_string("/proc/self/status").ok()?;
    let line = status.lines().find(|l| l.starts_with("VmHWM:"))?;
    line.split_whitespace().nth(1)?.parse::<usize>().ok().map(|k| k / 1024)
}

#[test]
#[ignore = "a table of four minutes: up to 3 GiB of memory"]
#[expect(
    clippy::disallowed_methods,
    reason = "the seconds of a table, which nothing depends on"
)]
fn large_maps() {
    const SIDE: usize = 512;
    println!("before: {:?} MiB", peak());
    for (radius, side) in [(30.0, 10.0), (120.0, 30.0), (240.0, 60.0)] {
        let mut labels = vec![0_u16; SIDE.pow(3)];
        for (n, label) in labels.iter_mut().enumerate() {
            let at = [n % SIDE, n / SIDE % SIDE, n / SIDE / SIDE].map(|k| k as f64 - 255.3);
            *label = u16::from(Vector3::from(at).norm() < radius) * 7;
        }
        let map = LabelMap {
            size: [SIDE; 3],
            origin: Vector3::zeros(),
            spacing: Vector3::repeat(1.0),
            labels: &labels,
        };
        let (begun, before) = (std::time::Instant::now(), peak());
        let smoothing = Smoothing {
            sigma: 1.0,
            ..Smoothing::default()
        };
        let field = LabelField::new(&map, 7, &smoothing).unwrap();
        let (field_seconds, after) = (begun.elapsed().as_secs_f64(), peak());
        let mesh = Mesh::new(&field, field.corners, &Settings::of_side(side), &|_, _| false).unwrap();
        let seconds = begun.elapsed().as_secs_f64() - field_seconds;
        let exact = 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3);
        println!(
            "radius {radius}: field {field_seconds:.1} s, {before:?} to {after:?} MiB; mesh of {} cubes {seconds:.1} s, volume {:.5}",
            mesh.elements.len(),
            mesh.volume() / exact
        );
        // A ball of voxels has its volume to some parts of a surface's worth of voxels, and is smoothed to its own.
        assert!((mesh.volume() / exact - 1.0).abs() < 0.01);
    }
}
