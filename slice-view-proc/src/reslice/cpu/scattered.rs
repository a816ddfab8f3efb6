//! Places in any order, one after the other.

use bus::volume::VolumeView;
use geometry::Point;

use super::aligned::Separable;
use super::kernels::Draw;
use super::vector::Vector;
use super::walk::Walk;

/// Places, mm in the CT's frame, and the values there.
pub(super) struct Scattered<'a, 'v> {
    pub(super) volume: &'a VolumeView<'v>,
    pub(super) places: &'a [[f32; 3]],
    pub(super) hu: &'a mut [f32],
}

impl Draw for Scattered<'_, '_> {
    fn draw<const N: usize>(&mut self, kernel: &impl Separable<N>) {
        let (voxel_from_ct, dims) = (self.volume.grid.voxel_from_ct(), self.volume.grid.dims());
        let padding = f32::from(self.volume.padding_hu);
        Vector::with(kernel.vector(), || {
            for (place, value) in self.places.iter().zip(self.hu.iter_mut()) {
                let [x, y, z] = place.map(f64::from);
                let index = (voxel_from_ct * Point::new(x, y, z)).mm();
                // Outside, or no number.
                *value = padding;
                if let Some(walk) = Walk::one(index, dims) {
                    kernel.points(&walk, 0..1, std::slice::from_mut(value));
                }
            }
        });
    }
}
