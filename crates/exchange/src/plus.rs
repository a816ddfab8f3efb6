//! Device sets of the PLUS toolkit, `.xml`: the transforms of their `CoordinateDefinitions`, which hold its calibrations.
//!
//! `From="StylusTip" To="Stylus"` takes points of StylusTip to Stylus: `stylus_from_stylus_tip`. Matrices are by rows, mm, in the frames
//! of the tools themselves: no patient's axes are in such a file. `Error` has no unit and no definition; PLUS's own pivoting writes the
//! mean residual there, which is no error of the tip.

mod error;
mod read;
mod scan;
mod wires;
mod write;

pub use error::PlusError;
pub use read::read;
pub use scan::{ScanArray, ScanConversion, scan_conversion};
pub use wires::{MAX_WIRES, PhantomWire, wires};
pub use write::write;

use geometry::{Affine, Frame, Point, Rigid, Vector};

use geometry::rotation::RotationMatrix;

/// The longest file, bytes.
pub const MAX_BYTES: usize = 16 << 20;
/// Most transforms of a file.
pub const MAX_TRANSFORMS: usize = 1024;
/// The largest Frobenius distance of a matrix from the nearest rotation, as for ITK's.
pub const MOST_OFF: f64 = crate::itk::MOST_OFF;

/// How far both ways between two frames may miss one another beside what their rotations being put right explains, mm: PLUS writes six digits.
const MOST_APART_MM: f64 = 1e-2;

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
    /// Whether the file has its inverse alone, and it was turned round.
    pub is_inverse: bool,
    /// What the file holds and that was taken for.
    file: Affine<To, From>,
    /// The Frobenius distance of the file's matrix from the rotation that was taken for it.
    pub off: f64,
    /// What the file calls its error.
    pub error: Option<f64>,
    /// When it was made, as the file has it.
    pub date: Option<String>,
}

impl<To: Frame, From: Frame> Found<To, From> {
    /// How far the image of a point lies from where the file has it, in the file's unit.
    pub fn moved(&self, point: Point<From>) -> f64 {
        (self.file * point).distance(self.to_from_from * point)
    }
}

impl DeviceSet {
    /// The transform between two frames by their names, which the caller says are `To` and `From`. Where the file has the way back
    /// alone, that is turned round, and where it has both, they must agree; chains are not composed.
    ///
    /// # Errors
    /// [`PlusError::Missing`], [`PlusError::Same`], [`PlusError::Twice`], [`PlusError::Contradicts`], [`PlusError::Hand`],
    /// [`PlusError::NotRigid`].
    pub fn find<To: Frame, From: Frame>(&self, from: &str, to: &str) -> Result<Found<To, From>, PlusError> {
        if from == to {
            return Err(PlusError::Same {
                name: crate::quoted(from),
            });
        }
        let (there, back) = (self.only(from, to)?, self.only(to, from)?);
        if let Some(one) = there {
            let (to_from_from, off) = one.rigid()?;
            if let Some(back) = back {
                agree(one, &to_from_from, back)?;
            }
            return Ok(one.found(to_from_from, one.affine(), off, false));
        }
        if let Some(one) = back {
            let (back, off) = one.rigid::<From, To>()?;
            // A matrix that is nearly a rotation has an inverse.
            let file = one
                .affine::<From, To>()
                .inverse()
                .unwrap_or_else(|| affine_of(&back.inverse()));
            return Ok(one.found(back.inverse(), file, off, true));
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

/// Refuses two ways between two frames that are not those there and back.
fn agree<To: Frame, From: Frame>(
    one: &Definition,
    there: &Rigid<To, From>,
    back: &Definition,
) -> Result<(), PlusError> {
    let (from_from_to, _) = back.rigid::<From, To>()?;
    let loop_of = *there * from_from_to;
    let mm = loop_of.translation().norm();
    let angle = loop_of.rotation().distance(geometry::rotation::Rotation::IDENTITY);
    // Each rotation may have been put right by MOST_OFF, which moves what is as far away as the one frame is from the other.
    let arm = there.translation().norm();
    match angle <= 2.0 * MOST_OFF && mm <= MOST_APART_MM + 2.0 * MOST_OFF * arm {
        true => Ok(()),
        false => Err(PlusError::Contradicts {
            name: one.name(),
            back: back.name(),
            mm,
            degrees: angle.to_degrees(),
        }),
    }
}

/// The same as numbers.
fn affine_of<To, From>(rigid: &Rigid<To, From>) -> Affine<To, From> {
    let ([a, b, c], [x, y, z]) = (rigid.rotation().matrix().rows(), rigid.translation_mm());
    let row = |[i, j, k]: [f64; 3], t| [i, j, k, t];
    Affine::from_rows([row(a, x), row(b, y), row(c, z)])
}

impl Definition {
    /// Of a rigid transform.
    pub fn new<To, From>(from: &str, to: &str, to_from_from: &Rigid<To, From>) -> Self {
        let [a, b, c] = affine_of(to_from_from).rows();
        Self {
            from: from.to_owned(),
            to: to.to_owned(),
            rows: [a, b, c, [0.0, 0.0, 0.0, 1.0]],
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
        file: Affine<To, From>,
        off: f64,
        is_inverse: bool,
    ) -> Found<To, From> {
        Found {
            to_from_from,
            is_inverse,
            file,
            off,
            error: self.error,
            date: self.date.clone(),
        }
    }

    /// As it stands.
    fn affine<To, From>(&self) -> Affine<To, From> {
        let [a, b, c, _] = self.rows;
        Affine::from_rows([a, b, c])
    }

    /// The rigid transform, and how far its matrix is from a rotation.
    fn rigid<To, From>(&self) -> Result<(Rigid<To, From>, f64), PlusError> {
        let [a, b, c, _] = self.rows;
        let turn = [a, b, c].map(|[x, y, z, _]| [x, y, z]);
        let name = || self.name();
        let nearest = RotationMatrix::nearest(turn).map_err(|why| PlusError::Hand { name: name(), why })?;
        if nearest.distance > MOST_OFF {
            let affine = self.affine::<To, From>();
            return Err(PlusError::NotRigid {
                name: name(),
                off: nearest.distance,
                columns: [0, 1, 2].map(|axis| affine.step(axis).norm()),
            });
        }
        let translation = Vector::new(a[3], b[3], c[3]);
        Ok((
            Rigid::from_parts(nearest.matrix.rotation(), translation),
            nearest.distance,
        ))
    }
}
