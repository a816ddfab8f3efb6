//! Three planes through a volume's middle, gathered while its slices pass.
//!
//! Planes lie along the patient's axes whatever the voxels' axes are: each pixel is interpolated trilinearly between the
//! voxels around it, through the whole affine map, so that oblique and sheared volumes are shown in their true shape. What
//! a slice gives to a pixel is added when the slice comes; no slice is kept.

use geometry::{Point, VolumeGrid};

/// Pixels along the volume's longest side.
const LONGEST: f64 = 480.0;
/// Pixels with less of measured voxels around them than this are padding: just under a half, so that rounding does not make
/// a pattern where a plane runs midway between the two.
const MEASURED: f32 = 0.499;

/// What a pixel shows.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(super) enum Shown {
    /// No voxel's cell is there.
    Outside,
    /// Mostly voxels that were not measured.
    Padding,
    /// HU.
    Measured(f32),
}

/// Which way a plane lies and is looked at.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub(super) struct View {
    /// Its name.
    pub name: &'static str,
    /// The patient axis across the plane, 0 to 2.
    normal: usize,
    /// The patient axis from left to right and that from top to bottom, and whether each is run backwards.
    across: (usize, bool),
    down: (usize, bool),
    /// At the left, right, top and bottom.
    pub letters: [&'static str; 4],
}

/// As radiologists hang films: the patient's right is on the left of the image, and in the sagittal one the front is.
pub(super) const VIEWS: [View; 3] = [
    View {
        name: "axial",
        normal: 2,
        across: (0, false),
        down: (1, false),
        letters: ["R", "L", "A", "P"],
    },
    View {
        name: "frontal",
        normal: 1,
        across: (0, false),
        down: (2, true),
        letters: ["R", "L", "S", "I"],
    },
    View {
        name: "sagittal",
        normal: 0,
        across: (1, false),
        down: (2, true),
        letters: ["A", "P", "S", "I"],
    },
];

/// Planes that fill while slices pass.
#[derive(Debug)]
pub(super) struct Planes {
    /// In the order of [`VIEWS`].
    pub planes: [Plane; 3],
    /// The distance of neighbouring pixels in all of them, mm.
    pub pixel_mm: f64,
    /// The padding where it can be told from air.
    padding_hu: Option<i16>,
    columns: usize,
}

impl Planes {
    /// Empty planes through the middle of `grid`.
    pub(super) fn new(grid: &VolumeGrid, padding_hu: Option<i16>) -> Self {
        let (low, high) = grid.bounds();
        let [x, y, z] = (high - low).mm();
        let pixel_mm = x.max(y).max(z) / LONGEST;
        Self {
            planes: VIEWS.map(|view| Plane::new(grid, view, pixel_mm)),
            pixel_mm,
            padding_hu,
            columns: grid.dims()[0] as usize,
        }
    }

    /// Takes what slice `k` has for the planes.
    pub(super) fn add(&mut self, k: u32, slice: &[i16]) {
        let slice = Slice {
            k,
            voxels: slice,
            columns: self.columns,
            padding_hu: self.padding_hu,
        };
        self.planes.iter_mut().for_each(|plane| plane.add(&slice));
    }
}

/// One plane.
#[derive(Debug)]
pub(super) struct Plane {
    /// How it lies.
    pub view: View,
    /// Pixels across and down.
    pub size: [u32; 2],
    /// Places of the pixels in the volume, row by row; `None` outside.
    places: Vec<Option<Place>>,
    /// Numbers of the pixels inside, by the slice below them.
    by_slice: Vec<Vec<u32>>,
    /// Weight of what was measured, and its HU times weight.
    sums: Vec<[f32; 2]>,
}

/// Voxel indices below a pixel, and the way to the next voxels, 0 to 1.
#[derive(Debug, Clone, Copy)]
struct Place {
    index: [u32; 3],
    fraction: [f32; 3],
}

