//! Summaries and pictures of volumes whose answers are known.

use geometry::{Affine, Ct, Point, VolumeGrid, Voxel};

use super::*;
use crate::phantom_source::PhantomSource;
use crate::source::{Conversion, Facts};

/// A volume whose voxel is what a function of its place says.
struct Field<F> {
    grid: VolumeGrid,
    hu: F,
    padding_hu: i16,
    conversion: Conversion,
    facts: Facts,
}

impl<F: Fn(Point<Ct>) -> i16 + Send + Sync> Field<F> {
    fn new(dims: [i64; 3], rows: [[f64; 4]; 3], hu: F) -> Self {
        Self {
            grid: VolumeGrid::checked(dims, Affine::<Ct, Voxel>::from_rows(rows)).unwrap(),
            hu,
            padding_hu: -2000,
            conversion: Conversion::default(),
            facts: Facts::default(),
        }
    }
}

impl<F: Fn(Point<Ct>) -> i16 + Send + Sync> VoxelSource for Field<F> {
    fn grid(&self) -> &VolumeGrid {
        &self.grid
    }
    fn padding_hu(&self) -> i16 {
        self.padding_hu
    }
    fn describe(&self) -> String {
        "a field".to_owned()
    }
    fn facts(&self) -> Facts {
        self.facts.clone()
    }
    fn read_slice(&mut self, k: u32, out: &mut [i16]) -> Result<(), ReadError> {
        let [nx, ny, _] = self.grid.dims();
        for (at, voxel) in (0..ny).flat_map(|j| (0..nx).map(move |i| [i, j, k])).zip(out) {
            let [x, y, z] = at.map(f64::from);
            *voxel = (self.hu)(self.grid.ct_from_voxel() * Point::new(x, y, z));
        }
        Ok(())
    }
    fn finish(&mut self) -> Result<Conversion, ReadError> {
        Ok(self.conversion)
    }
}

fn summary(source: &mut dyn VoxelSource) -> Summary {
    inspect(source, None).unwrap().summary
}

/// Turned by 30 degrees around x, mirrored and with steps of 1 x 2 x 3 mm; stored frontally.
fn turned() -> [[f64; 4]; 3] {
    let (s, c) = 30_f64.to_radians().sin_cos();
    [
        [-1.0, 0.0, 0.0, 5.0],
        [0.0, -2.0 * s, 3.0 * c, 6.0],
        [0.0, -2.0 * c, -3.0 * s, 7.0],
    ]
}

#[test]
fn the_generated_patient() {
    let mut source = PhantomSource::new(1, [6.0; 3]).unwrap();
    let hash_by_loading = {
        let layout = bus::volume::Layout::choose(source.grid().dims()).unwrap();
        let mut stored = vec![0; layout.stored() as usize];
        crate::fill(&mut source, &layout, &mut stored, |_| true)
            .unwrap()
            .hash
            .to_string()
    };
    let mut source = PhantomSource::new(1, [6.0; 3]).unwrap();
    let summary = summary(&mut source);
    assert_eq!(summary.hash, hash_by_loading);
    assert_eq!(
        (summary.place.letters.as_str(), summary.place.handedness),
        ("LPS", Handedness::RightHanded)
    );
    assert_eq!(
        summary.place.orientation,
        "columns to left, rows to posterior, slices to superior"
    );
    assert!(summary.place.off_axis_degrees.iter().all(|d| *d < 1e-6) && summary.place.tilt_degrees < 1e-9);
    assert_eq!(summary.warnings, [""; 0]);
    // Air around the patient is the padding, and cannot be told from it.
    assert!(!summary.padding.told_from_air && summary.padding.share > 0.2);
    let hu = summary.hu.unwrap();
    assert!(hu.min == -1000 && hu.max > 300, "{hu:?}");
}

#[test]
fn a_turned_mirrored_volume_is_named_axis_by_axis() {
    let place = Place::of(&Field::new([4, 5, 6], turned(), |_| 0).grid);
    assert_eq!(
        (place.letters.as_str(), place.handedness),
        ("RIP", Handedness::LeftHanded)
    );
    assert_eq!(
        place.orientation,
        "columns to right, rows to inferior, slices to posterior"
    );
    let [x, y, z] = place.off_axis_degrees;
    assert!(
        x < 1e-6 && (y - 30.0).abs() < 1e-9 && (z - 30.0).abs() < 1e-9,
        "{place:?}"
    );
    assert!(place.tilt_degrees < 1e-9 && place.slant_degrees < 1e-9, "{place:?}");
    assert_eq!(place.size_mm.map(f64::round), [4.0, 10.0, 18.0]);
}

