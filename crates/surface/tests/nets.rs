//! Surface nets against solids whose surface is known, through grids of every kind. Nothing here knows how nets are made.

#![allow(clippy::unwrap_used, reason = "a step that fails here is a test that fails")]

use std::collections::BTreeMap;

use geometry::{Affine, Ct, Point, VolumeGrid, Voxel};
use surface::nets::{Lattice, extract};
use surface::{Average, Field, MOST_SAMPLES, Mesh, SurfaceError, bone, structures};

/// Rows of `ct_from_voxel`.
type Rows = [[f64; 4]; 3];

const CUBES: Rows = [[1.0, 0.0, 0.0, -20.0], [0.0, 1.0, 0.0, 7.0], [0.0, 0.0, 1.0, 100.0]];
/// Anisotropic, as of thick slices.
const BRICKS: Rows = [[0.7, 0.0, 0.0, 0.0], [0.0, 0.8, 0.0, 0.0], [0.0, 0.0, 2.5, -60.0]];
/// A gantry tilted by 20 degrees: slices are shifted along y as they go up.
const TILTED: Rows = [[0.7, 0.0, 0.0, 5.0], [0.0, 0.7, 0.51, 5.0], [0.0, 0.0, 1.41, 5.0]];
/// Left-handed, and with its axes in another order.
const MIRRORED: Rows = [[0.0, 1.0, 0.0, 0.0], [1.2, 0.0, 0.0, 0.0], [0.0, 0.0, 0.9, 0.0]];
const GRIDS: [Rows; 4] = [CUBES, BRICKS, TILTED, MIRRORED];

fn grid(dims: [i64; 3], rows: Rows) -> VolumeGrid {
    VolumeGrid::checked(dims, Affine::from_rows(rows)).unwrap()
}

/// The surface of what `value` is at least `level`, at places in mm.
fn net(grid: &VolumeGrid, level: f64, value: impl Fn([f64; 3]) -> f64) -> Mesh {
    let lattice = Lattice {
        dims: grid.dims(),
        ct_from_sample: grid.ct_from_voxel(),
        level: level as f32,
        most: 1_000_000,
    };
    let [nx, ny, _] = grid.dims();
    let layer = |z: u32, values: &mut [f32], _: &mut [u8]| {
        for (i, out) in (0..nx * ny).zip(values.iter_mut()) {
            *out = value(place(grid.ct_from_voxel(), [i % nx, i / nx, z])) as f32;
        }
        Ok(())
    };
    extract(&lattice, layer).unwrap()
}

fn place(affine: Affine<Ct, Voxel>, voxel: [u32; 3]) -> [f64; 3] {
    let [x, y, z] = voxel.map(f64::from);
    (affine * Point::new(x, y, z)).mm()
}

/// Half the longest diagonal of a voxel, mm.
fn half_diagonal(grid: &VolumeGrid) -> f64 {
    let affine = grid.ct_from_voxel();
    let signs = [[1.0, 1.0], [1.0, -1.0], [-1.0, 1.0], [-1.0, -1.0]];
    let diagonals = signs.map(|[s, t]| (affine.step(0) + affine.step(1) * s + affine.step(2) * t).norm());
    diagonals.into_iter().fold(0.0, f64::max) / 2.0
}

fn corner(mesh: &Mesh, i: u32) -> [f64; 3] {
    mesh.points()[i as usize].map(f64::from)
}

/// How often each edge occurs in each direction: of a closed surface that is turned one way everywhere, once in both.
fn is_closed(mesh: &Mesh) -> bool {
    let mut edges: BTreeMap<[u32; 2], [u32; 2]> = BTreeMap::new();
    for &[a, b, c] in mesh.triangles() {
        for [from, to] in [[a, b], [b, c], [c, a]] {
            edges.entry([from.min(to), from.max(to)]).or_default()[usize::from(from > to)] += 1;
        }
    }
    edges.values().all(|times| *times == [1, 1])
}

fn euler_number(mesh: &Mesh) -> i64 {
    let mut edges: Vec<[u32; 2]> = Vec::new();
    for &[a, b, c] in mesh.triangles() {
        edges.extend([[a, b], [b, c], [c, a]].map(|[from, to]| [from.min(to), from.max(to)]));
    }
    edges.sort_unstable();
    edges.dedup();
    mesh.points().len() as i64 - edges.len() as i64 + mesh.triangles().len() as i64
}

/// Of a closed surface that is turned outwards the volume, by the divergence theorem.
fn volume(mesh: &Mesh) -> f64 {
    let of = |&[a, b, c]: &[u32; 3]| {
        let [[ax, ay, az], [bx, by, bz], [cx, cy, cz]] = [a, b, c].map(|i| corner(mesh, i));
        (ax * (by * cz - bz * cy) - ay * (bx * cz - bz * cx) + az * (bx * cy - by * cx)) / 6.0
    };
    mesh.triangles().iter().map(of).sum()
}

