//! The images of the default scene, as one pose asks for them.

use std::path::Path;

use bus::volume::OwnedVolume;
use geometry::{Ct, Direction, Point, Rigid, Tool};
use phantom::Phantom;
use scene::{Scene, View};
use slice_view_proc::plane;
use slice_view_proc::reslice::{Cpu, Resampler};

use crate::shared::ct;
use crate::shared::figures::{Times, cpu_ms, load};

const POSES: usize = 40;
/// What the seven images may take together, ms.
const TARGET_MS: f64 = 8.0;

/// The generated patient as demonstrations load it, and the CT.
pub(crate) fn tables(ct: &OwnedVolume) {
    let phantom = Phantom::new(phantom::DEFAULT_SEED);
    let grid = phantom.grid(phantom::DEFAULT_SPACING_MM).expect("the default");
    let patient = ct::volume(grid, |z, slice| phantom.fill_slice(&grid, z, slice));
    let poses = approach(&phantom);
    let views = Scene::parse("", Path::new("")).expect("the default scene").views;
    for (name, volume) in [("generated patient at 1.5 mm", &patient), ("CT", ct)] {
        table(name, volume, &views, &poses);
    }
}

/// From the skin to the node and past it, with the tube swaying.
fn approach(phantom: &Phantom) -> Vec<Rigid<Ct, Tool>> {
    let approach = phantom.approach();
    let target = phantom.targets().iter().find(|t| t.name == approach.target);
    let target = target.expect("the approach leads to a target").centre;
    let pose = |i: usize| {
        let part = i as f64 / (POSES - 1) as f64;
        let tip = approach.entry.lerp(target, part);
        let [x, y, z] = ((target - approach.entry) * (1.0 / target.distance(approach.entry))).mm();
        let sway = 0.1 * (8.0 * part).sin();
        tube(tip, [x + sway, y - sway, z + sway])
    };
    (0..POSES).map(pose).collect()
}

fn tube(tip: Point<Ct>, [x, y, z]: [f64; 3]) -> Rigid<Ct, Tool> {
    let along = geometry::Vector::new(x, y, z).direction().expect("not zero");
    Rigid::from_axes(tip, along, Direction::Y).expect("not along y")
}

fn table(name: &str, volume: &OwnedVolume, views: &[View], poses: &[Rigid<Ct, Tool>]) {
    let mut resamplers = [Cpu::default(), Cpu::portable()];
    let samplings: Vec<_> = views.iter().map(|view| view.sampling).collect();
    for resampler in &mut resamplers {
        let prepared = resampler.prepare(&volume.view(), &samplings, &mut || {});
        prepared.expect("enough memory");
    }
    let mut totals = [Times::default(), Times::default()];
    let mut each = vec![Times::default(); views.len()];
    for pose in poses {
        for (i, resampler) in resamplers.iter_mut().enumerate() {
            let times: Vec<f64> = views.iter().map(|view| draw(resampler, volume, view, pose)).collect();
            totals[i].push(times.iter().sum());
            if i == 0 {
                each.iter_mut().zip(times).for_each(|(all, ms)| all.push(ms));
            }
        }
    }
    println!("\n{} images of the default scene, {name}; {}", views.len(), load());
    for (view, times) in views.iter().zip(&each) {
        let [width, height] = view.size;
        println!("{:<28}{width} x {height}{:>9.2} ms", view.name, times.median());
    }
    let met = if totals[0].median() <= TARGET_MS {
        "met"
    } else {
        "NOT met"
    };
    println!(
        "all: vector {:.2} ({:.2}) ms, portable {:.2} ({:.2}) ms, median (least) of {POSES} poses; at most {TARGET_MS} ms: {met}",
        totals[0].median(),
        totals[0].least(),
        totals[1].median(),
        totals[1].least()
    );
}

fn draw(resampler: &mut Cpu, volume: &OwnedVolume, view: &View, pose: &Rigid<Ct, Tool>) -> f64 {
    let plane = plane(view, &volume.grid, pose).expect("a usual plane");
    let mut hu = vec![0.0; (view.size[0] * view.size[1]) as usize];
    // The pages of the image are brought in before, as a renderer keeps its image.
    hu.fill(1.0);
    cpu_ms(|| {
        let drawn = resampler.reslice(&volume.view(), &plane, &view.sampling, &mut hu);
        drawn.expect("prepared");
    })
}
