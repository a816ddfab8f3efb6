//! Where a tube has moved organs, for one pose, and what certifies it.

use iceoryx2::prelude::ZeroCopySend;

/// Travels in front of the places of all nodes: three `f32` a node, mm in the mesh's own frame (see
/// [`super::TissueMesh`]), organ by organ. None where there is no state for the pose.
///
/// On the wire: numbers only. Read it through [`TissueHeader::state_of`].
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/TissueHeader/3")]
pub struct TissueHeader {
    /// Counts the states of a run from 1.
    pub seq: u64,
    /// The pose that it answers: [`super::ToolPose::seq`].
    pub pose_seq: u64,
    /// When that pose was captured, ns on the run's clock.
    pub t_capture_ns: i64,
    /// When this was published, ns on the run's clock.
    pub t_publish_ns: i64,
    /// The registration that the pose rests on.
    pub registration_id: u64,
    /// The mesh that the nodes are of.
    pub mesh_id: [u8; 32],
    /// Which second derivatives served, counted from 1: with the poses it fixes the bits.
    pub factor: u64,
    /// Free forces over the forces of contact.
    pub residual: f64,
    /// What further steps would move, mm: an estimate of the algebraic part of the error alone, and no bound.
    pub unsettled_mm: f64,
    /// The way that is left to the pose, mm: above 0 while the model catches up.
    pub left_mm: f64,
    /// What the tissue does to the tube, N, in the CT's axes.
    pub force: [f64; 3],
    /// Its moment about the tip, N mm, in the CT's axes.
    pub moment: [f64; 3],
    /// The deepest point of a surface in the tube, mm.
    pub depth_mm: f64,
    /// The least determinant of the deformation gradient at the points of the elements.
    pub least_determinant: f64,
    /// Energy of the model, N mm.
    pub energy: f64,
    /// Steps made.
    pub steps: u32,
    /// Code of a [`TissueState`].
    pub state: u32,
    /// The pose of the state that [`Self::errors`] are of, and when that was captured: this one, or one some states ago.
    pub errors_pose_seq: u64,
    /// See [`Self::errors_pose_seq`].
    pub errors_t_capture_ns: i64,
    /// How many of [`Self::errors`] there are.
    pub errors_known: u64,
    /// What uncertain numbers of the model do to the places of targets; whatever is not among them is not known.
    pub errors: [PlaceError; MOST_ERRORS],
    /// Covariance of [`Self::force`] by these numbers, N^2 in the CT's axes: xx, xy, xz, yy, yz, zz. See [`Self::force_95_n`].
    pub force_covariance: [f64; 6],
    /// 1 where [`Self::force_covariance`] is known.
    pub force_error_known: u64,
    /// Why there is no state, as UTF-8 with zeros behind it: see [`Self::why`].
    pub why: [u64; WHY_WORDS],
}

const _: () = assert!(size_of::<TissueHeader>() == 1576 && align_of::<TissueHeader>() == 8);

/// Words of 8 bytes that say why a pose was refused.
pub(super) const WHY_WORDS: usize = 20;

/// So much of a text as there is room for, whole characters, with zeros behind it.
pub(super) fn packed(text: &str) -> [u64; WHY_WORDS] {
    let mut words = [0; WHY_WORDS];
    let room = bytemuck::cast_slice_mut::<u64, u8>(&mut words);
    let end = text.floor_char_boundary(room.len());
    room[..end].copy_from_slice(&text.as_bytes()[..end]);
    words
}

/// The text that was packed; empty of what is none.
pub(super) fn unpacked(words: &[u64; WHY_WORDS]) -> &str {
    let room = bytemuck::cast_slice::<u64, u8>(words);
    let end = room.iter().position(|byte| *byte == 0).unwrap_or(room.len());
    let text = std::str::from_utf8(&room[..end]).unwrap_or_default();
    if text.chars().any(char::is_control) { "" } else { text }
}

/// Places whose error a state tells, at most.
pub const MOST_ERRORS: usize = 16;

/// What uncertain numbers of a model do to a place of an organ, to first order.
///
/// On the wire: numbers only. Read it through [`TissueHeader::error_of`].
#[derive(Debug, Default, Clone, Copy, PartialEq, ZeroCopySend, bytemuck::Pod, bytemuck::Zeroable)]
#[repr(C)]
#[type_name("trocar/PlaceError/1")]
pub struct PlaceError {
    /// The place at rest, mm in the CT's frame: whose error it is.
    pub at_rest_mm: [f64; 3],
    /// Covariance of where the model has it, mm^2 in the CT's axes: xx, xy, xz, yy, yz, zz.
    pub covariance: [f64; 6],
}

