//! What was painted, as a picture to be written.

/// The pixels 0x00RRGGBB of a screen of `size`, as an image for `picture::write_png`. Pixels that are missing are black.
pub fn canvas(pixels: &[u32], [columns, rows]: [u32; 2]) -> picture::Canvas {
    let mut canvas = picture::Canvas::new(columns, rows);
    for (to, pixel) in canvas.rgba_mut().as_chunks_mut::<4>().0.iter_mut().zip(pixels) {
        let [_, r, g, b] = pixel.to_be_bytes();
        *to = [r, g, b, 255];
    }
    canvas
}
