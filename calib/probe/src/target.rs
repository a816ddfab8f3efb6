//! What the points of the images lie on: wires of a phantom.

use geometry::{Phantom, Point};
use nalgebra::Vector3;

use crate::error::ProbeError;

/// A wire by its ends.
#[derive(Debug, Clone, PartialEq)]
pub struct Wire {
    /// Its name, for reports.
    pub name: String,
    /// One end.
    pub front: Point<Phantom>,
    /// The other.
    pub back: Point<Phantom>,
}

/// The wires of a phantom, checked.
#[derive(Debug, Clone, PartialEq)]
pub struct Wires {
    wires: Vec<Wire>,
    pub(crate) lines: Vec<Line>,
}

/// A wire for the fit.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Line {
    pub(crate) front: Vector3<f64>,
    /// Unit vector to the back, and how far it is.
    pub(crate) along: Vector3<f64>,
    pub(crate) length: f64,
    /// Two unit vectors across it.
    pub(crate) across: [Vector3<f64>; 2],
}

/// Wires that differ by less than this, rad, are parallel: 5 degrees.
const PARALLEL_RAD: f64 = 0.087_266_462_599_716_48;

impl Wires {
    /// Checks the wires of a phantom.
    ///
    /// # Errors
    /// [`ProbeError::WireCount`], [`ProbeError::WireLength`], [`ProbeError::WiresParallel`].
    pub fn new(wires: Vec<Wire>) -> Result<Self, ProbeError> {
        let all = Self::to_check(wires)?;
        let (wires, lines) = (&all.wires, &all.lines);
        if wires.len() < 3 {
            return Err(ProbeError::WireCount { found: wires.len() });
        }
        let between = |a: &Line, b: &Line| a.along.cross(&b.along).norm().min(1.0).asin();
        let pairs = lines
            .iter()
            .enumerate()
            .flat_map(|(i, a)| lines[..i].iter().map(move |b| between(a, b)));
        let most = pairs.fold(0.0, f64::max);
        if most < PARALLEL_RAD {
            return Err(ProbeError::WiresParallel {
                wires: lines.len(),
                most_deg: most.to_degrees(),
            });
        }
        Ok(all)
    }

    /// Wires that a calibration is checked with: one is enough, and they may be parallel.
    ///
    /// # Errors
    /// [`ProbeError::WireCount`], [`ProbeError::WireLength`].
    pub fn to_check(wires: Vec<Wire>) -> Result<Self, ProbeError> {
        if !(1..=100).contains(&wires.len()) {
            return Err(ProbeError::WireCount { found: wires.len() });
        }
        let lines: Vec<Line> = wires.iter().map(line).collect::<Result<_, _>>()?;
        Ok(Self { wires, lines })
    }

    /// The wires, in the order in which they were given.
    pub fn all(&self) -> &[Wire] {
        &self.wires
    }
}

fn line(wire: &Wire) -> Result<Line, ProbeError> {
    let (front, back) = (Vector3::from(wire.front.mm()), Vector3::from(wire.back.mm()));
    let length = (back - front).norm();
    let wrong = || ProbeError::WireLength {
        wire: wire.name.clone(),
        found: length,
    };
    // A NaN is within nothing.
    if !(1.0..=1000.0).contains(&length) || front.amax().is_nan() || front.amax() > 1e5 {
        return Err(wrong());
    }
    let along = (back - front) / length;
    // The axis that is least along the wire gives a well-defined direction across it.
    let mut axis = Vector3::zeros();
    axis[along.iamin()] = 1.0;
    let first = along.cross(&axis).try_normalize(0.0).ok_or_else(wrong)?;
    Ok(Line {
        front,
        along,
        length,
        across: [first, along.cross(&first)],
    })
}
