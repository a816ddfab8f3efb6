//! What the lines over an image cost: `cargo test --release -p slice-view-proc cost -- --ignored --nocapture`.

use geometry::{Affine, Direction, Point, Tool, VolumeGrid};
use scene::Scene;

use super::*;
use crate::view;

const ROUNDS: usize = 200;

/// The time that this thread works on it, microseconds.
fn micros(draw: impl FnOnce()) -> f64 {
    let now = || {
        let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
        time.tv_sec as f64 * 1e6 + time.tv_nsec as f64 / 1e3
    };
    let began = now();
    draw();
    now() - began
}

fn median(mut times: Vec<f64>) -> f64 {
    times.sort_by(f64::total_cmp);
    times[times.len() / 2]
}

/// The whole overlay beside what it was while the tube was its axis alone, in the same run.
/// Draws a part of an image.
type Part<'a> = &'a dyn Fn(&mut Canvas);

#[test]
#[ignore = "measures"]
#[allow(clippy::print_stdout, reason = "the figures are what this is for")]
fn the_cost_of_an_overlay() {
    let scene = Scene::parse("", std::path::Path::new("")).unwrap();
    let affine = Affine::from_rows([[1.0, 0.0, 0.0, -60.0], [0.0, 1.0, 0.0, -60.0], [0.0, 0.0, 1.0, -60.0]]);
    let grid = VolumeGrid::checked([120; 3], affine).unwrap();
    let along = geometry::Vector::new(0.8, 0.5, 0.3).direction().unwrap();
    let pose = Rigid::from_axes(Point::new(3.0, -7.0, 11.0), along, Direction::Z).unwrap();
    let chosen = Chosen {
        name: "node".to_owned(),
        centre: Point::new(30.0, 10.0, 20.0),
        radius_mm: 2.5,
        entry: Some(Point::new(-50.0, -40.0, -10.0)),
        stop_mm: 5.0,
    };
    for (view, name) in [(1, "axial local"), (0, "axial global"), (6, "perpendicular")] {
        let view = &scene.views[view];
        let plane = view::plane(view, &grid, &pose).unwrap();
        let overlay = Overlay {
            view,
            plane: &plane,
            is_placed: true,
            views: &scene.views,
            pose: Some(pose),
            tool: &scene.tool,
            targets: &scene.targets,
            chosen: Some(&chosen),
            accuracy: None,
            outside: false,
            remarks: &[],
            notice: Notice::Live,
            origin: Origin::Tracker,
            seq: 7,
            registration_id: 1,
            volume: "01234567",
            marks: Marks::default(),
            caution: "",
            tissue: crate::tissue::Tissues::default(),
        };
        let mut canvas = Canvas::new(512, 512);
        let [handle, tip] = [-scene.tool.length_mm, 0.0].map(|z| plane.project(pose * Point::<Tool>::new(0.0, 0.0, z)));
        let line = overlay.line(palette::TUBE, 2.0, false);
        let mut times = [Vec::new(), Vec::new(), Vec::new()];
        for _ in 0..ROUNDS {
            times[0].push(micros(|| overlay.draw(&mut canvas)));
            times[1].push(micros(|| {
                overlay.draw_cuts(&mut canvas);
                overlay.draw_planned(&mut canvas);
                overlay.draw_tube(&mut canvas, pose, 9.0);
                overlay.draw_ruler(&mut canvas);
            }));
            times[2].push(micros(|| canvas.line([handle.x, handle.y], [tip.x, tip.y], line)));
        }
        let [all, lines, axis] = times.map(median);
        let before = all - lines + axis;
        println!(
            "{name}: {all:.0} us, before {before:.0} us, {:.2} times; the new lines {lines:.0} us",
            all / before
        );
        let parts: [(&str, Part<'_>); 4] = [
            ("cuts", &|canvas| overlay.draw_cuts(canvas)),
            ("plan", &|canvas| overlay.draw_planned(canvas)),
            ("tube and path", &|canvas| overlay.draw_tube(canvas, pose, 9.0)),
            ("ruler", &|canvas| overlay.draw_ruler(canvas)),
        ];
        for (what, draw) in parts {
            let times = (0..ROUNDS).map(|_| micros(|| draw(&mut canvas))).collect();
            println!("    {what}: {:.0} us", median(times));
        }
    }
}
