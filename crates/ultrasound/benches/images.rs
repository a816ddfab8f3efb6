//! What an image costs, by its size, beams and depth: `cargo bench -p ultrasound`.
//!
//! The body is a formula of about 50 ns, as a CT between its voxels costs; what a dearer one adds is its price times the
//! number of times it is asked, which is printed beside.

#![allow(clippy::disallowed_methods, reason = "measures wall time")]
#![allow(clippy::print_stdout, reason = "prints its result")]
#![allow(clippy::unwrap_used, reason = "a step that fails here is a benchmark that fails")]

use std::time::Instant;

use ultrasound::{Beams, Pose, Scanner, Scene, Settings, Shape};

/// The best of so many is told: others share the machine.
const TURNS: u64 = 15;

/// A bone of 16 mm under fat and muscle, whose middle is at x = 0, y = 35.
fn thigh([x, y, z]: [f64; 3]) -> f64 {
    let fascia = 8.0 + (x / 9.0 + z / 20.0).sin();
    let soft = if y < fascia { -100.0 } else { 52.0 };
    let bone = (0.5 - (x.hypot(y - 35.0) - 16.0) / 1.6).clamp(0.0, 1.0);
    if y < 0.0 { -1000.0 } else { soft + (700.0 - soft) * bone }
}

fn linear(size: [usize; 2], depth: f64) -> Shape {
    let pixel = [40.0 / (size[0] - 1) as f64, depth / (size[1] - 1) as f64];
    let beams = Beams::Linear {
        from_mm: 0.0,
        to_mm: 40.0,
        face_mm: 0.0,
    };
    Shape::new(size, pixel, beams, depth).unwrap()
}

fn convex(size: [usize; 2]) -> Shape {
    let pixel = 140.0 / size[0] as f64;
    let beams = Beams::Convex {
        centre_mm: [70.0, -40.0],
        radius_mm: 50.0,
        half_angle: 0.55,
    };
    Shape::new(size, [pixel; 2], beams, 120.0).unwrap()
}

fn main() {
    let load = std::fs::read_to_string("/proc/loadavg").unwrap_or_default();
    println!("load {}", load.trim());
    let (shallow, deep) = (Settings::shallow(), Settings::deep());
    let cases = [
        (
            "linear 400 x 400, 40 mm, 128 beams",
            linear([400, 400], 40.0),
            Settings { beams: 128, ..shallow },
        ),
        ("linear 400 x 400, 40 mm, 192 beams", linear([400, 400], 40.0), shallow),
        ("linear 400 x 400, 60 mm, 192 beams", linear([400, 400], 60.0), shallow),
        ("linear 820 x 616, 50 mm, 192 beams", linear([820, 616], 50.0), shallow),
        (
            "convex 400 x 400, 120 mm, 128 beams",
            convex([400, 400]),
            Settings { beams: 128, ..deep },
        ),
        ("convex 1024 x 1024, 120 mm, 192 beams", convex([1024, 1024]), deep),
    ];
    for (name, shape, settings) in cases {
        let mut scanner = Scanner::new(&shape, &settings).unwrap();
        let middle = shape.place_mm([(shape.columns() - 1) as f64 / 2.0, 0.0])[0];
        let mut least = f64::INFINITY;
        for number in 0..TURNS {
            // Each a little aside, as a hand moves.
            let origin = [-middle, -0.3, 0.1 * number as f64];
            let pose = Pose::new(origin, [1.0, 0.0, 0.0], [0.0, 1.0, 0.0]).unwrap();
            let began = Instant::now();
            std::hint::black_box(scanner.scan(&Scene::of(&thigh), &pose, number).unwrap());
            least = least.min(began.elapsed().as_secs_f64() * 1e3);
        }
        let (asked, cell) = (scanner.asked(), scanner.scatterers_per_cell());
        println!("{name:<38} {least:6.1} ms; HU asked for {asked:>5} times; {cell:.1} scatterers a cell");
    }
}
