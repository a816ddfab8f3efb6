//! Organs in a slice where a state has them: the HU of what lies at each pixel now, and what nothing is known of.

use bus::volume::VolumeView;
use geometry::{Ct, Model, Point, Rigid, SlicePlane, checked};
use picture::{Canvas, Rgb, palette};
use scene::Filter;

use super::RenderError;
use crate::reslice::Resampler;
use crate::tissue::Moved;
use crate::warp::{Pixel, Warp, Warped};

/// What tissue has left: stripes the other way than outside the examination, on no grey of a slice.
const STRIPE: Rgb = Rgb(64, 72, 96);
const GROUND: Rgb = Rgb(12, 14, 22);
const PERIOD: usize = 8;
const WIDTH: usize = 2;

/// Draws organs; its buffers are taken once.
#[derive(Debug, Default)]
pub(super) struct Organs {
    warp: Warp,
    /// Pixels of tissue, their places at rest, and the HU there.
    at: Vec<usize>,
    places: Vec<[f32; 3]>,
    hu: Vec<f32>,
    /// Of pixels that are no slice of the examination: which, and what they are.
    marked: Vec<(usize, Pixel)>,
    /// How many of these two places claim.
    covered_twice: usize,
}

impl Organs {
    /// Puts the HU of tissue to where it is now; `hu` has those of the examination as it was taken. Whatever pixel is neither is
    /// kept for [`Self::mark`].
    ///
    /// # Errors
    /// [`RenderError`].
    pub(super) fn put(
        &mut self,
        moved: &Moved<'_>,
        (volume, plane, filter): (&VolumeView<'_>, &SlicePlane, Filter),
        resampler: &mut dyn Resampler,
        hu: &mut [f32],
    ) -> Result<(), RenderError> {
        // Also where nothing comes of this image: marks of the one before are not its own.
        self.clear();
        let ct_from_model = moved.shapes.ct_from_model;
        let plane = of_model(plane, ct_from_model)?;
        let warped = self.warp.draw(&plane, &moved.organs())?;
        self.at.clear();
        self.places.clear();
        self.covered_twice = warped.twice;
        sort(warped, &mut self.at, &mut self.marked);
        let placed = |at: &usize| {
            let [x, y, z] = warped.rest[*at].map(f64::from);
            (ct_from_model * Point::<Model>::new(x, y, z)).mm().map(|x| x as f32)
        };
        self.places.extend(self.at.iter().map(placed));
        self.hu.resize(self.at.len(), 0.0);
        resampler.reslice_at(volume, &self.places, filter, &mut self.hu)?;
        for (at, value) in self.at.iter().zip(&self.hu) {
            hu[*at] = *value;
        }
        Ok(())
    }

    /// Nothing is tissue and nothing marked.
    pub(super) fn clear(&mut self) {
        self.marked.clear();
        self.covered_twice = 0;
    }

    /// Pixels of this image that two places claim.
    pub(super) fn covered_twice(&self) -> usize {
        self.covered_twice
    }

    /// Hatches what tissue has left, and colours what two places claim.
    pub(super) fn mark(&self, canvas: &mut Canvas) {
        let width = canvas.width() as usize;
        let pixels = canvas.rgba_mut();
        for (at, pixel) in &self.marked {
            let across = (at % width + PERIOD * width - at / width) % PERIOD;
            let Rgb(r, g, b) = match pixel {
                Pixel::Twice => palette::ALARM,
                _ if across < WIDTH => STRIPE,
                _ => GROUND,
            };
            pixels[4 * at..4 * at + 4].copy_from_slice(&[r, g, b, 255]);
        }
    }
}

fn sort(warped: &Warped, inside: &mut Vec<usize>, marked: &mut Vec<(usize, Pixel)>) {
    for (at, pixel) in warped.pixels.iter().enumerate() {
        match pixel {
            Pixel::Outside => {}
            Pixel::Inside(_) => inside.push(at),
            Pixel::Vacated | Pixel::Twice => marked.push((at, *pixel)),
        }
    }
}

/// A plane as the model's frame has it.
fn of_model(plane: &SlicePlane, ct_from_model: Rigid<Ct, Model>) -> Result<SlicePlane, RenderError> {
    let model_from_ct = ct_from_model.inverse();
    let axes = [plane.right(), plane.down()].map(|axis| (model_from_ct * axis).components());
    let origin = (model_from_ct * plane.origin()).mm();
    Ok(checked::slice_plane(origin, axes, plane.pixel_mm(), plane.size())?)
}

#[cfg(test)]
mod tests;
