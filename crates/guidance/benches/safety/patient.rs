//! A label map of 104 structures: organs, one in another, vessels, and bones about them.

use chance::SplitMix64;
use geometry::{Affine, Ct, Point, Vector, VolumeGrid};

pub(crate) const SIDE: usize = 512;
pub(crate) const STEP_MM: f64 = 0.75;
pub(crate) const STRUCTURES: i16 = 104;

pub(crate) struct Patient {
    pub(crate) grid: VolumeGrid,
    /// x fastest, then y.
    pub(crate) labels: Vec<i16>,
}

impl Patient {
    pub(crate) fn new() -> Self {
        let step = |k: usize| {
            let mut v = [0.0; 3];
            v[k] = STEP_MM;
            Vector::<Ct>::new(v[0], v[1], v[2])
        };
        let map = Affine::from_steps(Point::new(0.0, 0.0, 0.0), [0, 1, 2].map(step));
        let mut patient = Self {
            grid: VolumeGrid::checked([SIDE as i64; 3], map).unwrap(),
            labels: vec![0; SIDE * SIDE * SIDE],
        };
        let mut random = SplitMix64::new(3);
        for label in 1..=STRUCTURES {
            let mut at = |spread: f64| [0; 3].map(|_| random.around(256.0, spread));
            match label {
                // Organs of 45 to 165 mm.
                1..=50 => {
                    let middle = at(190.0);
                    let radii = [0; 3].map(|_| random.around(70.0, 40.0));
                    patient.paint(label, middle, radii, |d| d.iter().map(|x| x * x).sum::<f64>() <= 1.0);
                }
                // Shells, as of bones.
                51..=74 => {
                    let middle = at(190.0);
                    let radii = [0; 3].map(|_| random.around(30.0, 15.0));
                    patient.paint(label, middle, radii, |d| {
                        (0.8..=1.0).contains(&d.iter().map(|x| x * x).sum::<f64>().sqrt())
                    });
                }
                // Vessels: balls along a line that bends.
                _ => {
                    let (mut place, mut way) = (at(180.0), at(1.0).map(|x| x - 256.0));
                    for _ in 0..120 {
                        patient.paint(label, place, [7.0; 3], |d| d.iter().map(|x| x * x).sum::<f64>() <= 1.0);
                        way = way.map(|w| (w + random.around(0.0, 0.4)).clamp(-1.0, 1.0));
                        place = [0, 1, 2].map(|k| (place[k] + 2.5 * way[k]).clamp(8.0, 503.0));
                    }
                }
            }
        }
        patient
    }

    /// Gives a label to the voxels about `middle` whose offsets, in units of `radii`, are `in_it`.
    fn paint(&mut self, label: i16, middle: [f64; 3], radii: [f64; 3], in_it: impl Fn([f64; 3]) -> bool) {
        let low = |k: usize| (middle[k] - radii[k]).ceil().max(0.0) as usize;
        let high = |k: usize| ((middle[k] + radii[k]).floor() as usize).min(SIDE - 1);
        for z in low(2)..=high(2) {
            for y in low(1)..=high(1) {
                for x in low(0)..=high(0) {
                    let d = [x, y, z].map(|i| i as f64);
                    if in_it([0, 1, 2].map(|k| (d[k] - middle[k]) / radii[k])) {
                        self.labels[x + SIDE * (y + SIDE * z)] = label;
                    }
                }
            }
        }
    }

    pub(crate) fn slice(&self, z: u32) -> &[i16] {
        &self.labels[z as usize * SIDE * SIDE..][..SIDE * SIDE]
    }
}
