//! Meshes and states as messages.

use bus::message::{MeshCube, MeshOrgan, TissueHeader, TissueMesh, TissueState, ToolPose};
use geometry::{Ct, Model, Rigid};
use organs::Body;
use simulation::space::cells::{Field, Lattice};
use simulation::space::frames::State;

use crate::live::{Answer, Live};

/// Values of an organ's region lie at most so far apart, mm.
const REGION_STEP: f64 = 2.0;
/// The region's values are told one cube and so many steps beyond the organ.
const BEYOND: f64 = 2.0;

/// The mesh of one organ as images want it.
pub(crate) fn mesh(
    body: &Body,
    lattice: &Lattice,
    (ct_from_model, volume_hash): (Rigid<Ct, Model>, [u8; 32]),
) -> TissueMesh {
    let cubes = lattice.cubes.iter().map(|cube| MeshCube {
        low: cube.low.into(),
        side: cube.side,
        nodes: cube.nodes,
    });
    let [low, high] = body.field.corners;
    let (low, high) = (
        low.add_scalar(-BEYOND * REGION_STEP),
        high.add_scalar(BEYOND * REGION_STEP),
    );
    let dims = [0, 1, 2].map(|a| ((high[a] - low[a]) / REGION_STEP).ceil().max(1.0) as u32 + 1);
    let mut region = Vec::with_capacity(dims.iter().map(|n| *n as usize).product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let step = nalgebra::Vector3::new(f64::from(x), f64::from(y), f64::from(z)) * REGION_STEP;
                region.push(body.field.value(&(low + step)) as f32);
            }
        }
    }
    TissueMesh {
        ct_from_model,
        volume_hash,
        organs: vec![MeshOrgan {
            name: body.name.clone(),
            nodes: lattice.places.len() as u32,
            cubes: cubes.collect(),
            region_origin: low.into(),
            region_step_mm: REGION_STEP,
            region_dims: dims,
            region,
        }],
    }
}

/// What goes before the nodes of a state: of a sample, with a running number and the mesh's id. Without an answer the sample has no pose.
pub(crate) fn header(
    sample: &ToolPose,
    (seq, mesh_id): (u64, [u8; 32]),
    answer: Option<&Answer>,
    live: &Live,
) -> TissueHeader {
    let mut header = TissueHeader {
        seq,
        pose_seq: sample.seq,
        t_capture_ns: sample.t_capture_ns,
        registration_id: sample.registration_id,
        mesh_id,
        state: TissueState::Lost.code(),
        ..TissueHeader::default()
    };
    let frame = match answer {
        None => return header,
        Some(Answer::Refused(_) | Answer::Unseen { .. }) => {
            header.state = TissueState::Refused.code();
            return header.because(&answer.and_then(Answer::why).unwrap_or_default());
        }
        Some(Answer::State(frame)) => frame,
    };
    let (state, left_mm) = match frame.state {
        State::Settled => (TissueState::Settled, 0.0),
        State::Approximate => (TissueState::Approximate, 0.0),
        State::CatchingUp { left } => (TissueState::CatchingUp, left),
        State::Refused(_) => (TissueState::Refused, 0.0),
    };
    TissueHeader {
        factor: frame.factor,
        residual: frame.residual,
        unsettled_mm: frame.unsettled,
        left_mm,
        force: live.turned(&frame.force.force),
        moment: live.moment_about_tip(frame),
        depth_mm: frame.depth,
        least_determinant: frame.least_determinant,
        energy: frame.energy,
        steps: frame.steps as u32,
        state: state.code(),
        ..header
    }
}
