//! The volume on the card: a three-dimensional texture, filled piece by piece.
//!
//! Only one piece of voxels at a time is in this process's memory besides the shared volume; bricks become rows on the
//! way.

use bus::volume::Layout;
use wgpu::{Extent3d, TextureFormat};

use super::super::ResliceError;
use super::device::Card;

/// Slices handed over at a time: 4 MiB of a usual CT.
const SLICES: u32 = 8;

/// What is kept of a volume.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) enum Contents {
    /// Voxels that programs read: 16-bit integers.
    Voxels,
    /// Voxels that the sampler reads: the same, as fractions of 32767.
    Fractions,
    /// Coefficients of the B-spline: 32-bit floating point.
    Coefficients,
}

impl Contents {
    fn format(self) -> TextureFormat {
        match self {
            Self::Voxels => TextureFormat::R16Sint,
            Self::Fractions => TextureFormat::R16Snorm,
            Self::Coefficients => TextureFormat::R32Float,
        }
    }

    fn bytes_per_voxel(self) -> u32 {
        match self {
            Self::Voxels | Self::Fractions => 2,
            Self::Coefficients => 4,
        }
    }

    /// On the card, for a volume of these dimensions.
    pub(super) fn bytes(self, dims: [u32; 3]) -> u64 {
        dims.into_iter().map(u64::from).product::<u64>() * u64::from(self.bytes_per_voxel())
    }
}

/// A texture and what it holds.
#[derive(Debug)]
pub(super) struct Uploaded {
    pub(super) contents: Contents,
    pub(super) view: wgpu::TextureView,
    texture: wgpu::Texture,
}

impl Uploaded {
    /// How many pieces [`Uploaded::fill`] takes.
    pub(super) fn pieces(dims: [u32; 3]) -> u32 {
        dims[2].div_ceil(SLICES)
    }

    /// Takes room on the card for `contents` of a volume.
    ///
    /// # Errors
    /// [`ResliceError::Gpu`] where the card is too small.
    pub(super) fn empty(card: &Card, dims: [u32; 3], contents: Contents) -> Result<Self, ResliceError> {
        check_size(dims, card.limits.max_texture_dimension_3d)?;
        let texture = card.device.create_texture(&wgpu::TextureDescriptor {
            label: None,
            size: extent(dims),
            mip_level_count: 1,
            sample_count: 1,
            dimension: wgpu::TextureDimension::D3,
            format: contents.format(),
            usage: wgpu::TextureUsages::COPY_DST | wgpu::TextureUsages::TEXTURE_BINDING,
            view_formats: &[],
        });
        card.check()?;
        let view = texture.create_view(&wgpu::TextureViewDescriptor::default());
        Ok(Self {
            contents,
            view,
            texture,
        })
    }

    /// Uploads piece number `piece`, some slices, of values that lie in `layout`.
    ///
    /// # Errors
    /// [`ResliceError::Gpu`].
    pub(super) fn fill<T: bytemuck::Pod>(
        &self,
        card: &Card,
        layout: &Layout,
        values: &[T],
        piece: u32,
    ) -> Result<(), ResliceError> {
        let [xs, ys, zs] = [0, 1, 2].map(|axis| layout.table(axis));
        let Some(layers) = zs.chunks(SLICES as usize).nth(piece as usize) else {
            return Ok(());
        };
        let mut rows: Vec<T> = Vec::with_capacity(xs.len() * ys.len() * layers.len());
        for &z in layers {
            for &y in ys {
                // Row by row, as a copy to a texture wants it, from wherever the layout has them.
                rows.extend(xs.iter().map(|&x| values[(x + y + z) as usize]));
            }
        }
        self.fill_slab(card, piece * SLICES, bytemuck::cast_slice(&rows))
    }

    /// Hands over whole slices from `z` on, and waits for them, so that they do not pile up on the way.
    fn fill_slab(&self, card: &Card, z: u32, bytes: &[u8]) -> Result<(), ResliceError> {
        let Extent3d { width, height, .. } = self.texture.size();
        let bytes_per_row = width * self.contents.bytes_per_voxel();
        let slices = bytes.len() as u64 / (u64::from(bytes_per_row) * u64::from(height));
        card.queue.write_texture(
            wgpu::TexelCopyTextureInfo {
                origin: wgpu::Origin3d { x: 0, y: 0, z },
                ..self.texture.as_image_copy()
            },
            bytes,
            wgpu::TexelCopyBufferLayout {
                offset: 0,
                bytes_per_row: Some(bytes_per_row),
                rows_per_image: Some(height),
            },
            extent([width, height, slices as u32]),
        );
        card.finish(None, card.patience())
    }

    /// Overwrites the first slices with zeros, as a card with bad memory may.
    #[cfg(test)]
    pub(super) fn spoil(&self, card: &Card) {
        let Extent3d { width, height, .. } = self.texture.size();
        let bytes = width * height * self.contents.bytes_per_voxel() * self.texture.depth_or_array_layers();
        self.fill_slab(card, 0, &vec![0; bytes as usize]).unwrap();
    }
}

/// A texture has at most so many voxels along each axis.
fn check_size(dims: [u32; 3], most: u32) -> Result<(), ResliceError> {
    // Places have 15 bits of voxels and a sign.
    let most = most.min(i16::MAX as u32);
    if dims.iter().all(|&n| n <= most) {
        return Ok(());
    }
    let [x, y, z] = dims;
    Err(ResliceError::Gpu(format!(
        "a volume of {x} x {y} x {z} voxels; it holds {most} along an axis"
    )))
}

fn extent([width, height, depth_or_array_layers]: [u32; 3]) -> Extent3d {
    Extent3d {
        width,
        height,
        depth_or_array_layers,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn volumes_longer_than_a_texture_are_refused_in_words() {
        assert!(check_size([2048, 1, 2048], 2048).is_ok());
        let refused = check_size([512, 512, 2049], 2048).unwrap_err().to_string();
        assert!(refused.contains("512 x 512 x 2049 voxels"), "{refused}");
        assert!(check_size([40_000, 1, 1], 65_536).is_err());
    }

    #[test]
    fn a_ct_takes_its_own_size() {
        assert_eq!(Contents::Voxels.bytes([512, 512, 400]), 200 << 20);
        assert_eq!(Contents::Coefficients.bytes([512, 512, 400]), 400 << 20);
    }
}
