//! The phantom of a device set of PLUS.

use std::path::Path;

use exchange::plus;
use geometry::{Phantom, Point, Reference, Uncertain};
use nalgebra::{Matrix6, Vector6};
use probe::{Wire, Wires};

use super::error::ProbeCommandError;
use crate::input_files::source::Source;

/// A phantom and where it stands.
pub(super) struct Told {
    pub(super) wires: Wires,
    pub(super) reference_from_phantom: Uncertain<Reference, Phantom>,
    /// What the file calls the error of its place.
    pub(super) error: Option<f64>,
}

/// Reads wires and place; `frames` are the phantom's and the reference's, `errors` the deviations of shift (mm) and
/// turn (rad) about the
/// middle of the wires. Wires of a check may be few.
pub(super) fn read(
    path: &Path,
    frames: [&str; 2],
    errors: [f64; 2],
    to_check: bool,
) -> Result<Told, ProbeCommandError> {
    let source = Source::read_whole(path)?;
    let plus = |source| ProbeCommandError::Plus {
        path: path.to_owned(),
        source: Box::new(source),
    };
    let bytes = source.text.as_bytes();
    let wires = plus::wires(bytes).map_err(plus)?;
    let set = plus::read(bytes).map_err(plus)?;
    let found = set.find::<Reference, Phantom>(frames[0], frames[1]).map_err(plus)?;
    let point = |p: [f64; 3]| Point::new(p[0], p[1], p[2]);
    let all: Vec<Wire> = wires
        .iter()
        .map(|wire| Wire {
            name: wire.name.clone(),
            front: point(wire.front_mm),
            back: point(wire.back_mm),
        })
        .collect();
    let middle = middle(&all);
    let wires = if to_check {
        Wires::to_check(all)
    } else {
        Wires::new(all)
    };
    let wires = wires.map_err(|source| ProbeCommandError::Wires {
        path: path.to_owned(),
        source,
    })?;
    let [shift, turn] = errors.map(|s| s * s);
    let covariance = Matrix6::from_diagonal(&Vector6::new(turn, turn, turn, shift, shift, shift));
    let about = found.to_from_from * middle;
    let placed = Uncertain::from_covariance_about(about, found.to_from_from, covariance);
    Ok(Told {
        wires,
        reference_from_phantom: placed.map_err(|source| ProbeCommandError::Covariance {
            path: path.to_owned(),
            source,
        })?,
        error: found.error,
    })
}

fn middle(wires: &[Wire]) -> Point<Phantom> {
    let mut sum = [0.0; 3];
    for end in wires.iter().flat_map(|wire| [wire.front.mm(), wire.back.mm()]) {
        sum = [sum[0] + end[0], sum[1] + end[1], sum[2] + end[2]];
    }
    let [x, y, z] = sum.map(|s| s / (2.0 * wires.len().max(1) as f64));
    Point::new(x, y, z)
}
