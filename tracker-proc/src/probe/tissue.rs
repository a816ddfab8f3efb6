//! What the sound of a simulated probe runs through: the run's own patient.

use bus::port::SharedVolume;
use bus::volume::VolumeView;
use geometry::{Ct, Point};
use phantom::Phantom;
use scene::{Scene, VolumeSource};
use ultrasound::Body;

/// The HU of the patient at every place.
#[derive(Debug)]
pub(crate) enum Tissue {
    /// The generated patient itself, and not the voxels that were made of him.
    Phantom(Box<Phantom>),
    /// A CT.
    Ct(Box<SharedVolume>),
}

impl Tissue {
    /// The patient of a scene whose examination is `volume`.
    pub(crate) fn of(scene: &Scene, volume: SharedVolume) -> Self {
        match scene.volume.source {
            VolumeSource::Phantom { .. } => Self::Phantom(Box::new(Phantom::new(scene.seed))),
            VolumeSource::File(_) => Self::Ct(Box::new(volume)),
        }
    }
}

impl Body for Tissue {
    fn hu(&self, [x, y, z]: [f64; 3]) -> f64 {
        let place = Point::new(x, y, z);
        match self {
            Self::Phantom(phantom) => phantom.hu(place),
            Self::Ct(volume) => between_voxels(&volume.view(), place),
        }
    }
}

/// The HU between eight voxels; beyond the outermost ones the volume's padding, as nothing is known there.
fn between_voxels(volume: &VolumeView<'_>, place: Point<Ct>) -> f64 {
    let index = (volume.grid.voxel_from_ct() * place).mm();
    let dims = volume.grid.dims();
    let (mut first, mut share) = ([0_u32; 3], [0.0; 3]);
    for axis in 0..3 {
        let floor = index[axis].floor();
        // Also false for what is not finite.
        if !(floor >= 0.0 && floor + 1.0 < f64::from(dims[axis])) {
            return f64::from(volume.padding_hu);
        }
        (first[axis], share[axis]) = (floor as u32, index[axis] - floor);
    }
    let [x, y, z] = first;
    let along_x = |y, z| {
        let [a, b] = [x, x + 1].map(|x| f64::from(volume.at([x, y, z])));
        a + share[0] * (b - a)
    };
    let [front, back] = [z, z + 1].map(|z| {
        let (a, b) = (along_x(y, z), along_x(y + 1, z));
        a + share[1] * (b - a)
    });
    front + share[2] * (back - front)
}

#[cfg(test)]
mod tests {
    use super::*;
    use bus::volume::Layout;
    use geometry::{Affine, Vector, VolumeGrid};

    #[test]
    fn a_linear_field_is_met_between_voxels_and_nothing_beyond_them() {
        let steps = [
            Vector::new(2.0, 0.0, 0.0),
            Vector::new(0.0, 1.5, 0.0),
            Vector::new(0.0, 0.0, 3.0),
        ];
        let grid = VolumeGrid::checked([5, 6, 7], Affine::from_steps(Point::new(-4.0, 1.0, 10.0), steps)).unwrap();
        let layout = Layout::choose([5, 6, 7]).unwrap();
        let mut voxels = vec![0_i16; layout.stored() as usize];
        let field = |[x, y, z]: [f64; 3]| 10.0 * x + 20.0 * y - 4.0 * z;
        for (x, y, z) in (0..5).flat_map(|x| (0..6).flat_map(move |y| (0..7).map(move |z| (x, y, z)))) {
            let place = (grid.ct_from_voxel() * Point::new(f64::from(x), f64::from(y), f64::from(z))).mm();
            voxels[layout.offset([x, y, z])] = field(place) as i16;
        }
        let view = VolumeView {
            grid: &grid,
            layout: &layout,
            voxels: &voxels,
            padding_hu: -1000,
        };
        for [x, y, z] in [[-4.0, 1.0, 10.0], [-1.3, 2.2, 17.7], [3.9, 8.4, 27.9]] {
            // Values at voxels are whole, and what lies between is linear.
            assert!((between_voxels(&view, Point::new(x, y, z)) - field([x, y, z])).abs() < 1e-9);
        }
        for beyond in [
            [-4.1, 2.0, 11.0],
            [4.1, 2.0, 11.0],
            [0.0, f64::NAN, 11.0],
            [0.0, 2.0, 28.1],
        ] {
            let [x, y, z] = beyond;
            assert_eq!(between_voxels(&view, Point::new(x, y, z)), -1000.0, "{beyond:?}");
        }
    }
}
