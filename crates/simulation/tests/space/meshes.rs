//! Meshes: what nodes reproduce, and that constant stress is in balance.

use nalgebra::{Matrix3, Vector3};
use simulation::law::Law;
use simulation::space::cells::{Ball, Field, Mesh, NoMesh, Plane, Settings};
use simulation::space::law::Material;
use simulation::space::solid::{Deformable, Solid};

use crate::random;

const CORNERS: [f64; 2] = [-10.0, 10.0];

fn mesh(field: &dyn Field, settings: &Settings) -> Mesh {
    let corners = CORNERS.map(Vector3::repeat);
    // Cubes on one side are a quarter as large, with a step of sizes between.
    Mesh::new(field, corners, settings, &|low, _| low.x + low.y < -2.0).unwrap()
}

fn settings(side: f64) -> [Settings; 2] {
    let quadratic = Settings {
        levels: 2,
        ..Settings::of_side(side)
    };
    [quadratic, quadratic.fast()]
}

#[test]
fn nodes_reproduce_polynomials_of_their_degree() {
    let mut state = 5;
    for (settings, quadratic) in settings(4.0).into_iter().zip([1.0, 0.0]) {
        let settings = Settings {
            least_fill: 0.3,
            ..settings
        };
        let ball = Ball {
            centre: Vector3::new(0.3, -0.7, 1.1),
            radius: 8.0,
        };
        let mesh = mesh(&ball, &settings);
        let coefficients: Vec<f64> = (0..10).map(|_| random(&mut state) - 0.5).collect();
        let polynomial = |x: &Vector3<f64>| {
            let c = &coefficients;
            let linear = c[0] + c[1] * x.x + c[2] * x.y + c[3] * x.z;
            let squares = c[4] * x.x * x.x + c[5] * x.y * x.y + c[6] * x.z * x.z;
            linear + quadratic * (squares + c[7] * x.x * x.y + c[8] * x.y * x.z + c[9] * x.z * x.x)
        };
        let mut extended = 0;
        for point in mesh.points() {
            let row = mesh.point_row(point);
            let value: f64 = row.iter().map(|(n, w)| w * polynomial(&mesh.nodes[*n as usize])).sum();
            let size: f64 = row
                .iter()
                .map(|(n, w)| (w * polynomial(&mesh.nodes[*n as usize])).abs())
                .sum();
            extended += usize::from(row.iter().any(|(_, w)| w.abs() > 1.0 + 1e-9));
            // Some hundred products of rounded weights.
            assert!(
                (value - polynomial(&point.at)).abs() < 1e-13 * (1.0 + size),
                "{point:?}"
            );
        }
        println!(
            "{} nodes, {} elements, {extended} points with extended nodes",
            mesh.nodes.len(),
            mesh.elements.len()
        );
        // Weights above 1 are those of extended nodes; a point within eight nodes seldom has them.
        assert!(quadratic == 0.0 || extended > 0);
    }
}

#[test]
fn constant_stress_is_in_balance_across_sizes_and_cuts() {
    let g = Matrix3::new(0.1, -0.05, 0.02, 0.03, -0.08, 0.06, -0.04, 0.07, 0.05);
    let tilted = Plane {
        point: Vector3::new(0.3, 0.2, 0.4),
        normal: Vector3::new(0.3, -0.5, 0.8),
    };
    for settings in settings(2.5) {
        for law in [Law::Linear, Law::NeoHookean] {
            let material = Material::new(law, 3.0, 0.45).unwrap();
            let solid = Deformable::new(mesh(&tilted, &settings), material, Vector3::zeros()).unwrap();
            let a: Vec<f64> = solid.mesh().nodes.iter().flat_map(|x| (g * x).data.0[0]).collect();
            let mut residual = vec![0.0; a.len()];
            solid.gradient(&a, &mut residual).unwrap();
            let stress = material.response(&g).unwrap().stress;
            let stress = Matrix3::from_column_slice(stress.as_slice());
            let mut largest = 0.0_f64;
            for (i, force) in solid.traction(|_, normal| stress * normal) {
                residual[i] -= force;
                largest = largest.max(force.abs());
            }
            // Where cut cubes end with the grid no traction is known.
            let inner = |x: &Vector3<f64>| x.amax() < CORNERS[1] - 2.0 * settings.side;
            let worst = solid
                .mesh()
                .nodes_where(inner)
                .into_iter()
                .flat_map(|n| [3 * n, 3 * n + 1, 3 * n + 2]);
            let worst = worst.map(|i| residual[i].abs()).fold(0.0, f64::max);
            println!("{law:?}: {worst:e} beside {largest}");
            // Rules are exact for these polynomials to some 1e-14; sums of a hundred terms.
            assert!(worst < 1e-11 * largest, "{worst:e} {largest}");
        }
    }
}