#[test]
fn a_ball_is_found_where_it_is_closed_and_turned_outwards_in_every_grid() {
    for rows in GRIDS {
        let grid = grid([48, 44, 40], rows);
        let ([x, y, z], radius) = (grid.centre().mm(), 9.3);
        let middle = [x + 0.31, y - 0.17, z + 0.23];
        let from_middle = |p: [f64; 3]| (0..3).map(|a| (p[a] - middle[a]).powi(2)).sum::<f64>().sqrt();
        let mesh = net(&grid, 0.0, |p| radius - from_middle(p));
        assert!(mesh.triangles().len() > 300);
        for p in mesh.points() {
            let off = (from_middle(p.map(f64::from)) - radius).abs();
            assert!(off <= half_diagonal(&grid), "{rows:?}: {off} mm");
        }
        assert!(is_closed(&mesh), "{rows:?}");
        assert_eq!(euler_number(&mesh), 2, "{rows:?}");
        // Within a layer of half a diagonal on each side of the ball's own surface.
        let (found, truth) = (volume(&mesh), 4.0 / 3.0 * std::f64::consts::PI * radius.powi(3));
        assert!((found / truth - 1.0).abs() < 0.1, "{rows:?}: {found} of {truth} mm^3");
    }
}

#[test]
fn a_box_that_the_examination_cuts_off_is_closed_there_half_a_voxel_beyond_the_last_one() {
    let grid = grid([20, 18, 16], CUBES);
    let inside = |x: f64| if (-30.0..=-8.4).contains(&x) { 1.0 } else { 0.0 };
    let mesh = net(&grid, 0.5, |[x, ..]| inside(x));
    assert!(is_closed(&mesh));
    assert_eq!(euler_number(&mesh), 2);
    let range = |axis: usize| {
        let values = || mesh.points().iter().map(|p| f64::from(p[axis]));
        [values().fold(f64::MAX, f64::min), values().fold(f64::MIN, f64::max)]
    };
    // Voxels -20 to -9 along x are inside; the corners lie halfway to those that are not.
    for (axis, expected) in [[-20.5, -8.5], [6.5, 24.5], [99.5, 115.5]].into_iter().enumerate() {
        let found = range(axis);
        assert!(
            (0..2).all(|end| (found[end] - expected[end]).abs() < 1e-4),
            "{axis}: {found:?}"
        );
    }
    assert!((volume(&mesh) - 12.0 * 18.0 * 16.0).abs() < 0.05 * 12.0 * 18.0 * 16.0);
}

/// A ring has Euler number 0, two balls 4.
#[test]
fn holes_and_parts_are_what_they_are() {
    let grid = grid([48, 44, 40], CUBES);
    let [x, y, z] = grid.centre().mm();
    let ring = net(&grid, 0.0, |p| {
        let around = (p[0] - x).hypot(p[1] - y) - 12.0;
        4.1 - around.hypot(p[2] - z)
    });
    assert!(is_closed(&ring));
    assert_eq!(euler_number(&ring), 0);
    let balls = net(&grid, 0.0, |p| {
        let beside = (p[0] - x).abs() - 11.0;
        6.2 - beside.hypot(p[1] - y).hypot(p[2] - z)
    });
    assert!(is_closed(&balls));
    assert_eq!(euler_number(&balls), 4);
}

