//! Whole answers: the generated patient's kidney, and what is refused before any pose.

mod pushed;
mod several;

use std::path::Path;

use geometry::{Ct, Direction, Point, Rigid, Tool, checked};
use scene::Scene;
use simulation::space::frames::State;

use crate::anatomy::{Anatomy, NoAnatomy, make};
use crate::live::{Answer, Live};

const ENTRY: [f64; 3] = [115.1, 86.3, 115.4];
const NODE: [f64; 3] = [28.5, 2.6, 50.0];

fn scene(more: &str) -> Scene {
    let text =
        format!("[volume]\nsource = \"phantom\"\nspacing_mm = 3.0\n[tissue]\norgans = \"demo-kidney.toml\"\n{more}");
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/solids/scene.toml");
    Scene::parse(&text, &beside).unwrap()
}

fn anatomy(scene: &Scene) -> Result<Anatomy, NoAnatomy> {
    let volume = volume_loader::load_seeded(&scene.volume, scene.seed).unwrap();
    let spec = scene.tissue.as_ref().unwrap();
    make(
        (scene, spec),
        (&volume.grid, volume.hash.0),
        volume_loader::load_labels_seeded,
    )
}

/// The tool with its tip on the way from the entry to the node, `left` mm before that, and moved aside.
fn on_the_way(left: f64, aside: [f64; 3]) -> Rigid<Ct, Tool> {
    let way: [f64; 3] = std::array::from_fn(|a| NODE[a] - ENTRY[a]);
    let length = way.iter().map(|x| x * x).sum::<f64>().sqrt();
    let tip: [f64; 3] = std::array::from_fn(|a| NODE[a] - way[a] / length * left + aside[a]);
    Rigid::from_axes(
        Point::new(tip[0], tip[1], tip[2]),
        checked::direction(way).unwrap(),
        Direction::X,
    )
    .unwrap()
}

fn state(answer: Answer) -> (State, f64) {
    match answer {
        Answer::State(frame) => (frame.state, frame.force.force.norm()),
        other => panic!("{other:?}"),
    }
}

#[test]
fn an_organ_follows_the_tube_and_only_where_somebody_saw_how_it_came_there() {
    let mut anatomy = anatomy(&scene("")).unwrap();
    the_tube_lies_where_the_tool_does(&anatomy);
    let live = &mut anatomy.live;
    let begun = live.frames.state().to_vec();
    assert!(!live.is_of_another(7));
    // Anywhere in the fat, from one sample to the next: the organ is at rest, to the bit.
    for left in [130.0, 90.0, 120.0, 82.0] {
        assert_eq!(state(live.answer(on_the_way(left, [0.0; 3]))), (State::Settled, 0.0));
        assert_eq!(live.frames.state(), begun);
    }
    // In it at once, 100 mm off: not by a way that somebody saw. It stays so until the tube is drawn back.
    let far = on_the_way(10.0, [0.0; 3]);
    for _ in 0..2 {
        let Answer::Unseen { way } = live.answer(far) else {
            panic!("a state")
        };
        assert!((way - 72.0).abs() < 0.1, "{way}");
    }
    // Nearer to where the model has it than any walk is long, and in tissue still: nobody saw it go in.
    assert!(matches!(live.answer(on_the_way(70.0, [0.0; 3])), Answer::Unseen { way } if way < 13.0));
    assert_eq!(state(live.answer(on_the_way(82.0, [0.0; 3]))), (State::Settled, 0.0));
    // Pushed, in steps of 0.5 mm.
    let mut last = 0.0;
    for k in 0..=24 {
        let (found, force) = state(live.answer(on_the_way(82.0 - 0.5 * f64::from(k), [0.0; 3])));
        assert!(matches!(found, State::Settled | State::Approximate), "{k}: {found:?}");
        last = force;
    }
    // Some tenths of a newton, by a law and by springs that are assumed: the order of it alone is looked at.
    assert!((0.1..1.0).contains(&last), "{last} N");
    assert!(live.frames.state() != begun.as_slice());
    // Moved on by less than a walk while it presses: no rest, though a tube there would be free of the organ at rest.
    let aside = on_the_way(70.0, [0.0, 0.0, -14.0]);
    assert!(live.frames.is_clear(&live.pose(aside)));
    match live.answer(aside) {
        Answer::State(frame) => assert!(frame.factor > 1),
        Answer::Refused(_) => {}
        Answer::Met(met) => panic!("{met}"),
        Answer::Unseen { way } => panic!("{way}"),
    }
    another_registration_is_no_way_of_the_tube(live);
    // And away from all: at rest again.
    assert_eq!(state(live.answer(on_the_way(130.0, [0.0; 3]))), (State::Settled, 0.0));
    assert_eq!(live.frames.state(), begun);
}