impl PlaceError {
    /// The covariance as a matrix; `None` of what is none: a number that is none, or a variance below zero.
    pub fn matrix(&self) -> Option<[[f64; 3]; 3]> {
        covariance(&self.covariance)
    }
}

/// A model that is off by more than a metre, or a kilonewton, is none: mm^2, N^2.
const MOST_VARIANCE: f64 = 1e6;
/// So many deviations of a normal deviate to both sides hold 95 %.
const NORMAL_95: f64 = 1.959_963_984_540_054;

/// A covariance as a matrix; `None` of what is none: a number that is none, or a variance below zero.
fn covariance(values: &[f64; 6]) -> Option<[[f64; 3]; 3]> {
    let [xx, xy, xz, yy, yz, zz] = *values;
    // Off the diagonal no number is larger than the variances allow, but for rounding.
    let fits = |c: f64, a: f64, b: f64| c * c <= a * b * (1.0 + 1e-9) + f64::MIN_POSITIVE;
    let is_one = values.iter().all(|c| c.is_finite())
        && [xx, yy, zz].iter().all(|v| (0.0..=MOST_VARIANCE).contains(v))
        && fits(xy, xx, yy)
        && fits(xz, xx, zz)
        && fits(yz, yy, zz)
        // Each two may go together, and all three not.
        && xx * (yy * zz - yz * yz) - xy * (xy * zz - yz * xz) + xz * (xy * yz - yy * xz)
            >= -1e-9 * xx * yy * zz - f64::MIN_POSITIVE;
    is_one.then_some([[xx, xy, xz], [xy, yy, yz], [xz, yz, zz]])
}

/// How far a state came. Only of [`TissueState::Settled`] and [`TissueState::Approximate`] the tube is where the pose says.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum TissueState {
    /// Forces balance and no point is deeper than allowed.
    Settled,
    /// At the pose, but forces do not balance within the steps of a frame, or points are too deep.
    Approximate,
    /// On its way to the pose.
    CatchingUp,
    /// The model does not bear the pose; the process says why in its note.
    Refused,
    /// There is no pose.
    Lost,
}

/// What of the tissue an image shows.
#[derive(Debug, Clone, Copy, PartialEq, Eq, Default)]
pub enum TissueShown {
    /// The scene has none.
    #[default]
    None,
    /// Organs where a settled state has them.
    Settled,
    /// Organs where a state has them that is not settled: the image says so.
    Approximate,
    /// The CT as it was taken, as there is no state for the pose in time: the image says so.
    Late,
    /// The same, as the model is on its way to the pose: the image says so.
    CatchingUp,
    /// The same, as the model does not bear the pose: the image says so.
    Refused,
    /// The CT as it was taken, as a person, or the kind of view, wants it: the image says so.
    Rigid,
}

/// Where an image has the chosen target.
#[derive(Debug, Default, Clone, Copy, PartialEq, Eq)]
#[repr(u32)]
pub enum TargetShown {
    /// None is chosen.
    #[default]
    None,
    /// As planned: the scene moves no organs.
    Planned,
    /// Where a settled state has the organ that it lies in.
    Model,
    /// The same, of a state that is not settled; or as planned, in no organ of such a state.
    NotSettled,
    /// As planned, beside organs that a settled state has moved: it lies in none of them, and the model does not move it.
    Beside,
    /// As planned, while organs that move are shown at rest: it may be elsewhere.
    AtRest,
}

impl TargetShown {
    const ALL: [Self; 6] = [
        Self::None,
        Self::Planned,
        Self::Model,
        Self::NotSettled,
        Self::Beside,
        Self::AtRest,
    ];

    /// The code on the wire.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// What has this code.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.get(code as usize).copied()
    }

    /// Whether a model has it elsewhere than it was planned.
    pub fn is_moved(self) -> bool {
        matches!(self, Self::Model | Self::NotSettled)
    }

    /// What stands beside its name.
    pub const fn words(self) -> &'static str {
        match self {
            Self::None | Self::Planned => "",
            Self::Model => "MODEL",
            Self::NotSettled => "MODEL NOT SETTLED",
            Self::Beside => "NOT IN THE MODEL",
            Self::AtRest => "ORGANS AT REST",
        }
    }
}

