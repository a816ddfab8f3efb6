//! One transform of a file, from its numbers to a rigid one.

use std::f64::consts::TAU;

use geometry::rotation::{Rotation, RotationMatrix};
use geometry::{Affine, Named, Rigid, Vector};

use super::{ItkError, MOST_OFF};

/// No number of a rigid transform is larger: mm, and entries of a matrix.
const MOST: f64 = 1e9;

/// Whether it is a number, and none too large.
pub(super) fn is_allowed(number: f64) -> bool {
    number.abs() <= MOST
}

/// A transform as files have it.
#[derive(Debug, Default, Clone, PartialEq)]
pub(super) struct Part {
    /// Its kind with precision and dimensions, `AffineTransform_double_3_3`.
    pub(super) kind: String,
    pub(super) parameters: Vec<f64>,
    /// The centre, and of Euler angles their order.
    pub(super) fixed: Vec<f64>,
}

/// What is taken of a transform.
pub(super) struct Taken {
    /// The rigid one.
    pub(super) rigid: Rigid<Named, Named>,
    /// What it was taken for, as the file has it.
    pub(super) file: Affine<Named, Named>,
    /// How far the file's matrix is from the rotation.
    pub(super) off: f64,
}

/// A matrix, a translation and the centre, as they stand.
struct Numbers {
    rows: [[f64; 3]; 3],
    translation: [f64; 3],
    centre: [f64; 3],
}

impl Part {
    /// The kind without precision and dimensions; `None` where it is not of three dimensions.
    fn name(&self) -> Option<&str> {
        let (rest, to) = self.kind.rsplit_once('_')?;
        let (rest, from) = rest.rsplit_once('_')?;
        let (name, precision) = rest.rsplit_once('_')?;
        let known = (to, from) == ("3", "3") && matches!(precision, "double" | "float");
        known.then_some(name)
    }

    /// Whether it puts together those that follow it.
    pub(super) fn is_composite(&self) -> bool {
        self.name() == Some("CompositeTransform")
    }

    /// Refuses a kind that is not read, before its numbers are.
    pub(super) fn known(&self, part: usize) -> Result<(), ItkError> {
        let name = self.name().unwrap_or_default();
        match KINDS.iter().any(|(kind, ..)| *kind == name) || self.is_composite() {
            true => Ok(()),
            false => {
                let found = crate::quoted(&self.kind);
                Err(ItkError::Kind { part, found })
            }
        }
    }

    /// Refuses numbers of a composite, which has none of its own.
    pub(super) fn without_numbers(&self) -> Result<(), ItkError> {
        let found = self.parameters.len() + self.fixed.len();
        match found {
            0 => Ok(()),
            found => Err(ItkError::Count {
                part: 0,
                kind: self.kind.clone(),
                what: "numbers of its own",
                found,
                expected: "none",
            }),
        }
    }

    /// The rigid transform.
    pub(super) fn rigid(&self, part: usize) -> Result<Taken, ItkError> {
        self.known(part)?;
        self.finite(part)?;
        let numbers = self.numbers(part)?;
        let kind = || self.kind.clone();
        let nearest = RotationMatrix::nearest(numbers.rows);
        let nearest = nearest.map_err(|why| ItkError::Hand {
            part,
            kind: kind(),
            why,
        })?;
        if nearest.distance > MOST_OFF {
            return Err(ItkError::NotRigid {
                part,
                kind: kind(),
                off: nearest.distance,
                columns: stretches(&numbers.affine()),
            });
        }
        // What is put right turns about the centre, so that the centre goes where the file has it.
        let turned = nearest.matrix.apply(numbers.centre);
        let [x, y, z] = [0, 1, 2].map(|i| numbers.centre[i] - turned[i] + numbers.translation[i]);
        let offset = Vector::new(x, y, z);
        Ok(Taken {
            rigid: Rigid::from_parts(nearest.matrix.rotation(), offset),
            file: numbers.affine(),
            off: nearest.distance,
        })
    }

    fn finite(&self, part: usize) -> Result<(), ItkError> {
        let bad = self.parameters.iter().chain(&self.fixed).find(|x| !is_allowed(**x));
        bad.map_or(Ok(()), |found| {
            let (kind, found) = (self.kind.clone(), found.to_string());
            Err(ItkError::Number { part, kind, found })
        })
    }