/// A registration that put the tip elsewhere in tissue was taken for the tube's way there, and its states were called settled.
fn another_registration_is_no_way_of_the_tube(live: &mut Live) {
    assert!(!live.is_of_another(7) && live.is_of_another(8));
    for left in [70.0, 62.0] {
        match live.answer(on_the_way(left, [0.0; 3])) {
            Answer::Unseen { way } => assert!(way < 30.0, "{way}"),
            other => panic!("{other:?}"),
        }
        assert!(!live.is_of_another(8));
    }
    // Drawn back, it has a way again.
    assert_eq!(state(live.answer(on_the_way(82.0, [0.0; 3]))), (State::Settled, 0.0));
    assert!(matches!(live.answer(on_the_way(81.5, [0.0; 3])), Answer::State(_)));
}

/// The pose of the simulation's tube, made of the tool's, has its foremost point and its direction; so do force and moment of a frame.
fn the_tube_lies_where_the_tool_does(anatomy: &Anatomy) {
    let tool = on_the_way(100.0, [0.0; 3]);
    let pose = anatomy.live.pose(tool);
    let model = anatomy.mesh.ct_from_model;
    let z = pose.rotation * nalgebra::Vector3::z();
    let foremost = pose.translation.vector + 6.0 * z;
    let found = (model * Point::<geometry::Model>::new(foremost.x, foremost.y, foremost.z)).mm();
    let tip = (tool * Point::<Tool>::new(0.0, 0.0, 0.0)).mm();
    assert!((0..3).all(|a| (found[a] - tip[a]).abs() < 1e-9), "{found:?} {tip:?}");
    let along = (tool * Direction::<Tool>::Z).components();
    let turned = anatomy.live.turned(&z);
    assert!((0..3).all(|a| (turned[a] - along[a]).abs() < 1e-12));
}

#[test]
fn what_is_not_the_runs_is_refused_by_name() {
    let why = |scene: &Scene| anatomy(scene).err().unwrap().to_string();
    let tool = why(&scene("[tool]\ndiameter_mm = 10.0"));
    assert!(tool.contains("found 12 mm; the run's tool has 10 mm"), "{tool}");
    let folder = tempfile::tempdir().unwrap();
    let organs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/solids/demo-kidney.toml");
    let text = std::fs::read_to_string(organs).unwrap();
    let write = |text: String| {
        std::fs::write(folder.path().join("organs.toml"), text).unwrap();
        let text = "[volume]\nsource = \"phantom\"\nspacing_mm = 3.0\n[tissue]\norgans = \"organs.toml\"";
        Scene::parse(text, &folder.path().join("s.toml")).unwrap()
    };
    let missing = why(&write(text.replace("labels = \"phantom\"", "labels = \"no.nii.gz\"")));
    assert!(missing.contains("no.nii.gz"), "{missing}");
    // A file by the name of the generated patient that is not there is not that patient.
    let missing = why(&write(text.replace("labels = \"phantom\"", "labels = \"ct/phantom\"")));
    assert!(missing.contains("ct/phantom"), "{missing}");
    // Nor are its labels anybody else's.
    let mut other = write(text);
    other.volume = scene::VolumeSpec::of_path(folder.path().join("ct.nii.gz"));
    let spec = other.tissue.as_ref().unwrap();
    let volume = volume_loader::load_seeded(&scene("").volume, 1).unwrap();
    let grid = (&volume.grid, volume.hash.0);
    let said = make((&other, spec), grid, volume_loader::load_labels_seeded);
    let said = said.err().unwrap().to_string();
    assert!(
        said.contains("that of the generated patient") && said.contains("ct.nii.gz"),
        "{said}"
    );
    // Labels of the same patient on another grid.
    let scene = scene("");
    let finer = Scene::parse("[volume]\nsource = \"phantom\"\nspacing_mm = 4.0", Path::new("s.toml")).unwrap();
    let volume = volume_loader::load_seeded(&finer.volume, 1).unwrap();
    let spec = scene.tissue.as_ref().unwrap();
    let grid = (&volume.grid, volume.hash.0);
    let other = make((&scene, spec), grid, volume_loader::load_labels_seeded)
        .err()
        .unwrap();
    assert!(matches!(other, NoAnatomy::OtherGrid { .. }), "{other}");
}
