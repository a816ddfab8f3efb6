//! Images at half their resolution.

use super::Image;

/// Sums of two by two pixels, over four where samples of 16 bits need it; an odd last column or row is left out. None where
/// nothing is left. With the steps of the half image that one of the image is: 4 or 1.
///
/// The pixel `(x, y)` has its centre at `(2 x + 1/2, 2 y + 1/2)` of the image.
pub(crate) fn halved(image: &Image) -> Option<(Image, f64)> {
    let (width, height) = (image.width() / 2, image.height() / 2);
    let most = image.samples().iter().copied().max().unwrap_or(0);
    let parts = if most > u16::MAX / 4 { 4 } else { 1 };
    let mut samples = Vec::with_capacity(width * height);
    for y in 0..height {
        let rows = image
            .row(2 * y)
            .chunks_exact(2)
            .zip(image.row(2 * y + 1).chunks_exact(2));
        samples.extend(rows.map(|(a, b)| {
            let sum = [a[0], a[1], b[0], b[1]].into_iter().map(u32::from).sum::<u32>();
            (sum / parts) as u16
        }));
    }
    let half = Image::new(width, height, samples).ok()?;
    Some((half, f64::from(4 / parts)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn four_pixels_make_one() {
        let small = Image::new(5, 3, (0..15).collect()).unwrap();
        let (half, of) = halved(&small).unwrap();
        assert_eq!(
            (half.width(), half.height(), half.samples(), of),
            (2, 1, &[12, 20][..], 4.0)
        );
        let (half, of) = halved(&Image::new(2, 2, vec![65535, 65535, 65535, 65534]).unwrap()).unwrap();
        assert_eq!((half.samples(), of), (&[65534][..], 1.0));
        assert!(halved(&Image::new(1, 7, vec![3; 7]).unwrap()).is_none());
    }
}
