//! Organs that the tube moves, as they come over the bus or out of a recording: their shapes once, and where they are for the poses of the last while.
//!
//! An image shows organs moved only with a state of its very pose; else it shows the examination as it was taken, and says so.

mod answers;

use bus::message::{
    TargetShown, TissueError, TissueHeader, TissueMesh, TissueMeshError, TissueMeshHeader, TissueShown,
};
use bus::port::HeadedSubscriber;
use bus::topic::{TISSUE, TISSUE_MESH};
use bus::{Bus, BusError, clock};
use geometry::{Ct, Model, Point, Rigid, UncertainPoint};
use scene::TissueSpec;

use crate::warp::{Cube, NoShape, Organ, Region, Shape};
pub(crate) use answers::Answers;
use answers::KEPT;

/// What an image shows of the tissue.
#[derive(Debug, Clone, Copy, Default)]
pub struct Tissues<'a> {
    /// What is shown.
    pub shown: TissueShown,
    /// Where the organs are, where they are shown moved.
    pub moved: Option<Moved<'a>>,
    /// How old the pose of the last state is, ns; `None` where there was none, or that says nothing.
    pub late_ns: Option<i64>,
    /// The state's number; 0 without.
    pub seq: u64,
    /// What the tissue does to the tube, N, of a settled state, and 95 % of what is uncertain of that; `None`: nobody knows.
    pub force_n: Option<(f64, Option<f64>)>,
    /// What a settled state tells of the model's errors at places.
    pub errors: Option<&'a TissueHeader>,
    /// Pixels that two places claim: of an image that is drawn, by whoever draws it, whatever the state is called.
    pub covered_twice: usize,
}

/// How well a model knows where it has a place.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct PlaceKnown {
    /// Covariance by uncertain numbers of the model, mm^2 in the CT's axes.
    pub(crate) covariance_mm2: [[f64; 3]; 3],
    /// The true place, were the model true but for these, lies this near with 95 % at least, mm.
    pub(crate) radius_95_mm: f64,
    /// How much older than the image's pose it is, ns.
    pub(crate) age_ns: i64,
}

impl Tissues<'_> {
    /// Where an image has a place of the patient: where it is at rest, but for one in an organ that is shown moved.
    pub fn place(&self, at_rest: Point<Ct>) -> Point<Ct> {
        let moved = self.moved.and_then(|moved| moved.place(at_rest));
        moved.unwrap_or(at_rest)
    }

    /// Where an image has a target, and whose place that is.
    pub(crate) fn target(&self, planned: Point<Ct>) -> (Point<Ct>, TargetShown) {
        let moved = self.moved.and_then(|moved| moved.place(planned));
        let shown = match (self.shown, self.moved, moved) {
            (TissueShown::None, ..) => TargetShown::Planned,
            (TissueShown::Settled, Some(_), Some(_)) => TargetShown::Model,
            (TissueShown::Settled, Some(_), None) => TargetShown::Beside,
            (TissueShown::Approximate, Some(_), _) => TargetShown::NotSettled,
            _ => TargetShown::AtRest,
        };
        (moved.unwrap_or(planned), shown)
    }

    /// How well a settled model knows where it has a target; `None`: nobody knows.
    pub(crate) fn known(&self, planned: Point<Ct>) -> Option<PlaceKnown> {
        let errors = self.errors.filter(|_| self.shown == TissueShown::Settled)?;
        let (covariance_mm2, age_ns) = errors.error_of(planned.mm())?;
        let whole = UncertainPoint::from_rows(planned, covariance_mm2).ok()?;
        Some(PlaceKnown {
            covariance_mm2,
            radius_95_mm: whole.radius_95_mm(),
            age_ns,
        })
    }

    /// Organs that cannot be drawn where a state has them.
    pub(crate) fn refused() -> Self {
        Self {
            shown: TissueShown::Refused,
            ..Self::default()
        }
    }

    /// Organs as the examination has them, in a scene where they move.
    pub fn rigid() -> Self {
        Self {
            shown: TissueShown::Rigid,
            ..Self::default()
        }
    }
}

/// Organs where a state has them.
#[derive(Debug, Clone, Copy)]
pub struct Moved<'a> {
    /// The organs at rest.
    pub shapes: &'a Shapes,
    /// Places of all nodes, mm in the model's frame.
    pub places: &'a [[f32; 3]],
}

/// Organs at rest.
#[derive(Debug)]
pub struct Shapes {
    /// Identifies them.
    pub mesh_id: [u8; 32],
    /// From their frame to the patient.
    pub ct_from_model: Rigid<Ct, Model>,
    /// In the order of their nodes.
    pub organs: Vec<Shape>,
}