/// As bone: voxels of whole numbers, read slice by slice.
fn with_field<T>(grid: &VolumeGrid, value: impl Fn([u32; 3]) -> i16, of: impl FnOnce(&mut Field<'_>) -> T) -> T {
    let [nx, ny, _] = grid.dims();
    let mut read = |z: u32, slice: &mut [i16]| {
        for (i, out) in (0..nx * ny).zip(slice.iter_mut()) {
            *out = value([i % nx, i / nx, z]);
        }
    };
    of(&mut Field { grid, read: &mut read })
}

#[test]
fn what_has_no_bone_is_empty_and_numbers_at_their_ends_do_no_harm() {
    let grid = grid([12, 11, 10], TILTED);
    let of = |hu: i16, level: f64| with_field(&grid, |_| hu, |field| bone(field, level)).unwrap();
    assert!(of(-1000, 300.0).is_empty() && of(i16::MIN, -32_767.0).is_empty());
    for (hu, level) in [(i16::MAX, 32_767.0), (i16::MAX, -32_768.0), (300, 300.0)] {
        let mesh = of(hu, level);
        assert!(is_closed(&mesh) && euler_number(&mesh) == 2, "{hu} {level}");
        assert!(mesh.points().iter().flatten().all(|c| c.is_finite()));
    }
    let noise = |[x, y, z]: [u32; 3]| {
        if (x * 7 + y * 5 + z * 3) % 4 < 2 {
            i16::MAX
        } else {
            i16::MIN
        }
    };
    let mesh = with_field(&grid, noise, |field| bone(field, 0.0)).unwrap();
    assert!(mesh.points().iter().flatten().all(|c| c.is_finite()));
    assert!(
        with_field(&grid, |_| 0, |field| bone(field, f64::NAN))
            .unwrap()
            .is_empty()
    );
}

#[test]
fn a_surface_that_is_too_large_is_refused_before_there_is_memory_for_it() {
    let lattice = |most| Lattice {
        dims: [40, 40, 40],
        ct_from_sample: Affine::from_rows(CUBES),
        level: 0.5,
        most,
    };
    // A chessboard: three quads at each voxel.
    let chess = |z: u32, values: &mut [f32], _: &mut [u8]| {
        for (i, value) in (0..1600).zip(values.iter_mut()) {
            *value = ((i % 40 + i / 40 + z) % 2) as f32;
        }
        Ok(())
    };
    assert_eq!(
        extract(&lattice(5000), chess),
        Err(SurfaceError::TooMany { most: 5000 })
    );
    let mesh = extract(&lattice(1_000_000), chess).unwrap();
    let count = mesh.triangles().len();
    assert!(count > 300_000 && extract(&lattice(count), chess).is_ok());
    assert!(
        extract(&lattice(count - 1), chess)
            .unwrap_err()
            .to_string()
            .contains("more than")
    );
}

#[test]
fn blocks_are_means_in_their_place_and_thin_walls_have_no_holes() {
    // 0.5 mm voxels: blocks of 2 x 2 x 1 of BRICKS-like voxels stay nearly cubes.
    let fine = grid(
        [64, 60, 20],
        [[0.7, 0.0, 0.0, 0.0], [0.0, 0.7, 0.0, 0.0], [0.0, 0.0, 2.5, 0.0]],
    );
    let average = Average::of(&fine, 64 * 60 * 20 / 4);
    assert_eq!(average, Average([2, 2, 1]));
    assert_eq!(average.dims(&fine), [32, 30, 20]);
    let [x, y, z] = (average.ct_from_sample(&fine) * Point::new(3.0, 0.0, 2.0)).mm();
    assert!((x - 6.5 * 0.7).abs() < 1e-12 && (y - 0.35).abs() < 1e-12 && (z - 5.0).abs() < 1e-12);
    assert_eq!(Average::of(&fine, 1_000_000), Average([1; 3]));
    // The largest grids there are become small enough.
    let huge = grid([2048, 2048, 800], BRICKS);
    let samples: u64 = Average::of(&huge, MOST_SAMPLES)
        .dims(&huge)
        .iter()
        .map(|n| u64::from(*n))
        .product();
    assert!(samples <= MOST_SAMPLES);
}

/// A large volume with a wall one voxel thin at an odd place: a step over every second voxel would lose it wholly.
#[test]
fn a_wall_of_one_voxel_survives_in_a_volume_that_is_averaged() {
    let grid = grid([241, 240, 240], CUBES);
    assert_ne!(Average::of(&grid, MOST_SAMPLES), Average([1; 3]));
    let wall = |[x, y, z]: [u32; 3]| match x {
        101 if (40..200).contains(&y) && (40..200).contains(&z) => 1200,
        _ => 0,
    };
    let mesh = with_field(&grid, wall, |field| bone(field, 300.0)).unwrap();
    assert!(is_closed(&mesh));
    assert_eq!(euler_number(&mesh), 2);
}

#[test]
fn structures_have_the_paint_of_their_label_each_and_labels_may_be_thousands() {
    let grid = grid([40, 40, 40], MIRRORED);
    let ball = |[x, y, z]: [u32; 3], middle: [i64; 3]| {
        let d = [x, y, z].map(i64::from);
        (0..3).map(|a| (d[a] - middle[a]).pow(2)).sum::<i64>() <= 36
    };
    let two = |p: [u32; 3]| match (ball(p, [10, 10, 10]), ball(p, [28, 28, 28])) {
        (true, _) => 1,
        (_, true) => 5000,
        _ => 0,
    };
    let mesh = with_field(&grid, two, structures).unwrap();
    assert!(is_closed(&mesh) && euler_number(&mesh) == 4 && volume(&mesh) > 0.0);
    let mut paints: BTreeMap<u8, usize> = BTreeMap::new();
    mesh.paints()
        .iter()
        .for_each(|paint| *paints.entry(*paint).or_default() += 1);
    assert_eq!(
        paints.keys().copied().collect::<Vec<_>>(),
        [1, ((5000 - 1) % 6 + 1) as u8]
    );
    let counts: Vec<usize> = paints.values().copied().collect();
    assert_eq!(counts[0], counts[1]);
    // Each voxel a label of its own: one surface.
    let all = |[x, y, z]: [u32; 3]| (1 + (x + 40 * y + 1600 * z) % 32_000) as i16;
    let mesh = with_field(&grid, all, structures).unwrap();
    assert!(is_closed(&mesh) && euler_number(&mesh) == 2);
    let negative = |[x, ..]: [u32; 3]| if x == 7 { -3 } else { 1 };
    assert_eq!(with_field(&grid, negative, structures), Err(SurfaceError::Negative(-3)));
    assert!(with_field(&grid, |_| 0, structures).unwrap().is_empty());
}