impl Plane {
    fn new(grid: &VolumeGrid, view: View, pixel_mm: f64) -> Self {
        let (low, high) = grid.bounds();
        let (low, high, centre) = (low.mm(), high.mm(), grid.centre().mm());
        let pixels = |axis: usize| ((high[axis] - low[axis]) / pixel_mm).round().max(1.0) as u32;
        let size = [pixels(view.across.0), pixels(view.down.0)];
        // The middle of the plane is the middle of the volume, whatever the rounding to whole pixels left over.
        let along = |(axis, backwards): (usize, bool), i: u32, count: u32| {
            let way = (f64::from(i) - (f64::from(count) - 1.0) / 2.0) * pixel_mm;
            (low[axis] + high[axis]) / 2.0 + if backwards { -way } else { way }
        };
        let mut plane = Self {
            view,
            size,
            places: Vec::with_capacity((size[0] * size[1]) as usize),
            by_slice: vec![Vec::new(); grid.dims()[2] as usize],
            sums: vec![[0.0; 2]; (size[0] * size[1]) as usize],
        };
        for v in 0..size[1] {
            for u in 0..size[0] {
                let mut p = [0.0; 3];
                p[view.normal] = centre[view.normal];
                p[view.across.0] = along(view.across, u, size[0]);
                p[view.down.0] = along(view.down, v, size[1]);
                plane.push(Place::of(grid, p));
            }
        }
        plane
    }

    fn push(&mut self, place: Option<Place>) {
        let below = place.and_then(|place| self.by_slice.get_mut(place.index[2] as usize));
        if let Some(below) = below {
            below.push(self.places.len() as u32);
        }
        self.places.push(place);
    }

    fn add(&mut self, slice: &Slice<'_>) {
        // The slice is the lower one of some pixels, and the upper one of those over the slice before.
        let lower = [Some(slice.k), slice.k.checked_sub(1)];
        for (upper, below) in lower.into_iter().enumerate() {
            let pixels = below.and_then(|k| self.by_slice.get(k as usize));
            for &pixel in pixels.into_iter().flatten() {
                let (Some(Some(place)), Some(sum)) =
                    (self.places.get(pixel as usize), self.sums.get_mut(pixel as usize))
                else {
                    continue;
                };
                let up = place.fraction[2];
                slice.gather(place, if upper == 1 { up } else { 1.0 - up }, sum);
            }
        }
    }

    /// What the pixels show, row by row from the top.
    pub(super) fn shown(&self) -> impl Iterator<Item = Shown> {
        self.places
            .iter()
            .zip(&self.sums)
            .map(|(place, [weight, sum])| match place {
                None => Shown::Outside,
                Some(_) if *weight < MEASURED => Shown::Padding,
                Some(_) => Shown::Measured(sum / weight),
            })
    }
}

impl Place {
    /// The place of `p` (mm LPS) in `grid`, or `None` outside the cells of its voxels.
    fn of(grid: &VolumeGrid, [x, y, z]: [f64; 3]) -> Option<Self> {
        let voxel = (grid.voxel_from_ct() * Point::new(x, y, z)).mm();
        let (mut index, mut fraction) = ([0; 3], [0.0; 3]);
        for axis in 0..3 {
            let last = f64::from(grid.dims()[axis]) - 1.0;
            if !(-0.5..=last + 0.5).contains(&voxel[axis]) {
                return None;
            }
            // Half a cell beyond the outermost voxels, their value goes on.
            let held = voxel[axis].clamp(0.0, last);
            index[axis] = held as u32;
            fraction[axis] = (held - held.floor()) as f32;
        }
        Some(Self { index, fraction })
    }
}

/// A slice on its way past.
struct Slice<'a> {
    k: u32,
    voxels: &'a [i16],
    columns: usize,
    padding_hu: Option<i16>,
}

impl Slice<'_> {
    /// Adds the four voxels around `place`, as a whole with `weight`, to `sum`.
    fn gather(&self, place: &Place, weight: f32, sum: &mut [f32; 2]) {
        let [fx, fy, _] = place.fraction;
        let first = place.index[1] as usize * self.columns + place.index[0] as usize;
        let around = [
            (first, (1.0 - fx) * (1.0 - fy)),
            (first + 1, fx * (1.0 - fy)),
            (first + self.columns, (1.0 - fx) * fy),
            (first + self.columns + 1, fx * fy),
        ];
        for (at, part) in around {
            // At the last column and row the part is zero, and there may be no such voxel.
            let Some(&hu) = self.voxels.get(at).filter(|_| part > 0.0) else {
                continue;
            };
            if Some(hu) != self.padding_hu {
                sum[0] += weight * part;
                sum[1] += weight * part * f32::from(hu);
            }
        }
    }
}
