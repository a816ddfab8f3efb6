//! Device sets of the PLUS toolkit, `.xml`: the transforms of their `CoordinateDefinitions`, which hold its calibrations.
//!
//! `From="StylusTip" To="Stylus"` takes points of StylusTip to Stylus: `stylus_from_stylus_tip`. Matrices are by rows, mm, in the frames
//! of the tools themselves: no patient's axes are in such a file. `Error` has no unit and no definition; PLUS's own pivoting writes the
//! mean residual there, which is no error of the tip.

mod error;
mod read;
mod write;

pub use error::PlusError;
pub use read::read;
pub use write::write;

use geometry::{Frame, Rigid, Vector};

use geometry::rotation::RotationMatrix;

/// The longest file, bytes.
pub const MAX_BYTES: usize = 16 << 20;
/// Most transforms of a file.
pub const MAX_TRANSFORMS: usize = 1024;
/// The largest Frobenius distance of a matrix from the nearest rotation, as for ITK's.
pub const MOST_OFF: f64 = crate::itk::MOST_OFF;

/// A transform of a device set.
#[derive(Debug, Clone, PartialEq)]
pub struct Definition {
    /// The frame of the points that it takes.
    pub from: String,
    /// The frame that it takes them to.
    pub to: String,
    /// By rows, mm.
    pub rows: [[f64; 4]; 4],
    /// What the file calls its error.
    pub error: Option<f64>,
    /// When it was made, as the file has it.
    pub date: Option<String>,
}

/// The content of a file.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct DeviceSet {
    /// In their order.
    pub definitions: Vec<Definition>,
}

/// A rigid transform of a device set.
#[derive(Debug, Clone, PartialEq)]
pub struct Found<To: Frame, From: Frame> {
    /// The transform that was asked for.
    pub to_from_from: Rigid<To, From>,
    /// Whether the file has its inverse, and it was turned round.
    pub is_inverse: bool,
    /// The Frobenius distance of the file's matrix from the rotation that was taken for it.
    pub off: f64,
    /// What the file calls its error.
    pub error: Option<f64>,
    /// When it was made, as the file has it.
    pub date: Option<String>,
}

impl DeviceSet {
    /// The transform between two frames by their names, which the caller says are `To` and `From`. Where the file has the way back
    /// alone, that is turned round; chains are not composed.
    ///
    /// # Errors
    /// [`PlusError::Missing`], [`PlusError::Twice`], [`PlusError::Hand`], [`PlusError::NotRigid`].
    pub fn find<To: Frame, From: Frame>(&self, from: &str, to: &str) -> Result<Found<To, From>, PlusError> {
        if let Some(one) = self.only(from, to)? {
            let (to_from_from, off) = one.rigid()?;
            return Ok(one.found(to_from_from, off, false));
        }
        if let Some(one) = self.only(to, from)? {
            let (back, off) = one.rigid::<From, To>()?;
            return Ok(one.found(back.inverse(), off, true));
        }
        let names = self.definitions.iter().take(32).map(Definition::name).collect();
        let (from, to) = (crate::quoted(from), crate::quoted(to));
        Err(PlusError::Missing { from, to, names })
    }

    fn only(&self, from: &str, to: &str) -> Result<Option<&Definition>, PlusError> {
        let mut those = self.definitions.iter().filter(|one| one.from == from && one.to == to);
        let first = those.next();
        match those.next() {
            None => Ok(first),
            Some(again) => Err(PlusError::Twice { name: again.name() }),
        }
    }
}

impl Definition {
    /// Of a rigid transform.
    pub fn new<To, From>(from: &str, to: &str, to_from_from: &Rigid<To, From>) -> Self {
        let turn = to_from_from.rotation().matrix().rows();
        let [x, y, z] = to_from_from.translation_mm();
        let [a, b, c] = turn;
        let row = |[i, j, k]: [f64; 3], t| [i, j, k, t];
        Self {
            from: from.to_owned(),
            to: to.to_owned(),
            rows: [row(a, x), row(b, y), row(c, z), [0.0, 0.0, 0.0, 1.0]],
            error: None,
            date: None,
        }
    }

    /// The name as PLUS has it in sequences, `StylusTipToStylus`.
    pub fn name(&self) -> String {
        crate::quoted(&format!("{}To{}", self.from, self.to))
    }

    fn found<To: Frame, From: Frame>(
        &self,
        to_from_from: Rigid<To, From>,
        off: f64,
        is_inverse: bool,
    ) -> Found<To, From> {
        Found {
            to_from_from,
            is_inverse,
            off,
            error: self.error,
            date: self.date.clone(),
        }
    }

    /// The rigid transform, and how far its matrix is from a rotation.
    fn rigid<To, From>(&self) -> Result<(Rigid<To, From>, f64), PlusError> {
        let [a, b, c, _] = self.rows;
        let turn = [a, b, c].map(|[x, y, z, _]| [x, y, z]);
        let name = || self.name();
        let nearest = RotationMatrix::nearest(turn).map_err(|why| PlusError::Hand { name: name(), why })?;
        if nearest.distance > MOST_OFF {
            let column = |j: usize| turn.iter().map(|row| row[j] * row[j]).sum::<f64>().sqrt();
            return Err(PlusError::NotRigid {
                name: name(),
                off: nearest.distance,
                columns: [0, 1, 2].map(column),
            });
        }
        let translation = Vector::new(a[3], b[3], c[3]);
        Ok((
            Rigid::from_parts(nearest.matrix.rotation(), translation),
            nearest.distance,
        ))
    }
}
