//! The patient as a scanner measures it, a slice at a time.

use chance::{Chance, mix};
use geometry::{Affine, Ct, GridError, Point, VolumeGrid};
use phantom::Phantom;
use volume_loader::source::{Conversion, ReadError, VoxelSource};

use super::erf::erf;
use crate::plan::Dials;

/// Its metal, HU.
const METAL_HU: f64 = 14_000.0;
/// Deviation of the scanner's blur, mm.
const BLUR_MM: f64 = 0.45;
/// Where the scanner clips, HU.
const CLIP_HU: f64 = 3071.0;
/// So far beyond its surface a bead's share is below 1e-12: seven deviations, mm.
const FADE_MM: f64 = 7.0 * BLUR_MM;
/// Layers that a slice's thickness is averaged over; a millimetre or less each up to slices of 9 mm.
const LAYERS: u32 = 9;

/// An examination of the generated patient.
pub(crate) struct Scan {
    patient: Phantom,
    grid: VolumeGrid,
    metal: Vec<Point<Ct>>,
    /// Of each bead, mm.
    radius_mm: f64,
    noise_hu: f64,
    seed: u64,
}

impl Scan {
    /// With voxels at places drawn from the seed, so that beads lie anywhere between them.
    ///
    /// # Errors
    /// [`GridError`].
    pub(crate) fn new(patient: Phantom, dials: &Dials, metal: &[Point<Ct>], seed: u64) -> Result<Self, GridError> {
        let (spacing_mm, noise_hu) = (dials.ct.spacing_mm, dials.ct.noise_hu);
        let grid = patient.grid(spacing_mm)?;
        let (map, chance) = (grid.ct_from_voxel(), Chance::new(seed, 0));
        let [x, y, z] = [0, 1, 2].map(|k| map.rows()[k][3] + spacing_mm[k] * (chance.uniform(k as u64) - 0.5));
        let moved = Affine::from_steps(Point::new(x, y, z), [0, 1, 2].map(|axis| map.step(axis)));
        Ok(Self {
            grid: VolumeGrid::checked(grid.dims().map(i64::from), moved)?,
            patient,
            metal: metal.to_vec(),
            radius_mm: 0.5 * dials.bead_mm,
            noise_hu,
            seed,
        })
    }

    /// What a bead's metal is of what is seen at `p`, averaged over the slice's thickness.
    fn share(&self, bead: Point<Ct>, p: Point<Ct>) -> f64 {
        let thick = self.grid.ct_from_voxel().step(2);
        let layer = |k: u32| {
            let off = (f64::from(k) + 0.5) / f64::from(LAYERS) - 0.5;
            share(bead.distance(p + thick * off), self.radius_mm)
        };
        (0..LAYERS).map(layer).sum::<f64>() / f64::from(LAYERS)
    }

    /// HU at a voxel's centre before noise and clipping, where its tissue has `tissue`.
    fn with_metal(&self, p: Point<Ct>, tissue: f64, reach: [f64; 3]) -> f64 {
        let is_near = |bead: &&Point<Ct>| {
            let off = (**bead - p).mm();
            (0..3).all(|k| off[k].abs() < reach[k])
        };
        let near = self.metal.iter().filter(is_near);
        near.fold(tissue, |hu, bead| {
            let share = self.share(*bead, p);
            share * METAL_HU + (1.0 - share) * hu
        })
    }
}

/// (1) of [the module](super), of a bead of radius `r`.
fn share(d: f64, r: f64) -> f64 {
    let s = BLUR_MM;
    // At the centre the second term is a difference quotient; here it is off by less than 1e-9.
    let d = d.max(1e-4);
    let root = s * std::f64::consts::SQRT_2;
    let bell = |x: f64| (-0.5 * (x / s).powi(2)).exp();
    let rim = s / (d * std::f64::consts::TAU.sqrt()) * (bell(r - d) - bell(r + d));
    (0.5 * (erf((r + d) / root) + erf((r - d) / root)) - rim).clamp(0.0, 1.0)
}

impl VoxelSource for Scan {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }

    fn padding_hu(&self) -> i16 {
        phantom::AIR_HU as i16
    }

    fn describe(&self) -> String {
        "generated patient with metal beads".to_owned()
    }

    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        self.patient.fill_slice(&self.grid, k, out);
        let (map, [nx, _, _], spacing) = (self.grid.ct_from_voxel(), self.grid.dims(), self.grid.spacing_mm());
        // The axes are the patient's: a bead is seen within its reach, and half a slice along z.
        let far = self.radius_mm + FADE_MM;
        let reach = [far, far, far + 0.5 * spacing[2]];
        let chance = Chance::new(mix(self.seed ^ mix(1)), u64::from(k));
        let [ox, oy, oz] = map.rows().map(|row| row[3]);
        let slice = oz + spacing[2] * f64::from(k);
        let is_metal = self.metal.iter().any(|bead| (bead.mm()[2] - slice).abs() < reach[2]);
        for (at, value) in (0_u64..).zip(out.iter_mut()) {
            let mut hu = f64::from(*value);
            if is_metal {
                let (i, j) = (at % u64::from(nx), at / u64::from(nx));
                let p = Point::new(ox + spacing[0] * i as f64, oy + spacing[1] * j as f64, slice);
                hu = self.with_metal(p, hu, reach);
            }
            if self.noise_hu > 0.0 {
                hu += self.noise_hu * noise(chance, at);
            }
            // Within i16 by the clipping.
            *value = hu.round().clamp(-1024.0, CLIP_HU) as i16;
        }
        Ok(())
    }

    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(Conversion::default())
    }
}

