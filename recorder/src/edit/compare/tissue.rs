//! States of organs of the same pose, in two recordings.

use std::iter::Peekable;
use std::path::Path;

use serde::Serialize;

use crate::read::damage::OpenError;
use crate::read::reader::{Messages, ReadError};
use crate::read::seek::Session;
use crate::wire::proto::TissueFrame;
use crate::wire::schema::TISSUE;

/// How far apart organs are. Keys are only ever added.
#[derive(Debug, Default, Clone, PartialEq, Serialize)]
pub(crate) struct Tissue {
    /// States of the same pose.
    pub common: u64,
    /// Of these, with the same bits: nodes, how far the state came, what certifies it, forces, factor.
    pub identical: u64,
    /// Of these, with another mesh or another number of nodes: nothing says how far organs are apart.
    pub other_mesh: u64,
    /// States of poses that the other recording has none of.
    pub alone: [u64; 2],
    /// The largest distance of a node, mm, and the number of its pose.
    pub farthest_mm: f64,
    /// See `farthest_mm`.
    pub farthest_seq: u64,
    /// The largest difference of a force on the tube, N.
    pub force_n: f64,
    /// The pose of the first state that differs.
    pub first_different: Option<u64>,
}

/// Compares the states of `a` with those of `b`, each of the same pose; `None` where neither has any. What cannot be read is passed
/// over, and so counts as alone in the other.
///
/// # Errors
/// [`OpenError`].
pub(crate) fn compare(a: &Path, b: &Path) -> Result<Option<Tissue>, OpenError> {
    let [a, b] = [Session::open(a)?, Session::open(b)?];
    if !a.may_hold(TISSUE) && !b.may_hold(TISSUE) {
        return Ok(None);
    }
    let mut a = readable(a.tissue_from(i64::MIN)?);
    let mut b = readable(b.tissue_from(i64::MIN)?);
    let mut found = Tissue::default();
    // Poses come in the order of their capture in both.
    while let (Some(one), Some(other)) = (a.peek(), b.peek()) {
        match pose_of(one).cmp(&pose_of(other)) {
            std::cmp::Ordering::Less => {
                found.alone[0] += 1;
                a.next();
            }
            std::cmp::Ordering::Greater => {
                found.alone[1] += 1;
                b.next();
            }
            std::cmp::Ordering::Equal => {
                found.pair(one, other);
                a.next();
                b.next();
            }
        }
    }
    found.alone[0] += a.count() as u64;
    found.alone[1] += b.count() as u64;
    let any = found.common > 0 || found.alone != [0, 0];
    Ok(any.then_some(found))
}

fn readable(messages: Messages<TissueFrame>) -> Peekable<impl Iterator<Item = TissueFrame>> {
    let until_end = messages.take_while(|message| !matches!(message, Err(ReadError::Damage(damage)) if damage.stops));
    until_end.filter_map(Result::ok).peekable()
}

fn pose_of(state: &TissueFrame) -> (i64, u64, u64) {
    let header = &state.header;
    (header.t_capture_ns, header.pose_seq, header.registration_id)
}

impl Tissue {
    fn pair(&mut self, one: &TissueFrame, other: &TissueFrame) {
        self.common += 1;
        if is_same(one, other) {
            self.identical += 1;
            return;
        }
        self.first_different.get_or_insert(one.header.pose_seq);
        let of_mesh = |state: &TissueFrame| (state.header.mesh_id, state.nodes.len());
        if of_mesh(one) != of_mesh(other) {
            self.other_mesh += 1;
            return;
        }
        let [a, b] = [one, other].map(|state| state.nodes.as_chunks::<3>().0);
        for (a, b) in a.iter().zip(b) {
            let [x, y, z] = std::array::from_fn(|k| f64::from(b[k]) - f64::from(a[k]));
            let apart = x.hypot(y).hypot(z);
            // Also where one of them is no number.
            if apart.is_nan() || apart > self.farthest_mm {
                (self.farthest_mm, self.farthest_seq) = (apart, one.header.pose_seq);
            }
        }
        let [x, y, z] = std::array::from_fn(|k| other.header.force[k] - one.header.force[k]);
        let force = x.hypot(y).hypot(z);
        if force.is_nan() || force > self.force_n {
            self.force_n = force;
        }
    }
}

/// Of one model, to the bit; when it was published, and how many were before it, is of the run.
fn is_same(one: &TissueFrame, other: &TissueFrame) -> bool {
    let numbers = |state: &TissueFrame| {
        let h = &state.header;
        let scalars = [
            h.residual,
            h.unsettled_mm,
            h.left_mm,
            h.depth_mm,
            h.least_determinant,
            h.energy,
        ];
        let all: Vec<u64> = scalars
            .iter()
            .chain(&h.force)
            .chain(&h.moment)
            .chain(&h.force_covariance)
            .chain(
                h.errors
                    .iter()
                    .flat_map(|error| error.at_rest_mm.iter().chain(&error.covariance)),
            )
            .map(|x| x.to_bits())
            .collect();
        // How many are known says with them which: a pose's number may be another where poses were made again.
        (
            h.mesh_id,
            h.factor,
            h.state,
            h.steps,
            h.errors_known,
            h.force_error_known,
            h.errors_t_capture_ns,
            all,
        )
    };
    let [a, b] = [one, other].map(|state| state.nodes.iter().map(|x| x.to_bits()));
    numbers(one) == numbers(other) && a.eq(b)
}

impl std::fmt::Display for Tissue {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(
            f,
            "{} states of the tissue of the same pose, {} the same to the bit",
            self.common, self.identical
        )?;
        if self.alone != [0, 0] {
            write!(
                f,
                "; only in the first {}, only in the second {}",
                self.alone[0], self.alone[1]
            )?;
        }
        if let Some(seq) = self.first_different {
            write!(
                f,
                "; the first that differs is of pose {seq}; {} of another mesh; nodes at most {:.3e} mm apart (pose {}), forces {:.3e} N",
                self.other_mesh, self.farthest_mm, self.farthest_seq, self.force_n
            )?;
        }
        writeln!(f)
    }
}

#[cfg(test)]
mod tests;