    fn numbers(&self, part: usize) -> Result<Numbers, ItkError> {
        let name = self.name().unwrap_or_default();
        let Some((_, count, said, take)) = KINDS.iter().find(|(kind, ..)| *kind == name) else {
            return Err(ItkError::Kind {
                part,
                found: crate::quoted(&self.kind),
            });
        };
        let wrong = |what, found, expected| ItkError::Count {
            part,
            kind: self.kind.clone(),
            what,
            found,
            expected,
        };
        if self.parameters.len() != *count {
            return Err(wrong("Parameters", self.parameters.len(), said));
        }
        let centre = match (name, &self.fixed[..]) {
            ("TranslationTransform" | "IdentityTransform", []) => [0.0; 3],
            ("Euler3DTransform", [x, y, z] | [x, y, z, _]) | (_, [x, y, z]) => [*x, *y, *z],
            _ => return Err(wrong("FixedParameters", self.fixed.len(), "the three of a centre")),
        };
        let p = &self.parameters;
        let last = |from: usize| [0, 1, 2].map(|i| p.get(from + i).copied().unwrap_or(0.0));
        let rows = match take {
            Take::Nothing => [[1.0, 0.0, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            // Radians go once round; what is more is degrees, and another rotation.
            Take::Euler if p[..3].iter().any(|angle| angle.abs() > TAU) => {
                let (kind, found) = (self.kind.clone(), [p[0], p[1], p[2]]);
                return Err(ItkError::Angle { part, kind, found });
            }
            Take::Euler => euler([p[0], p[1], p[2]], self.fixed.get(3).is_some_and(|zyx| *zyx != 0.0)),
            Take::Versor => versor([p[0], p[1], p[2]]).map_err(|length| {
                let kind = self.kind.clone();
                ItkError::Versor { part, kind, length }
            })?,
            Take::Matrix => [[p[0], p[1], p[2]], [p[3], p[4], p[5]], [p[6], p[7], p[8]]],
        };
        // A similarity is a versor, a translation and a scale, which the matrix then shows.
        let scale = if name == "Similarity3DTransform" { p[6] } else { 1.0 };
        let translation = match take {
            Take::Nothing => last(0),
            Take::Euler | Take::Versor => last(3),
            Take::Matrix => last(9),
        };
        let rows = rows.map(|row| row.map(|x| x * scale));
        Ok(Numbers {
            rows,
            translation,
            centre,
        })
    }
}

impl Numbers {
    fn affine(&self) -> Affine<Named, Named> {
        let (m, c) = (&self.rows, self.centre);
        let turned = |i: usize| (0..3).map(|j| m[i][j] * c[j]).sum::<f64>();
        let row = |i: usize| [m[i][0], m[i][1], m[i][2], c[i] - turned(i) + self.translation[i]];
        Affine::from_rows([row(0), row(1), row(2)])
    }
}

/// By how much it stretches along each axis.
pub(super) fn stretches(affine: &Affine<Named, Named>) -> [f64; 3] {
    [0, 1, 2].map(|axis| affine.step(axis).norm())
}

/// How the rotation stands among the parameters.
enum Take {
    Nothing,
    Euler,
    Versor,
    Matrix,
}

/// The kinds, how many parameters each has, and how they are taken.
const KINDS: [(&str, usize, &str, Take); 8] = [
    ("IdentityTransform", 0, "none", Take::Nothing),
    ("TranslationTransform", 3, "3", Take::Nothing),
    ("Euler3DTransform", 6, "6", Take::Euler),
    ("VersorTransform", 3, "3", Take::Versor),
    ("VersorRigid3DTransform", 6, "6", Take::Versor),
    ("Similarity3DTransform", 7, "7", Take::Versor),
    ("AffineTransform", 12, "12", Take::Matrix),
    ("MatrixOffsetTransformBase", 12, "12", Take::Matrix),
];

/// Angles about x, y and z: applied about y, x and z in turn, or about x, y and z.
fn euler([a, b, c]: [f64; 3], is_zyx: bool) -> [[f64; 3]; 3] {
    let about = |axis: [f64; 3], angle: f64| {
        let half = angle / 2.0;
        let [x, y, z] = axis.map(|c| c * half.sin());
        Rotation::from_quaternion([half.cos(), x, y, z]).unwrap_or(Rotation::IDENTITY)
    };
    let [x, y, z] = [
        about([1.0, 0.0, 0.0], a),
        about([0.0, 1.0, 0.0], b),
        about([0.0, 0.0, 1.0], c),
    ];
    let product = if is_zyx { z * y * x } else { z * x * y };
    product.matrix().rows()
}

/// The vector part of a unit quaternion; its length where that is more than 1.
fn versor([x, y, z]: [f64; 3]) -> Result<[[f64; 3]; 3], f64> {
    let length = x.hypot(y).hypot(z);
    // As far as rounding to six digits makes it.
    if length > 1.0 + 1e-6 {
        return Err(length);
    }
    let w = (1.0 - length * length).max(0.0).sqrt();
    Rotation::from_quaternion([w, x, y, z])
        .map(|r| r.matrix().rows())
        .map_err(|_| length)
}
