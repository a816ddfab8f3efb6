//! The server's pixels and ours: four bytes each, red, green, blue and one that says nothing.

use x11rb::protocol::xproto::{ImageOrder, Setup, Visualtype};

/// How a server lays out the pixels of its root.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct Layout {
    /// Bytes of a pixel, 2 to 4.
    bytes: usize,
    /// Rows begin at multiples of so many bytes.
    pad: usize,
    is_big_endian: bool,
    /// Where red, green and blue lie in a pixel.
    masks: [u32; 3],
}

impl Layout {
    /// The layout of a screen of `depth` bits with this visual; `None` where colours are not red, green and blue in a pixel of 16 to 32
    /// bits.
    pub(super) fn of(setup: &Setup, depth: u8, visual: &Visualtype) -> Option<Self> {
        let format = setup.pixmap_formats.iter().find(|format| format.depth == depth)?;
        let masks = [visual.red_mask, visual.green_mask, visual.blue_mask];
        let is_usable = matches!(format.bits_per_pixel, 16 | 24 | 32) && format.scanline_pad >= 8;
        (is_usable && masks.iter().all(|mask| *mask != 0)).then_some(Self {
            bytes: usize::from(format.bits_per_pixel / 8),
            pad: usize::from(format.scanline_pad / 8),
            is_big_endian: setup.image_byte_order == ImageOrder::MSB_FIRST,
            masks,
        })
    }

    fn stride(&self, width: usize) -> usize {
        (width * self.bytes).next_multiple_of(self.pad)
    }

    /// The server's bytes of an image as ours; `None` where they are too few.
    pub(super) fn decode(&self, data: &[u8], [width, height]: [usize; 2]) -> Option<Vec<u8>> {
        let stride = self.stride(width);
        let mut rgbx = Vec::with_capacity(width * height * 4);
        for y in 0..height {
            let row = data.get(y * stride..y * stride + width * self.bytes)?;
            for pixel in row.chunks_exact(self.bytes) {
                let value = self.value(pixel);
                rgbx.extend(self.masks.map(|mask| channel(value, mask)));
                rgbx.push(255);
            }
        }
        Some(rgbx)
    }

    /// Our bytes as the server's.
    pub(super) fn encode(&self, rgbx: &[u8], width: usize) -> Vec<u8> {
        let stride = self.stride(width);
        let mut data = Vec::with_capacity(rgbx.len());
        for row in rgbx.chunks_exact(width * 4) {
            let begin = data.len();
            for pixel in row.chunks_exact(4) {
                self.push(&mut data, self.pixel([pixel[0], pixel[1], pixel[2]]));
            }
            data.resize(begin + stride, 0);
        }
        data
    }

    /// A colour as the server's number for it.
    pub(super) fn pixel(&self, rgb: [u8; 3]) -> u32 {
        let shifted = |(mask, value): (u32, u8)| {
            let top = mask >> mask.trailing_zeros();
            (u32::from(value) * top / 255) << mask.trailing_zeros() & mask
        };
        self.masks
            .into_iter()
            .zip(rgb)
            .map(shifted)
            .fold(0, |all, one| all | one)
    }

    fn value(&self, pixel: &[u8]) -> u32 {
        let join = |value: u32, byte: &u8| value << 8 | u32::from(*byte);
        match self.is_big_endian {
            true => pixel.iter().fold(0, join),
            false => pixel.iter().rev().fold(0, join),
        }
    }

    fn push(&self, data: &mut Vec<u8>, value: u32) {
        let little = value.to_le_bytes();
        match self.is_big_endian {
            true => data.extend(little[..self.bytes].iter().rev()),
            false => data.extend(&little[..self.bytes]),
        }
    }
}

/// A colour of 255, whatever number of bits the server has for it.
fn channel(value: u32, mask: u32) -> u8 {
    let top = u64::from(mask >> mask.trailing_zeros());
    let found = u64::from((value & mask) >> mask.trailing_zeros());
    u8::try_from(found * 255 / top.max(1)).unwrap_or(u8::MAX)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn layouts() -> Vec<Layout> {
        let eight = [0xff_0000, 0xff00, 0xff];
        let layout = |bytes, pad, is_big_endian, masks| Layout {
            bytes,
            pad,
            is_big_endian,
            masks,
        };
        vec![
            layout(4, 4, false, eight),
            layout(4, 4, true, eight),
            layout(3, 4, false, eight),
            layout(3, 4, true, eight),
            layout(4, 4, false, [0x3ff0_0000, 0xf_fc00, 0x3ff]),
            layout(2, 4, false, [0xf800, 0x7e0, 0x1f]),
        ]
    }

    /// Black and white are exact in every layout, which is all that the cell asks for.
    #[test]
    fn black_and_white_come_back() {
        let image: Vec<u8> = (0..7 * 3)
            .flat_map(|i| if i % 3 == 0 { [255; 4] } else { [0, 0, 0, 255] })
            .collect();
        for layout in layouts() {
            let data = layout.encode(&image, 7);
            assert_eq!(layout.decode(&data, [7, 3]).as_ref(), Some(&image), "{layout:?}");
            assert_eq!(layout.decode(&data[1..], [7, 4]), None);
        }
    }

    #[test]
    fn colours_come_back_where_there_are_bits_for_them() {
        let [layout, ..] = layouts()[..] else { unreachable!() };
        assert_eq!(layout.pixel([0x12, 0x34, 0x56]), 0x12_3456);
        let image = [1, 2, 3, 255, 250, 251, 252, 255];
        assert_eq!(layout.decode(&layout.encode(&image, 2), [2, 1]).unwrap(), image);
    }
}
