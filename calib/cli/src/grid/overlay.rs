//! What was found, drawn on the image.

use std::collections::HashSet;
use std::path::{Path, PathBuf};

use nalgebra::Vector2;
use optics::grid::{Found, project};
use optics::image::Image;
use picture::{Anchor, Canvas, Line, PngError, Rgb, write_png};

const SEEN: Rgb = Rgb(0, 230, 90);
const MISSING: Rgb = Rgb(255, 60, 60);
const COLUMNS: Rgb = Rgb(255, 190, 0);
const ROWS: Rgb = Rgb(70, 170, 255);

/// The image in grey, its darkest sample black and its brightest white.
pub(crate) fn canvas(image: &Image) -> Canvas {
    let mut canvas = Canvas::new(image.width() as u32, image.height() as u32);
    let least = image.samples().iter().min().copied().unwrap_or(0);
    let most = image.samples().iter().max().copied().unwrap_or(0);
    let range = f64::from(most - least).max(1.0);
    for (pixel, sample) in canvas.rgba_mut().chunks_exact_mut(4).zip(image.samples()) {
        let grey = (f64::from(sample - least) / range * 255.0) as u8;
        pixel.copy_from_slice(&[grey, grey, grey, 255]);
    }
    canvas
}

/// A pixel's middle, which is at whole coordinates here, on a canvas, where it is at halves.
pub(crate) fn on_canvas(at: Vector2<f64>) -> [f64; 2] {
    [at.x + 0.5, at.y + 0.5]
}

/// A name for each image's overlay: the file's own without folder and ending, with a number where another image, in
/// another folder or of another format, has it already. None comes twice.
pub(crate) fn stems(images: &[PathBuf]) -> Vec<String> {
    let mut taken = HashSet::new();
    let one = |path: &PathBuf| {
        let stem = path.file_stem().unwrap_or_default().to_string_lossy().into_owned();
        let numbered = (2..).map(|k| format!("{stem}.{k}"));
        let free = std::iter::once(stem.clone())
            .chain(numbered)
            .find(|name| !taken.contains(name))
            .unwrap_or_default();
        taken.insert(free.clone());
        free
    };
    images.iter().map(one).collect()
}

/// Writes the image with a cross at every disc seen, a ring where one is missing, arrows along the first row and
/// column from the disc 0, 0, and the numbers of the corners.
pub(crate) fn write(path: &Path, image: &Image, found: &Found) -> Result<(), PngError> {
    let mut canvas = canvas(image);
    let place = |c: usize, r: usize| on_canvas(project(&found.homography, Vector2::new(c as f64, r as f64)));
    for disc in &found.discs {
        let [x, y] = on_canvas(disc.at);
        canvas.line([x - 3.0, y], [x + 3.0, y], Line::solid(SEEN, 1.0));
        canvas.line([x, y - 3.0], [x, y + 3.0], Line::solid(SEEN, 1.0));
        if disc.mark {
            canvas.circle([x, y], 9.0, Line::solid(COLUMNS, 1.5));
        }
    }
    for [col, row] in &found.missing {
        canvas.circle(place(*col, *row), 4.0, Line::solid(MISSING, 1.5));
    }
    let all = || {
        found
            .discs
            .iter()
            .map(|d| [d.col, d.row])
            .chain(found.missing.iter().copied())
    };
    let last = [0, 1].map(|k| all().map(|c| c[k]).max().unwrap_or(0));
    let at = |c: usize, r: usize| {
        let seen = found.discs.iter().find(|d| [d.col, d.row] == [c, r]);
        seen.map_or_else(|| place(c, r), |d| on_canvas(d.at))
    };
    canvas.line(at(0, 0), at(last[0], 0), Line::solid(COLUMNS, 1.0));
    canvas.line(at(0, 0), at(0, last[1]), Line::solid(ROWS, 1.0));
    for [c, r] in [[0, 0], [last[0], 0], [0, last[1]], last] {
        let [x, y] = at(c, r);
        canvas.text([x, y - 14.0], &format!("{c},{r}"), 14.0, SEEN, Anchor::Centre);
    }
    write_png(path, &canvas, &[])
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn two_images_of_one_name_do_not_overwrite_each_other() {
        let images = ["a/view.png", "b/view.png", "view.2.png", "view.jpg", "other.png"].map(PathBuf::from);
        assert_eq!(stems(&images), ["view", "view.2", "view.2.2", "view.3", "other"]);
    }
}