/// Nearly normal noise at a tenth of a logarithm's price: the sum of four even numbers, with their variance of 1 / 3 put right. It goes no
/// further than 3.5 deviations, of which a scanner's noise is beyond in one voxel of 2000.
fn noise(chance: Chance, draw: u64) -> f64 {
    let bits = (chance.uniform(draw) * (1_u64 << 52) as f64) as u64;
    let part = |k: u32| f64::from(((bits >> (13 * k)) & 0x1fff) as u16) / 8192.0;
    ((0..4).map(part).sum::<f64>() - 2.0 + 0.5 / 2048.0) * 3.0_f64.sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use geometry::Vector;

    /// The share integrates to the ball's volume: blurring moves metal and makes none.
    #[test]
    fn a_blurred_ball_has_the_ball_s_volume() {
        let n = 40_000;
        let r = 1.0;
        let step = (r + FADE_MM) / f64::from(n);
        let shell = |k: i32| {
            let d = (f64::from(k) + 0.5) * step;
            4.0 * std::f64::consts::PI * d * d * share(d, r) * step
        };
        let volume: f64 = (0..n).map(shell).sum();
        let ball = 4.0 / 3.0 * std::f64::consts::PI * r * r * r;
        // The midpoint rule's error is of the order of the step's square, 1e-8; what lies beyond the reach is below 1e-10.
        assert!((volume / ball - 1.0).abs() < 1e-6, "{volume} {ball}");
        // At the centre the closed form's limit: erf(r / (s sqrt 2)) - sqrt(2 / pi) r / s exp(-r^2 / (2 s^2)).
        let s = BLUR_MM;
        let limit = erf(r / (s * 2.0_f64.sqrt()))
            - (2.0 / std::f64::consts::PI).sqrt() * r / s * (-0.5 * (r / s).powi(2)).exp();
        assert!((share(0.0, r) - limit).abs() < 1e-6, "{} {limit}", share(0.0, r));
    }

    #[test]
    fn noise_has_its_moments() {
        let n = 200_000;
        let draws: Vec<f64> = (0..n).map(|k| noise(Chance::new(3, 0), k)).collect();
        let mean = draws.iter().sum::<f64>() / n as f64;
        let variance = draws.iter().map(|x| x * x).sum::<f64>() / n as f64;
        // Five standard errors: 1 / sqrt(n), and sqrt(2 / n) for the variance, less for a bounded one.
        assert!(mean.abs() < 5.0 / (n as f64).sqrt(), "{mean}");
        assert!((variance - 1.0).abs() < 5.0 * (2.0 / n as f64).sqrt(), "{variance}");
    }

    /// A bead in the image, by its own weight: the centre of what metal adds to the slices, unclipped and without noise.
    #[test]
    fn a_bead_lies_where_it_is_said_to_lie() {
        let patient = super::super::patient();
        let bead = patient.beads()[0].centre;
        let text = "[[stratum]]\nname = \"a\"\nct = { spacing_mm = [0.9, 0.8, 0.6], noise_hu = 0.0 }";
        let plan = crate::plan::Plan::of_texts([(std::path::Path::new("a.toml"), text)]).unwrap();
        let scan = Scan::new(patient, &plan.strata[0].dials, &[bead], 5).unwrap();
        let map = scan.grid.ct_from_voxel();
        let [nx, ny, nz] = scan.grid.dims();
        let (mut sum, mut moment) = (0.0, Vector::new(0.0, 0.0, 0.0));
        for k in 0..nz {
            for j in 0..ny {
                for i in 0..nx {
                    let p = map * Point::new(f64::from(i), f64::from(j), f64::from(k));
                    if bead.distance(p) < scan.radius_mm + FADE_MM + 1.0 {
                        let share = scan.share(bead, p);
                        (sum, moment) = (sum + share, moment + (p - bead) * share);
                    }
                }
            }
        }
        let off = moment * (1.0 / sum);
        // A centre of samples s apart is off by what the spectrum's slope leaves at their own frequency: of a bell of deviation b at most
        // 4 pi b^2 / s exp(-2 (pi b / s)^2), 0.02 mm for 0.9; of means over slices of 0.6 mm at most 0.6 / pi exp(-2 (pi b / 0.6)^2), 3e-6.
        assert!(off.norm() < 0.02, "{off:?}");
    }
}