/// Why organs are not shown moved.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum NoTissue {
    /// The message.
    #[error(transparent)]
    Mesh(#[from] TissueMeshError),
    /// Its numbers.
    #[error("organ {organ} of the tissue: {why}")]
    Shape {
        /// From 0.
        organ: usize,
        /// Why.
        why: NoShape,
    },
    /// Organs of another examination.
    #[error("the mesh of the tissue is of another examination")]
    Examination,
    /// A state.
    #[error(transparent)]
    State(#[from] TissueError),
}

impl Shapes {
    /// The organs of a message, in the examination of this hash, cut in pieces of at most `piece_mm`.
    ///
    /// # Errors
    /// [`NoTissue`].
    pub fn read(
        (header, bytes): (&TissueMeshHeader, &[u8]),
        volume_hash: &[u8; 32],
        piece_mm: f64,
    ) -> Result<Self, NoTissue> {
        let mesh = TissueMesh::read(header, bytes)?;
        if mesh.volume_hash != *volume_hash {
            return Err(NoTissue::Examination);
        }
        let mut organs = Vec::with_capacity(mesh.organs.len());
        for (organ, one) in mesh.organs.into_iter().enumerate() {
            let cubes: Vec<Cube> = one
                .cubes
                .iter()
                .map(|cube| Cube {
                    low: cube.low,
                    side: cube.side,
                    nodes: cube.nodes,
                })
                .collect();
            let region = Region::new(one.region_origin, one.region_step_mm, one.region_dims, one.region);
            let shape = region.and_then(|region| Shape::new(&cubes, one.nodes as usize, region, piece_mm));
            organs.push(shape.map_err(|why| NoTissue::Shape { organ, why })?);
        }
        Ok(Self {
            mesh_id: header.mesh_id,
            ct_from_model: mesh.ct_from_model,
            organs,
        })
    }

    fn nodes(&self) -> usize {
        self.organs.iter().map(Shape::nodes).sum()
    }
}

impl Moved<'_> {
    /// Where the model has a place of the patient that lies in an organ at rest; `None` for one that lies in none, and for one that the regions of
    /// two organs have, as between organs that nearly touch: nobody knows which of them it goes with.
    pub fn place(&self, at_rest: Point<Ct>) -> Option<Point<Ct>> {
        let own = (self.shapes.ct_from_model.inverse() * at_rest).mm();
        let organs = self.organs();
        let mut owners = organs.iter().filter(|organ| organ.shape.region().at(own) < 0.0);
        let organ = owners.next().filter(|_| owners.next().is_none())?;
        let [x, y, z] = organ.shape.moved(organ.places, own)?;
        Some(self.shapes.ct_from_model * Point::new(x, y, z))
    }

    /// The organs with the places of their nodes.
    pub fn organs(&self) -> Vec<Organ<'_>> {
        let mut first = 0;
        let each = self.shapes.organs.iter().map(|shape| {
            let places = &self.places[first..first + shape.nodes()];
            first += shape.nodes();
            Organ { shape, places }
        });
        each.collect()
    }
}

/// States as they come, each of which wakes.
pub(crate) type States = HeadedSubscriber<TissueHeader, f32>;

/// The states of a run.
///
/// # Errors
/// [`BusError::Open`].
pub(crate) fn states(bus: &Bus) -> Result<States, BusError> {
    HeadedSubscriber::open_waking(bus, &TISSUE, KEPT)
}

/// What came over the bus.
#[derive(Debug)]
pub(crate) struct Tissue {
    meshes: HeadedSubscriber<TissueMeshHeader, u8>,
    pub(crate) answers: Answers,
    /// Without a state for so long after the capture of a pose it is shown rigid, ns.
    pub(crate) late_ns: i64,
    /// States have been late: poses do not wait for theirs.
    pub(crate) behind: bool,
    /// The pose that was drawn last without its state: number and capture.
    pub(crate) lacked: Option<(u64, i64)>,
    /// Refused so far, of which the first was told.
    pub(crate) refused: u64,
}

impl Tissue {
    pub(crate) fn open(bus: &Bus, spec: &TissueSpec) -> Result<Self, BusError> {
        Ok(Self {
            meshes: HeadedSubscriber::open(bus, &TISSUE_MESH, 1)?,
            answers: Answers::new(spec.piece_mm, spec.tolerance),
            late_ns: clock::ns(spec.late),
            behind: false,
            lacked: None,
            refused: 0,
        })
    }

    /// Takes what came; why the first of what was refused was so.
    pub(crate) fn listen(
        &mut self,
        states: &States,
        volume_hash: &[u8; 32],
        now_ns: i64,
    ) -> Result<Option<NoTissue>, BusError> {
        let mut why = self.take_meshes(volume_hash)?;
        // Whoever joins late may be given the newest state before its mesh: it waits where it is.
        while self.answers.has_shapes()
            && let Some(state) = states.next()?
        {
            if !self.answers.is_of(&state.header().mesh_id) {
                // Sent before the state, and maybe after the look above.
                why = why.or(self.take_meshes(volume_hash)?);
            }
            match self.answers.take_state(state.header(), state.values()) {
                Ok(()) => {
                    self.behind &= now_ns.saturating_sub(state.header().t_capture_ns) >= self.late_ns;
                }
                Err(error) => why = why.or(Some(error)),
            }
        }
        self.refused += u64::from(why.is_some());
        Ok(why.filter(|_| self.refused == 1))
    }

    fn take_meshes(&mut self, volume_hash: &[u8; 32]) -> Result<Option<NoTissue>, BusError> {
        let mut why = None;
        while let Some(mesh) = self.meshes.next()? {
            let taken = self.answers.take_mesh((mesh.header(), mesh.values()), volume_hash);
            why = why.or(taken.err());
        }
        Ok(why)
    }
}

#[cfg(test)]
pub(crate) mod stage;
#[cfg(test)]
mod tests;
