//! Several organs: the shipped kidney, vessel and lymph node, and a tube that comes from a side where it pushes the node to the vessel.

use bus::message::{TissueState, ToolPose};
use simulation::space::frames::State;

use super::*;
use crate::message::{header, owner, places};

/// A place in the kidney's lower pole, and one in fat.
const IN_THE_KIDNEY: [f64; 3] = [62.0, 40.0, 95.0];
const IN_FAT: [f64; 3] = [65.2, 38.0, 60.0];

/// The tool with its tip so far from the node's middle, on the patient's left of it, pushed to the right. By half a millimetre to the
/// back: a round tip that meets a node in the middle lets it slip off to any side.
pub(super) fn at_the_node(from: f64) -> Rigid<Ct, Tool> {
    let tip = Point::new(NODE[0] + from, NODE[1] + 0.5, NODE[2]);
    Rigid::from_axes(tip, checked::direction([-1.0, 0.0, 0.0]).unwrap(), Direction::Y).unwrap()
}

/// Where the nodes of each organ are, by the messages.
fn organ_by_organ(anatomy: &Anatomy) -> Vec<Vec<f32>> {
    let mut all = Vec::new();
    places(&anatomy.lattices, &anatomy.live, &mut all);
    let organs = anatomy
        .mesh
        .organs
        .iter()
        .map(|organ| all.drain(..3 * organ.nodes as usize).collect());
    let organs = organs.collect();
    assert!(all.is_empty());
    organs
}

/// How far a node of an organ is moved at most.
fn farthest(now: &[f32], before: &[f32]) -> f32 {
    now.iter().zip(before).map(|(a, b)| (a - b).abs()).fold(0.0, f32::max)
}

#[test]
fn organs_that_the_tube_pushes_into_one_another_are_refused_by_name_and_one_that_it_does_not_touch_stays_at_rest() {
    let text = "seed = 1\n[volume]\nsource = \"phantom\"\nspacing_mm = 1.5\n[tissue]\norgans = \"demo-organs.toml\"\n";
    let beside = Path::new(env!("CARGO_MANIFEST_DIR")).join("../config/solids/scene.toml");
    let mut anatomy = anatomy(&Scene::parse(text, &beside).unwrap()).unwrap();
    let unknowns = anatomy.live.frames.state().len();
    assert!(
        unknowns <= 3600 && anatomy.said.contains(&format!("3 organs of {unknowns} unknowns")),
        "{}",
        anatomy.said
    );
    // Whose place it is goes by the region of the message, as in images.
    let whose = |at: [f64; 3]| owner(&anatomy.mesh, anatomy.live.own(Point::new(at[0], at[1], at[2])));
    assert_eq!(
        [whose(IN_THE_KIDNEY), whose(NODE), whose(IN_FAT)],
        [Some(0), Some(2), None]
    );
    assert_eq!(whose([12.0, 4.0, 60.0]), Some(1));

    let at_rest = organ_by_organ(&anatomy);
    assert_eq!(state(anatomy.live.answer(at_the_node(8.0))), (State::Settled, 0.0));
    assert_eq!(organ_by_organ(&anatomy), at_rest);
    // Some 4 mm of fat are between node and aorta: so far the node is pushed, and no farther.
    let (mut pushed, mut met) = (0.0, None);
    for k in 0..20 {
        let from = 3.0 - 0.5 * f64::from(k);
        let before = anatomy.live.frames.state().to_vec();
        match anatomy.live.answer(at_the_node(from)) {
            Answer::State(frame) => {
                assert!(
                    matches!(frame.state, State::Settled | State::Approximate),
                    "{from}: {frame:?}"
                );
                let now = organ_by_organ(&anatomy);
                assert!(now[0] == at_rest[0] && now[1] == at_rest[1], "{from}");
                pushed = farthest(&now[2], &at_rest[2]);
            }
            other => {
                assert_eq!(anatomy.live.frames.state(), before, "{from}");
                met = Some((from, other));
                break;
            }
        }
    }
    let (from, met) = met.unwrap();
    let why = met.why().unwrap();
    println!("pushed by {pushed} mm; {from} mm: {why}");
    let said = "organs aorta and para-aortic node lie 0.";
    assert!(
        why.starts_with(said) && why.ends_with("mm in one another, which the model does not bear"),
        "{why}"
    );
    assert!((2.5..9.0).contains(&pushed), "{pushed}");
    let told = header(&ToolPose::EMPTY, (1, [0; 32]), Some(&met), &anatomy.live);
    assert_eq!((told.state_of(), told.why()), (Ok(TissueState::Refused), &*why));
    // Deeper it is refused again; drawn back, it goes on from where nothing was in anything.
    assert!(matches!(anatomy.live.answer(at_the_node(from - 0.5)), Answer::Met(_)));
    assert!(matches!(anatomy.live.answer(at_the_node(from + 1.0)), Answer::State(_)));
    // The way back is as long as several frames may walk; then it is free, and at rest.
    for _ in 0..3 {
        assert!(matches!(anatomy.live.answer(at_the_node(8.0)), Answer::State(_)));
    }
    assert_eq!(state(anatomy.live.answer(at_the_node(8.0))), (State::Settled, 0.0));
    assert_eq!(organ_by_organ(&anatomy), at_rest);
}
