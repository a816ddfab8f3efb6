//! A kidney that the tube pushes back onto the muscles: by the voxels of the label map, which no contact asks, it stays out of them.

use std::path::Path;
use std::time::Duration;

use geometry::{Ct, Direction, Point, Rigid, Tool, checked};
use nalgebra::Vector3;
use organs::Labels;
use scene::Scene;
use simulation::space::frames::State;

use super::anatomy;
use crate::anatomy::Anatomy;
use crate::live::Answer;

/// The muscles of the back.
const MUSCLES: [u16; 2] = [86, 88];
/// From the front, straight back.
const ENTRY: [f64; 3] = [58.0, -60.0, 110.0];
const TARGET: [f64; 3] = [58.0, 60.0, 110.0];

/// The shipped kidney with a tube from the front, and a soft bath alone that holds it; with contact or without.
fn scene(folder: &Path, contact: bool) -> Scene {
    let shipped = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/solids/demo-kidney.toml");
    let text = std::fs::read_to_string(shipped).unwrap();
    let held = text.find("[[attachments]]").unwrap()..text.find("[surroundings]").unwrap();
    let table = "[[contacts]]\norgan = \"left kidney\"\nwith = [\"psoas and back muscles\"]\nball = 4.0\n\n";
    let text = format!(
        "{}{}{}",
        &text[..held.start],
        if contact { table } else { "" },
        &text[held.end..]
    );
    let text = text.replace("entry = [115.1, 86.3, 115.4]", &format!("entry = {ENTRY:?}"));
    let text = text.replace("target = [28.5, 2.6, 50.0]", &format!("target = {TARGET:?}"));
    let text = text.replace("stroke = 80.0", "stroke = 16.0");
    assert!(text.contains("stroke = 16.0") && text.contains(&format!("{ENTRY:?}")));
    std::fs::write(folder.join("organs.toml"), text).unwrap();
    let text = "[volume]\nsource = \"phantom\"\nspacing_mm = 3.0\n[tissue]\norgans = \"organs.toml\"";
    Scene::parse(text, &folder.join("s.toml")).unwrap()
}

fn labels(scene: &Scene) -> Labels {
    let map = volume_loader::load_labels_seeded(Path::new("phantom"), &scene.volume, scene.seed).unwrap();
    let (volume, view) = (&map.volume, map.volume.view());
    Labels::new(&volume.grid, volume.hash.to_string(), |z, out| view.slice(z, out)).unwrap()
}

/// The tool with its tip so far from the entry.
fn gone(way: f64) -> Rigid<Ct, Tool> {
    let tip = Point::new(ENTRY[0], ENTRY[1] + way, ENTRY[2]);
    Rigid::from_axes(tip, checked::direction([0.0, 1.0, 0.0]).unwrap(), Direction::X).unwrap()
}

/// How deep a place lies in voxels of muscle: its distance from the nearest voxel of anything else, mm.
fn depth(labels: &Labels, at: &Vector3<f64>) -> f64 {
    if !MUSCLES.contains(&labels.at(at)) {
        return 0.0;
    }
    let mut least = f64::INFINITY;
    let (low, high) = (at.add_scalar(-15.0), at.add_scalar(15.0));
    labels.each([&low, &high], &mut |middle, label| {
        if !MUSCLES.contains(&label) {
            let beside = (at - middle).abs() - 0.5 * labels.spacing;
            least = least.min(beside.map(|b| b.max(0.0)).norm());
        }
    });
    least
}

/// The deepest point of the organ's surface in voxels of muscle, mm.
fn deepest(anatomy: &Anatomy, labels: &Labels) -> f64 {
    let (frames, mut most) = (&anatomy.live.frames, 0.0_f64);
    let bodies = &frames.system().bodies;
    let part = bodies.part(0, frames.state());
    for point in 0..bodies.solid(0).points() {
        most = most.max(depth(labels, &bodies.solid(0).point(part, point)));
    }
    most
}

/// The time that this thread has been at work.
fn worked() -> Duration {
    let time = rustix::time::clock_gettime(rustix::time::ClockId::ThreadCPUTime);
    Duration::new(time.tv_sec as u64, time.tv_nsec as u32)
}

#[test]
fn a_kidney_that_is_pushed_onto_muscles_frame_by_frame_stays_out_of_their_voxels() {
    let folder = tempfile::tempdir().unwrap();
    let [mut kept, mut free] = [true, false].map(|contact| anatomy(&scene(folder.path(), contact)).unwrap());
    assert!(
        kept.said.contains("kept out of psoas and back muscles"),
        "{}",
        kept.said
    );
    println!("{}", kept.said);
    let labels = labels(&scene(folder.path(), true));
    let at_rest = deepest(&kept, &labels);
    let (mut spent, mut deep, mut pressed) = ([Duration::ZERO; 2], [0.0_f64; 2], 0.0_f64);
    let (mut states, mut touched) = (0, None);
    for k in 0..=140 {
        let way = 30.0 + 0.5 * f64::from(k);
        let mut force = 0.0_f64;
        for (n, anatomy) in [&mut kept, &mut free].into_iter().enumerate() {
            let began = worked();
            let answer = anatomy.live.answer(gone(way));
            let Answer::State(frame) = answer else {
                panic!("{way} mm, {n}: {answer:?}")
            };
            force = force.max(frame.force.force.norm());
            if force > 0.0 {
                spent[n] += worked() - began;
            }
            assert!(
                matches!(frame.state, State::Settled | State::Approximate),
                "{way}: {frame:?}"
            );
            deep[n] = deep[n].max(deepest(anatomy, &labels));
        }
        states += usize::from(force > 0.0);
        pressed = pressed.max(kept.live.frames.bone_force(0).unwrap().force.norm());
        touched = touched.or((force > 0.0).then_some(way));
        if touched.is_some_and(|first| way >= first + 12.0) {
            break;
        }
    }
    println!(
        "{states} frames; in voxels of muscle at rest {at_rest:.2} mm, at most {:.2} with contact, {:.2} without; on muscles {pressed:.3} N; time with contact {:.2} of that without",
        deep[0],
        deep[1],
        spent[0].as_secs_f64() / spent[1].as_secs_f64()
    );
    assert!(pressed > 0.05 && free.live.frames.bone_force(0).is_none());
    // What smoothing moves of the surface beside its voxels is a voxel at most, here as at rest.
    let voxel = labels.spacing.max();
    assert!(deep[0] < at_rest + voxel && deep[1] > deep[0] + voxel, "{deep:?}");
}