/// Why a state is none.
#[derive(Debug, Clone, PartialEq, thiserror::Error)]
pub enum TissueError {
    /// A code that no version has.
    #[error("tissue {seq}: state {found}; known are 0 to 4")]
    State {
        /// The state's number.
        seq: u64,
        /// The code.
        found: u32,
    },
    /// Nodes of another mesh.
    #[error("tissue {seq}: of mesh {found}; that in use is {expected}")]
    Mesh {
        /// The state's number.
        seq: u64,
        /// Its mesh.
        found: String,
        /// The mesh that is known.
        expected: String,
    },
    /// Too few or too many places.
    #[error("tissue {seq}: {found} coordinates; the mesh has {expected}")]
    Nodes {
        /// The state's number.
        seq: u64,
        /// Coordinates found.
        found: usize,
        /// Three for each node.
        expected: usize,
    },
    /// A state whose certificate says something else.
    #[error("tissue {seq} is called {state}, and its certificate denies it: {what} is {found}; {allowed}")]
    Denied {
        /// The state's number.
        seq: u64,
        /// What it is called.
        state: &'static str,
        /// Which number of the certificate.
        what: &'static str,
        /// Its value.
        found: f64,
        /// What is allowed of such a state.
        allowed: String,
    },
    /// A coordinate that is no number, or farther than any patient.
    #[error("tissue {seq}: coordinate {at} is {found} mm; at most {most} mm are allowed")]
    Place {
        /// The state's number.
        seq: u64,
        /// Which, from 0.
        at: usize,
        /// Its value.
        found: f32,
        /// The most.
        most: f32,
    },
}

/// No point of a settled state is deeper in the tube, nor farther off it while it presses, mm.
pub const MOST_DEPTH_MM: f64 = 1e-3;

/// No node lies farther from the mesh's origin along an axis, mm.
const FARTHEST_MM: f32 = 1e4;

impl TissueState {
    const ALL: [Self; 5] = [
        Self::Settled,
        Self::Approximate,
        Self::CatchingUp,
        Self::Refused,
        Self::Lost,
    ];

    /// The code on the wire.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// A word for errors and reports.
    pub const fn word(self) -> &'static str {
        match self {
            Self::Settled => "settled",
            Self::Approximate => "approximate",
            Self::CatchingUp => "catching up",
            Self::Refused => "refused",
            Self::Lost => "lost",
        }
    }

    /// Whether the nodes are of the pose.
    pub const fn is_of_pose(self) -> bool {
        matches!(self, Self::Settled | Self::Approximate)
    }
}

impl TissueShown {
    /// All, in the order of their codes.
    pub const ALL: [Self; 7] = [
        Self::None,
        Self::Settled,
        Self::Approximate,
        Self::Late,
        Self::CatchingUp,
        Self::Refused,
        Self::Rigid,
    ];

    /// The code in a stamp.
    pub const fn code(self) -> u32 {
        self as u32
    }

    /// What has this code.
    pub fn from_code(code: u32) -> Option<Self> {
        Self::ALL.get(code as usize).copied()
    }

    /// A word for reports and PNGs.
    pub const fn word(self) -> &'static str {
        match self {
            Self::None => "none",
            Self::Settled => "settled",
            Self::Approximate => "approximate",
            Self::Late => "late",
            Self::CatchingUp => "catching up",
            Self::Refused => "refused",
            Self::Rigid => "rigid",
        }
    }
}

impl TissueHeader {
    /// The same with so much of these words as there is room for.
    #[must_use]
    pub fn because(mut self, why: &str) -> Self {
        self.why = packed(why);
        self
    }

    /// Why a pose was refused, in the model's words; empty where none was, or what is told is no text.
    pub fn why(&self) -> &str {
        unpacked(&self.why)
    }

    /// How far it came.
    ///
    /// # Errors
    /// [`TissueError::State`].
    pub fn state_of(&self) -> Result<TissueState, TissueError> {
        let (seq, found) = (self.seq, self.state);
        let state = TissueState::ALL.get(found as usize).copied();
        state.ok_or(TissueError::State { seq, found })
    }

