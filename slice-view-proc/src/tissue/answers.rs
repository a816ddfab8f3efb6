//! States by the poses that they answer.

use std::collections::VecDeque;

use bus::message::{TissueError, TissueHeader, TissueMeshHeader, TissueShown, TissueState, ToolPose};

use super::{Moved, NoTissue, Shapes, Tissues};

/// States that are kept: an image may be asked for of a pose that is not the newest.
pub(super) const KEPT: usize = 32;

/// A state of the organs.
#[derive(Debug)]
struct Kept {
    header: TissueHeader,
    state: TissueState,
    places: Vec<[f32; 3]>,
}

/// Organs at rest, and where they are for the poses of the last while.
#[derive(Debug)]
pub(crate) struct Answers {
    piece_mm: f64,
    /// To which settled states are in balance.
    tolerance: f64,
    shapes: Option<Shapes>,
    kept: VecDeque<Kept>,
}

impl Answers {
    /// None yet; shapes will be cut in pieces of at most `piece_mm`, and states are in balance to `tolerance` where they are settled.
    pub(crate) fn new(piece_mm: f64, tolerance: f64) -> Self {
        Self {
            piece_mm,
            tolerance,
            shapes: None,
            kept: VecDeque::with_capacity(KEPT),
        }
    }

    pub(super) fn has_shapes(&self) -> bool {
        self.shapes.is_some()
    }

    /// Whether the organs known are those of this id.
    pub(super) fn is_of(&self, mesh_id: &[u8; 32]) -> bool {
        self.shapes.as_ref().is_some_and(|shapes| shapes.mesh_id == *mesh_id)
    }

    /// Takes organs at rest, in the examination of this hash. Whoever was started again may have others: states of the old ones go with them.
    ///
    /// # Errors
    /// [`NoTissue`].
    pub(crate) fn take_mesh(
        &mut self,
        mesh: (&TissueMeshHeader, &[u8]),
        volume_hash: &[u8; 32],
    ) -> Result<(), NoTissue> {
        if !self.is_of(&mesh.0.mesh_id) {
            let shapes = Shapes::read(mesh, volume_hash, self.piece_mm)?;
            self.kept.clear();
            self.shapes = Some(shapes);
        }
        Ok(())
    }

    /// Takes a state of the organs known. One whose certificate denies what it is called is kept as refused, so that images of its pose say so.
    ///
    /// # Errors
    /// [`NoTissue`]; without organs it is of another mesh.
    pub(crate) fn take_state(&mut self, header: &TissueHeader, values: &[f32]) -> Result<(), NoTissue> {
        let known = self.shapes.as_ref();
        let (id, nodes) = known.map_or(([0; 32], 0), |shapes| (shapes.mesh_id, shapes.nodes()));
        let mut kept = kept((header, values), (&id, nodes))?;
        let denied = header.certified(self.tolerance).err();
        if let Some(why) = &denied {
            kept = Kept {
                header: header.because(&why.to_string()),
                state: TissueState::Refused,
                places: Vec::new(),
            };
        }
        self.kept.truncate(KEPT - 1);
        self.kept.push_front(kept);
        denied.map_or(Ok(()), |why| Err(why.into()))
    }

    /// Whether a pose is answered.
    pub(crate) fn has(&self, pose: &ToolPose) -> bool {
        self.of(pose).is_some()
    }

    /// A number alone may come again: a source that counts anew has the moment to tell them by.
    fn of(&self, pose: &ToolPose) -> Option<&Kept> {
        let of = |header: &TissueHeader| (header.pose_seq, header.registration_id, header.t_capture_ns);
        let pose = (pose.seq, pose.registration_id, pose.t_capture_ns);
        let is_of = |kept: &&Kept| of(&kept.header) == pose;
        self.kept.iter().find(is_of)
    }

    /// What an image of a pose shows; `now_ns` where it claims the present.
    pub(crate) fn shown(&self, pose: &ToolPose, now_ns: Option<i64>) -> Tissues<'_> {
        let (Some(kept), Some(shapes)) = (self.of(pose), &self.shapes) else {
            let last_ns = self.kept.front().map(|kept| kept.header.t_capture_ns);
            return Tissues {
                shown: TissueShown::Late,
                late_ns: now_ns.zip(last_ns).map(|(now, last)| now.saturating_sub(last)),
                ..Tissues::default()
            };
        };
        let shown = match kept.state {
            TissueState::Settled => TissueShown::Settled,
            TissueState::Approximate => TissueShown::Approximate,
            TissueState::CatchingUp => TissueShown::CatchingUp,
            TissueState::Refused => TissueShown::Refused,
            TissueState::Lost => TissueShown::Rigid,
        };
        let places = kept.places.as_slice();
        Tissues {
            shown,
            moved: kept.state.is_of_pose().then_some(Moved { shapes, places }),
            late_ns: None,
            seq: kept.header.seq,
            force_n: (kept.state == TissueState::Settled).then(|| kept.header.force_95_n()),
            errors: Some(&kept.header),
            ..Tissues::default()
        }
    }

    /// The first bytes of the mesh's id, for stamps; 0 without a mesh.
    pub(crate) fn mesh(&self) -> u64 {
        let id = self.shapes.as_ref().map_or([0; 32], |shapes| shapes.mesh_id);
        u64::from_be_bytes(std::array::from_fn(|k| id[k]))
    }
}

fn kept((header, values): (&TissueHeader, &[f32]), (id, nodes): (&[u8; 32], usize)) -> Result<Kept, TissueError> {
    let state = header.state_of()?;
    // Without a state for the pose there are no places, but it must be of the mesh all the same.
    let nodes = if state.is_of_pose() || !values.is_empty() {
        nodes
    } else {
        0
    };
    Ok(Kept {
        header: *header,
        state,
        places: header.places(values, (id, nodes))?.to_vec(),
    })
}