#[test]
fn volume_is_that_of_the_region_whatever_the_sizes() {
    let ball = Ball {
        centre: Vector3::new(0.3, -0.7, 1.1),
        radius: 8.0,
    };
    for settings in settings(4.0) {
        let mesh = mesh(&ball, &settings);
        let exact = 4.0 / 3.0 * std::f64::consts::PI * 512.0;
        let found = mesh.volume() + mesh.left_out();
        // That of the rules: 1e-3 at four fifths of the radius, order 7 down to half of it.
        assert!(
            (found / exact - 1.0).abs() < 1e-3 * (0.5_f64 / 0.8).powi(7),
            "{found} {exact}"
        );
    }
}

#[test]
fn bad_input_is_refused_by_name() {
    let ball = Ball {
        centre: Vector3::zeros(),
        radius: 8.0,
    };
    let with = |settings: Settings, low: f64| {
        let corners = [Vector3::repeat(low), Vector3::repeat(10.0)];
        Mesh::new(&ball, corners, &settings, &|_, _| true).map(|m| m.nodes.len())
    };
    let good = Settings::of_side(4.0);
    for side in [0.0, -1.0, f64::NAN, f64::INFINITY] {
        assert!(
            matches!(with(Settings { side, ..good }, -10.0), Err(NoMesh::Setting { .. })),
            "{side}"
        );
    }
    for settings in [
        Settings { levels: 7, ..good },
        Settings {
            least_fill: f64::NAN,
            ..good
        },
    ] {
        assert!(matches!(with(settings, -10.0), Err(NoMesh::Setting { .. })));
    }
    for low in [10.0, 11.0, f64::NAN, f64::NEG_INFINITY] {
        assert!(matches!(with(good, low), Err(NoMesh::Box { .. })), "{low}");
    }
    assert_eq!(with(good, 9.0), Err(NoMesh::Empty));
    for side in [1e-3, 1e-300] {
        assert!(
            matches!(with(Settings { side, ..good }, -10.0), Err(NoMesh::TooMany { .. })),
            "{side}"
        );
    }
    assert!(matches!(
        with(
            Settings {
                levels: 6,
                most_cubes: 1000,
                ..good
            },
            -10.0
        ),
        Err(NoMesh::TooMany { .. })
    ));
    // A ball in the corner of eight cubes that it hardly fills.
    assert!(matches!(
        with(Settings::of_side(100.0), -90.0),
        Err(NoMesh::Thin { .. })
    ));
}

#[test]
fn a_box_of_whole_cubes_has_no_cube_more() {
    let everywhere = Plane {
        point: Vector3::new(0.0, 0.0, 1e3),
        normal: Vector3::z(),
    };
    for (low, high, side, count) in [(-0.1, 0.2, 0.1, 27), (-10.0, 20.1, 4.3, 343), (0.0, 100.0, 25.0, 64)] {
        let corners = [Vector3::repeat(low), Vector3::repeat(high)];
        let mesh = Mesh::new(&everywhere, corners, &Settings::of_side(side), &|_, _| false).unwrap();
        assert_eq!(mesh.elements.len(), count, "{low} {high} {side}");
        let volume = (high - low).powi(3);
        assert!((mesh.volume() / volume - 1.0).abs() < 1e-12);
        // The last face belongs to the last cube.
        assert!(mesh.row(&corners[1]).is_some() && mesh.row(&corners[0]).is_some());
    }
}
