//! The numbers that sum a comparison up.

use std::fmt;

use serde::Serialize;

use super::Compared;
use super::tissue::Tissue;

/// How some distances or angles are spread. All zero without any.
#[derive(Debug, Default, Clone, Copy, PartialEq, Serialize)]
pub(crate) struct Spread {
    /// Root of the mean of the squares.
    pub rms: f64,
    /// Half of them are at most this, by nearest rank.
    pub p50: f64,
    /// 95 of a hundred.
    pub p95: f64,
    /// The largest.
    pub max: f64,
    /// The sequence number of the largest.
    pub max_seq: u64,
}

impl Spread {
    fn of(values: &[(u64, f64)]) -> Self {
        let Some(&(max_seq, max)) = values.iter().max_by(|a, b| a.1.total_cmp(&b.1)) else {
            return Self::default();
        };
        let all = || values.iter().map(|&(_, value)| value);
        Self {
            rms: (all().map(|v| v * v).sum::<f64>() / values.len() as f64).sqrt(),
            p50: fit::quantile(all().collect(), 0.5),
            p95: fit::quantile(all().collect(), 0.95),
            max,
            max_seq,
        }
    }
}

/// The numbers that sum a comparison up. Keys are only ever added.
#[derive(Debug, Clone, PartialEq, Serialize)]
pub(crate) struct Summary {
    /// Numbers that both recordings have.
    pub common: usize,
    /// Of these, with a pose in both.
    pub compared: usize,
    /// Of these, with the tip at the same place and the tube in the same direction.
    pub same_place: usize,
    /// Of these, with the same bits in both, of all that is said of a pose but when it was published: covariance, errors,
    /// registration.
    pub identical: usize,
    /// With a pose in the first only, in the second only.
    pub valid_in_one: [usize; 2],
    /// Numbers that only the first, only the second has.
    pub alone: [u64; 2],
    /// Samples in each whose number had come before.
    pub repeated: [u64; 2],
    /// Places in each file that could not be read: what was there is not compared.
    pub damaged: [u64; 2],
    /// The examinations of both, where they say so and they are not the same: nothing says how far apart the tips are in a patient.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub other_examination: Option<[String; 2]>,
    /// Between the tips, mm.
    pub tip_mm: Spread,
    /// Between the orientations, degrees.
    pub angle_deg: Spread,
    /// Organs, where a recording says where they were.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub tissue: Option<Tissue>,
}

impl Summary {
    /// Sums up.
    pub(crate) fn of(compared: &Compared) -> Self {
        let all = &compared.differences;
        let values = |value: &dyn Fn(&super::Difference) -> Option<f64>| -> Vec<(u64, f64)> {
            all.iter().filter_map(|d| Some((d.seq, value(d)?))).collect()
        };
        let tips = values(&|d| d.tip_mm());
        let angles = values(&|d| d.angle_rad().map(f64::to_degrees));
        let valid_only = |i: usize| all.iter().filter(|d| d.status[i] == 0 && d.status[1 - i] != 0).count();
        let same = |d: &&super::Difference| d.apart == Some(([0.0; 3], 0.0));
        Self {
            common: all.len(),
            compared: tips.len(),
            same_place: all.iter().filter(same).count(),
            identical: all.iter().filter(same).filter(|d| d.is_identical).count(),
            valid_in_one: [valid_only(0), valid_only(1)],
            alone: compared.alone,
            repeated: compared.repeated,
            damaged: compared.damaged,
            other_examination: compared.other_examination.clone(),
            tip_mm: Spread::of(&tips),
            angle_deg: Spread::of(&angles),
            tissue: compared.tissue.clone(),
        }
    }
}

impl fmt::Display for Summary {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        writeln!(
            f,
            "{} poses of the same number; in both valid {}, at the same place {}, and to the last bit of all that is said of them {}; valid in \
             the first only {}, in the second only {}",
            self.common, self.compared, self.same_place, self.identical, self.valid_in_one[0], self.valid_in_one[1]
        )?;
        if let Some([a, b]) = &self.other_examination {
            writeln!(f, "OF TWO EXAMINATIONS: {a} and {b}")?;
        }
        if self.damaged != [0, 0] {
            let [a, b] = self.damaged;
            writeln!(
                f,
                "could not be read and is not compared: {a} places of the first, {b} of the second"
            )?;
        }
        if self.alone != [0, 0] {
            writeln!(
                f,
                "only in the first {}, only in the second {}",
                self.alone[0], self.alone[1]
            )?;
        }
        if self.repeated != [0, 0] {
            writeln!(
                f,
                "numbers that came again (the later one counts): {} in the first, {} in the second",
                self.repeated[0], self.repeated[1]
            )?;
        }
        writeln!(
            f,
            "{:<14}{:>11}{:>11}{:>11}{:>11}  of pose",
            "", "rms", "p50", "p95", "max"
        )?;
        for (name, s) in [("tip, mm", self.tip_mm), ("angle, deg", self.angle_deg)] {
            writeln!(
                f,
                "{name:<14}{:>11.4}{:>11.4}{:>11.4}{:>11.4}  {}",
                s.rms, s.p50, s.p95, s.max, s.max_seq
            )?;
        }
        self.tissue.as_ref().map_or(Ok(()), |tissue| tissue.fmt(f))
    }
}