#[test]
fn no_two_axes_are_named_alike() {
    // Exactly between two patient axes.
    let h = 0.5_f64.sqrt();
    let rows = [[h, h, 0.0, 0.0], [-h, h, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let letters = Place::of(&Field::new([4, 4, 4], rows, |_| 0).grid).letters;
    assert!(letters == "LPS" || letters == "ALS", "{letters}");
}

#[test]
fn tilt_and_slant_in_degrees() {
    let t = 18.5_f64.to_radians().tan();
    let rows = [[1.0, 0.01, 0.0, 0.0], [0.0, 1.0, -2.0 * t, 0.0], [0.0, 0.0, 2.0, 0.0]];
    let mut source = Field::new([3, 3, 3], rows, |p| p.mm()[0] as i16);
    source.conversion.rounded = 7;
    let summary = summary(&mut source);
    assert!((summary.place.tilt_degrees - 18.5).abs() < 1e-9);
    assert!((summary.place.slant_degrees - 0.01_f64.atan().to_degrees()).abs() < 1e-9);
    let said = summary.warnings.join("\n");
    for words in [
        "18.50 degrees off their normal",
        "0.573 degrees off a right angle",
        "there is no air",
        "7 of 27 voxels were fractions",
    ] {
        assert!(said.contains(words), "{words}: {said}");
    }
}

#[test]
fn pictures_show_each_place_in_its_place() {
    // A field that is linear in the patient, on a turned, sheared, mirrored grid: trilinear interpolation is exact.
    let mut rows = turned();
    rows[0][2] += 0.8;
    let hu = |p: Point<Ct>| {
        let [x, y, z] = p.mm();
        (300.0 + 20.0 * x + 7.0 * y - 11.0 * z).round() as i16
    };
    let mut source = Field::new([40, 30, 20], rows, hu);
    let grid = source.grid;
    let mut planes = planes::Planes::new(&grid, None);
    let mut slice = vec![0; 1200];
    for k in 0..20 {
        source.read_slice(k, &mut slice).unwrap();
        planes.add(k, &slice);
    }
    let (low, high) = grid.bounds();
    let middle = low.lerp(high, 0.5).mm();
    let centre = grid.centre().mm();
    let mut inside = 0;
    for plane in &planes.planes {
        let [width, height] = plane.size;
        for (at, shown) in plane.shown().enumerate() {
            let u = ((at as u32 % width) as f64 - (f64::from(width) - 1.0) / 2.0) * planes.pixel_mm;
            let v = ((at as u32 / width) as f64 - (f64::from(height) - 1.0) / 2.0) * planes.pixel_mm;
            // To the right and down, as radiologists look: +x and +y; +x and -z; +y and -z.
            let p = match plane.view.name {
                "axial" => Point::new(middle[0] + u, middle[1] + v, centre[2]),
                "frontal" => Point::new(middle[0] + u, centre[1], middle[2] - v),
                _ => Point::new(centre[0], middle[1] + u, middle[2] - v),
            };
            let voxel = (grid.voxel_from_ct() * p).mm();
            let dims = grid.dims().map(f64::from);
            let within = |by: f64| (0..3).all(|a| voxel[a] >= -by && voxel[a] <= dims[a] - 1.0 + by);
            match shown {
                planes::Shown::Outside => assert!(!within(0.49), "{} {voxel:?}", plane.view.name),
                planes::Shown::Padding => panic!("there is none"),
                // Between the middles of voxels; half a cell beyond, the value goes on.
                planes::Shown::Measured(found) if within(0.0) => {
                    inside += 1;
                    let [x, y, z] = p.mm();
                    let want = 300.0 + 20.0 * x + 7.0 * y - 11.0 * z;
                    // Voxels are rounded to whole HU, fractions are f32.
                    assert!(
                        (f64::from(found) - want).abs() < 0.6,
                        "{} {voxel:?}: {found} for {want}",
                        plane.view.name
                    );
                }
                planes::Shown::Measured(_) => assert!(within(0.51)),
            }
        }
    }
    assert!(inside > 50_000, "{inside}");
}

#[test]
fn padding_is_kept_out_of_numbers_and_windows() {
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    // The front half was not measured.
    let hu = |p: Point<Ct>| if p.mm()[1] < 9.5 { -2000 } else { 40 };
    let mut source = Field::new([20, 20, 20], rows, hu);
    let inspection = inspect(&mut source, Some(WINDOW)).unwrap();
    let range = inspection.summary.hu.unwrap();
    assert_eq!((range.min, range.max, inspection.summary.padding.share), (40, 40, 0.5));
    let canvas = inspection.picture.unwrap();
    let count = |colour: [u8; 4]| canvas.rgba().chunks(4).filter(|p| **p == colour).count();
    // 40 HU are 127.5, and f32 rounds to either side.
    let grey = [127, 128].map(|c| count([c, c, c, 255])).iter().sum::<usize>();
    let blue = count([0, 0, 72, 255]);
    // Half of 480 x 480 pixels in each plane; the frontal one lies just between and counts as measured.
    assert!(
        blue.abs_diff(480 * 480) < 2000 && grey.abs_diff(2 * 480 * 480) < 2000,
        "{blue} {grey}"
    );
}

#[test]
fn json_has_its_names_and_the_report_its_lines() {
    let rows = [[1.0, 0.0, 0.0, 0.0], [0.0, 1.0, 0.0, 0.0], [0.0, 0.0, 1.0, 0.0]];
    let mut source = Field::new([20, 20, 20], rows, |p| (50.0 * p.mm()[0]) as i16 - 400);
    source.facts.warnings.push("a doubt".to_owned());
    source.facts.extra.insert("codec".to_owned(), "RLE Lossless".into());
    let summary = inspect(&mut source, None).unwrap().summary;
    let json = serde_json::to_value(&summary).unwrap();
    for name in [
        "format",
        "dims",
        "spacing_mm",
        "size_mm",
        "ct_from_voxel",
        "orientation",
        "letters",
        "handedness",
        "tilt_degrees",
        "hu",
        "padding",
        "histogram",
        "changed",
        "hash",
        "warnings",
    ] {
        assert!(!json[name].is_null(), "{name}: {json}");
    }
    assert_eq!(
        (json["handedness"].as_str(), json["extra"]["codec"].as_str()),
        (Some("right-handed"), Some("RLE Lossless"))
    );
    assert_eq!(json["histogram"]["bins"].as_array().map(Vec::len), Some(64));
    let report = summary.to_string();
    for words in ["orientation    LPS", "codec", "warning: a doubt", "fat soft", "█"] {
        assert!(report.contains(words), "{words}: {report}");
    }
}
