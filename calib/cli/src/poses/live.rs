//! Poses that were heard of a run, as a recording; and written as one.

use std::path::{Path, PathBuf};

use super::{PosesError, Recording, Seen};
use crate::live::{Listened, LiveError};
use crate::store;

/// The most poses that take part: more of them, so close in time, say nothing new.
const MOST: usize = 4000;

impl Recording {
    /// The poses of a run, evenly thinned where there are very many. Its hash is that of their numbers.
    pub(crate) fn heard(run: &str, heard: &Listened) -> Result<Self, PosesError> {
        let mut recording = Self::new(&PathBuf::from(format!("run {run}")));
        let mut hash = blake3::Hasher::new();
        let step = heard.poses.len().div_ceil(MOST).max(1);
        for (pose, t_s) in heard.poses.iter().zip(&heard.times_s).step_by(step) {
            let rigid = pose.transform();
            let numbers = [*t_s]
                .into_iter()
                .chain(rigid.quaternion())
                .chain(rigid.translation_mm());
            for number in numbers.chain(pose.upper()) {
                hash.update(&number.to_le_bytes());
                recording.bytes += 8;
            }
            recording.add(
                Some(*t_s),
                Some(Seen {
                    pose: rigid,
                    off: 0.0,
                    covariance: Some(pose.upper()),
                }),
            )?;
        }
        (recording.frames, recording.invalid) = (heard.frames, heard.frames - heard.poses.len());
        recording.blake3 = hash.finalize().to_hex().to_string();
        recording.checked(false)
    }
}

/// Writes what was heard as a file that [`Recording::read`] reads.
pub(crate) fn keep(path: &Path, heard: &Listened) -> Result<(), LiveError> {
    let columns: Vec<String> = (0..21).map(|i| format!("c{i}")).collect();
    let mut text = format!("t_s,qw,qx,qy,qz,tx_mm,ty_mm,tz_mm,{}\n", columns.join(","));
    for (pose, t_s) in heard.poses.iter().zip(&heard.times_s) {
        let rigid = pose.transform();
        let numbers = [*t_s]
            .into_iter()
            .chain(rigid.quaternion())
            .chain(rigid.translation_mm());
        let numbers: Vec<String> = numbers.chain(pose.upper()).map(|x| x.to_string()).collect();
        text += &numbers.join(",");
        text.push('\n');
    }
    Ok(store::write(path, Ok(text), std::iter::empty())?)
}
