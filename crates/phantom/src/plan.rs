//! The numbers that differ from patient to patient, drawn from the seed.

use crate::trunk::TrunkWall;
use crate::vec3::Vec3;
use chance::SplitMix64;

/// z of the middle of the third lumbar vertebra in levels above L5.
const L3_LEVEL: f64 = 2.0;

/// One patient's measures, mm and HU.
#[derive(Debug, Clone)]
pub(crate) struct Plan {
    /// The skin.
    pub skin: TrunkWall,
    /// Thickness of the fat under the skin at the flanks, the belly and the back, mm.
    pub fat: [f64; 3],
    /// Distance from one vertebra's middle to the next, mm.
    pub pitch: f64,
    /// y of the middle of L3, mm.
    pub spine_y: f64,
    /// Right-left half-width of L5's body, mm.
    pub body_half_width: f64,
    /// Shifts of the liver, the spleen, the right and the left kidney, mm.
    pub shifts: [Vec3; 4],
    /// Size of the organs relative to the middle patient's.
    pub organ_size: f64,
    /// Added to the HU of the organs: another moment of the contrast.
    pub enhancement: f64,
    /// Where the loops of bowel turn and how full they are.
    pub bowel: SplitMix64,
}

impl Plan {
    /// The patient of this seed.
    pub(crate) fn new(seed: u64) -> Self {
        let mut random = SplitMix64::new(seed);
        let skin = TrunkWall {
            half: [random.around(158.0, 3.0), random.around(109.0, 2.0)],
            centre_y: 0.0,
        };
        Self {
            skin,
            fat: [
                random.around(15.0, 2.0),
                random.around(16.0, 3.0),
                random.around(10.0, 1.5),
            ],
            pitch: random.around(36.5, 0.6),
            spine_y: random.around(31.0, 1.5),
            body_half_width: random.around(25.0, 1.0),
            shifts: std::array::from_fn(|_| std::array::from_fn(|_| random.around(0.0, 2.5))),
            organ_size: random.around(1.0, 0.03),
            enhancement: random.around(0.0, 6.0),
            bowel: SplitMix64::new(random.bits()),
        }
    }

    /// Middle of the spine's body column at height `z`, mm: the lumbar lordosis, a parabola whose most anterior point
    /// is L3.
    pub(crate) fn spine_at(&self, z: f64) -> Vec3 {
        let dz = z - L3_LEVEL * self.pitch;
        [0.0, self.spine_y + 9e-4 * dz * dz, z]
    }

    /// Direction of the spine at height `z`, upwards; not of unit length.
    pub(crate) fn spine_direction(&self, z: f64) -> Vec3 {
        [0.0, 1.8e-3 * (z - L3_LEVEL * self.pitch), 1.0]
    }

    /// Outer surface of the muscular wall.
    pub(crate) fn muscle_wall(&self) -> TrunkWall {
        let [flank, belly, back] = self.fat;
        self.skin.inset(flank + 2.0, belly + 2.0, back + 2.0)
    }

    /// Inner surface of the muscular wall: the cavity.
    pub(crate) fn cavity(&self) -> TrunkWall {
        self.muscle_wall().inset(14.0, 10.0, 16.0)
    }
}