    /// How far it came, where what certifies it does not deny that: a settled state is in balance to `tolerance`, the scene's `tissue.tolerance`, no point of it
    /// is deeper than [`MOST_DEPTH_MM`] and nothing is inside out; a state of the pose has no way left, and one that catches up has some.
    ///
    /// # Errors
    /// [`TissueError::State`], [`TissueError::Denied`]. What is no number denies what it certifies.
    pub fn certified(&self, tolerance: f64) -> Result<TissueState, TissueError> {
        let state = self.state_of()?;
        let denied = |what, found, is_allowed: bool, allowed: &dyn Fn() -> String| match is_allowed {
            true => Ok(()),
            false => Err(TissueError::Denied {
                seq: self.seq,
                state: state.word(),
                what,
                found,
                allowed: allowed(),
            }),
        };
        let Self {
            residual,
            unsettled_mm,
            depth_mm,
            least_determinant,
            left_mm,
            ..
        } = *self;
        if state == TissueState::Settled {
            let (rest, most) = (0.0..=tolerance, MOST_DEPTH_MM);
            denied("residual", residual, rest.contains(&residual), &|| {
                format!("0 to {tolerance} are allowed")
            })?;
            denied("depth_mm", depth_mm, depth_mm <= most, &|| {
                format!("at most {most} mm are allowed")
            })?;
            // Infinite where one step more could not be made.
            denied("unsettled_mm", unsettled_mm, unsettled_mm >= 0.0, &|| {
                "0 mm or more are allowed".to_owned()
            })?;
            denied("least_determinant", least_determinant, least_determinant > 0.0, &|| {
                "more than 0 is allowed, nothing may be inside out".to_owned()
            })?;
            let [x, y, z] = self.force;
            let force = x.hypot(y).hypot(z);
            denied("force", force, force.is_finite(), &|| "a force is a number".to_owned())?;
        }
        match state {
            TissueState::Settled | TissueState::Approximate => {
                denied("left_mm", left_mm, left_mm == 0.0, &|| {
                    "no way is left at the pose".to_owned()
                })?;
            }
            TissueState::CatchingUp => {
                denied("left_mm", left_mm, left_mm > 0.0, &|| {
                    "some way is left to the pose".to_owned()
                })?;
            }
            TissueState::Refused | TissueState::Lost => {}
        }
        Ok(state)
    }

    /// The covariance of where the model has a place at rest, mm^2 in the CT's axes, and how much older than the state's its pose is, ns; `None` where it
    /// is not known, or what is told is no covariance.
    pub fn error_of(&self, at_rest_mm: [f64; 3]) -> Option<([[f64; 3]; 3], i64)> {
        let known = usize::try_from(self.errors_known).ok()?;
        let errors = self.errors.get(..known)?;
        let age_ns = self
            .t_capture_ns
            .checked_sub(self.errors_t_capture_ns)
            .filter(|age| *age >= 0)?;
        let error = errors.iter().find(|error| error.at_rest_mm == at_rest_mm)?;
        Some((error.matrix()?, age_ns))
    }

    /// How much the tissue presses on the tube, N, and what uncertain numbers of the model leave of that, to first order: 95 % of a normal deviate, of the
    /// size alone where there is a force, of the worst direction where there is none. The second is `None` where it is not known, or what is told is no
    /// covariance, or of a pose to come.
    pub fn force_95_n(&self) -> (f64, Option<f64>) {
        let force = self.force;
        let size = force[0].hypot(force[1]).hypot(force[2]);
        let is_known = self.force_error_known == 1 && self.errors_t_capture_ns <= self.t_capture_ns;
        let matrix = is_known.then(|| covariance(&self.force_covariance)).flatten();
        let variance = matrix.map(|matrix| match size > 0.0 {
            true => {
                let along = matrix.map(|row| (0..3).map(|k| row[k] * force[k] / size).sum::<f64>());
                (0..3).map(|k| along[k] * force[k] / size).sum::<f64>().max(0.0)
            }
            // No direction is the force's own: no eigenvalue is larger than the trace.
            false => matrix[0][0] + matrix[1][1] + matrix[2][2],
        });
        (size, variance.map(|variance| NORMAL_95 * variance.sqrt()))
    }

    /// The places of the nodes of a mesh of this id with so many nodes: the door from the bus to a picture.
    ///
    /// # Errors
    /// [`TissueError`]: of another mesh, too few or too many, a coordinate that is no place in a patient.
    pub fn places<'a>(
        &self,
        values: &'a [f32],
        (id, nodes): (&[u8; 32], usize),
    ) -> Result<&'a [[f32; 3]], TissueError> {
        let seq = self.seq;
        if self.mesh_id != *id {
            let name = |id: &[u8; 32]| id[..4].iter().map(|b| format!("{b:02x}")).collect::<String>();
            return Err(TissueError::Mesh {
                seq,
                found: name(&self.mesh_id),
                expected: name(id),
            });
        }
        if values.len() != 3 * nodes {
            return Err(TissueError::Nodes {
                seq,
                found: values.len(),
                expected: 3 * nodes,
            });
        }
        if let Some(at) = values.iter().position(|x| x.is_nan() || x.abs() > FARTHEST_MM) {
            return Err(TissueError::Place {
                seq,
                at,
                found: values[at],
                most: FARTHEST_MM,
            });
        }
        Ok(bytemuck::cast_slice(values))
    }
}

#[cfg(test)]
mod tests;
