//! Wires and walls in water.

use ultrasound::{Level, Met, Scanner, Scene, Settings, Wall, Wire, truth, water};

use super::{PIXEL, brightest, linear, straight};

const LEVEL: Level = Level {
    bone_hu: 300.0,
    speed_ratio: 1.0,
    gel_mm: 2.5,
};

/// The weighted mean place of what is above half of the range, in a box about a place, mm.
fn centroid(grey: &[u8], columns: usize, about: [f64; 2], half: f64) -> [f64; 2] {
    let (mut sum, mut mass) = ([0.0; 2], 0.0);
    for (at, &grey) in grey.iter().enumerate() {
        let place = [at % columns, at / columns].map(|part| part as f64 * PIXEL);
        let inside = (0..2).all(|i| (place[i] - about[i]).abs() < half);
        let weight = f64::from(grey.saturating_sub(128));
        if inside && weight > 0.0 {
            mass += weight;
            (0..2).for_each(|i| sum[i] += weight * place[i]);
        }
    }
    sum.map(|part| part / mass)
}

#[test]
fn a_wire_is_a_dot_where_it_crosses_the_plane() {
    let shape = linear();
    // Square to the image, and aslant as the middle wires of an N are (0.46 rad), three depths.
    let wires: Vec<Wire> = [
        (8.0, 12.0, 0.0),
        (20.0, 20.3, 0.5),
        (31.0, 30.0, -0.5),
        (14.0, 40.0, 0.0),
    ]
    .into_iter()
    .map(|(x, y, lean)| Wire {
        ends: [[x - 20.0 * lean, y, -20.0], [x + 20.0 * lean, y, 20.0]],
    })
    .collect();
    let scene = Scene {
        body: &water,
        wires: &wires,
        walls: &[],
    };
    let mut scanner = Scanner::new(&shape, &Settings::shallow()).unwrap();
    let grey = scanner.scan(&scene, &straight(), 1).unwrap();
    let truth = truth(&scene, &straight(), &shape, &LEVEL, 2).unwrap();
    assert_eq!(truth.wires.len(), 4);
    for (wire, crossing) in wires.iter().zip(&truth.wires) {
        let closed = [(wire.ends[0][0] + wire.ends[1][0]) / 2.0, wire.ends[0][1]];
        assert!((0..2).all(|i| (crossing.pixel[i] * PIXEL - closed[i]).abs() < 1e-9));
        let found = centroid(&grey, shape.columns(), closed, 3.0);
        // A pixel: the dot is symmetric, its samples are not quite.
        assert!(
            (0..2).all(|i| (found[i] - closed[i]).abs() < PIXEL),
            "{found:?} for {closed:?}"
        );
    }
    let nothing = (150..170).flat_map(|row| (300..390).map(move |column| row * 401 + column));
    assert!(nothing.into_iter().all(|at| grey[at] < 40), "water is black");
}

#[test]
fn a_tank_s_bottom_is_a_line_and_hides_what_is_below() {
    let shape = linear();
    // y = 30 + 0.1 (x - 20) in the image's plane, aslant across it too.
    let walls = [Wall {
        point: [20.0, 30.0, 0.0],
        normal: [-0.1, 1.0, 0.2],
    }];
    let wires = [Wire {
        ends: [[20.0, 40.0, -20.0], [20.0, 40.0, 20.0]],
    }];
    let scene = Scene {
        body: &water,
        wires: &wires,
        walls: &walls,
    };
    let settings = Settings::shallow();
    let mut scanner = Scanner::new(&shape, &settings).unwrap();
    let grey = scanner.scan(&scene, &straight(), 1).unwrap();
    let truth = truth(&scene, &straight(), &shape, &LEVEL, 41).unwrap();
    assert!(truth.wires.is_empty(), "behind the wall");
    for (beam, met) in truth.beams.iter().enumerate() {
        let x = beam as f64;
        let closed = 30.0 + 0.1 * (x - 20.0);
        let Met::Bone(crossing) = met else { panic!("{met:?}") };
        assert!((crossing.depth_mm - closed).abs() < 1e-9);
        if (2..=38).contains(&beam) {
            let (row, _) = brightest(&shape, &grey, beam * 10, 50);
            let bound = settings.pulse_mm / 2.0 + PIXEL;
            assert!((row as f64 * PIXEL - closed).abs() < bound, "{row} for {closed}");
        }
    }
}
