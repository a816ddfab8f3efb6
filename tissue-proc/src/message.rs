//! Meshes and states as messages.

use bus::message::{MeshCube, MeshOrgan, TissueHeader, TissueMesh, TissueState, ToolPose};
use geometry::{Ct, Model, Rigid};
use organs::Body;
use simulation::space::cells::{Field, Lattice};
use simulation::space::frames::State;

use crate::live::{Answer, Live};

/// Values of an organ's region lie at most so far apart, mm; of a small organ this part of the cube root of its volume, so that what is trilinear between
/// them still has its shape.
const REGION_STEP: f64 = 2.0;
const REGION_PART: f64 = 0.2;
/// The region's values are told one cube and so many steps beyond the organ.
const BEYOND: f64 = 2.0;

/// The meshes of organs as images want them, in their order.
pub(crate) fn mesh(
    bodies: &[Body],
    lattices: &[Lattice],
    (ct_from_model, volume_hash): (Rigid<Ct, Model>, [u8; 32]),
) -> TissueMesh {
    TissueMesh {
        ct_from_model,
        volume_hash,
        organs: bodies.iter().zip(lattices).map(organ).collect(),
    }
}

/// The organ that images take a place of the model's frame along with: the only one whose region has it. Where two organs' regions have it, as
/// between organs that nearly touch, they take it along with none.
pub(crate) fn owner(mesh: &TissueMesh, own: [f64; 3]) -> Option<usize> {
    let mut all = (0..mesh.organs.len()).filter(|organ| has(&mesh.organs[*organ], own));
    all.next().filter(|_| all.next().is_none())
}

/// Whether a region is negative at a place, trilinear between its values.
fn has(organ: &MeshOrgan, own: [f64; 3]) -> bool {
    let index: [f64; 3] = std::array::from_fn(|a| (own[a] - organ.region_origin[a]) / organ.region_step_mm);
    let last = organ.region_dims.map(|n| f64::from(n) - 1.0);
    if !(0..3).all(|a| (0.0..=last[a]).contains(&index[a])) {
        return false;
    }
    let [nx, ny, _] = organ.region_dims.map(|n| n as usize);
    let low: [f64; 3] = std::array::from_fn(|a| index[a].floor().min(last[a] - 1.0));
    let corner = |k: usize| {
        let up = [0, 1, 2].map(|a| k >> a & 1);
        let each = (0..3).map(|a| {
            if up[a] == 1 {
                index[a] - low[a]
            } else {
                1.0 - index[a] + low[a]
            }
        });
        let [x, y, z]: [usize; 3] = std::array::from_fn(|a| low[a] as usize + up[a]);
        each.product::<f64>() * f64::from(organ.region[(z * ny + y) * nx + x])
    };
    (0..8).map(corner).sum::<f64>() < 0.0
}

fn organ((body, lattice): (&Body, &Lattice)) -> MeshOrgan {
    let cubes = lattice.cubes.iter().map(|cube| MeshCube {
        low: cube.low.into(),
        side: cube.side,
        nodes: cube.nodes,
    });
    let [low, high] = body.field.corners;
    let step_mm = REGION_STEP.min(REGION_PART * body.facts.volume.cbrt());
    let (low, high) = (low.add_scalar(-BEYOND * step_mm), high.add_scalar(BEYOND * step_mm));
    let dims = [0, 1, 2].map(|a| ((high[a] - low[a]) / step_mm).ceil().max(1.0) as u32 + 1);
    let mut region = Vec::with_capacity(dims.iter().map(|n| *n as usize).product());
    for z in 0..dims[2] {
        for y in 0..dims[1] {
            for x in 0..dims[0] {
                let step = nalgebra::Vector3::new(f64::from(x), f64::from(y), f64::from(z)) * step_mm;
                region.push(body.field.value(&(low + step)) as f32);
            }
        }
    }
    MeshOrgan {
        name: body.name.clone(),
        nodes: lattice.places.len() as u32,
        cubes: cubes.collect(),
        region_origin: low.into(),
        region_step_mm: step_mm,
        region_dims: dims,
        region,
    }
}

/// Where all nodes of a state are, organ by organ as in the mesh's message, behind what `into` has.
pub(crate) fn places(lattices: &[Lattice], live: &Live, into: &mut Vec<f32>) {
    let (bodies, a) = (live.frames.bodies(), live.frames.state());
    for (organ, lattice) in lattices.iter().enumerate() {
        lattice.displaced(bodies.part(organ, a), into);
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
        Some(Answer::Refused(_) | Answer::Met(_) | Answer::Unseen { .. }) => {
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
