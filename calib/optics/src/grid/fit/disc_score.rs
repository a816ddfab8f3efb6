//! Whether a disc is where a fitted grid says.

use nalgebra::{Matrix2, Matrix3, Matrix4, Vector2, Vector4};

use crate::disc::{Blurred, Ellipse, REACH, Raster};
use crate::grid::fit::disc_jacobian::point;
use crate::grid::fit::grid_fit::GridFit;
use crate::grid::homography::project;
use crate::image::Image;

/// So many times the noise is left where there is nothing but a disc.
const NOISY_TIMES: f64 = 1.5;

/// The share of the expected contrast at a cell, and its standard deviation; none outside the image.
///
/// Least squares of the pixels on the disc's coverage beside a plane of grey, so that shade and edges of the paper do
/// not count. Other discs of the grid are taken out first. Where it is asked whether there is anything but a disc, which the end
/// of the paper is on a table darker than the discs, it must leave less than what it explains, or than noise does: the share is 0
/// otherwise.
pub(crate) fn amplitude(image: &Image, whole: &GridFit, cell: [i32; 2], alone: bool) -> Option<[f64; 2]> {
    let (width, height) = (image.width(), image.height());
    let own = whole.outline(cell)?;
    let centre = whole.at(cell);
    if !image.holds(centre) {
        return None;
    }
    // The fit's slopes of grey are those a hundred pixels.
    let off = (centre - whole.origin) / 100.0;
    // Contrast changes over the grid with the light.
    let contrast = whole.contrast[0] + whole.contrast[1] * off.x + whole.contrast[2] * off.y;
    let back = Back::of(whole, cell)?;
    // Beyond 2.5 deviations of the blur a disc keeps less than 1 % of its contrast: such pixels tell but of paper.
    let window = Blurred::new(own, whole.sigma).window(2.5 * whole.sigma, width, height);
    let [columns, rows] = window;
    let raster = |ellipse: Ellipse| {
        let mut raster = Raster::default();
        raster.set(ellipse, whole.sigma, columns);
        raster
    };
    // Blurred discs reach into the next cell: what the fit knows of those is taken out.
    let near = [[1, 0], [-1, 0], [0, 1], [0, -1]].map(|[dx, dy]| whole.outline([cell[0] + dx, cell[1] + dy]));
    let reaching = |e: &Ellipse| {
        let [x, y] = Blurred::new(*e, whole.sigma).window(REACH * whole.sigma, width, height);
        meet(x, columns) && meet(y, rows)
    };
    let mut others: Vec<Raster> = near.into_iter().flatten().filter(reaching).map(raster).collect();
    let mut own = raster(own);
    let (mut matrix, mut vector, mut squares, mut count) = (Matrix4::zeros(), Vector4::zeros(), 0.0, 0);
    for y in rows[0]..rows[1] {
        own.row(y);
        others.iter_mut().for_each(|o| o.row(y));
        for x in columns[0]..columns[1] {
            let place = Vector2::new(x as f64, y as f64);
            let at = back.at(place);
            // Beyond the cell other discs weigh more than what is asked for.
            if at.x.abs() > 0.6 || at.y.abs() > 0.6 {
                continue;
            }
            let rest: f64 = others.iter().map(|o| o.value(x)).sum();
            // The contrast is that of paper less disc: added back over the other discs, it makes paper of them.
            let value = f64::from(image.sample(x, y)) + contrast * rest;
            // About the disc's middle, so that the plane's slopes are nearly uncorrelated with its value and with the
            // coverage.
            let d = place - centre;
            let row = Vector4::new(own.value(x), 1.0, d.x, d.y);
            matrix += row * row.transpose();
            vector += row * value;
            squares += value * value;
            count += 1;
        }
    }
    // Four numbers are fitted: fewer pixels say nothing of how well.
    if count < 8 {
        return None;
    }
    let inverse = matrix.try_inverse()?;
    let found = inverse * vector;
    // Rounding may leave a variance of 0 just below it.
    let deviation = whole.noise * inverse[(0, 0)].max(0.0).sqrt();
    // By found^2 / inverse the squares would grow, were the disc left out of the fit.
    let (left, explained) = (squares - vector.dot(&found), found[0].powi(2) / inverse[(0, 0)]);
    let noise = f64::from(count) * (NOISY_TIMES * whole.noise).powi(2);
    if alone && left > explained.max(noise) {
        return Some([0.0, deviation / contrast.abs()]);
    }
    // A dark disc lowers the grey, and has a positive contrast.
    Some([-found[0] / contrast, deviation / contrast.abs()])
}

/// From pixels to how far off a cell they are: through a lens by the derivative there, which is enough for half a step.
enum Back {
    Plane(Matrix3<f64>, Vector2<f64>),
    LensModel(Matrix2<f64>, Vector2<f64>),
}

impl Back {
    fn of(whole: &GridFit, cell: [i32; 2]) -> Option<Self> {
        Some(match &whole.bent {
            Some(bent) => Self::LensModel(bent.pitch(cell).try_inverse()?, bent.at(cell)),
            None => Self::Plane(whole.h.try_inverse()?, point(cell)),
        })
    }

    fn at(&self, place: Vector2<f64>) -> Vector2<f64> {
        match self {
            Self::Plane(back, cell) => project(back, place) - cell,
            Self::LensModel(back, centre) => back * (place - centre),
        }
    }
}

/// Whether two ranges have something in common.
fn meet(a: [usize; 2], b: [usize; 2]) -> bool {
    a[0] < b[1] && b[0] < a[1]
}
