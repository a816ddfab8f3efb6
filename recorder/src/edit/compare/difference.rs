//! Two poses of one sequence number.

use geometry::{Ct, Point, Rigid, Tool};

use super::tissue::Tissue;
use super::{Sample, Samples};

/// What lies between the poses of one sequence number.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) struct Difference {
    /// The number.
    pub seq: u64,
    /// The source's own time of the sample, from the first recording, ns.
    pub t_device_ns: i64,
    /// Status of both: 0 is valid.
    pub status: [u32; 2],
    /// The tips, LPS mm; `None` where there is no pose.
    pub tips_mm: [Option<[f64; 3]>; 2],
    /// From the tip of the first to that of the second, LPS mm, and the angle between the two orientations, radians;
    /// `None` where one of them has no pose.
    pub apart: Option<([f64; 3], f64)>,
    /// Whether both say the same, to the last bit: pose, covariance, error, registration, stamps but that of publication.
    pub is_identical: bool,
}

impl Difference {
    pub(crate) fn of(seq: u64, a: &Sample, b: &Sample) -> Self {
        Self {
            seq,
            t_device_ns: a.t_device_ns,
            status: [a.status, b.status],
            tips_mm: [a.pose, b.pose].map(|pose| pose.map(tip_mm)),
            is_identical: a.bits == b.bits,
            apart: a.pose.zip(b.pose).map(|(a, b)| (tip_offset_mm(a, b), angle_rad(a, b))),
        }
    }

    /// Between the tips, mm.
    pub(crate) fn tip_mm(&self) -> Option<f64> {
        self.apart.map(|([x, y, z], _)| x.hypot(y).hypot(z))
    }

    /// Between the orientations, radians, 0 to pi.
    pub(crate) fn angle_rad(&self) -> Option<f64> {
        self.apart.map(|(_, angle)| angle)
    }
}

/// The tool's frame begins at the inner tip.
fn tip_mm(pose: Rigid<Ct, Tool>) -> [f64; 3] {
    (pose * Point::<Tool>::new(0.0, 0.0, 0.0)).mm()
}

fn tip_offset_mm(a: Rigid<Ct, Tool>, b: Rigid<Ct, Tool>) -> [f64; 3] {
    let (a, b) = (tip_mm(a), tip_mm(b));
    std::array::from_fn(|i| b[i] - a[i])
}

/// The angle of `a^-1 b`: `2 atan2(|v|, |w|)` of its quaternion, which keeps its digits at small angles and is exactly 0
/// for equal ones.
fn angle_rad(a: Rigid<Ct, Tool>, b: Rigid<Ct, Tool>) -> f64 {
    let ([aw, ax, ay, az], [bw, bx, by, bz]) = (a.quaternion(), b.quaternion());
    let w = aw * bw + ax * bx + ay * by + az * bz;
    let x = aw * bx - ax * bw - ay * bz + az * by;
    let y = aw * by - ay * bw - az * bx + ax * bz;
    let z = aw * bz - az * bw - ax * by + ay * bx;
    2.0 * x.hypot(y).hypot(z).atan2(w.abs())
}

/// Two recordings side by side.
#[derive(Debug, Clone, PartialEq)]
pub(crate) struct Compared {
    /// Every number that both have, in order.
    pub differences: Vec<Difference>,
    /// Numbers that only the first, only the second has.
    pub alone: [u64; 2],
    /// Samples in each whose number had come before; the later one counts.
    pub repeated: [u64; 2],
    /// Places in each file that could not be read.
    pub damaged: [u64; 2],
    /// The examinations of both, where they are not the same.
    pub other_examination: Option<[String; 2]>,
    /// Organs, where a recording says where they were.
    pub tissue: Option<Tissue>,
}

impl Compared {
    pub(crate) fn of(a: &Samples, b: &Samples) -> Self {
        let both = a.by_seq.iter().filter_map(|(&seq, sample)| {
            let other = b.by_seq.get(&seq)?;
            Some(Difference::of(seq, sample, other))
        });
        let differences: Vec<_> = both.collect();
        let common = differences.len();
        Self {
            alone: [a, b].map(|samples| (samples.by_seq.len() - common) as u64),
            repeated: [a.repeated, b.repeated],
            damaged: [a.damaged, b.damaged],
            other_examination: None,
            differences,
            tissue: None,
        }
    }
}
